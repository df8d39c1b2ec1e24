//! Products of square matrices after a program's statements, in loops: the dense part of a function.

use std::collections::BTreeSet;
use std::ops::Range;

use modyn_runtime::{OperationCount, Scalar};

use super::{Execution, InvalidProgram, Operand, Program, Source};
use crate::trace::{Product, ProductGraph};

/// The lanes of a vector of rows.
pub const ROW_LANES: usize = 4;

/// The largest number of vectors of rows that are summed at a time. The sums of two matrices, their factors and a vector of A fit the 16
/// registers of most processors.
const MAX_VECTORS: usize = 5;

/// Products of square matrices after a program's statements: results that are the entries of a matrix B are replaced by those of
/// A B + C, or by those of the sum of this and its transpose. Matrices are consecutive results, by columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Products {
    /// The number of rows and of columns of the matrices.
    pub size: usize,
    /// The index of the first result of A.
    pub factor: usize,
    /// The products, in place of each B.
    pub products: Vec<Product>,
    /// The columns with nonzeros.
    pub blocks: Vec<ProductBlock>,
    /// The entries of C that are not zero: the index of a result, and the number that is added to it.
    pub addends: Vec<(usize, Operand)>,
}

/// Columns of the products that have the same nonzeros.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductBlock {
    /// The columns.
    pub columns: Range<usize>,
    /// The rows of the products that are not zero.
    pub rows: Range<usize>,
    /// The rows of the matrices B that are not zero.
    pub terms: Vec<Range<usize>>,
}

impl Program {
    /// Returns the program of a graph and of the products of its results, over `arguments` scalars. `blocks` are the products'
    /// nonzeros: those of the graph on scalars, also where `of` has limbs in lanes, which compute some entries as sums of zeros.
    ///
    /// # Errors
    ///
    /// Returns the first violation of a rule.
    pub fn with_products(
        of: &ProductGraph,
        blocks: &[ProductBlock],
        arguments: usize,
        execution: Execution,
    ) -> Result<Self, InvalidProgram> {
        let ProductGraph { ref graph, size, factor, ref products } = *of;
        let entries = size * size;
        let mut program = Self::lowered(graph, arguments, execution);
        let results = program.results.len() - products.len() * entries;
        let addends = program.results.split_off(results);
        let places = products.iter().flat_map(|&Product { first, .. }| first..first + entries);
        let addends = places.zip(addends).filter(|(_, addend)| !is_zero(addend)).collect();
        let (products, blocks) = (products.clone(), blocks.to_vec());
        let products = Products { size, factor, products, blocks, addends };
        let zero = Operand { source: Source::Constant(0.0), negated: false, lanes: 1 };
        for entry in products.outside() {
            program.results[entry] = zero;
        }
        program.products = Some(products);
        program.finished()
    }
}

impl Products {
    /// Returns the operations of all sums. On vectors an operation on rows in lanes counts once.
    pub(super) fn operations(&self, execution: Execution) -> OperationCount {
        let sums = self.blocks.iter().map(|block| {
            let terms: usize = block.terms.iter().map(Range::len).sum();
            let rows = match execution {
                Execution::Simd => block.vectors(self.size).iter().map(|(_, count)| count).sum(),
                _ => block.rows.len(),
            };
            self.products.len() * block.columns.len() * rows * terms
        });
        let multiplications = sums.sum();
        let with_transposes = self.transposed().count() * self.size * (self.size + 1) / 2;
        let additions = multiplications + self.addends.len() + with_transposes;
        OperationCount { additions, multiplications, ..OperationCount::default() }
    }

    /// Returns the operations in the text of the loops: a sum for each block and matrix.
    pub(super) fn static_operations(&self) -> OperationCount {
        let multiplications = self.products.len() * self.blocks.len();
        let additions = multiplications + self.addends.len() + self.transposed().count();
        OperationCount { additions, multiplications, ..OperationCount::default() }
    }

    /// Returns the index of the first result of each product to which its transpose is added.
    pub fn transposed(&self) -> impl Iterator<Item = usize> {
        let products = self.products.iter().filter(|product| product.with_transpose);
        products.map(|product| product.first)
    }

    /// Returns the results that are entries of a matrix B outside of its blocks.
    fn outside(&self) -> impl Iterator<Item = usize> {
        let n = self.size;
        let inside = |column: usize, row: usize| {
            self.blocks.iter().any(|block| {
                block.columns.contains(&column)
                    && block.terms.iter().any(|rows| rows.contains(&row))
            })
        };
        let places = (0..n).flat_map(move |column| (0..n).map(move |row| (column, row)));
        let outside: Vec<usize> = places
            .filter(|&(column, row)| !inside(column, row))
            .map(|(column, row)| column * n + row)
            .collect();
        self.products.iter().flat_map(move |product| {
            outside.clone().into_iter().map(move |entry| product.first + entry)
        })
    }

    /// Replaces results by the products; `addend` returns the number of an operand.
    pub(super) fn apply<S: Scalar>(&self, results: &mut [S], addend: impl Fn(&Operand) -> S) {
        let n = self.size;
        let a = results[self.factor..][..n * n].to_vec();
        for &Product { first: matrix, .. } in &self.products {
            for block in &self.blocks {
                for column in block.columns.clone() {
                    let column = &mut results[matrix + n * column..][..n];
                    let factors = column.to_vec();
                    for row in block.rows.clone() {
                        let terms = block.terms.iter().cloned().flatten();
                        let sum = |sum, k: usize| a[k * n + row].mul_add(factors[k], sum);
                        column[row] = terms.fold(S::zero(), sum);
                    }
                }
            }
        }
        for (result, operand) in &self.addends {
            results[*result] = results[*result] + addend(operand);
        }
        for first in self.transposed() {
            for (column, row) in
                (0..n).flat_map(|column| (0..=column).map(move |row| (column, row)))
            {
                let places = [first + column * n + row, first + row * n + column];
                let sum = results[places[0]] + results[places[1]];
                results[places[0]] = sum;
                results[places[1]] = sum;
            }
        }
    }

    /// Returns the rule that the products of a program break.
    pub(super) fn fault(&self, program: &Program) -> Option<&'static str> {
        let (n, results) = (self.size, &program.results);
        let firsts = || self.products.iter().map(|product| product.first);
        let matrices = || firsts().chain([self.factor]);
        let end = |first: usize| first.checked_add(n.checked_mul(n)?);
        if program.execution.has_many_states() {
            return Some("only programs of one state have products");
        }
        if program.execution == Execution::Simd && n < ROW_LANES {
            return Some("products on vectors have as many rows as a vector has lanes");
        }
        if !matrices().all(|m| end(m).is_some_and(|end| end <= results.len())) {
            return Some("matrices of products are results");
        }
        let mut sorted: Vec<usize> = matrices().collect();
        sorted.sort_unstable();
        if sorted.windows(2).any(|two| two[1] - two[0] < n * n) || self.products.is_empty() {
            return Some("matrices of products are different results");
        }
        let mut addends = self.addends.iter().map(|(result, _)| *result);
        let of_product = |result| firsts().any(|first| (first..first + n * n).contains(&result));
        if !addends.all(of_product) {
            return Some("numbers are added to results that are products");
        }
        let fits = |range: &Range<usize>| range.start < range.end && range.end <= n;
        let mut end = 0;
        let fits = self.blocks.iter().all(|block| {
            let follows = std::mem::replace(&mut end, block.columns.end) <= block.columns.start;
            follows && [&block.columns, &block.rows].into_iter().chain(&block.terms).all(fits)
        });
        if !fits {
            return Some("blocks of products are in order, and within their matrices");
        }
        let zeros = self.outside().all(|entry| is_zero(&results[entry]));
        (!zeros).then_some("matrices of products are zero outside of their blocks")
    }
}

impl ProductBlock {
    /// Returns the vectors of rows that are summed at a time, for matrices of `size` rows: the first row of the first vector, and the
    /// number of vectors. The last ones may overlap those before them, or have rows outside of the block, whose sums are zero.
    #[must_use]
    pub fn vectors(&self, size: usize) -> Vec<(usize, usize)> {
        let (mut row, mut left) = (self.rows.start, self.rows.len().div_ceil(ROW_LANES));
        // Vectors have no more rows than the matrices.
        let (most, mut groups) = ((size / ROW_LANES).clamp(1, MAX_VECTORS), Vec::new());
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

/// Returns the columns with nonzeros of the products of a graph's results. Consecutive columns with the same nonzeros are one block.
pub fn product_blocks(of: &ProductGraph) -> Vec<ProductBlock> {
    let ProductGraph { ref graph, size: n, factor, ref products } = *of;
    let is_nonzero = |first: usize, column: usize, row: usize| {
        graph.value(graph.outputs[first + n * column + row]) != Some(0.0)
    };
    let mut blocks: Vec<ProductBlock> = Vec::new();
    for column in 0..n {
        let terms: BTreeSet<usize> =
            (0..n).filter(|&k| products.iter().any(|of| is_nonzero(of.first, column, k))).collect();
        let of_sum =
            |row: &usize| terms.contains(row) || terms.iter().any(|&k| is_nonzero(factor, k, *row));
        let rows: Vec<usize> = (0..n).filter(of_sum).collect();
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else { continue };
        let (rows, terms) = (*first..last + 1, ranges(&terms));
        match blocks.last_mut() {
            Some(block)
                if block.columns.end == column && block.rows == rows && block.terms == terms =>
            {
                block.columns.end += 1;
            }
            _ => blocks.push(ProductBlock { columns: column..column + 1, rows, terms }),
        }
    }
    blocks
}

/// Returns numbers as ranges of consecutive numbers.
pub(super) fn ranges(numbers: &BTreeSet<usize>) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some(range) if range.end == number => range.end += 1,
            _ => ranges.push(number..number + 1),
        }
    }
    ranges
}
