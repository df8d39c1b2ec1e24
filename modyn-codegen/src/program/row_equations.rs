//! Equations of constraint rows within a program, of which some may be dependent.
//!
//! In nearly all states constraint rows are independent, and L D L^T in their order suffices
//! (`equations/constraints/full_rank.rs`); the same factors say whether rows of any rank are
//! needed. A tracer sets the solution for rows of any rank apart
//! (`ConstraintWorkspace::set_apart`): its operands are further outputs of the graph, its results
//! further inputs (`DenseParts`), and selections choose. Rust calls `solve/rank.rs`, which the
//! interpreter runs as well; C prints a function of it. Machine code has two forms of such a
//! function: the form for independent rows has a guard that finds states with dependent rows and
//! calls the form for rows of any rank (`modyn-jit/src/assembly.rs`). Plans of other languages, and
//! those with `code = unrolled`, trace rows of any rank.

use modyn_runtime::Scalar;
use modyn_runtime::equations::constraints::RowSystem;

use super::{Execution, Operand, Operation, Program};
use crate::graph::dense::row_results;
use crate::graph::{Expr, Graph};
use crate::passes::optimize;

/// The equations A x = b of constraint rows, for one or more right-hand sides b. The results are
/// x = A^+ b for each of them, then A x - b for each, then the rank of A. They are any numbers
/// where the last operand is not negative: then no operation counts them.
#[derive(Clone, Debug, PartialEq)]
pub struct RowEquations {
    /// For each constraint, the number of its rows.
    pub blocks: Vec<usize>,
    /// The number of right-hand sides.
    pub sides: usize,
    /// The lower triangle of A by rows; the right-hand sides; for each constraint the scale of its
    /// thresholds; the tolerance and the rounding; the number that is negative where the results
    /// count.
    pub operands: Vec<Operand>,
}

impl Program {
    /// Returns whether there are equations of constraint rows of which some may be dependent.
    #[must_use]
    pub fn has_row_equations(&self) -> bool {
        let is_one = |operation: &Operation| matches!(operation, Operation::RowEquations(_));
        self.statements.iter().any(|statement| is_one(&statement.operation))
    }
}

impl RowEquations {
    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.blocks.iter().sum()
    }

    /// Returns the number of results.
    #[must_use]
    pub fn results(&self) -> usize {
        row_results(self.rows(), self.sides)
    }

    /// Returns the number that is negative where the results count.
    #[must_use]
    pub fn margin(&self) -> &Operand {
        &self.operands[self.operands.len() - 1]
    }

    /// Returns the operands without the last one.
    #[must_use]
    pub fn numbers(&self) -> &[Operand] {
        &self.operands[..self.operands.len() - 1]
    }

    /// Returns the lower triangle, the right-hand sides, the scales, and the tolerance with the
    /// rounding.
    #[must_use]
    pub fn parts(&self) -> [&[Operand]; 4] {
        parts(&self.blocks, self.sides, self.numbers())
    }

    /// Returns the program of the results from [the numbers](Self::numbers), in straight-line code.
    #[must_use]
    pub fn program(&self) -> Program {
        let count = self.numbers().len();
        let graph = Graph::trace(|| {
            let inputs: Vec<Expr> = (0..count).map(Expr::input).collect();
            system(&self.blocks, parts(&self.blocks, self.sides, &inputs)).solve()
        });
        Program::new(&optimize(graph), count, Execution::Scalar)
    }

    /// Returns the number of operands that equations of this form have.
    pub(super) fn count(blocks: &[usize], sides: usize) -> usize {
        let rows: usize = blocks.iter().sum();
        rows * (rows + 1) / 2 + sides * rows + blocks.len() + 3
    }

    /// Returns whether there are as many operands as the equations have.
    pub(super) fn fits(&self) -> bool {
        let rows = self.blocks.iter().all(|rows| (1..=6).contains(rows));
        rows && self.sides > 0 && self.operands.len() == Self::count(&self.blocks, self.sides)
    }

    /// Returns the results, from a function that returns the number of an operand.
    pub(super) fn evaluate<S: Scalar>(&self, number: impl Fn(&Operand) -> S) -> Vec<S> {
        let numbers = |part: &[Operand]| part.iter().map(&number).collect::<Vec<S>>();
        let parts = self.parts().map(numbers);
        system(&self.blocks, parts.each_ref().map(Vec::as_slice)).solve()
    }
}

/// Returns the parts of the numbers of equations: the lower triangle, the right-hand sides, the
/// scales, the tolerance and the rounding.
fn parts<'a, T>(blocks: &[usize], sides: usize, numbers: &'a [T]) -> [&'a [T]; 4] {
    let rows: usize = blocks.iter().sum();
    let (triangle, rest) = numbers.split_at(rows * (rows + 1) / 2);
    let (sides, rest) = rest.split_at(sides * rows);
    let (scales, tolerances) = rest.split_at(blocks.len());
    [triangle, sides, scales, tolerances]
}

/// Returns the equations of constraints with these numbers of rows.
fn system<S: Scalar>(blocks: &[usize], parts: [&[S]; 4]) -> RowSystem<S> {
    let [matrix, sides, scales, tolerances] = parts.map(<[S]>::to_vec);
    let tolerances = [tolerances[0], tolerances[1]];
    RowSystem { blocks: blocks.to_vec(), matrix, sides, scales, tolerances }
}
