//! Writes the code as an object file: its section, its symbols, and the descriptions of its stack
//! frames.

use object::write::{
    Object as File, Relocation, SectionId, StandardSection, Symbol, SymbolSection,
};
use object::{
    Architecture, BinaryFormat, Endianness, RelocationEncoding, RelocationFlags, RelocationKind,
    SectionFlags, SectionKind, SymbolFlags, SymbolKind, SymbolScope, macho, pe,
};

use super::ObjectFormat;
use super::text::Text;
use super::unwind::{eh_frame, unwind_information};

/// Returns the object file. The names of `hidden` symbols are not visible outside of the program or
/// library that the object becomes part of.
pub(super) fn file(
    text: &Text,
    prefix: &str,
    format: ObjectFormat,
    hidden: bool,
) -> object::write::Result<Vec<u8>> {
    let binary = match format {
        ObjectFormat::Elf => BinaryFormat::Elf,
        ObjectFormat::MachO => BinaryFormat::MachO,
        ObjectFormat::Coff => BinaryFormat::Coff,
    };
    let mut file = File::new(binary, Architecture::X86_64, Endianness::Little);
    let section = file.section_id(StandardSection::Text);
    file.append_section_data(section, &text.code, 64);
    let scope = if hidden { SymbolScope::Linkage } else { SymbolScope::Dynamic };
    for symbol in &text.symbols {
        file.add_symbol(Symbol {
            name: format!("{prefix}_{}", symbol.name).into_bytes(),
            value: symbol.start as u64,
            size: symbol.length as u64,
            kind: if symbol.is_function { SymbolKind::Text } else { SymbolKind::Data },
            scope,
            weak: false,
            section: SymbolSection::Section(section),
            flags: SymbolFlags::None,
        });
    }
    match format {
        ObjectFormat::Elf => {
            frames_of_elf(&mut file, section, text)?;
            // The stack holds no code.
            file.add_section(Vec::new(), b".note.GNU-stack".to_vec(), SectionKind::Other);
        }
        ObjectFormat::Coff => frames_of_coff(&mut file, section, text)?,
        ObjectFormat::MachO => {
            // macOS 11.0; the linker asks for a version.
            let mut version = object::write::MachOBuildVersion::default();
            (version.platform, version.minos, version.sdk) =
                (macho::PLATFORM_MACOS, 11 << 16, 11 << 16);
            file.set_macho_build_version(version);
        }
    }
    file.write()
}

/// Adds `.eh_frame`.
fn frames_of_elf(
    file: &mut File<'_>,
    section: SectionId,
    text: &Text,
) -> object::write::Result<()> {
    let (bytes, starts) = eh_frame(&text.frames);
    let frames = file.section_id(StandardSection::EhFrame);
    file.append_section_data(frames, &bytes, 8);
    let symbol = file.section_symbol(section);
    for (frame, at) in text.frames.iter().zip(starts) {
        let flags = RelocationFlags::Generic {
            kind: RelocationKind::Relative,
            encoding: RelocationEncoding::Generic,
            size: 32,
        };
        let relocation =
            Relocation { offset: at as u64, symbol, addend: frame.start as i64, flags };
        file.add_relocation(frames, relocation)?;
    }
    Ok(())
}

/// Adds `.pdata`, a table of functions, and `.xdata`, the descriptions of their frames.
fn frames_of_coff(
    file: &mut File<'_>,
    section: SectionId,
    text: &Text,
) -> object::write::Result<()> {
    let [functions, descriptions] = [".pdata", ".xdata"].map(|name| {
        let name = name.as_bytes().to_vec();
        let section = file.add_section(Vec::new(), name, SectionKind::ReadOnlyData);
        file.section_mut(section).flags = SectionFlags::Coff {
            characteristics: pe::IMAGE_SCN_CNT_INITIALIZED_DATA
                | pe::IMAGE_SCN_MEM_READ
                | pe::IMAGE_SCN_ALIGN_4BYTES,
        };
        section
    });
    let [of_text, of_descriptions] =
        [section, descriptions].map(|section| file.section_symbol(section));
    // The table is in the order of addresses.
    let mut frames = text.frames.clone();
    frames.sort_by_key(|frame| frame.start);
    for frame in frames {
        let Some(description) = unwind_information(&frame) else { continue };
        let place = file.append_section_data(descriptions, &description, 4);
        let row = file.append_section_data(functions, &[0; 12], 4);
        let addresses =
            [(of_text, frame.start as u64), (of_text, frame.last as u64), (of_descriptions, place)];
        for (k, (symbol, address)) in (0..).zip(addresses) {
            let flags = RelocationFlags::Coff { typ: pe::IMAGE_REL_AMD64_ADDR32NB };
            let addend = address as i64;
            let relocation = Relocation { offset: row + 4 * k, symbol, addend, flags };
            file.add_relocation(functions, relocation)?;
        }
    }
    Ok(())
}
