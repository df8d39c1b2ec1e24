//! A linear map of columns after a program's statements, in loops: the dense part of derivatives under constraints.

use std::collections::BTreeSet;
use std::ops::Range;

use modyn_runtime::{OperationCount, Scalar};

use super::products::{ProductBlock, ROW_LANES, is_zero, ranges};
use super::{Execution, Operand, Program};
use crate::trace::MapForm;

/// A matrix that is no result, and multiplies the columns of others. The products are results.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMap {
    /// The number of rows: the results for each column.
    pub rows: usize,
    /// The number of entries of a column that the map multiplies.
    pub terms: usize,
    /// The entries of the matrix, then those of the others, by columns.
    pub entries: Vec<Operand>,
    /// For each other matrix and each row, the first result, and the distance between the results of consecutive columns.
    pub targets: Vec<Vec<(usize, usize)>>,
    /// The columns with nonzeros, with all rows.
    pub blocks: Vec<ProductBlock>,
}

/// The form of a matrix of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapMatrix {
    /// The name in the text of a function: `map`, then `columns0` and so on.
    pub name: String,
    /// The number of columns.
    pub columns: usize,
    /// The number of rows.
    pub rows: usize,
}

impl LinearMap {
    /// Returns the map with these entries.
    pub(super) fn new(form: &MapForm, entries: Vec<Operand>) -> Self {
        let MapForm { rows, terms, ref targets, .. } = *form;
        let mut map = Self { rows, terms, entries, targets: targets.clone(), blocks: Vec::new() };
        map.blocks = map.blocks();
        map
    }

    /// Returns the number of columns of a matrix that the map multiplies.
    #[must_use]
    pub fn columns(&self) -> usize {
        let others = self.entries.len().saturating_sub(self.rows * self.terms);
        others / (self.terms * self.targets.len()).max(1)
    }

    /// Returns the matrix of the map, then the others.
    #[must_use]
    pub fn matrices(&self) -> Vec<MapMatrix> {
        let (terms, columns) = (self.terms, self.columns());
        let others = (0..self.targets.len()).map(|m| format!("columns{m}"));
        let others = others.map(|name| MapMatrix { name, columns, rows: terms });
        let map = MapMatrix { name: "map".into(), columns: terms, rows: self.rows };
        [map].into_iter().chain(others).collect()
    }

    /// Returns the matrix to which an entry belongs, and the entry's index there; `None` if there is no such entry.
    #[must_use]
    pub fn place(&self, entry: usize) -> Option<(MapMatrix, usize)> {
        let mut index = entry;
        self.matrices().into_iter().find_map(|matrix| {
            let entries = matrix.columns * matrix.rows;
            match index.checked_sub(entries) {
                None => Some((matrix, index)),
                Some(rest) => {
                    index = rest;
                    None
                }
            }
        })
    }

    /// Returns the index of the first entry of another matrix.
    fn first(&self, matrix: usize) -> usize {
        self.rows * self.terms + matrix * self.terms * self.columns()
    }

    /// Returns the operations of all sums. On vectors an operation on rows in lanes counts once.
    pub(super) fn operations(&self, execution: Execution) -> OperationCount {
        let lanes = if execution == Execution::Simd { ROW_LANES } else { 1 };
        let sums = self.blocks.iter().map(|block| {
            let terms: usize = block.terms.iter().map(ExactSizeIterator::len).sum();
            self.targets.len() * block.columns.len() * terms * self.rows.div_ceil(lanes)
        });
        let multiplications = sums.sum();
        OperationCount { additions: multiplications, multiplications, ..OperationCount::default() }
    }

    /// Returns the operations in the text of the loops: a sum for each block and matrix.
    pub(super) fn static_operations(&self) -> OperationCount {
        let multiplications = self.targets.len() * self.blocks.len();
        OperationCount { additions: multiplications, multiplications, ..OperationCount::default() }
    }

    /// Replaces results by the products; `number` returns the number of an operand.
    pub(super) fn apply<S: Scalar>(&self, results: &mut [S], number: impl Fn(&Operand) -> S) {
        let (rows, terms) = (self.rows, self.terms);
        let entries: Vec<S> = self.entries.iter().map(number).collect();
        for (m, targets) in self.targets.iter().enumerate() {
            for block in &self.blocks {
                for column in block.columns.clone() {
                    let column_entries = &entries[self.first(m) + terms * column..][..terms];
                    for (row, (first, stride)) in targets.iter().enumerate() {
                        let terms_of = block.terms.iter().cloned().flatten();
                        let sum = |sum: S, k: usize| {
                            entries[k * rows + row].mul_add(column_entries[k], sum)
                        };
                        results[first + stride * column] = terms_of.fold(S::zero(), sum);
                    }
                }
            }
        }
    }

    /// Returns the rule that the map of a program breaks.
    pub(super) fn fault(&self, program: &Program) -> Option<&'static str> {
        let (rows, terms, columns) = (self.rows, self.terms, self.columns());
        if program.execution.has_many_states() {
            return Some("only programs of one state have a map");
        }
        if program.execution == Execution::Simd && rows < ROW_LANES {
            return Some("maps on vectors have as many rows as a vector has lanes");
        }
        let is_whole = terms * columns > 0 && self.first(self.targets.len()) == self.entries.len();
        if !is_whole {
            return Some("a map and its matrices are whole");
        }
        let targets = self.targets.iter().flatten().map(|&(first, stride)| {
            let last = stride.checked_mul(columns - 1)?.checked_add(first)?;
            (last < program.results.len()).then_some((first, stride))
        });
        let Some(targets) = targets.collect::<Option<Vec<_>>>() else {
            return Some("the products of a map are results");
        };
        let places = targets
            .iter()
            .flat_map(|&(first, stride)| (0..columns).map(move |j| first + stride * j));
        let mut seen = BTreeSet::new();
        let mut fits = self.targets.iter().all(|targets| targets.len() == rows);
        fits &=
            places.into_iter().all(|place| is_zero(&program.results[place]) && seen.insert(place));
        if !fits {
            return Some("the products of a map replace different zeros");
        }
        let other = self.blocks != self.blocks();
        other.then_some("the blocks of a map are its matrices' nonzeros")
    }

    /// Returns the columns with nonzeros. Consecutive columns with nearly the same nonzeros are one block.
    fn blocks(&self) -> Vec<ProductBlock> {
        let (terms, matrices) = (self.terms, self.targets.len());
        let mut blocks: Vec<(Range<usize>, BTreeSet<usize>)> = Vec::new();
        for column in 0..self.columns() {
            let is_nonzero = |k: &usize| {
                let entry = |m| &self.entries[self.first(m) + column * terms + k];
                !(0..matrices).map(entry).all(is_zero)
            };
            let own: BTreeSet<usize> = (0..terms).filter(is_nonzero).collect();
            let is_near =
                |of: &BTreeSet<usize>, both: &BTreeSet<usize>| 8 * both.len() <= 9 * of.len();
            match blocks.last_mut() {
                _ if own.is_empty() => {}
                Some((range, of))
                    if range.end == column && {
                        let both = &*of | &own;
                        is_near(of, &both) && is_near(&own, &both)
                    } =>
                {
                    range.end += 1;
                    of.extend(own);
                }
                _ => blocks.push((column..column + 1, own)),
            }
        }
        let block = |(columns, terms): (Range<usize>, BTreeSet<usize>)| ProductBlock {
            columns,
            rows: 0..self.rows,
            terms: ranges(&terms),
        };
        blocks.into_iter().map(block).collect()
    }
}
