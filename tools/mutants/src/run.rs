//! Runs tests against mutants.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::list::{self, Mutant};
use crate::record::{self, Reach};
use crate::test::{self, Binary, Outcome, Run, Test};
use crate::{Result, build};

/// The options of a run.
pub struct Options {
    /// Tests that take less time are left out.
    pub shortest: Duration,
    /// Tests that take longer are left out.
    pub longest: Duration,
    /// The processor time for one mutant.
    pub budget: Duration,
    /// The number of random cases of a property test; 0 for the number that the test chooses.
    pub cases: u32,
    /// Parts of the names of mutants; none for all mutants.
    pub only: Vec<String>,
    /// The time after which no further mutant is started.
    pub end: Duration,
    /// The number of tests that run at a time.
    pub processes: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            shortest: Duration::ZERO,
            longest: Duration::from_millis(250),
            budget: Duration::from_secs(60),
            cases: 6,
            only: Vec::new(),
            end: Duration::from_secs(24 * 3600),
            processes: 1,
        }
    }
}

/// The result of the tests of one mutant.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Verdict {
    /// The mutant.
    pub id: u32,
    /// The test that did not pass, and how it ended.
    pub caught: Option<(Test, Outcome)>,
    /// The number of tests that reach the mutant, also those that did not run.
    pub reached_by: usize,
    /// The number of tests that ran.
    pub ran: usize,
    /// The limit of this run in seconds: tests that take longer did not run.
    pub longest: f64,
}

/// What past tests of this run tell about the best order.
#[derive(Default)]
struct History {
    /// The mutants of each file that a test caught.
    caught: HashMap<(String, Test), f64>,
    /// The mutants that a test caught, and those against which it ran.
    rates: HashMap<Test, (f64, f64)>,
}

impl History {
    fn note(&mut self, file: &str, test: &Test, caught: bool) {
        let rate = self.rates.entry(test.clone()).or_default();
        rate.1 += 1.0;
        if caught {
            rate.0 += 1.0;
            *self.caught.entry((file.into(), test.clone())).or_default() += 1.0;
        }
    }

    /// Returns the expected number of mutants that a test catches in a second.
    fn value(&self, file: &str, reach: &Reach) -> f64 {
        let here = self.caught.get(&(file.to_string(), reach.test.clone())).copied();
        let (caught, ran) = self.rates.get(&reach.test).copied().unwrap_or_default();
        let rate = (caught + 10.0 * here.unwrap_or_default() + 1.0) / (ran + 2.0);
        rate / (reach.seconds + 0.05)
    }
}

/// Runs the tests that reach a mutant until one of them fails, for each mutant that no earlier run caught.
pub fn run(folder: &Path, options: &Options) -> Result<()> {
    let start = Instant::now();
    let binaries = test::binaries(folder)?;
    let binaries: HashMap<&str, &Binary> = binaries.iter().map(|b| (b.name.as_str(), b)).collect();
    // The record may have tests of binaries that have been removed since.
    let mut reaches = record::read(folder)?;
    reaches.retain(|reach| binaries.contains_key(reach.test.binary.as_str()));
    let mutants = list::read(folder)?;
    let mut history = History::default();
    let mut caught = HashSet::new();
    let path = folder.join("verdicts.jsonl");
    for Verdict { id, caught: by, .. } in read_lines(&path)? {
        if let Some((test, _)) = by {
            history.note(&mutants[id as usize - 1].file, &test, true);
            caught.insert(id);
        }
    }
    let file = File::options().create(true).append(true).open(&path);
    let file = Mutex::new(file.map_err(|e| format!("{}: {e}", path.display()))?);
    let history = Mutex::new(history);
    let skipped = unbuilt(folder)?;
    let wanted = |mutant: &&Mutant| {
        let named = |text: &String| mutant.name.contains(text);
        (options.only.is_empty() || options.only.iter().any(named))
            && !skipped.contains(&mutant.id)
            && !caught.contains(&mutant.id)
    };
    let mut queue: Vec<&Mutant> = mutants.iter().filter(wanted).collect();
    println!("{} mutants", queue.len());
    queue.reverse();
    let queue = Mutex::new(queue);
    let work = || {
        while start.elapsed() < options.end {
            let Some(mutant) = queue.lock().expect("not poisoned").pop() else { break };
            let verdict = judge(mutant, options, &reaches, &binaries, &history)?;
            let line = serde_json::to_string(&verdict).map_err(|e| e.to_string())?;
            let mut file = file.lock().expect("not poisoned");
            writeln!(file, "{line}").map_err(|e| format!("{}: {e}", path.display()))?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..options.processes).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().expect("no panic"))
    })
}

/// Runs the tests of one mutant.
fn judge(
    mutant: &Mutant,
    options: &Options,
    reaches: &[Reach],
    binaries: &HashMap<&str, &Binary>,
    history: &Mutex<History>,
) -> Result<Verdict> {
    let reaching: Vec<&Reach> =
        reaches.iter().filter(|reach| reach.mutants.contains(&mutant.id)).collect();
    let mut verdict = Verdict {
        id: mutant.id,
        caught: None,
        reached_by: reaching.len(),
        ran: 0,
        longest: options.longest.as_secs_f64(),
    };
    let (shortest, longest) = (options.shortest.as_secs_f64(), options.longest.as_secs_f64());
    let mut left: Vec<&Reach> = reaching;
    left.retain(|reach| (shortest..=longest).contains(&reach.seconds));
    {
        let history = history.lock().expect("not poisoned");
        let value = |reach: &Reach| history.value(&mutant.file, reach);
        left.sort_by(|a, b| value(b).total_cmp(&value(a)));
    }
    let mut spent = Duration::ZERO;
    for reach in left {
        if spent > options.budget {
            break;
        }
        let before = Instant::now();
        let limit = Duration::from_secs_f64(10.0 + 8.0 * reach.seconds);
        // With all random cases, a test takes far longer than recorded.
        let limit = if options.cases == 0 { limit + Duration::from_secs(120) } else { limit };
        let run = Run { mutant: mutant.id, cases: options.cases, seen: None, limit };
        let outcome = binaries[reach.test.binary.as_str()].run(&reach.test.name, &run)?;
        spent += before.elapsed();
        verdict.ran += 1;
        let failed = outcome != Outcome::Passed;
        history.lock().expect("not poisoned").note(&mutant.file, &reach.test, failed);
        if failed {
            verdict.caught = Some((reach.test.clone(), outcome));
            break;
        }
    }
    Ok(verdict)
}

/// Returns the mutants that are in no test binary.
pub fn unbuilt(folder: &Path) -> Result<HashSet<u32>> {
    let mut all: HashSet<u32> = build::read_json(folder, "dropped.json")?;
    all.extend(build::read_json::<Vec<u32>>(folder, "not_selectable.json")?);
    Ok(all)
}

/// Reads a file with a value of JSON in each line; none if there is no file.
pub fn read_lines<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<Vec<T>> {
    let text = match fs::read_to_string(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        text => text.map_err(|e| format!("{}: {e}", path.display()))?,
    };
    let lines = text.lines().map(serde_json::from_str).collect::<serde_json::Result<_>>();
    lines.map_err(|e| format!("{}: {e}", path.display()))
}
