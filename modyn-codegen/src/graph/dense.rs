//! The dense parts of graphs: products of matrices, and equations of constraint rows that may be
//! dependent.

use std::ops::Range;

/// The dense parts that a graph leaves to loops. After the results, the outputs of the graph are
/// the operands of the products, then the operands of the equations; after the arguments, its
/// inputs are the results of the equations.
#[derive(Clone, Debug, Default)]
pub struct DenseParts {
    /// The form of equations of constraint rows, some of which may be dependent.
    pub rows: Option<RowForm>,
    /// The form of the products.
    pub products: Option<ProductForm>,
}

/// The form of equations of constraint rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowForm {
    /// For each constraint, the number of its rows.
    pub blocks: Vec<usize>,
    /// The number of right-hand sides.
    pub sides: usize,
}

/// Returns the number of results of equations of this number of rows: two for each row and
/// right-hand side, and the rank.
pub(crate) const fn row_results(rows: usize, sides: usize) -> usize {
    2 * rows * sides + 1
}

/// The form of products of one matrix A with several matrices B, which are added to results. Its
/// operands are the entries of A, then the entries of each B, by columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductForm {
    /// The number of rows of A.
    pub rows: usize,
    /// The number of columns of A, and of rows of each B.
    pub terms: usize,
    /// The number of the function's results, which come before the operands.
    pub results: usize,
    /// For each B, the results to which the rows of A B are added.
    pub targets: Vec<Vec<ProductTarget>>,
}

/// The results to which rows of a product are added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductTarget {
    /// The rows.
    pub rows: Range<usize>,
    /// The result for the first of these rows in the first column.
    pub first: usize,
    /// The distance between the results for consecutive rows of a column.
    pub by_row: usize,
    /// The distance between the results for a row in consecutive columns.
    pub by_column: usize,
}

impl ProductTarget {
    /// Returns the target of a square product of `n` rows: a result by columns from `first` on.
    #[must_use]
    pub fn square(first: usize, n: usize) -> Self {
        Self { rows: 0..n, first, by_row: 1, by_column: n }
    }

    /// Returns the targets of consecutive rows. Of each row: the result in the first column, and
    /// the distance to that in the next one.
    pub(crate) fn of_rows(rows: impl Iterator<Item = (usize, usize)>) -> Vec<Self> {
        let mut targets: Vec<Self> = Vec::new();
        for (row, (first, by_column)) in rows.enumerate() {
            match targets.last_mut() {
                Some(last)
                    if last.by_column == by_column && last.first + last.rows.len() == first =>
                {
                    last.rows.end += 1;
                }
                _ => targets.push(Self { rows: row..row + 1, first, by_row: 1, by_column }),
            }
        }
        targets
    }

    /// Returns the target of the transposed product.
    #[must_use]
    pub fn transposed(self) -> Self {
        Self { by_row: self.by_column, by_column: self.by_row, ..self }
    }

    /// Returns the result for a row, which the target has, in a column.
    #[must_use]
    pub fn result(&self, row: usize, column: usize) -> usize {
        self.first + (row - self.rows.start) * self.by_row + column * self.by_column
    }
}
