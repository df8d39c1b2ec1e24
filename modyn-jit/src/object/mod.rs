//! Object files: a robot's functions as machine code that linkers take, with a C header and a Rust
//! text that calls them.
//!
//! A large robot's crate then builds as fast as a small one's: there is no function for rustc to
//! compile. In a build script:
//!
//! ```no_run
//! use modyn_jit::object::ObjectBuilder;
//!
//! fn main() -> Result<(), modyn_jit::CompileError> {
//!     modyn_codegen::Builder::new().urdf("robots/humanoid.urdf").compile_object(None)?;
//!     Ok(())
//! }
//! ```
//!
//! and in the crate `modyn::include_model!(humanoid);`, as with `Builder::compile`.
//!
//! ```text
//! plan ─ assembly ─▶ programs ─ text ─▶ programs, helpers, entries ─ file ─▶ ELF, Mach-O, COFF
//!   └─ modyn-codegen ─▶ C header, Rust text                 ELF, Mach-O, COFF ─ library ─▶ library
//! ```
//!
//! The programs and their instructions are the same as in [`Compiled`](crate::Compiled), so results
//! are the same bits. The object needs no other code. The host can be any machine: it does not run
//! the code.

mod assembler;
mod convention;
mod entry;
mod file;
mod helpers;
mod library;
mod looped;
#[cfg(test)]
mod tests;
mod text;
mod unwind;

use std::path::PathBuf;

use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics};
use modyn_codegen::{Builder, FloatType, MachineCode, MachineTarget, ObjectPlanning};

use crate::code_size::CodeSize;
use crate::error::CompileError;
use crate::instruction_set::InstructionSet;
use convention::Convention;
use text::Text;

/// The format of object files, with the calling convention of the systems that use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ObjectFormat {
    /// Linux and the BSDs; System V's calling convention.
    Elf,
    /// macOS; System V's calling convention.
    MachO,
    /// Windows; Microsoft's calling convention.
    Coff,
}

impl ObjectFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Elf, Self::MachO, Self::Coff];

    /// Returns the format of this system.
    #[must_use]
    pub fn of_this_system() -> Self {
        if cfg!(windows) {
            Self::Coff
        } else if cfg!(target_vendor = "apple") {
            Self::MachO
        } else {
            Self::Elf
        }
    }

    fn convention(self) -> Convention {
        match self {
            Self::Elf | Self::MachO => Convention::SystemV,
            Self::Coff => Convention::Windows,
        }
    }

    fn target(self) -> MachineTarget {
        let (words, cfg) = match self {
            Self::Elf => (
                "x86-64 with ELF, as on Linux",
                "all(target_arch = \"x86_64\", not(windows), not(target_vendor = \"apple\"))",
            ),
            Self::MachO => {
                ("x86-64 and macOS", "all(target_arch = \"x86_64\", target_vendor = \"apple\")")
            }
            Self::Coff => ("x86-64 and Windows", "all(target_arch = \"x86_64\", windows)"),
        };
        MachineTarget { words, cfg }
    }
}

/// The options of an object file; the options of the robot belong to a [`Builder`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjectOptions {
    /// The vector instructions, of x86-64. Processors without them cannot run the code; `Sse2` by
    /// default, which all of x86-64 have.
    pub instruction_set: InstructionSet,
    /// The format; by default this system's format.
    pub format: ObjectFormat,
    /// The prefix of the C functions; by default the name of the robot's type in snake case.
    pub prefix: Option<String>,
}

impl Default for ObjectOptions {
    fn default() -> Self {
        let instruction_set = InstructionSet::Sse2;
        let format = ObjectFormat::of_this_system();
        Self { instruction_set, format, prefix: None }
    }
}

/// A robot's functions as an object file, and the texts beside it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Object {
    /// The bytes of the object file.
    pub bytes: Vec<u8>,
    /// The C header: the functions of `modyn generate --target c`, and `PREFIX_is_supported`.
    pub header: String,
    /// The Rust text: the robot's type, whose functions call the object's. It needs the crate
    /// `modyn`.
    pub wrapper: String,
    /// The format of the file.
    pub format: ObjectFormat,
    /// The prefix of the C functions.
    pub prefix: String,
    /// The name of the robot's type in Rust.
    pub type_name: String,
    /// The warnings about the description.
    pub warnings: Vec<Diagnostic>,
    /// The other files that were read, which the description names.
    pub files: Vec<PathBuf>,
    /// Counts of the code of each function.
    pub sizes: Vec<(&'static str, CodeSize)>,
}

impl Object {
    /// Returns a static library that holds the object file.
    ///
    /// # Errors
    ///
    /// If the library would be too large for its format.
    pub fn static_library(&self) -> std::io::Result<Vec<u8>> {
        library::library(self)
    }
}

/// Object files from a [`Builder`].
pub trait ObjectBuilder {
    /// Returns the functions of one state as an object file, in the scalar of the builder, with the
    /// texts beside it. Writes no file.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, or that a function has too many
    /// arguments.
    fn generate_object(&self, options: &ObjectOptions) -> Result<Object, CompileError>;

    /// Compiles in a build script, for `modyn::include_model!`: writes a static library and the
    /// Rust text that calls it to `OUT_DIR`, and tells Cargo to link the library. The names of its
    /// functions contain a hash of the code, so a program can have several robots of one name.
    ///
    /// Without an instruction set, it is the best one that rustc may use for the target, by its
    /// target features.
    ///
    /// # Errors
    ///
    /// The errors of [`generate_object`](Self::generate_object), the target is not x86-64, or a
    /// file cannot be written.
    fn compile_object(
        &self,
        instruction_set: Option<InstructionSet>,
    ) -> Result<Object, CompileError>;
}

impl ObjectBuilder for Builder {
    fn generate_object(&self, options: &ObjectOptions) -> Result<Object, CompileError> {
        generate(self, options, false)
    }

    fn compile_object(
        &self,
        instruction_set: Option<InstructionSet>,
    ) -> Result<Object, CompileError> {
        library::compile(self, instruction_set)
    }
}

/// Returns an object file. `hashed` prefixes contain a hash of the code.
fn generate(
    builder: &Builder,
    options: &ObjectOptions,
    hashed: bool,
) -> Result<Object, CompileError> {
    let planned: ObjectPlanning = builder.plan_object()?;
    let ObjectOptions { instruction_set, format, ref prefix } = *options;
    if instruction_set.architecture() != "x86_64" {
        let message = format!(
            "object files are made for x86-64, and {instruction_set:?} is an instruction set of {}",
            instruction_set.architecture()
        );
        let help = "select `Sse2`, `Avx2` or `Avx512`; elsewhere `Builder::generate` and `Builder::compile` print Rust";
        return Err(error(Code::Option, &message, help));
    }
    let plan = &planned.planning.plan;
    let model = &planned.planning.model;
    let convention = format.convention();
    let text = match planned.scalar() {
        FloatType::F64 => text::text::<f64>(plan, model, instruction_set, convention)?,
        FloatType::F32 => text::text::<f32>(plan, model, instruction_set, convention)?,
    };
    let prefix = match prefix {
        Some(prefix) => checked(prefix)?,
        None if hashed => format!("modyn_{}_{:016x}", planned.prefix(), hash(&text)),
        None => planned.prefix(),
    };
    let bytes = file::file(&text, &prefix, format, hashed).map_err(|reason| {
        let message = format!("the object file cannot be made: {reason}");
        error(Code::Output, &message, "generate fewer functions")
    })?;
    let needs = instruction_set.words();
    let features = instruction_set.features();
    let code = MachineCode { prefix, target: format.target(), needs, features };
    Ok(Object {
        bytes,
        header: planned.header(&code),
        wrapper: planned.wrapper(&code),
        format,
        prefix: code.prefix,
        type_name: planned.type_name(),
        warnings: planned.planning.warnings,
        files: planned.planning.files,
        sizes: text.sizes,
    })
}

/// Returns a prefix that is an identifier of C.
fn checked(prefix: &str) -> Result<String, CompileError> {
    let starts = prefix.starts_with(|c: char| c.is_ascii_alphabetic());
    if starts && prefix.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(prefix.into());
    }
    let help = "begin with an ASCII letter; letters, digits and underscores follow";
    Err(error(Code::Option, "the prefix is no name in C", help))
}

fn error(code: Code, message: &str, help: &str) -> CompileError {
    Diagnostics::from(Diagnostic::error(code, message).with_help(help)).into()
}

/// Returns the FNV-1a hash of the code and of its names.
fn hash(text: &Text) -> u64 {
    let names = text.symbols.iter().flat_map(|symbol| symbol.name.as_bytes());
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
    text.code.iter().chain(names).fold(0xcbf2_9ce4_8422_2325, step)
}
