//! The graphs of functions whose columns are solved for by one graph.

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::ColumnEquations;
use modyn_runtime::equations::factorization::MergedUduLayout;
use modyn_runtime::equations::{ConstraintWorkspace, Workspace};
use modyn_runtime::spatial::Wrench;

use super::Tracer;
use super::constraints::{settings_count, settings_of};
use crate::graph::{Expr, Graph, Id};
use crate::passes::optimize;

/// A graph, and the graph that computes a part of its results for each of several columns.
#[derive(Clone, Debug)]
pub struct ColumnsGraph {
    /// The graph of all numbers that are no results of columns.
    pub graph: Graph,
    /// The graph of a column. Its inputs are the numbers of the column, then those that all columns have in common.
    pub column: Graph,
    /// For each column the numbers that the graph of a column receives, as outputs of the first graph.
    pub columns: Vec<Vec<usize>>,
    /// The numbers that all columns have in common, as outputs of the first graph.
    pub common: Vec<usize>,
    /// The results.
    pub results: Vec<ColumnResult>,
    /// The columns that are computed together.
    pub lanes: usize,
}

/// A result of a function with columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnResult {
    /// An output of the first graph.
    Output(usize),
    /// An output of the graph of a column, for this column.
    OfColumn {
        /// The column.
        column: usize,
        /// The output.
        output: usize,
    },
}

/// The lists of outputs of a graph.
#[derive(Default)]
struct Outputs(Vec<Expr>);

impl Outputs {
    /// Adds outputs, and returns their indices.
    fn add(&mut self, outputs: impl IntoIterator<Item = Expr>) -> Vec<usize> {
        let first = self.0.len();
        self.0.extend(outputs);
        (first..self.0.len()).collect()
    }
}

impl Tracer<'_> {
    /// Returns the graphs of
    /// [`constrained_forward_dynamics_derivatives`](Self::constrained_forward_dynamics_derivatives), of which one computes a column.
    #[must_use]
    pub fn constrained_forward_dynamics_derivatives_by_columns(
        &self,
        layout: &UduLayout,
    ) -> ColumnsGraph {
        let (nq, n, contacts) = (self.model.nq, self.model.nv, self.model.contacts());
        let count = self.model.constraints.len();
        let groups = [nq, n, n, contacts, settings_count(self.model)];
        let (mut common, mut first, mut rank) = (Vec::new(), Vec::new(), Vec::new());
        let mut columns: Vec<Vec<usize>> = Vec::new();
        let graph = self.trace_groups(groups, |model, [q, qd, tau, active, settings]| {
            let (mut qdd, mut wrenches) = (self.vector(), vec![Wrench::zero(); count]);
            let model = &self.with_column_lanes(model);
            let layout = &MergedUduLayout::new(model, layout.clone());
            let equations = ColumnEquations::new(
                model,
                layout,
                (&q, &qd, &tau),
                (&active, &settings_of(&settings)),
                (&mut Workspace::new(model), &mut ConstraintWorkspace::new(model, layout)),
                (&mut qdd, &mut wrenches),
            );
            let ColumnEquations { forces, accelerations, common: numbers, rank: of } = equations;
            let mut outputs = Outputs::default();
            let components = wrenches.iter().flat_map(Wrench::components);
            first = outputs.add(qdd.into_iter().chain(components));
            rank = outputs.add([of]);
            common = outputs.add(numbers);
            let mut column = |force: &dyn Fn(usize) -> Expr, change: &dyn Fn(usize) -> Expr| {
                let rows = accelerations[0].len() / n.max(1);
                columns.push(outputs.add((0..n).map(force).chain((0..rows).map(change))));
            };
            for (f, c) in forces.iter().zip(&accelerations) {
                (0..n).for_each(|j| column(&|i| f[j * n + i], &|r| c[r * n + j]));
            }
            for j in 0..n {
                let minus_one = |i| if i == j { -Expr::one() } else { Expr::zero() };
                column(&minus_one, &|_| Expr::zero());
            }
            outputs.0
        });
        let graph = optimize(graph);
        let (column, common) = self.column(&graph, &common, |numbers, own| {
            let model = self.model.cast();
            let model = &self.with_column_lanes(&model);
            let layout = &MergedUduLayout::new(model, layout.clone());
            let (mut dqdd, mut wrenches) = (self.vector(), vec![Wrench::zero(); count]);
            let results = (&mut *dqdd, &mut *wrenches);
            ColumnEquations::solve(model, layout, numbers, own.split_at(n), results);
            dqdd.into_iter().chain(wrenches.iter().flat_map(Wrench::components)).collect()
        });
        let matrices = (0..3 * n).flat_map(|column| (0..n).map(move |output| (column, output)));
        let of_wrench = |matrix: usize, c: usize| {
            let component = move |j| (0..6).map(move |k| (matrix * n + j, n + 6 * c + k));
            (0..n).flat_map(component)
        };
        let wrenches = (0..3).flat_map(|matrix| (0..count).flat_map(move |c| of_wrench(matrix, c)));
        let of_columns = matrices.chain(wrenches);
        let of_columns =
            of_columns.map(|(column, output)| ColumnResult::OfColumn { column, output });
        let outputs = |of: Vec<usize>| of.into_iter().map(ColumnResult::Output);
        let results = outputs(first).chain(of_columns).chain(outputs(rank)).collect();
        ColumnsGraph { graph, column, columns, common, results, lanes: self.columns }
    }

    /// Returns the graph of a column, and which of the `common` outputs it reads. Outputs that are constants are folded, and equal ones
    /// are one input. `equations` receive the common numbers and those of the column.
    fn column(
        &self,
        graph: &Graph,
        common: &[usize],
        equations: impl Fn(&[Expr], &[Expr]) -> Vec<Expr>,
    ) -> (Graph, Vec<usize>) {
        let rows: usize = self.model.constraints.iter().map(|c| c.rows.len()).sum();
        let own = self.model.nv + rows;
        let trace = |read: &dyn Fn(Id) -> Option<usize>| {
            optimize(Graph::trace(|| {
                let number = |&output: &usize| {
                    let id = graph.outputs[output];
                    match (graph.value(id), read(id)) {
                        (Some(value), _) => Expr::from_f64(value),
                        (None, Some(place)) => Expr::input(own + place),
                        (None, None) => Expr::zero(),
                    }
                };
                let numbers: Vec<Expr> = common.iter().map(number).collect();
                equations(&numbers, &(0..own).map(Expr::input).collect::<Vec<_>>())
            }))
        };
        let first = |id: Id| common.iter().position(|&output| graph.outputs[output] == id);
        let read = trace(&first).live_inputs();
        let read: Vec<usize> = read.into_iter().filter_map(|i| i.checked_sub(own)).collect();
        let place = |id: Id| read.iter().position(|&k| graph.outputs[common[k]] == id);
        (trace(&place), read.iter().map(|&k| common[k]).collect())
    }
}
