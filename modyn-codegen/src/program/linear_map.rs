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
    /// The entries of the matrix by columns.
    pub map: Vec<Operand>,
    /// The other matrices, by columns.
    pub matrices: Vec<Vec<Operand>>,
    /// For each of these and each row, the first result, and the distance between the results of consecutive columns.
    pub targets: Vec<Vec<(usize, usize)>>,
    /// The columns with nonzeros, with all rows.
    pub blocks: Vec<ProductBlock>,
}

impl LinearMap {
    /// Returns the map of these operands: its matrix, then the other matrices.
    pub(super) fn new(form: &MapForm, operands: &[Operand]) -> Self {
        let MapForm { rows, terms, targets, .. } = form;
        let (map, rest) = operands.split_at(rows * terms);
        let matrices = rest.chunks((rest.len() / targets.len().max(1)).max(1));
        let matrices: Vec<Vec<Operand>> = matrices.map(<[Operand]>::to_vec).collect();
        let blocks = blocks(*rows, *terms, &matrices);
        Self { rows: *rows, map: map.to_vec(), matrices, targets: targets.clone(), blocks }
    }

    /// Returns the number of entries of a column that the map multiplies.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.map.len() / self.rows.max(1)
    }

    /// Returns the number of columns of a matrix that the map multiplies.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.matrices.first().map_or(0, |matrix| matrix.len() / self.terms().max(1))
    }

    /// Returns all entries.
    pub(super) fn operands(&self) -> impl Iterator<Item = &Operand> {
        self.map.iter().chain(self.matrices.iter().flatten())
    }

    /// Returns the operations of all sums. On vectors an operation on rows in lanes counts once.
    pub(super) fn operations(&self, execution: Execution) -> OperationCount {
        let lanes = if execution == Execution::Simd { ROW_LANES } else { 1 };
        let sums = self.blocks.iter().map(|block| {
            let terms: usize = block.terms.iter().map(ExactSizeIterator::len).sum();
            self.matrices.len() * block.columns.len() * terms * self.rows.div_ceil(lanes)
        });
        let multiplications = sums.sum();
        OperationCount { additions: multiplications, multiplications, ..OperationCount::default() }
    }

    /// Returns the operations in the text of the loops: a sum for each block and matrix.
    pub(super) fn static_operations(&self) -> OperationCount {
        let multiplications = self.matrices.len() * self.blocks.len();
        OperationCount { additions: multiplications, multiplications, ..OperationCount::default() }
    }

    /// Replaces results by the products; `number` returns the number of an operand.
    pub(super) fn apply<S: Scalar>(&self, results: &mut [S], number: impl Fn(&Operand) -> S) {
        let (rows, terms) = (self.rows, self.terms());
        let map: Vec<S> = self.map.iter().map(&number).collect();
        for (matrix, targets) in self.matrices.iter().zip(&self.targets) {
            for block in &self.blocks {
                for column in block.columns.clone() {
                    for (row, (first, stride)) in targets.iter().enumerate() {
                        let terms_of = block.terms.iter().cloned().flatten();
                        let sum = |sum: S, k: usize| {
                            map[k * rows + row].mul_add(number(&matrix[column * terms + k]), sum)
                        };
                        results[first + stride * column] = terms_of.fold(S::zero(), sum);
                    }
                }
            }
        }
    }

    /// Returns the rule that the map of a program breaks.
    pub(super) fn fault(&self, program: &Program) -> Option<&'static str> {
        let (rows, terms, columns) = (self.rows, self.terms(), self.columns());
        if program.execution.has_many_states() {
            return Some("only programs of one state have a map");
        }
        if program.execution == Execution::Simd && rows < ROW_LANES {
            return Some("maps on vectors have as many rows as a vector has lanes");
        }
        let is_whole = rows * terms == self.map.len()
            && terms * columns > 0
            && self.matrices.iter().all(|matrix| matrix.len() == terms * columns);
        if !is_whole || self.matrices.len() != self.targets.len() {
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
        let other = self.blocks != blocks(rows, terms, &self.matrices);
        other.then_some("the blocks of a map are its matrices' nonzeros")
    }
}

/// Returns the columns with nonzeros. Consecutive columns with nearly the same nonzeros are one block.
fn blocks(rows: usize, terms: usize, matrices: &[Vec<Operand>]) -> Vec<ProductBlock> {
    let columns = matrices.first().map_or(0, |matrix| matrix.len() / terms.max(1));
    let mut blocks: Vec<(Range<usize>, BTreeSet<usize>)> = Vec::new();
    for column in 0..columns {
        let is_nonzero = |k: &usize| {
            let mut entries = matrices.iter().filter_map(|of| of.get(column * terms + k));
            !entries.all(is_zero)
        };
        let own: BTreeSet<usize> = (0..terms).filter(is_nonzero).collect();
        let is_near = |of: &BTreeSet<usize>, both: &BTreeSet<usize>| 8 * both.len() <= 9 * of.len();
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
        rows: 0..rows,
        terms: ranges(&terms),
    };
    blocks.into_iter().map(block).collect()
}
