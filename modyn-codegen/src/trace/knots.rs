//! The graphs of knots, from the derivatives of forward dynamics.
//!
//! With the derivatives F of the accelerations by a variable, the derivatives of the velocities
//! qd' = qd + h qdd are h F (+ 1 by qd). Where F is the product A B of matrices apart, these are the
//! products (h A) B.

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::mechanism::coordinates::quaternion_blocks;

use super::composition::Composition;
use super::constraints::settings_count;
use super::{DenseLoops, Tracer};
use crate::graph::dense::{ProductForm, ProductTarget, row_results};
use crate::graph::{Graph, Id, Node};

/// The dynamics of a knot.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Dynamics {
    /// Forward dynamics.
    Free,
    /// Forward dynamics with closed loops and contacts.
    Constrained,
}

impl Tracer<'_> {
    /// Returns the graph of the velocities after a semi-implicit step, their derivatives with
    /// respect to q, qd and tau, by rows, and the derivatives of the coordinates at quaternions.
    /// Inputs: `q`, `qd`, `tau` and the time.
    #[must_use]
    pub fn knot(&self, layout: &UduLayout) -> Graph {
        self.knot_of(Dynamics::Free, &self.forward_dynamics_derivatives(layout))
    }

    /// Returns the graph of the velocities after a semi-implicit step under constraints, the
    /// wrenches, the derivatives of the step, the derivatives of the wrenches, and the rank. Inputs:
    /// `q`, `qd`, `tau`, the time, active contacts and settings.
    #[must_use]
    pub fn constrained_knot(&self, layout: &UduLayout) -> Graph {
        // The time is not among the inputs of the dynamics.
        let rows = self.loops.rows.map(|first| first - 1);
        let dynamics = self.with_loops(DenseLoops { rows, ..self.loops });
        self.knot_of(
            Dynamics::Constrained,
            &dynamics.constrained_forward_dynamics_derivatives(layout),
        )
    }

    /// Returns the graph of a knot from the graph of the derivatives of its dynamics, whose dense
    /// parts stay apart.
    fn knot_of(&self, dynamics: Dynamics, graph: &Graph) -> Graph {
        let nq = self.model.nq;
        let n = self.model.nv;
        let mut all = Composition::new();
        let [q, qd, tau, dt] = [nq, n, n, 1].map(|count| all.inputs(count));
        let constraints = match dynamics {
            Dynamics::Free => Vec::new(),
            Dynamics::Constrained => all.inputs(self.model.contacts() + settings_count(self.model)),
        };
        let parameters = all.inputs(self.parameters.len());
        let of_rows = graph.dense.rows.as_ref().map_or_else(Vec::new, |form| {
            debug_assert_eq!(self.loops.rows, Some(all.inputs));
            all.inputs(row_results(self.rows(), form.sides))
        });
        let groups = [&q[..], &qd, &tau, &constraints, &parameters, &of_rows];
        let outputs = all.add(graph, &groups);
        let dt = dt[0];

        let wrenches = match dynamics {
            Dynamics::Free => 0,
            Dynamics::Constrained => 6 * self.model.constraints.len(),
        };
        let (qdd, after_qdd) = outputs.split_at(n);
        let (wrenches, derivatives) = after_qdd.split_at(wrenches);
        let (changes, after_changes) = derivatives.split_at(3 * n * n);
        let of_wrenches = 3 * n * wrenches.len() + usize::from(dynamics == Dynamics::Constrained);
        let (changes_of_wrenches, operands) = after_changes.split_at(of_wrenches);

        let change: Vec<Id> = qdd.iter().map(|&x| all.scaled_lane(dt, x)).collect();
        let next = all.sums(&qd, &change);
        let mut matrices: Vec<Id> = Vec::with_capacity(3 * n * n);
        for matrix in changes.chunks((n * n).max(1)) {
            let rows = (0..n).flat_map(|i| (0..n).map(move |j| matrix[j * n + i]));
            matrices.extend(rows.map(|x| all.scaled_lane(dt, x)));
        }
        let one = all.constant(1.0);
        for entry in matrices[n * n..2 * n * n].iter_mut().step_by(n + 1) {
            *entry = all.sum(one, *entry);
        }
        let displacement = all.scaled(dt, &next);
        let moved = all.add(&self.integrate_derivatives(), &[&q, &displacement, &parameters]);
        let zero = all.constant(0.0);
        let mut blocks = Vec::new();
        for matrix in moved.chunks((n * n).max(1)) {
            let places = quaternion_blocks(&self.model.coordinates, n);
            blocks.extend(places.map(|place| place.map_or(zero, |place| matrix[place])));
        }

        let first = n + wrenches.len();
        let products = graph.dense.products.clone();
        let form = products.map(|form| KnotForm { first, n, blocks: blocks.len(), form });
        let operands = form.as_ref().map_or_else(
            || operands.to_vec(),
            |form| form.operands(operands, |x| all.scaled_lane(dt, x)),
        );
        let groups = [&next[..], wrenches, &matrices, &blocks, changes_of_wrenches, &operands];
        let mut knot = all.with_outputs(&groups);
        knot.dense.rows.clone_from(&graph.dense.rows);
        knot.dense.products = form.map(KnotForm::placed);
        knot
    }
}

/// The products of the derivatives of dynamics, which become the products of a knot.
struct KnotForm {
    /// The first result of the derivatives of accelerations, then of velocities.
    first: usize,
    /// The number of degrees of freedom.
    n: usize,
    /// The number of results of blocks at quaternions.
    blocks: usize,
    form: ProductForm,
}

impl KnotForm {
    /// Returns whether a target is of derivatives of accelerations.
    fn is_of_accelerations(&self, target: &ProductTarget) -> bool {
        target.first < self.first + 3 * self.n * self.n
    }

    /// Returns the operands of the products and of equations of rows with the rows of derivatives of
    /// accelerations scaled.
    fn operands(&self, operands: &[Id], mut scaled: impl FnMut(Id) -> Id) -> Vec<Id> {
        let ProductForm { rows, terms, ref targets, .. } = self.form;
        let of_accelerations = targets[0].iter().filter(|target| self.is_of_accelerations(target));
        let mut is_scaled = vec![false; rows];
        of_accelerations.for_each(|target| is_scaled[target.rows.clone()].fill(true));
        let mut all = operands.to_vec();
        for (entry, x) in all[..rows * terms].iter_mut().enumerate() {
            if is_scaled[entry % rows] {
                *x = scaled(*x);
            }
        }
        all
    }

    /// Returns the form with the places of the knot's results: derivatives of velocities by rows,
    /// and derivatives of wrenches after the blocks.
    fn placed(mut self) -> ProductForm {
        let n = self.n;
        let size = n * n;
        for target in self.form.targets.iter_mut().flatten() {
            if target.first < self.first + 3 * size {
                let place = target.first - self.first;
                target.first = self.first + place / size * size + place % size * n;
                target.by_row = n;
                target.by_column = 1;
            } else {
                target.first += self.blocks;
            }
        }
        self.form.results += self.blocks;
        self.form
    }
}

impl Composition {
    /// Returns the product with a factor. The lanes of a pack are scaled together.
    fn scaled_lane(&mut self, factor: Id, x: Id) -> Id {
        match self.graph.node(x) {
            Node::ExtractLane(pack, lane) => {
                let scaled = self.product(factor, pack);
                self.graph.make(Node::ExtractLane(scaled, lane))
            }
            Node::Neg(x) => {
                let scaled = self.scaled_lane(factor, x);
                self.graph.make(Node::Neg(scaled))
            }
            _ => self.product(factor, x),
        }
    }
}
