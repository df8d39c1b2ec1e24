//! Runs modyn's tests against mutants of its sources.
//!
//! `cargo mutants` lists the mutants. It would compile the workspace once for each of them. This tool builds all mutants
//! that compile into one copy of the sources, each selected at run time by its number in the environment variable
//! `MUTANT`: `a + b` becomes `match (a, b) { (l, r) => if mutant(17) { l - r } else { l + r } }`. One build then serves
//! every mutant. README.md says how to run it.

mod build;
mod list;
mod record;
mod report;
mod run;
mod scope;
mod test;
mod weave;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// The errors of a command, as text for the user.
type Result<T> = std::result::Result<T, String>;

const USAGE: &str = "\
usage: modyn-mutants COMMAND FOLDER [OPTION...]

  build FOLDER    list the mutants of the repository in the current folder, build those that compile into a copy of it,
                  and build the tests of that copy
  record FOLDER   run every test once and record which mutants it reaches, and its time
  run FOLDER      run the tests that reach a mutant until one fails, for each mutant that no earlier run caught
  report FOLDER   print the counts, and the mutants that were not caught, by file

options of `record` and `run`:
  --longest SECONDS   leave out tests that take longer (600; 0.25)

options of `run`:
  --shortest SECONDS  leave out tests that take less time (0)
  --budget SECONDS    processor time for each mutant (60)
  --cases N           random cases of a property test (6); 0 for the number that the test chooses
  --only TEXT         only mutants whose name (file, line, change) contains the text; can be repeated
  --hours HOURS       start no further mutant after this time (24)
  --processes N       the number of tests that run at a time (1)";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match command(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn command(arguments: &[String]) -> Result<()> {
    let [command, folder, options @ ..] = arguments else { return Err(USAGE.into()) };
    std::fs::create_dir_all(folder).map_err(|e| format!("{folder}: {e}"))?;
    let folder = &PathBuf::from(folder).canonicalize().map_err(|e| format!("{folder}: {e}"))?;
    match (command.as_str(), options) {
        ("build", []) => build::build(folder),
        ("record", options) => {
            // Slow tests can be recorded later, with a higher limit.
            let default = run::Options { longest: Duration::from_secs(600), ..Default::default() };
            record::record(folder, run_options(options, default)?.longest)
        }
        ("run", options) => run::run(folder, &run_options(options, run::Options::default())?),
        ("report", []) => report::report(folder),
        _ => Err(USAGE.into()),
    }
}

fn run_options(mut arguments: &[String], mut options: run::Options) -> Result<run::Options> {
    while let [name, value, rest @ ..] = arguments {
        let number = || value.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
        let number = || number().ok_or_else(|| format!("{name} {value}: not a number >= 0"));
        let time = || number().map(Duration::from_secs_f64);
        match name.as_str() {
            "--shortest" => options.shortest = time()?,
            "--longest" => options.longest = time()?,
            "--budget" => options.budget = time()?,
            "--cases" => options.cases = number()? as u32,
            "--only" => options.only.push(value.clone()),
            "--hours" => options.end = Duration::from_secs_f64(3600.0 * number()?),
            "--processes" => options.processes = (number()? as usize).max(1),
            _ => return Err(USAGE.into()),
        }
        arguments = rest;
    }
    if arguments.is_empty() { Ok(options) } else { Err(USAGE.into()) }
}
