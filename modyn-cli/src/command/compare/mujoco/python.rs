//! MuJoCo in a Python process.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use modyn_codegen::diagnostics::sanitize_for_display;
use serde_json::Value;

use crate::command::outcome::Failure;

/// The program that the process runs.
const SCRIPT: &str = include_str!("steps.py");

/// The exit code of the program without the package `mujoco`.
const WITHOUT_MUJOCO: i32 = 3;

/// The Python that is run by default.
const DEFAULT: &str = if cfg!(windows) { "python" } else { "python3" };

/// A process that has a scene in MuJoCo.
pub struct Process {
    name: String,
    child: Child,
    output: BufReader<ChildStdout>,
}

impl Process {
    /// Starts the program, and returns the process with the description of the scene.
    pub fn start(python: Option<&Path>, scene: &Path) -> Result<(Self, Value), Failure> {
        let python = python.unwrap_or(Path::new(DEFAULT));
        let name = sanitize_for_display(&python.display().to_string());
        let mut command = Command::new(python);
        command.args(["-c", SCRIPT]).arg(scene);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let cannot = |why: String| {
            Failure::usage(format!(
                "error: `--mujoco` runs MuJoCo in Python, and `{name}` cannot be run ({why})\n\
                 help: install Python 3 and its package `mujoco` (`pip install mujoco`), or name a Python that \
                 has the package: `--python PATH`"
            ))
        };
        let mut child = command.spawn().map_err(|error| cannot(error.to_string()))?;
        let output = child.stdout.take().ok_or_else(|| cannot("it has no output".into()))?;
        let mut process = Self { name, child, output: BufReader::new(output) };
        let described = process.line()?;
        if let Some(error) = described["error"].as_str() {
            let error = sanitize_for_display(error.trim());
            return Err(Failure::Negative(format!(
                "error: MuJoCo does not read the file: {error}"
            )));
        }
        Ok((process, described))
    }

    /// Sends a line of JSON, and returns the answer.
    pub fn ask(mut self, question: &Value) -> Result<Value, Failure> {
        // A process that has ended is found by its missing answer.
        if let Some(mut input) = self.child.stdin.take() {
            let _ = writeln!(input, "{question}");
        }
        let answer = self.line()?;
        let _ = self.child.wait();
        Ok(answer)
    }

    /// Returns the next line of the output.
    fn line(&mut self) -> Result<Value, Failure> {
        let mut line = String::new();
        let read = self.output.read_line(&mut line);
        match serde_json::from_str(&line) {
            Ok(value) if read.is_ok() => Ok(value),
            _ => Err(self.failure()),
        }
    }

    /// Returns the failure of a process that ended without an answer.
    fn failure(&mut self) -> Failure {
        let name = &self.name;
        drop(self.child.stdin.take());
        let mut said = String::new();
        if let Some(errors) = &mut self.child.stderr {
            // What cannot be read is not shown.
            let _ = errors.read_to_string(&mut said);
        }
        let code = self.child.wait().ok().and_then(|status| status.code());
        if code == Some(WITHOUT_MUJOCO) {
            return Failure::usage(format!(
                "error: `{name}` does not have the package `mujoco`\n\
                 help: `{name} -m pip install mujoco`, or name a Python that has the package: `--python PATH`"
            ));
        }
        let last = sanitize_for_display(said.trim().lines().last().unwrap_or("it says nothing"));
        Failure::usage(format!("error: MuJoCo in `{name}` fails: {last}"))
    }
}
