//! The places of numbers in the records of bodies. Numbers that are needed in different sweeps
//! share a place.

use std::collections::{BTreeMap, BTreeSet};

use modyn_runtime::equations::dynamics::Sweep;

use super::cut::{Kind, Number};
use crate::graph::Id;

/// The places of the numbers of one kind's records.
pub(super) struct Slots {
    /// The places of the numbers between bodies, which all kinds share.
    exchanged: BTreeMap<(usize, usize), usize>,
    kept: BTreeMap<Id, usize>,
}

/// Returns the places for each kind, and the length of a record. `needed` are the numbers between
/// bodies that some body reads.
pub(super) fn slots(
    kinds: &[Kind],
    sweeps: &[(Sweep, usize)],
    needed: &BTreeSet<(usize, usize)>,
) -> (Vec<Slots>, usize) {
    let mut shared = Taken::default();
    let exchanged: BTreeMap<(usize, usize), usize> = needed
        .iter()
        .map(|&(sweep, k)| {
            // The sum of an inward sweep begins in the sweep before.
            let first = if sweeps[sweep].0 == Sweep::Inward { sweep - 1 } else { sweep };
            ((sweep, k), shared.take(first, sweep))
        })
        .collect();
    let mut length = shared.0.len();
    let of_kind = |kind: &Kind| {
        let mut taken = shared.clone();
        let kept =
            kind.kept.iter().map(|(&id, &(first, last))| (id, taken.take(first, last))).collect();
        length = length.max(taken.0.len());
        Slots { exchanged: exchanged.clone(), kept }
    };
    (kinds.iter().map(of_kind).collect(), length)
}

impl Slots {
    /// Returns the place of a number in the record; `None` if it has none.
    pub fn of(&self, number: &Number) -> Option<usize> {
        match number {
            Number::Exchanged(sweep, k) => self.exchanged.get(&(*sweep, *k)).copied(),
            Number::Kept(id) => self.kept.get(id).copied(),
            _ => None,
        }
    }
}

/// For each place, the sweeps in which it is taken: the first and the last of each use.
#[derive(Clone, Default)]
struct Taken(Vec<Vec<(usize, usize)>>);

impl Taken {
    /// Returns the first place that is free in these sweeps, and takes it.
    fn take(&mut self, first: usize, last: usize) -> usize {
        let is_free = |uses: &Vec<(usize, usize)>| {
            uses.iter().all(|&(other_first, other_last)| last < other_first || other_last < first)
        };
        let place = self.0.iter().position(is_free).unwrap_or_else(|| {
            self.0.push(Vec::new());
            self.0.len() - 1
        });
        self.0[place].push((first, last));
        place
    }
}
