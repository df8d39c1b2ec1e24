//! The outcome of a command, and its output.

use std::fmt;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::diagnostics::{Code, Diagnostics};
use modyn_codegen::output::{Replaces, check_place, write_file};

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
            Self::Diagnostics(diagnostics, description) => {
                diagnostics::render(diagnostics.as_slice(), description.as_ref())
            }
            Self::Negative(message) | Self::Usage(message) => format!("{message}\n"),
            Self::Reported => String::new(),
        };
        to_stderr(&text);
        ExitCode::from(self.code())
    }

    fn code(&self) -> u8 {
        match self {
            Self::Diagnostics(diagnostics, _) => {
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
                if diagnostics.iter().all(|one| options.contains(&one.code)) { 2 } else { 1 }
            }
            Self::Negative(_) | Self::Reported => 1,
            Self::Usage(_) => 2,
        }
    }
}

/// Writes to standard output, with colours on terminals. A broken pipe is not an error.
pub fn to_stdout(text: &str) -> Result<(), Failure> {
    written(anstream::stdout().lock(), text.as_bytes())
}

fn written(mut out: impl Write, content: &[u8]) -> Result<(), Failure> {
    match out.write_all(content).and_then(|()| out.flush()) {
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

/// Writes a text, or to standard output for `-`. None of the `inputs` is overwritten, nor a text
/// that modyn did not write.
pub fn to_file(path: &Path, text: &str, inputs: &[PathBuf]) -> Result<(), Failure> {
    write_all(&[Written { path, content: text.as_bytes(), replaces: Replaces::Written }], inputs)
}

/// A file to be written.
pub struct Written<'a> {
    pub path: &'a Path,
    pub content: &'a [u8],
    pub replaces: Replaces,
}

/// Writes files, or to standard output for `-`, once all of them may be written.
pub fn write_all(files: &[Written], inputs: &[PathBuf]) -> Result<(), Failure> {
    for file in files {
        may_write(file.path, inputs, file.replaces)?;
    }
    for file in files {
        if is_stdout(file.path) {
            written(std::io::stdout().lock(), file.content)?;
        } else {
            write_file(file.path, file.content, inputs, file.replaces)
                .map_err(|error| cannot_be_written(file.path, &error))?;
        }
    }
    Ok(())
}

/// Checks that a file may be written, before the work for it.
pub fn may_write(path: &Path, inputs: &[PathBuf], replaces: Replaces) -> Result<(), Failure> {
    if is_stdout(path) {
        return Ok(());
    }
    check_place(path, inputs, replaces).map_err(|error| cannot_be_written(path, &error))
}

fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

fn cannot_be_written(path: &Path, error: &std::io::Error) -> Failure {
    let path = sanitize_for_display(&path.display().to_string());
    Failure::usage(format!("error: `{path}` cannot be written: {error}"))
}
