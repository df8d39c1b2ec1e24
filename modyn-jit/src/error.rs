//! Errors of compilation and of calls.

use std::{fmt, io};

use modyn_codegen::diagnostics::Diagnostics;

use crate::generate::MAX_ARRAYS;
use crate::instruction_set::InstructionSet;

/// The reason why a robot has no machine code.
#[derive(Debug)]
#[non_exhaustive]
pub enum CompileError {
    /// The description or an option is wrong.
    Description(Diagnostics),
    /// Machine code is not made for this system: see [`InstructionSet::detect`].
    Architecture,
    /// The processor lacks the selected vector instructions.
    InstructionSet {
        /// The selected instruction set.
        wanted: InstructionSet,
        /// The best instruction set of the processor.
        available: InstructionSet,
    },
    /// A function has more arguments than machine code can have.
    Arguments {
        /// The name of the function.
        function: &'static str,
        /// The number of its arrays of numbers, the array of run-time parameters included.
        arrays: usize,
    },
    /// The system gives no executable memory.
    Memory(io::Error),
}

impl fmt::Display for CompileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let instead = "`modyn::Interpreter` computes the same quantities without machine code";
        match self {
            Self::Description(diagnostics) => diagnostics.fmt(f),
            Self::Architecture => {
                let architecture = std::env::consts::ARCH;
                let system = std::env::consts::OS;
                write!(
                    f,
                    "machine code is made for x86-64, and for aarch64 except on Windows, and this \
                     is {architecture} with \
                     {system}; {instead}"
                )
            }
            Self::InstructionSet { wanted, available } => write!(
                f,
                "this processor has no {wanted:?}, its best is {available:?}; leave \
                 `instruction_set` out to have the best"
            ),
            Self::Arguments { function, arrays } => write!(
                f,
                "`{function}` has {arrays} arrays of arguments with the run-time parameters, and machine code at most \
                 {MAX_ARRAYS}; leave it out, or divide the fused function"
            ),
            Self::Memory(reason) => {
                write!(f, "the system gives no executable memory ({reason}); {instead}")
            }
        }
    }
}

impl std::error::Error for CompileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Description(diagnostics) => Some(diagnostics),
            Self::Memory(reason) => Some(reason),
            Self::Architecture | Self::InstructionSet { .. } | Self::Arguments { .. } => None,
        }
    }
}

impl From<Diagnostics> for CompileError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Description(diagnostics)
    }
}

/// The reason why a function was not called. Nothing was written in that case.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CallError {
    /// The function was not compiled.
    NotCompiled {
        /// The name of the function.
        function: String,
        /// The names of the compiled functions.
        compiled: Vec<&'static str>,
    },
    /// The function was compiled for one state at a time.
    NoBatch {
        /// The name of the function.
        function: &'static str,
    },
    /// The function has another number of arguments.
    Arguments {
        /// The name of the function.
        function: &'static str,
        /// The names of its arguments.
        expected: Vec<&'static str>,
        /// The number of arguments that were given.
        found: usize,
    },
    /// An argument or the result has the wrong length.
    Length {
        /// The name of the function.
        function: &'static str,
        /// The argument's name, or `result`.
        name: &'static str,
        /// The required length.
        expected: usize,
        /// The given length.
        found: usize,
    },
    /// The length of an argument of a batch is no multiple of its length for one state.
    States {
        /// The name of the function.
        function: &'static str,
        /// The argument's name.
        name: &'static str,
        /// Its length for one state.
        one: usize,
        /// The given length.
        found: usize,
    },
    /// The function is one of a link and no link was given, or the other way round.
    Link {
        /// The name of the function.
        function: &'static str,
        /// The link that was given.
        link: Option<usize>,
        /// The number of links; `None` if the function is not one of a link.
        links: Option<usize>,
    },
}

impl fmt::Display for CallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotCompiled { function, compiled } => {
                write!(f, "`{function}` was not compiled; compiled were: {}", compiled.join(", "))
            }
            Self::NoBatch { function } => write!(
                f,
                "`{function}` was compiled for one state at a time; set `Options::batches`"
            ),
            Self::Arguments { function, expected, found: count } => {
                let expected = expected.join(", ");
                write!(f, "`{function}` takes the arguments {expected}, and {count} were given")
            }
            Self::Length { function, name, expected, found: length } => {
                write!(
                    f,
                    "`{name}` of `{function}` has {expected} numbers, and {length} were given"
                )
            }
            Self::States { function, name, one, found: length } => write!(
                f,
                "`{name}` of `{function}` has {one} numbers a state, and {length} are no multiple of that"
            ),
            Self::Link { function, link: Some(_), links: None } => {
                write!(f, "`{function}` is not about one link; call it without")
            }
            Self::Link { function, link: None, .. } => {
                write!(f, "`{function}` is about one link; call it with the link's index")
            }
            Self::Link { function, link: Some(link), links: Some(links) } => {
                write!(f, "`{function}` of link {link}: there are {links} links, the first is 0")
            }
        }
    }
}

impl std::error::Error for CallError {}
