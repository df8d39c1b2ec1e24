//! Suggestions for misspelt names.

use crate::work;

/// Returns the candidate that differs from `name` by one or two letters; the first of equally close
/// ones.
pub fn suggest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name: Vec<char> = name.chars().flat_map(char::to_lowercase).take(80).collect();
    let allowed = if name.len() < 4 { 1 } else { 2 };
    let mut best = None;
    for candidate in candidates {
        work::count(1);
        let other: Vec<char> = candidate.chars().flat_map(char::to_lowercase).take(80).collect();
        if name.len().abs_diff(other.len()) > allowed {
            continue;
        }
        let distance = distance(&name, &other);
        if distance <= allowed && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// Suggestions for the first misspelt names of a file. Each is a search through all names, so their
/// number is limited.
pub struct Suggestions(usize);

impl Suggestions {
    pub fn new() -> Self {
        Self(20)
    }

    /// Returns the same as [`suggest`]; `None` after the limit.
    pub fn suggest<'a>(
        &mut self,
        name: &str,
        candidates: impl IntoIterator<Item = &'a str>,
    ) -> Option<&'a str> {
        self.0 = self.0.checked_sub(1)?;
        suggest(name, candidates)
    }
}

/// Returns the number of letters to insert, delete or replace.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
