//! A static library that holds one object file, as linkers want it; and the build script's part.

use std::io::Cursor;
use std::path::Path;

use ar_archive_writer::{
    ArchiveKind, DEFAULT_OBJECT_READER, NewArchiveMember, write_archive_to_stream,
};
use modyn_codegen::Builder;
use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics};

use super::{Object, ObjectFormat, ObjectOptions};
use crate::error::CompileError;
use crate::instruction_set::InstructionSet;

/// Returns the static library of an object file.
pub(super) fn library(object: &Object) -> std::io::Result<Vec<u8>> {
    let kind = match object.format {
        ObjectFormat::Elf => ArchiveKind::Gnu,
        ObjectFormat::MachO => ArchiveKind::Darwin,
        ObjectFormat::Coff => ArchiveKind::Coff,
    };
    let name = match object.format {
        ObjectFormat::Coff => format!("{}.obj", object.prefix),
        ObjectFormat::Elf | ObjectFormat::MachO => format!("{}.o", object.prefix),
    };
    let member = NewArchiveMember::new(&object.bytes, &DEFAULT_OBJECT_READER, name);
    let mut archive = Cursor::new(Vec::new());
    write_archive_to_stream(&mut archive, &[member], kind, false, None)?;
    Ok(archive.into_inner())
}

/// Compiles in a build script; see [`ObjectBuilder::compile_object`].
pub(super) fn compile(
    builder: &Builder,
    instruction_set: Option<InstructionSet>,
) -> Result<Object, CompileError> {
    builder.rerun_if_changed();
    let mut options = options_of_cargo()?;
    options.instruction_set = instruction_set.unwrap_or(options.instruction_set);
    let object = super::generate(builder, &options, true)?;
    builder.rerun_if_others_changed(&object.files);
    let name = builder.write_to_out_dir(&object.type_name, &object.wrapper, &object.warnings)?;
    let folder = std::env::var_os("OUT_DIR").unwrap_or_default();
    let msvc = std::env::var("CARGO_CFG_TARGET_ENV").is_ok_and(|environment| environment == "msvc");
    let file =
        if msvc { format!("{}.lib", object.prefix) } else { format!("lib{}.a", object.prefix) };
    let path = Path::new(&folder).join(&file);
    let written = library(&object).and_then(|bytes| std::fs::write(&path, bytes));
    written.map_err(|reason| {
        let message = format!("the library of `{name}` cannot be written: {reason}");
        error(&message, "OUT_DIR must be a writable folder")
    })?;
    println!("cargo::rustc-link-search=native={}", Path::new(&folder).display());
    println!("cargo::rustc-link-lib=static={}", object.prefix);
    Ok(object)
}

fn error(message: &str, help: &str) -> CompileError {
    Diagnostics::from(Diagnostic::error(Code::Output, message).with_help(help)).into()
}

/// Returns the options for the target that Cargo compiles for: its object files, and the
/// instruction set that rustc may use.
fn options_of_cargo() -> Result<ObjectOptions, CompileError> {
    let variable = |name: &str| std::env::var(format!("CARGO_CFG_{name}")).unwrap_or_default();
    let architecture = variable("TARGET_ARCH");
    if architecture != "x86_64" {
        let message = format!("object files are made for x86-64, not for `{architecture}`");
        return Err(error(&message, "call `Builder::compile`, which prints Rust"));
    }
    let format = match variable("TARGET_OS").as_str() {
        "windows" => ObjectFormat::Coff,
        "macos" => ObjectFormat::MachO,
        _ => ObjectFormat::Elf,
    };
    let features = variable("TARGET_FEATURE");
    let has = |names: &[&str]| names.iter().all(|name| features.split(',').any(|f| f == *name));
    let mut sets = InstructionSet::ALL.into_iter().rev();
    let best = sets.find(|set| set.architecture() == architecture && has(set.features()));
    let instruction_set = best.unwrap_or(InstructionSet::Sse2);
    Ok(ObjectOptions { instruction_set, format, prefix: None })
}
