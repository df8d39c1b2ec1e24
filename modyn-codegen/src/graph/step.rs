//! The graph of a step with soft constraints, and its parts: the nodes that run once, and the nodes
//! that run in each iteration of the solver.

use std::ops::Range;

use super::Graph;

/// The numbers of a search: both ends, the slope at which it ends, and its end.
pub const SEARCH: usize = 6;

/// The parts of a step, as one graph. Its inputs after the arguments belong to one part each.
pub struct StepGraph {
    /// The graph.
    pub graph: Graph,
    /// The solvers, of which one runs in a step: the first without the rows of joint limits, for
    /// steps in which no limit acts.
    pub solvers: Vec<SolverParts>,
    /// The results but the residual and the number of iterations. Inputs: the solution of a solver.
    pub results: Part,
}

/// The parts of a solver.
pub struct SolverParts {
    /// The number of rows of the constraints.
    pub rows: usize,
    /// The index of the output that leaves the solver out where it is at least zero.
    pub skip: Option<usize>,
    /// The accelerations of the rows before the first iteration. They have no inputs.
    pub first: Part,
    /// The full step of an iteration. Inputs: the accelerations and balances of the rows, the
    /// scale, the number of iterations. Outputs: accelerations and balances; scale, iterations,
    /// residual, end; the search; the scale of the inputs; their accelerations and balances.
    pub advance: Part,
    /// An evaluation of a line search. Inputs: accelerations and balances of the start and of the
    /// full step, the search without its end, the scale. Outputs: accelerations and balances; the
    /// search.
    pub search: Part,
    /// The solution: joint accelerations, those that move the state, forces. Inputs: the
    /// accelerations of the rows.
    pub solution: Part,
}

/// The inputs and outputs of a part of a graph.
pub struct Part {
    /// The numbers of the inputs.
    pub inputs: Range<usize>,
    /// The indices of the outputs.
    pub outputs: Range<usize>,
}

impl StepGraph {
    /// Returns the number of arguments: the inputs before the inputs of the parts.
    #[must_use]
    pub fn arguments(&self) -> usize {
        self.solvers[0].advance.inputs.start
    }

    /// Returns a step with the same parts in a graph that has so many further arguments.
    #[must_use]
    pub fn in_graph(self, graph: Graph, added: usize) -> Self {
        let part = |Part { inputs, outputs }| {
            let Range { start, end }: Range<usize> = inputs;
            Part { inputs: start + added..end + added, outputs }
        };
        let solvers = self.solvers.into_iter().map(|solver| SolverParts {
            first: part(solver.first),
            advance: part(solver.advance),
            search: part(solver.search),
            solution: part(solver.solution),
            ..solver
        });
        Self { graph, solvers: solvers.collect(), results: part(self.results) }
    }
}
