//! Which tests reach which mutants.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::test::{self, Outcome, Run, Test};
use crate::{Result, run};

/// A test that passes without a mutant.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Reach {
    /// The test.
    pub test: Test,
    /// The processor time in seconds, with few random cases.
    pub seconds: f64,
    /// The mutants that it reaches.
    pub mutants: BTreeSet<u32>,
}

/// Runs every test twice without a mutant: once to record the mutants that it reaches, once for its time. Tests that a
/// former call has recorded do not run. Tests that take longer than `longest` are left out.
pub fn record(folder: &Path, longest: Duration) -> Result<()> {
    let recorded: BTreeSet<Test> = read(folder)?.into_iter().map(|reach| reach.test).collect();
    let path = folder.join("record.jsonl");
    let file = File::options().create(true).append(true).open(&path);
    let mut file = file.map_err(|e| format!("{}: {e}", path.display()))?;
    let seen = &folder.join("seen");
    for binary in test::binaries(folder)? {
        for test in binary.tests()? {
            if recorded.contains(&test) {
                continue;
            }
            let _ = fs::remove_file(seen);
            let mut run = Run {
                mutant: 0,
                cases: run::Options::default().cases,
                seen: Some(seen),
                limit: longest,
            };
            let outcome = binary.run(&test.name, &run)?;
            run.seen = None;
            let before = test::processor_time();
            let outcomes = match outcome {
                Outcome::Passed => [outcome, binary.run(&test.name, &run)?],
                _ => [outcome; 2],
            };
            if let Some(outcome) = outcomes.iter().find(|outcome| **outcome != Outcome::Passed) {
                println!("{} {}, without a mutant: {outcome:?}; left out", binary.name, test.name);
                continue;
            }
            let seconds = (test::processor_time() - before).as_secs_f64();
            let mutants = fs::read_to_string(seen).unwrap_or_default();
            let mutants = mutants.lines().filter_map(|id| id.parse().ok()).collect();
            let line = serde_json::to_string(&Reach { test, seconds, mutants });
            let line = line.map_err(|e| e.to_string())?;
            writeln!(file, "{line}").map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    Ok(())
}

/// Reads the tests that are recorded.
pub fn read(folder: &Path) -> Result<Vec<Reach>> {
    run::read_lines(&folder.join("record.jsonl"))
}
