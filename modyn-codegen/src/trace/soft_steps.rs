//! The graph of a step with soft constraints, before it is cut into what runs once and what runs in
//! each iteration of the solver.

use std::ops::Range;

use modyn_runtime::Scalar;
use modyn_runtime::equations::Workspace;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::soft_constraints::{
    Advance, Iterate, Progress, Search, SoftModel, StepInput, StepProblem,
};
use modyn_runtime::{ContactSurface, StepSettings};

use super::Tracer;
use crate::graph::{Expr, Graph};

/// The parts of a step, as one graph. Its inputs after the arguments belong to one part each.
pub struct StepGraph {
    /// The graph.
    pub graph: Graph,
    /// The number of rows of the constraints.
    pub rows: usize,
    /// The full step of an iteration. Inputs: the accelerations and balances of the rows, the
    /// scale, the number of iterations. Outputs: accelerations and balances; scale, iterations,
    /// residual, end; the search.
    pub advance: Part,
    /// An evaluation of a line search. Inputs: accelerations and balances of the start and of the
    /// full step, the search without its end, the scale. Outputs: accelerations and balances; the
    /// search.
    pub search: Part,
    /// The accelerations of the rows before the first iteration. They have no inputs.
    pub first: Part,
    /// The state and forces after the step. Inputs: the accelerations of the rows.
    pub solution: Part,
}

/// The inputs and outputs of a part of a graph.
pub struct Part {
    /// The numbers of the inputs.
    pub inputs: Range<usize>,
    /// The indices of the outputs.
    pub outputs: Range<usize>,
}

/// The numbers of a search: both ends, the slope at which it ends, and its end.
pub const SEARCH: usize = 6;

impl Tracer<'_> {
    /// Returns the parts of a step. Arguments: q, qd, tau, dt, the accelerations to start from, the
    /// settings.
    #[must_use]
    pub fn step(&self, elimination: &Elimination, soft: &SoftModel<f64>) -> StepGraph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let surfaces = ContactSurface::<Expr>::COUNT * self.model.contacts();
        let settings = StepSettings::<Expr>::COUNT + surfaces;
        let arguments = nq + 3 * nv + 1 + settings + self.parameters.len();
        let mut parts = Vec::new();
        let mut rows = 0;
        let groups = [nq, nv, nv, 1, nv, settings];
        let graph = self.trace_groups(groups, |model, [q, qd, tau, dt, warm_start, settings]| {
            let input = StepInput { q: &q, qd: &qd, tau: &tau, warm_start: &warm_start, dt: dt[0] };
            let settings = settings_of(&settings);
            let soft = soft.map(Expr::from_f64);
            let model = &model.without_friction();
            let mut workspace = Workspace::new(model);
            let mut problem =
                StepProblem::new(model, elimination, input, (&soft, &settings), &mut workspace);
            rows = problem.rows();
            let mut inputs = Inputs { next: arguments };
            let mut outputs = Vec::new();
            let mut part = |inputs: Range<usize>, numbers: Vec<Expr>| {
                let start = outputs.len();
                outputs.extend(numbers);
                parts.push(Part { inputs, outputs: start..outputs.len() });
            };
            let first = problem.first();
            part(0..0, first.accelerations);

            let begin = inputs.next;
            let start = inputs.iterate(rows);
            let [scale, iterations] = inputs.array();
            let progress = Progress { scale, iterations, ..Progress::first() };
            let Advance { end, progress, search } = problem.advance(&start, &progress);
            let Progress { scale, iterations, residual, end: ends } = progress;
            let numbers = [scale, iterations, residual, ends];
            part(
                begin..inputs.next,
                [&end.accelerations[..], &end.balances, &numbers, &search_numbers(&search)]
                    .concat(),
            );

            let begin = inputs.next;
            let [start, end] = [inputs.iterate(rows), inputs.iterate(rows)];
            let [low_place, low_slope, high_place, high_slope, least, scale] = inputs.array();
            let search = Search {
                low: [low_place, low_slope],
                high: [high_place, high_slope],
                least,
                end: Expr::zero(),
            };
            let (point, search) = problem.search([&start, &end], &search, scale);
            part(
                begin..inputs.next,
                [&point.accelerations[..], &point.balances, &search_numbers(&search)].concat(),
            );

            let begin = inputs.next;
            let accelerations = inputs.list(rows);
            let end = Iterate { accelerations, balances: vec![Expr::zero(); rows] };
            let solution = problem.solution(&end);
            part(
                begin..inputs.next,
                [&solution.q[..], &solution.qd, &solution.qdd, &solution.forces.concat()].concat(),
            );
            outputs
        });
        let [first, advance, search, solution] =
            <[Part; 4]>::try_from(parts).unwrap_or_else(|_| unreachable!("four parts are traced"));
        StepGraph { graph, rows, advance, search, first, solution }
    }
}

/// The next input of a part.
struct Inputs {
    next: usize,
}

impl Inputs {
    fn list(&mut self, count: usize) -> Vec<Expr> {
        self.next += count;
        (self.next - count..self.next).map(Expr::input).collect()
    }

    fn array<const N: usize>(&mut self) -> [Expr; N] {
        self.next += N;
        core::array::from_fn(|k| Expr::input(self.next - N + k))
    }

    fn iterate(&mut self, rows: usize) -> Iterate<Expr> {
        Iterate { accelerations: self.list(rows), balances: self.list(rows) }
    }
}

/// Returns the numbers of a search.
fn search_numbers(search: &Search<Expr>) -> [Expr; SEARCH] {
    let Search { low: [low, low_slope], high: [high, high_slope], least, end } = *search;
    [low, low_slope, high, high_slope, least, end]
}

/// Returns the settings of a step.
fn settings_of(numbers: &[Expr]) -> StepSettings<Expr, Vec<ContactSurface<Expr>>> {
    let (settings, surfaces) = numbers.split_first_chunk().expect("the settings are counted");
    let surfaces = surfaces.as_chunks().0.iter();
    let contacts = surfaces.map(|surface| ContactSurface::from_numbers(*surface)).collect();
    StepSettings::from_numbers(*settings, contacts)
}
