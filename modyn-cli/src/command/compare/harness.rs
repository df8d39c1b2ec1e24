//! The program that runs generated code: written, compiled by rustc without Cargo, and run.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::Function;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::output::ORIGIN;
use modyn_runtime::model::Model;
use tempfile::TempDir;

use super::quantities::{Quantity, State};
use crate::command::outcome::{Failure, to_file};

/// The program's main file: it reads states, and writes results and times. Marks are replaced by
/// the robot's parts.
const MAIN: &str = include_str!("main.rs.txt");

/// The program measures time with the same code as the command.
const TIMING: &str = include_str!("timing.rs");

/// The compiler.
pub struct Rustc {
    path: OsString,
    /// The version, as rustc prints it.
    pub version: String,
}

/// Returns the compiler: the value of `RUSTC`, or `rustc`.
pub fn rustc() -> Result<Rustc, Failure> {
    let path = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(&path).arg("--version").output();
    match output {
        Ok(output) if output.status.success() => {
            let version = sanitize_for_display(String::from_utf8_lossy(&output.stdout).trim());
            Ok(Rustc { path, version })
        }
        other => {
            let why = match other {
                Ok(output) => sanitize_for_display(String::from_utf8_lossy(&output.stderr).trim()),
                Err(error) => error.to_string(),
            };
            let path = sanitize_for_display(&path.to_string_lossy());
            Err(Failure::usage(format!(
                "error: `compare` compiles the robot's code with rustc, and `{path}` cannot be run ({why})\n\
                 help: install Rust {} or later (rustup.rs), or set RUSTC to the path of a rustc",
                env!("CARGO_PKG_RUST_VERSION")
            )))
        }
    }
}

/// The inputs of the program.
pub struct Harness<'a> {
    pub rustc: &'a Rustc,
    pub robot: &'a str,
    pub type_name: &'a str,
    pub quantities: &'a [Quantity],
    pub native: bool,
    pub keep: Option<&'a Path>,
}

/// A compiled program; its folder is deleted with it, unless it is kept.
pub struct Program {
    program: PathBuf,
    states: PathBuf,
    /// The number of functions.
    functions: usize,
    _folder: Option<TempDir>,
}

impl Harness<'_> {
    /// Writes and compiles the program.
    pub fn compile(&self, model: &Model) -> Result<Program, Failure> {
        let cannot = |what: &str, error: &dyn std::fmt::Display| {
            Failure::usage(format!("error: {what}: {error}"))
        };
        let (folder, temporary) = match self.keep {
            Some(folder) => {
                let made = std::fs::create_dir_all(folder);
                made.map_err(|error| cannot("the folder cannot be made", &error))?;
                (folder.to_owned(), None)
            }
            None => {
                let created = tempfile::tempdir();
                let temporary =
                    created.map_err(|error| cannot("no temporary folder can be made", &error))?;
                (temporary.path().to_owned(), Some(temporary))
            }
        };
        let robot = folder.join("robot.rs");
        let main = folder.join("main.rs");
        to_file(&robot, self.robot, &[])?;
        let marked = |text: &str| format!("// {ORIGIN} compare.\n{text}");
        to_file(&main, &marked(&self.main(model)), &[])?;
        to_file(&folder.join("timing.rs"), &marked(TIMING), &[])?;
        let program = folder.join(format!("compare{}", std::env::consts::EXE_SUFFIX));
        let mut command = Command::new(&self.rustc.path);
        command.args([
            "--edition=2024",
            "--crate-name=compare",
            "-Copt-level=3",
            "-Ccodegen-units=1",
        ]);
        if self.native {
            command.arg("-Ctarget-cpu=native");
        }
        let run = command.arg("-o").arg(&program).arg(&main).output();
        let output = run.map_err(|error| cannot("rustc cannot be run", &error))?;
        if !output.status.success() {
            let kept = temporary.map(TempDir::keep).unwrap_or(folder);
            let errors = String::from_utf8_lossy(&output.stderr);
            let said: Vec<String> = errors.lines().take(40).map(sanitize_for_display).collect();
            return Err(Failure::Negative(format!(
                "{}\nerror: {} does not compile the generated code, which is kept in {}\n\
                 help: it needs Rust {} or later; if that is so, please report this with the description",
                said.join("\n"),
                self.rustc.version,
                sanitize_for_display(&kept.display().to_string()),
                env!("CARGO_PKG_RUST_VERSION"),
            )));
        }
        let states = folder.join("states.bin");
        let functions = self.quantities.len();
        Ok(Program { program, states, functions, _folder: temporary })
    }

    fn main(&self, model: &Model) -> String {
        let mut calls = String::new();
        for quantity in self.quantities {
            let call = &quantity.call;
            let _ = writeln!(calls, "    run(&states, |s| Robot::{call});");
        }
        let has = |function| self.quantities.iter().any(|one| one.function == function);
        // Only types that the self-contained file carries can be named.
        let mut types = String::new();
        if has(Function::LinkPoses) {
            types += "flat!(robot::runtime::spatial::Pose<f64>, rotation, translation);\n";
        }
        if has(Function::InverseDynamicsDerivatives) {
            types += "flat!(robot::runtime::InverseDynamicsDerivatives<[[f64; NV]; NV]>, dtau_dq, dtau_dqd);\n";
        }
        if has(Function::ForwardDynamicsDerivatives) {
            types += "flat!(robot::runtime::ForwardDynamicsDerivatives<[f64; NV], [[f64; NV]; \
                      NV]>, qdd, dqdd_dq, dqdd_dqd, dqdd_dtau);\n";
        }
        MAIN.replace("__ROBOT__", self.type_name)
            .replace("__NQ__", &model.nq().to_string())
            .replace("__NV__", &model.nv().to_string())
            .replace("// __TYPES__\n", &types)
            .replace("    // __CALLS__\n", &calls)
    }
}

/// The numbers of each state's result, and the time of a call in nanoseconds.
pub type Measured = (Vec<Vec<f64>>, f64);

impl Program {
    /// Runs the program on these states, and returns the results of each function.
    pub fn run(&self, states: &[State]) -> Result<Vec<Measured>, Failure> {
        let numbers = states.iter().flat_map(|State { q, qd, u }| q.iter().chain(qd).chain(u));
        let bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(&self.states, bytes).map_err(|error| {
            Failure::usage(format!("error: the states cannot be written: {error}"))
        })?;
        let run = Command::new(&self.program).arg(&self.states).output();
        let output = run.map_err(|error| {
            Failure::usage(format!("error: the compiled program cannot be run: {error}"))
        })?;
        if !output.status.success() {
            let said = sanitize_for_display(String::from_utf8_lossy(&output.stderr).trim());
            return Err(Failure::Negative(format!("error: the compiled program fails: {said}")));
        }
        let mut numbers = output
            .stdout
            .chunks_exact(8)
            .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or_default()));
        let mut next = || {
            numbers
                .next()
                .ok_or_else(|| Failure::Negative("error: the compiled program broke off".into()))
        };
        let mut all = Vec::new();
        for _ in 0..self.functions {
            let nanoseconds = next()?;
            let length = next()? as usize;
            let result = |next: &mut dyn FnMut() -> Result<f64, Failure>| {
                (0..length).map(|_| next()).collect::<Result<Vec<f64>, Failure>>()
            };
            let results: Result<Vec<_>, Failure> =
                states.iter().map(|_| result(&mut next)).collect();
            all.push((results?, nanoseconds));
        }
        Ok(all)
    }
}
