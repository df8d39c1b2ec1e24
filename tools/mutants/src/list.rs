//! The list of mutants, as cargo-mutants writes it.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde::Deserialize;

use crate::{Result, scope};

/// A mutant.
#[derive(Clone, Debug, Deserialize)]
pub struct Mutant {
    /// The number that selects the mutant: its place in the list, from 1 on.
    #[serde(skip)]
    pub id: u32,
    /// The file, relative to the repository.
    pub file: String,
    /// The file, the place and the change, in words.
    pub name: String,
    /// The kind of the change: `BinaryOperator`, `FnValue`, ...
    pub genre: String,
    /// The operator or expression that replaces the original one.
    pub replacement: String,
    /// The place of the replaced text.
    pub span: Span,
}

impl Mutant {
    /// Returns whether another mutant is the same change, perhaps at another place of the file.
    pub fn is_same_change(&self, other: &Self) -> bool {
        let change = |m: &Self| (m.file.clone(), m.genre.clone(), m.replacement.clone());
        change(self) == change(other)
    }
}

/// A range of a file.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Span {
    /// The first character.
    pub start: Position,
    /// The character after the last one.
    pub end: Position,
}

/// A position in a file. Lines and columns count from 1, columns in characters.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Hash)]
pub struct Position {
    /// The line.
    pub line: usize,
    /// The column.
    pub column: usize,
}

/// Lists the mutants of the repository in the current folder and writes the list into `folder`.
pub fn write(folder: &Path) -> Result<()> {
    let mut command = Command::new("cargo");
    command.args(["mutants", "--list", "--json"]);
    command.args(scope::PACKAGES.iter().flat_map(|package| ["-p", package]));
    command.args(scope::SOURCES.iter().flat_map(|source| ["-f", source]));
    let output = command.output().map_err(|e| format!("cargo mutants: {e}"))?;
    if !output.status.success() {
        return Err(format!("cargo mutants --list: {}", String::from_utf8_lossy(&output.stderr)));
    }
    fs::write(folder.join("list.json"), output.stdout).map_err(|e| format!("list.json: {e}"))
}

/// Reads the list of `folder`.
pub fn read(folder: &Path) -> Result<Vec<Mutant>> {
    let text =
        fs::read_to_string(folder.join("list.json")).map_err(|e| format!("list.json: {e}"))?;
    let mut list: Vec<Mutant> =
        serde_json::from_str(&text).map_err(|e| format!("list.json: {e}"))?;
    for (id, mutant) in (1..).zip(&mut list) {
        mutant.id = id;
    }
    Ok(list)
}
