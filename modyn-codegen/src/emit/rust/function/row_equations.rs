//! The solution of equations of constraint rows by the runtime's loops, where some rows may be
//! dependent.

use super::Printer;
use crate::program::{Execution, Operand, RowEquations};

/// Returns the pattern that binds the results of row equations to these names.
pub(super) fn pattern(equations: &RowEquations, names: &[String]) -> String {
    let rows = equations.rows();
    let (solutions, rest) = names.split_at(equations.sides * rows);
    let (residuals, rank) = rest.split_at(equations.sides * rows);
    let lists = |names: &[String]| {
        let lists = names.chunks(rows).map(|names| format!("[{}]", names.join(", ")));
        lists.collect::<Vec<String>>().join(", ")
    };
    format!(
        "__modyn::solve::RowSolutions {{ solutions: [{}], residuals: [{}], rank: {} }}",
        lists(solutions),
        lists(residuals),
        rank.concat()
    )
}

impl Printer<'_> {
    /// Returns the text that solves row equations where their results count.
    pub(super) fn row_equations(&self, equations: &RowEquations) -> String {
        let list = |operands: &[Operand]| format!("[{}]", self.all(operands));
        let [triangle, sides, scales, tolerances] = equations.parts();
        let sides: Vec<String> = sides.chunks(equations.rows()).map(list).collect();
        let system = format!(
            "__modyn::solve::RowEquations {{ blocks: {:?}, matrix: {}, sides: [{}], scales: {}, tolerances: {} }}",
            equations.blocks,
            list(triangle),
            sides.join(", "),
            list(scales),
            list(tolerances),
        );
        let solved = match self.program.execution {
            Execution::Scalar => format!("{system}.solve()"),
            Execution::Simd => format!("V::outlined({system})"),
            Execution::Batch | Execution::Threads => format!("T::outlined({system})"),
        };
        format!(
            "if {}::is_known_nonnegative({}) {{ __modyn::solve::RowSolutions::zero() }} else {{ {solved} }}",
            self.kind(1),
            self.operand(equations.margin())
        )
    }
}
