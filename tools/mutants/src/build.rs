//! Builds a copy of the repository with all mutants that compile, and its tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde::Deserialize;

use crate::list::{self, Mutant};
use crate::weave::{Woven, weave};
use crate::{Result, scope, test};

const SELECTION: &str = include_str!("mutant.rs.in");

/// Lists the mutants of the repository in the current folder, builds all that compile into a copy, and builds its tests.
///
/// If a former call has built the same mutants, those that did not compile are known.
pub fn build(folder: &Path) -> Result<()> {
    let former = list::read(folder).unwrap_or_default();
    list::write(folder)?;
    let mutants = list::read(folder)?;
    let copy = folder.join("sources");
    copy_repository(&copy, &mutants)?;
    let known = mutants.len() == former.len()
        && mutants.iter().zip(&former).all(|(mutant, former)| mutant.is_same_change(former));
    let mut dropped: BTreeSet<u32> =
        if known { read_json(folder, "dropped.json").unwrap_or_default() } else { BTreeSet::new() };
    let woven = loop {
        let woven = weave_all(&copy, &mutants, &dropped)?;
        let failing = check(folder, &copy, &woven)?;
        if failing.is_empty() {
            break woven;
        }
        println!("{} mutants do not compile", failing.len());
        dropped.extend(failing);
        write_json(folder, "dropped.json", &dropped)?;
    };
    let not_selectable: Vec<u32> =
        woven.iter().flat_map(|(_, woven)| &woven.not_selectable).copied().collect();
    println!(
        "{} mutants: {} do not compile, {} cannot be selected at run time",
        mutants.len(),
        dropped.len(),
        not_selectable.len()
    );
    write_json(folder, "dropped.json", &dropped)?;
    write_json(folder, "not_selectable.json", &not_selectable)?;
    test::build(folder, &copy)
}

/// Returns a command of cargo in the copy of the repository.
pub fn cargo(folder: &Path, copy: &Path, arguments: &[&str]) -> Result<Output> {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(copy);
    command.env("CARGO_TARGET_DIR", folder.join("target"));
    // The texts of mutants draw warnings: parentheses, code that is not reached.
    command.env("RUSTFLAGS", "--cap-lints=allow");
    command.output().map_err(|e| format!("cargo: {e}"))
}

/// Writes a value as JSON into the folder.
pub fn write_json(folder: &Path, name: &str, value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string(value).map_err(|e| format!("{name}: {e}"))?;
    fs::write(folder.join(name), text).map_err(|e| format!("{name}: {e}"))
}

/// Reads a value as JSON from the folder.
pub fn read_json<T: for<'a> Deserialize<'a>>(folder: &Path, name: &str) -> Result<T> {
    let text = fs::read_to_string(folder.join(name)).map_err(|e| format!("{name}: {e}"))?;
    serde_json::from_str(&text).map_err(|e| format!("{name}: {e}"))
}

/// Copies the files that git tracks, as they are in the working tree, but for those with mutants. The library gets the
/// function that tells which mutant is selected.
fn copy_repository(copy: &Path, mutants: &[Mutant]) -> Result<()> {
    let mutated: BTreeSet<&str> = mutants.iter().map(|mutant| mutant.file.as_str()).collect();
    let library = format!("{}/src/lib.rs", scope::LIBRARY.0);
    let files = Command::new("git").args(["ls-files", "-z"]).output();
    let files = files.map_err(|e| format!("git ls-files: {e}"))?.stdout;
    for file in String::from_utf8_lossy(&files).split_terminator('\0') {
        if mutated.contains(file) {
            continue;
        }
        let mut content = fs::read(file).map_err(|e| format!("{file}: {e}"))?;
        if file == library {
            content.extend(SELECTION.replace("COUNT", &(mutants.len() + 1).to_string()).bytes());
        }
        update(&copy.join(file), &content)?;
    }
    Ok(())
}

/// Writes a file unless it has this content: cargo builds what is newer than its last build.
fn update(file: &Path, content: &[u8]) -> Result<()> {
    if fs::read(file).is_ok_and(|old| old == content) {
        return Ok(());
    }
    let folder = file.parent().expect("a file is in a folder");
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(file, content));
    written.map_err(|e| format!("{}: {e}", file.display()))
}

/// Writes all sources with their mutants.
fn weave_all(
    copy: &Path,
    mutants: &[Mutant],
    dropped: &BTreeSet<u32>,
) -> Result<Vec<(String, Woven)>> {
    let mut files: BTreeMap<&str, Vec<Mutant>> = BTreeMap::new();
    for mutant in mutants {
        files.entry(&mutant.file).or_default().push(mutant.clone());
    }
    let mut all = Vec::new();
    for (file, mutants) in files {
        let source = fs::read_to_string(file).map_err(|e| format!("{file}: {e}"))?;
        let (folder, name) = scope::LIBRARY;
        let root = if file.starts_with(&format!("{folder}/")) { "crate" } else { name };
        let woven = weave(&source, &mutants, dropped, &format!("{root}::__mutant"))
            .map_err(|e| format!("{file}: {e}"))?;
        update(&copy.join(file), woven.text.as_bytes())?;
        all.push((file.to_string(), woven));
    }
    Ok(all)
}

#[derive(Deserialize)]
struct Message {
    message: Option<Error>,
}

#[derive(Deserialize)]
struct Error {
    level: String,
    code: Option<Code>,
    rendered: Option<String>,
    spans: Vec<ErrorSpan>,
}

#[derive(Deserialize)]
struct Code {
    code: String,
}

#[derive(Clone, Deserialize)]
struct ErrorSpan {
    file_name: String,
    byte_start: usize,
    byte_end: usize,
    is_primary: bool,
    text: Vec<Line>,
    expansion: Option<Box<Expansion>>,
}

#[derive(Clone, Deserialize)]
struct Line {
    text: String,
}

#[derive(Clone, Deserialize)]
struct Expansion {
    span: ErrorSpan,
}

impl ErrorSpan {
    /// Returns the place outside of macros.
    fn outermost(&self) -> &Self {
        self.expansion.as_ref().map_or(self, |expansion| expansion.span.outermost())
    }

    /// Returns the mutants of the shortest of the ranges that contain the place.
    fn mutants<'a>(
        &self,
        woven: &'a [(String, Woven)],
        ranges: impl Fn(&'a Woven) -> &'a [(std::ops::Range<usize>, Vec<u32>)],
    ) -> &'a [u32] {
        let file = woven.iter().find(|(file, _)| self.file_name.ends_with(file));
        let ranges = file.map_or(&[][..], |(_, woven)| ranges(woven)).iter();
        let around = ranges.filter(|(r, _)| r.start <= self.byte_start && self.byte_end <= r.end);
        around.min_by_key(|(range, _)| range.len()).map_or(&[], |(_, mutants)| mutants)
    }
}

/// Returns the mutants that the compiler refuses. They are those in whose replacement an error is, else those of the
/// expression around the error, else those of its lines. If a match is not exhaustive, they are those that delete its arms.
fn check(folder: &Path, copy: &Path, woven: &[(String, Woven)]) -> Result<BTreeSet<u32>> {
    for tests in scope::TESTS.iter().take(scope::PACKAGES.len()) {
        let arguments = [&["check", "--message-format=json"], tests.package].concat();
        let output = cargo(folder, copy, &arguments)?;
        if output.status.success() {
            continue;
        }
        let mut failing = BTreeSet::new();
        let mut elsewhere = String::new();
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            let Ok(Message { message: Some(error) }) = serde_json::from_str(line) else { continue };
            if error.level != "error" || error.spans.is_empty() {
                continue;
            }
            let mut spans: Vec<&ErrorSpan> = error.spans.iter().collect();
            spans.sort_by_key(|span| !span.is_primary);
            let spans = || spans.iter().map(|span| span.outermost());
            // A match is no longer exhaustive.
            let of_arms = error.code.is_some_and(|code| code.code == "E0004");
            let found = spans()
                .map(|span| if of_arms { span.mutants(woven, |w| &w.matches) } else { &[] })
                .chain(spans().map(|span| span.mutants(woven, |w| &w.replacements)))
                .chain(spans().map(|span| span.mutants(woven, |w| &w.expressions)))
                .find(|mutants| !mutants.is_empty());
            match found {
                Some(mutants) => failing.extend(mutants),
                None => {
                    let before = failing.len();
                    failing.extend(spans().flat_map(|span| &span.text).flat_map(numbers));
                    if failing.len() == before {
                        elsewhere += &error.rendered.unwrap_or_default();
                    }
                }
            }
        }
        return if failing.is_empty() {
            Err(format!("{elsewhere}\n{}", String::from_utf8_lossy(&output.stderr)))
        } else {
            Ok(failing)
        };
    }
    Ok(BTreeSet::new())
}

/// Returns the numbers of the mutants in a line.
fn numbers(line: &Line) -> impl Iterator<Item = u32> + '_ {
    let calls = line.text.split("__mutant(").skip(1);
    calls.filter_map(|rest| rest.split(')').next()?.parse().ok())
}
