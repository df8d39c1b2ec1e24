//! The outcome of a command, and its output.

use std::fmt;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::diagnostics::{Code, Diagnostics};

use crate::command::description::Description;
use crate::command::diagnostics;

/// The reason why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// Diagnostics of the compiler about a description or about the options.
    Diagnostics(Diagnostics, Option<Description>),
    /// A negative result.
    Negative(String),
    /// The command line or a file is invalid.
    Usage(String),
    /// A negative result that was printed already.
    Reported,
}

impl Failure {
    /// Returns the failure of an invalid command line or file.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self::Usage(message.to_string())
    }

    /// Prints the failure, and returns the exit code.
    pub fn report(&self) -> ExitCode {
        let text = match self {
            Self::Diagnostics(found, description) => {
                diagnostics::render(found.as_slice(), description.as_ref())
            }
            Self::Negative(message) | Self::Usage(message) => format!("{message}\n"),
            Self::Reported => String::new(),
        };
        to_stderr(&text);
        ExitCode::from(self.code())
    }

    fn code(&self) -> u8 {
        match self {
            Self::Diagnostics(found, _) => {
                let options = [
                    Code::MissingFile,
                    Code::Gravity,
                    Code::Modules,
                    Code::RuntimeInertia,
                    Code::Payload,
                    Code::TypeName,
                    Code::Option,
                    Code::Output,
                ];
                if found.iter().all(|one| options.contains(&one.code)) { 2 } else { 1 }
            }
            Self::Negative(_) | Self::Reported => 1,
            Self::Usage(_) => 2,
        }
    }
}

/// Writes to standard output, with colours on terminals. A broken pipe is not an error.
pub fn to_stdout(text: &str) -> Result<(), Failure> {
    let mut out = anstream::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::usage(format!("error: standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes to standard error, with colours on terminals.
pub fn to_stderr(text: &str) {
    // There is no other place to report an error.
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}

/// Writes a file.
pub fn to_file(path: &Path, content: &(impl AsRef<[u8]> + ?Sized)) -> Result<(), Failure> {
    std::fs::write(path, content).map_err(|error| {
        let path = sanitize_for_display(&path.display().to_string());
        Failure::usage(format!("error: `{path}` cannot be written: {error}"))
    })
}
