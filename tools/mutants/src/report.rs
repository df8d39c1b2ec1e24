//! The result of all runs.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

use crate::list;
use crate::run::{self, Verdict};
use crate::test::Outcome;
use crate::{Result, build};

/// Prints the counts, and the mutants that no test caught, by file.
pub fn report(folder: &Path) -> Result<()> {
    let mutants = list::read(folder)?;
    let dropped: BTreeSet<u32> = build::read_json(folder, "dropped.json")?;
    let not_selectable: Vec<u32> = build::read_json(folder, "not_selectable.json")?;
    // The last verdict counts, unless an earlier one caught the mutant.
    let mut verdicts: HashMap<u32, Verdict> = HashMap::new();
    for verdict in run::read_lines::<Verdict>(&folder.join("verdicts.jsonl"))? {
        let last = verdicts.entry(verdict.id).or_insert_with(|| verdict.clone());
        if last.caught.is_none() {
            *last = verdict;
        }
    }
    let ended = |outcome| {
        let with = |verdict: &&Verdict| verdict.caught.as_ref().is_some_and(|c| c.1 == outcome);
        verdicts.values().filter(with).count()
    };
    let survivors: Vec<_> = mutants
        .iter()
        .filter_map(|mutant| Some((mutant, verdicts.get(&mutant.id)?)))
        .filter(|(_, verdict)| verdict.caught.is_none())
        .collect();
    println!("{:5} listed", mutants.len());
    println!("{:5} do not compile", dropped.len());
    println!("{:5} cannot be selected at run time", not_selectable.len());
    println!("{:5} run", verdicts.len());
    println!("{:5} caught by failed tests", ended(Outcome::Failed));
    println!("{:5} caught by exceeding the time of a test", ended(Outcome::OutOfTime));
    println!("{:5} caught by an abort", ended(Outcome::Aborted));
    println!("{:5} not caught", survivors.len());
    let unreached = survivors.iter().filter(|(_, verdict)| verdict.reached_by == 0).count();
    println!("{unreached:5} of these reached by no test");
    let mut files: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (mutant, verdict) in survivors {
        let change = mutant.name.strip_prefix(&mutant.file).unwrap_or(&mutant.name);
        let Verdict { id, reached_by, ran, .. } = verdict;
        let line = format!("  {id} {change} (reached by {reached_by} tests, {ran} ran)");
        files.entry(&mutant.file).or_default().push(line);
    }
    for (file, lines) in files {
        println!("\n{file}: {}\n{}", lines.len(), lines.join("\n"));
    }
    Ok(())
}
