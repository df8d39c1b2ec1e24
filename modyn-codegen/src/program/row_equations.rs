//! Equations of constraint rows within a program, of which some may be dependent.

use modyn_runtime::Scalar;
use modyn_runtime::equations::constraints::RowSystem;

use super::{Execution, InvalidProgram, Operand, Program};
use crate::trace::RowEquationsGraph;

/// The equations A x = b of constraint rows, for one or more right-hand sides b. The results are x = A^+ b for each of them, then A x - b
/// for each, then the rank of A. They are any numbers where the last operand is not negative: then no operation counts them.
#[derive(Clone, Debug, PartialEq)]
pub struct RowEquations {
    /// For each constraint, the number of its rows.
    pub blocks: Vec<usize>,
    /// The number of right-hand sides.
    pub sides: usize,
    /// The lower triangle of A by rows; the right-hand sides; for each constraint the scale of its thresholds; the tolerance and the
    /// rounding; the number that is negative where the results count.
    pub operands: Vec<Operand>,
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
        2 * self.sides * self.rows() + 1
    }

    /// Returns the lower triangle, the right-hand sides, the scales, the tolerance with the rounding, and the last operand.
    #[must_use]
    pub fn parts(&self) -> [&[Operand]; 5] {
        let rows = self.rows();
        let (triangle, rest) = self.operands.split_at(rows * (rows + 1) / 2);
        let (sides, rest) = rest.split_at(self.sides * rows);
        let (scales, rest) = rest.split_at(self.blocks.len());
        let (tolerances, margin) = rest.split_at(2);
        [triangle, sides, scales, tolerances, margin]
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
        let [matrix, sides, scales, tolerances, _] = self.parts().map(numbers);
        let tolerances = [tolerances[0], tolerances[1]];
        RowSystem { blocks: self.blocks.clone(), matrix, sides, scales, tolerances }.solve()
    }
}

impl Program {
    /// Returns the program of a graph with equations of constraint rows, over `arguments` scalars.
    ///
    /// # Errors
    ///
    /// Returns the first violation of a rule.
    pub fn with_row_equations(
        of: &RowEquationsGraph,
        arguments: usize,
        execution: Execution,
    ) -> Result<Self, InvalidProgram> {
        Self::lowered_with(&of.graph, arguments, execution, Some((&of.blocks, of.sides))).finished()
    }
}
