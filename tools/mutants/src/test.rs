//! The test binaries, and how one test runs within limits.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use serde::{Deserialize, Serialize};

use crate::build::{cargo, read_json, write_json};
use crate::{Result, scope};

/// A binary with tests.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Binary {
    /// The package and the target.
    pub name: String,
    /// The executable.
    pub path: PathBuf,
    /// The folder of its package, where its tests run.
    pub package: PathBuf,
}

/// A test of a binary.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Test {
    /// The name of its binary.
    pub binary: String,
    /// The path of the test.
    pub name: String,
}

/// How a test ended.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Outcome {
    /// The test passed.
    Passed,
    /// The test failed.
    Failed,
    /// The test exceeded its time.
    OutOfTime,
    /// The process was ended by another signal, such as that of an abort.
    Aborted,
}

/// The environment of a run.
pub struct Run<'a> {
    /// The selected mutant; 0 for none.
    pub mutant: u32,
    /// The number of random cases; 0 for the number that the test chooses.
    pub cases: u32,
    /// The file for the numbers of the mutants that are reached.
    pub seen: Option<&'a Path>,
    /// The limit of processor time.
    pub limit: Duration,
}

#[derive(Deserialize)]
struct Artifact {
    executable: Option<PathBuf>,
    manifest_path: PathBuf,
    profile: Profile,
    target: Target,
}

#[derive(Deserialize)]
struct Profile {
    test: bool,
}

#[derive(Deserialize)]
struct Target {
    name: String,
    kind: Vec<String>,
}

/// Builds the tests and writes the list of binaries.
pub fn build(folder: &Path, copy: &Path) -> Result<()> {
    let mut binaries: Vec<Binary> = Vec::new();
    for tests in scope::TESTS {
        let start = ["test", "--no-run", "--message-format=json"];
        let arguments = [&start, tests.package, tests.binaries].concat();
        let output = cargo(folder, copy, &arguments)?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            let Ok(artifact) = serde_json::from_str::<Artifact>(line) else { continue };
            let (true, Some(path)) = (artifact.profile.test, artifact.executable) else { continue };
            let package = artifact.manifest_path.parent().expect("a package has a folder");
            let short = package.file_name().expect("a name").to_string_lossy();
            let unit = if artifact.target.kind == ["test"] { "" } else { " (unit tests)" };
            let name = format!("{short}/{}{unit}", artifact.target.name);
            binaries.push(Binary { name, path, package: package.into() });
        }
    }
    println!("{} test binaries", binaries.len());
    write_json(folder, "binaries.json", &binaries)
}

/// Reads the list of binaries.
pub fn binaries(folder: &Path) -> Result<Vec<Binary>> {
    read_json(folder, "binaries.json")
}

impl Binary {
    /// Lists the tests that are not ignored.
    pub fn tests(&self) -> Result<Vec<Test>> {
        let list = |more: &[&str]| {
            let mut command = Command::new(&self.path);
            command.args(["--list", "--format", "terse"]).args(more).current_dir(&self.package);
            let output = command.output().map_err(|e| format!("{}: {e}", self.name))?;
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            let names = text.lines().filter_map(|line| line.strip_suffix(": test"));
            Ok::<_, String>(names.map(String::from).collect::<Vec<_>>())
        };
        let ignored = list(&["--ignored"])?;
        let tests = list(&[])?.into_iter().filter(|name| !ignored.contains(name));
        Ok(tests.map(|name| Test { binary: self.name.clone(), name }).collect())
    }

    /// Runs a test and returns how it ended.
    pub fn run(&self, test: &str, run: &Run<'_>) -> Result<Outcome> {
        // The shell sets limits that the process inherits: no core files, 6 GB of memory, and the time.
        let seconds = run.limit.as_secs().max(1);
        let limits = format!("ulimit -c 0; ulimit -v 6291456; ulimit -t {seconds}; exec \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &limits, "sh"]).arg(&self.path);
        command.args(["--exact", test, "--test-threads=1"]).current_dir(&self.package);
        command.env("MUTANT", run.mutant.to_string()).env("CARGO_MANIFEST_DIR", &self.package);
        command.env("RUST_BACKTRACE", "0").env("RAYON_NUM_THREADS", "1");
        command.env("PROPTEST_MAX_SHRINK_ITERS", "0").env("PROPTEST_FAILURE_PERSISTENCE", "off");
        match run.cases {
            0 => command.env_remove("PROPTEST_CASES"),
            cases => command.env("PROPTEST_CASES", cases.to_string()),
        };
        match run.seen {
            None => command.env_remove("MUTANTS_SEEN"),
            Some(file) => command.env("MUTANTS_SEEN", file),
        };
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| format!("{}: {e}", self.name))?;
        // A test that waits uses no processor time.
        let end = Instant::now() + 20 * run.limit + Duration::from_secs(60);
        let mut pause = Duration::from_millis(1);
        loop {
            if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
                return Ok(match status.code() {
                    Some(0) => Outcome::Passed,
                    Some(_) => Outcome::Failed,
                    None => match std::os::unix::process::ExitStatusExt::signal(&status) {
                        // SIGXCPU and SIGKILL, the two limits of processor time.
                        Some(24 | 9) => Outcome::OutOfTime,
                        _ => Outcome::Aborted,
                    },
                });
            }
            if Instant::now() > end {
                child.kill().and_then(|()| child.wait()).map_err(|e| e.to_string())?;
                return Ok(Outcome::OutOfTime);
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(20));
        }
    }
}

/// Returns the processor time of all processes that have ended.
pub fn processor_time() -> Duration {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the usage of children");
    let microseconds =
        usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
    Duration::from_micros(microseconds.unsigned_abs())
}
