//! Names of which no two are equal.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::work;

/// The names that are taken.
#[derive(Default)]
pub struct TakenNames {
    taken: FxHashSet<String>,
    /// The next number to try after a name and an ending.
    numbers: FxHashMap<String, usize>,
}

impl TakenNames {
    /// Returns the names with these taken.
    pub fn new<'n>(names: impl Iterator<Item = &'n str>) -> Self {
        Self { taken: names.map(String::from).collect(), numbers: FxHashMap::default() }
    }

    /// Returns a name that is not taken: this one, or with an ending. It is taken then.
    pub fn unique(&mut self, name: &str, ending: &str) -> String {
        let with_ending = format!("{name}_{ending}");
        for free in [name, &with_ending] {
            if self.taken.insert(free.to_owned()) {
                return free.to_owned();
            }
        }
        self.numbered(&with_ending, 2)
    }

    /// Returns a name that is not taken: this one with a number from `first` on. It is taken then.
    pub fn numbered(&mut self, name: &str, first: usize) -> String {
        // Each number is tried once, so that equal names take linear time.
        let next = self.numbers.entry(name.to_owned()).or_insert(first);
        *next = first.max(*next);
        loop {
            work::count(1);
            let numbered = format!("{name}_{next}");
            *next += 1;
            if self.taken.insert(numbered.clone()) {
                return numbered;
            }
        }
    }
}
