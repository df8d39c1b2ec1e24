//! Products of matrices after a program's statements, in loops: the dense part of a function.
//!
//! `Products` adds A B to results, for one matrix A and several matrices B. Derivatives of forward
//! dynamics are M^-1 times the derivatives of inverse dynamics; Hessians have the same columns and
//! another A; derivatives under constraints have the inverse of the equations of motion with their
//! constraint rows (`ColumnMap`). The graph ends before the products (`DenseParts`); the zeros of
//! its entries give the columns, rows and terms of the loops. A matrix that is a result is computed
//! in its place; otherwise statements store its entries into an array where they are computed. Rust
//! and C print loops, Rust for one state with rows in the lanes of vectors. Other languages and
//! machine code have products in straight-line code (`CodeForm::Unrolled`). In CUDA loops were
//! tried: NVRTC took no less time for a humanoid's derivatives, and the stack of a thread grew by
//! two thirds.

use std::collections::BTreeSet;
use std::ops::Range;

use modyn_runtime::{OperationCount, Scalar};

use super::{Execution, Operand, Program, Source};
use crate::graph::dense::{ProductForm, ProductTarget};

/// The lanes of a vector of rows.
pub const ROW_LANES: usize = 4;

/// The largest number of vectors of rows that are summed at a time. The sums of two matrices, their
/// factors and a vector of A fit the 16 registers of most processors.
const MAX_VECTORS: usize = 5;

/// Products A B of one matrix with several others, which are added to results.
#[derive(Clone, Debug, PartialEq)]
pub struct Products {
    /// The number of rows of A.
    pub rows: usize,
    /// The number of columns of A, and of rows of each B.
    pub terms: usize,
    /// The entries of A, then the entries of each B, by columns.
    pub entries: Vec<Operand>,
    /// For each B, the results to which the rows of A B are added.
    pub targets: Vec<Vec<ProductTarget>>,
    /// The columns with nonzeros.
    pub blocks: Vec<ProductBlock>,
    /// The index of the first result of A where A is a matrix of results, and each B has the form
    /// of results to which its product is added: it is computed in their place. Otherwise matrices
    /// are arrays, and statements store the entries that they compute.
    pub in_place: Option<usize>,
}

/// Columns of the products that have nearly the same nonzeros.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductBlock {
    /// The columns.
    pub columns: Range<usize>,
    /// The rows of the products that are not zero.
    pub rows: Range<usize>,
    /// The rows of the matrices B that are not zero.
    pub terms: Vec<Range<usize>>,
}

/// The array of a matrix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductMatrix {
    /// The name in the text of a function: `a`, then `b0` and so on.
    pub name: String,
    /// The number of columns.
    pub columns: usize,
    /// The number of rows.
    pub rows: usize,
}

impl Products {
    /// Returns products of matrices with these entries, which are added to these results.
    pub(super) fn new(
        form: &ProductForm,
        entries: Vec<Operand>,
        results: &[Operand],
        execution: Execution,
    ) -> Self {
        let ProductForm { rows, terms, ref targets, .. } = *form;
        let targets = targets.clone();
        let blocks = Vec::new();
        let mut products = Self { rows, terms, entries, targets, blocks, in_place: None };
        products.in_place = products.place_of_a(results, execution);
        products.blocks = products.blocks();
        products
    }

    /// Returns the number of columns of each B.
    #[must_use]
    pub fn columns(&self) -> usize {
        let others = self.entries.len().saturating_sub(self.rows * self.terms);
        others / (self.terms * self.targets.len()).max(1)
    }

    /// Returns the arrays of A and of each B, if there are some.
    #[must_use]
    pub fn arrays(&self) -> Vec<ProductMatrix> {
        if self.in_place.is_some() {
            return Vec::new();
        }
        let terms = self.terms;
        let columns = self.columns();
        let names = (0..self.targets.len()).map(|m| format!("b{m}"));
        let others = names.map(|name| ProductMatrix { name, columns, rows: terms });
        let a = ProductMatrix { name: "a".into(), columns: terms, rows: self.rows };
        [a].into_iter().chain(others).collect()
    }

    /// Returns the array to which an entry belongs, and the entry's index there; `None` if there is
    /// no such entry.
    #[must_use]
    pub fn place(&self, entry: usize) -> Option<(ProductMatrix, usize)> {
        let mut index = entry;
        self.arrays().into_iter().find_map(|matrix| {
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

    /// Returns the numbers of a program's results before the loops: each B in its place, or the
    /// numbers to which products are added.
    #[must_use]
    pub fn before(&self, results: &[Operand]) -> Vec<Operand> {
        let mut before = results.to_vec();
        if self.in_place.is_some() {
            let size = self.terms * self.columns();
            for (m, targets) in self.targets.iter().enumerate() {
                let b = &self.entries[self.first(m)..][..size];
                before[targets[0].first..][..size].copy_from_slice(b);
            }
        }
        before
    }

    /// Returns the addends of products in place: the index of the result, and the number. The
    /// addends of the first list are added before the sums with transposes, which complete
    /// symmetric matrices; the addends of the second list after these sums.
    #[must_use]
    pub fn addends(&self, results: &[Operand]) -> [Vec<(usize, Operand)>; 2] {
        let mut addends = [Vec::new(), Vec::new()];
        let n = self.rows;
        for targets in self.targets.iter().filter(|_| self.in_place.is_some()) {
            let product = &results[targets[0].first..][..n * n];
            let places = || (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
            let with_transpose = targets.len() > 1;
            let is_symmetric = places().all(|(i, j)| product[j * n + i] == product[i * n + j]);
            for (i, j) in places().filter(|(i, j)| !is_zero(&product[j * n + i])) {
                let after = with_transpose && (i == j || !is_symmetric);
                if after || i > j || !with_transpose {
                    let place = targets[0].first + j * n + i;
                    addends[usize::from(after)].push((place, product[j * n + i]));
                }
            }
        }
        addends
    }

    /// Returns the index of the first result of each product in place to which its transpose is
    /// added.
    pub fn transposed(&self) -> impl Iterator<Item = usize> {
        let targets = self.targets.iter().filter(|targets| targets.len() > 1);
        targets.filter(|_| self.in_place.is_some()).map(|targets| targets[0].first)
    }

    /// Returns whether the numbers are zero to which a block's product is added: it is stored in
    /// their place.
    #[must_use]
    pub fn replaces(
        &self,
        block: &ProductBlock,
        target: &ProductTarget,
        results: &[Operand],
    ) -> bool {
        let is_only = self.targets.iter().flatten().filter(|other| other.first == target.first);
        is_only.count() == 1 && target.of(block).all(|result| is_zero(&results[result]))
    }

    /// Returns the results that products replace.
    #[must_use]
    pub fn replaced(&self, results: &[Operand]) -> BTreeSet<usize> {
        let replaced = self.parts().filter(|(block, target)| self.replaces(block, target, results));
        replaced.flat_map(|(block, target)| target.of(block)).collect()
    }

    /// Returns each block with each target.
    fn parts(&self) -> impl Iterator<Item = (&ProductBlock, &ProductTarget)> {
        let targets = self.targets.iter().flatten();
        targets.flat_map(|target| self.blocks.iter().map(move |block| (block, target)))
    }

    /// Returns the index of the first entry of a matrix B.
    fn first(&self, matrix: usize) -> usize {
        self.rows * self.terms + matrix * self.terms * self.columns()
    }

    /// Returns the index of the first result of A if all matrices have places among the results of
    /// one state.
    fn place_of_a(&self, results: &[Operand], execution: Execution) -> Option<usize> {
        let n = self.rows;
        let is_square = n == self.terms && n == self.columns() && n > 1;
        if !is_square || execution.has_many_states() {
            return None;
        }
        let firsts = self.targets.iter().map(|targets| {
            let square = ProductTarget::square(targets.first()?.first, n);
            let both = [square.clone(), square.clone().transposed()];
            (*targets == both || *targets == both[..1]).then_some(square.first)
        });
        let mut taken = firsts.collect::<Option<Vec<usize>>>()?;
        let a = &self.entries[..n * n];
        let ends = results.len().checked_sub(n * n)?;
        taken.push((0..=ends).find(|&first| results[first..][..n * n] == *a)?);
        let place = taken.last().copied();
        taken.sort_unstable();
        let apart = taken.windows(2).all(|two| two[1] - two[0] >= n * n);
        place.filter(|_| apart && taken.last().is_some_and(|&last| last <= ends))
    }

    /// Returns the multiplications of all sums. On vectors an operation on rows in lanes counts
    /// once.
    pub(crate) fn multiplications(&self, execution: Execution) -> usize {
        let sums = self.blocks.iter().map(|block| {
            let terms: usize = block.terms.iter().map(Range::len).sum();
            let rows = match execution {
                Execution::Simd => block.vectors(self.rows).iter().map(|(_, count)| count).sum(),
                _ => block.rows.len(),
            };
            self.targets.len() * block.columns.len() * rows * terms
        });
        sums.sum()
    }

    /// Returns the operations of a call.
    pub(super) fn operations(&self, program: &Program) -> OperationCount {
        let multiplications = self.multiplications(program.execution);
        let transpose = self.rows * (self.rows + 1) / 2;
        let additions = multiplications
            + self.sums(&program.results, transpose, |block, target| target.of(block).count());
        OperationCount { additions, multiplications, ..OperationCount::default() }
    }

    /// Returns the operations in the text of the loops: a sum for each block and matrix.
    pub(super) fn static_operations(&self, program: &Program) -> OperationCount {
        let multiplications = self.targets.len() * self.blocks.len();
        let additions = multiplications + self.sums(&program.results, 1, |_, _| 1);
        OperationCount { additions, multiplications, ..OperationCount::default() }
    }

    /// Returns the sums of products and results: this many for a transpose, and as many for a block
    /// as `of_block` returns.
    fn sums(
        &self,
        results: &[Operand],
        transpose: usize,
        of_block: fn(&ProductBlock, &ProductTarget) -> usize,
    ) -> usize {
        if self.in_place.is_some() {
            let numbers: usize = self.addends(results).iter().map(Vec::len).sum();
            return numbers + transpose * self.transposed().count();
        }
        let added = self.parts().filter(|(block, target)| !self.replaces(block, target, results));
        added.map(|(block, target)| of_block(block, target)).sum()
    }

    /// Adds the products to the numbers of these results, in the order of the loops; `number`
    /// returns the number of an operand.
    pub(super) fn apply<S: Scalar>(
        &self,
        results: &[Operand],
        numbers: &mut [S],
        number: impl Fn(&Operand) -> S,
    ) {
        let n = self.rows;
        let entries: Vec<S> = self.entries.iter().map(&number).collect();
        for first in
            self.targets.iter().filter(|_| self.in_place.is_some()).map(|places| places[0].first)
        {
            numbers[first..][..n * n].fill(S::zero());
        }
        for (m, targets) in self.targets.iter().enumerate() {
            let targets = if self.in_place.is_some() { &targets[..1] } else { targets };
            for block in &self.blocks {
                for column in block.columns.clone() {
                    let factors = &entries[self.first(m) + self.terms * column..][..self.terms];
                    for target in targets {
                        for row in target.rows_of(block) {
                            let terms = block.terms.iter().cloned().flatten();
                            let sum =
                                |sum: S, k: usize| entries[k * n + row].mul_add(factors[k], sum);
                            let result = &mut numbers[target.result(row, column)];
                            *result = *result + terms.fold(S::zero(), sum);
                        }
                    }
                }
            }
        }
        let add = |numbers: &mut [S], addends: &[(usize, Operand)]| {
            for (result, addend) in addends {
                numbers[*result] = numbers[*result] + number(addend);
            }
        };
        let [before, after] = self.addends(results);
        add(numbers, &before);
        for first in self.transposed() {
            for (j, i) in (0..n).flat_map(|j| (0..=j).map(move |i| (j, i))) {
                let [a, b] = [first + j * n + i, first + i * n + j];
                let sum = numbers[a] + numbers[b];
                (numbers[a], numbers[b]) = (sum, sum);
            }
        }
        add(numbers, &after);
    }

    /// Returns the rule that the products of a program break.
    pub(super) fn fault(&self, program: &Program) -> Option<&'static str> {
        let rows = self.rows;
        let terms = self.terms;
        let columns = self.columns();
        if program.execution == Execution::Threads {
            return Some("programs of threads have no products");
        }
        if program.execution == Execution::Simd && rows < ROW_LANES {
            return Some("products on vectors have as many rows as a vector has lanes");
        }
        if terms * columns == 0 || self.first(self.targets.len()) != self.entries.len() {
            return Some("the matrices of products are whole");
        }
        let are_results = self.targets.iter().flatten().all(|target| {
            let ProductTarget { rows: Range { start, end }, first, by_row, by_column } = *target;
            let extent = |count: usize, by: usize| count.checked_sub(1)?.checked_mul(by);
            let extents = extent(end.saturating_sub(start), by_row).zip(extent(columns, by_column));
            let last = extents.and_then(|(a, b)| first.checked_add(a)?.checked_add(b));
            end <= rows && last.is_some_and(|last| last < program.results.len())
        });
        if !are_results {
            return Some("the rows of products are added to results");
        }
        if self.in_place != self.place_of_a(&program.results, program.execution) {
            return Some("matrices that are results are in place");
        }
        (self.blocks != self.blocks())
            .then_some("the blocks of products are their matrices' nonzeros")
    }

    /// Returns the columns with nonzeros. Consecutive columns with nearly the same nonzeros are one
    /// block.
    fn blocks(&self) -> Vec<ProductBlock> {
        let terms = self.terms;
        let matrices = self.targets.len();
        let mut blocks: Vec<(Range<usize>, BTreeSet<usize>)> = Vec::new();
        for column in 0..self.columns() {
            let is_nonzero = |k: &usize| {
                let entry = |m| &self.entries[self.first(m) + column * terms + k];
                !(0..matrices).map(entry).all(is_zero)
            };
            let new_rows: BTreeSet<usize> = (0..terms).filter(is_nonzero).collect();
            let is_near =
                |rows: &BTreeSet<usize>, both: &BTreeSet<usize>| 8 * both.len() <= 9 * rows.len();
            match blocks.last_mut() {
                _ if new_rows.is_empty() => {}
                Some((range, shared_rows))
                    if range.end == column && {
                        let both = &*shared_rows | &new_rows;
                        is_near(shared_rows, &both) && is_near(&new_rows, &both)
                    } =>
                {
                    range.end += 1;
                    shared_rows.extend(new_rows);
                }
                _ => blocks.push((column..column + 1, new_rows)),
            }
        }
        let block = |(columns, terms): (Range<usize>, BTreeSet<usize>)| {
            // B in place is replaced also where A is zero.
            let is_nonzero = |row: &usize| {
                let in_b = self.in_place.is_some() && terms.contains(row);
                in_b || terms.iter().any(|k| !is_zero(&self.entries[k * self.rows + row]))
            };
            let first = (0..self.rows).find(is_nonzero)?;
            let last = (0..self.rows).rfind(is_nonzero)?;
            Some(ProductBlock { columns, rows: first..last + 1, terms: ranges(&terms) })
        };
        blocks.into_iter().filter_map(block).collect()
    }
}

impl ProductTarget {
    /// Returns the rows of the target that a block has.
    pub(crate) fn rows_of(&self, block: &ProductBlock) -> Range<usize> {
        self.rows.start.max(block.rows.start)..self.rows.end.min(block.rows.end)
    }

    /// Returns the results of a block.
    fn of(&self, block: &ProductBlock) -> impl Iterator<Item = usize> {
        let rows = self.rows_of(block);
        let columns = block.columns.clone();
        let places = columns.flat_map(move |j| rows.clone().map(move |i| (i, j)));
        places.map(|(i, j)| self.result(i, j))
    }
}

impl ProductBlock {
    /// Returns the vectors of rows that are summed at a time, for matrices of `size` rows: the
    /// first row of the first vector, and the number of vectors. The last ones may overlap those
    /// before them, or have rows outside of the block, whose sums are zero.
    #[must_use]
    pub fn vectors(&self, size: usize) -> Vec<(usize, usize)> {
        let mut row = self.rows.start;
        let mut left = self.rows.len().div_ceil(ROW_LANES);
        // Vectors have no more rows than the matrices.
        let most = (size / ROW_LANES).clamp(1, MAX_VECTORS);
        let mut groups = Vec::new();
        while left > 0 {
            // As equal as possible: nine vectors are five and four.
            let count = left.div_ceil(left.div_ceil(most));
            groups.push((row.min(size.saturating_sub(ROW_LANES * count)), count));
            left -= count;
            row += ROW_LANES * count;
        }
        groups
    }
}

/// Returns whether an operand is the constant zero.
pub(crate) fn is_zero(operand: &Operand) -> bool {
    matches!(operand.source, Source::Constant(value) if value == 0.0)
}

/// Returns numbers as ranges of consecutive numbers.
fn ranges(numbers: &BTreeSet<usize>) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some(range) if range.end == number => range.end += 1,
            _ => ranges.push(number..number + 1),
        }
    }
    ranges
}
