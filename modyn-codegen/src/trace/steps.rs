//! The graph of the derivatives of a semi-implicit Euler step, from the derivatives of forward
//! dynamics.
//!
//! A step is qd' = qd + h qdd and q' = q (+) h qd'. With the derivatives P and J of (+) by q and by
//! the displacement, and the change F of the accelerations by a variable, the changes by that
//! variable are
//!
//! ```text
//! of qd':  G = h F    (+ 1 by qd)
//! of q':   h J G      (+ P by q)
//! ```

use modyn_runtime::equations::brge::UduLayout;

use super::Tracer;
use super::composition::Composition;
use crate::graph::{Graph, Id};

/// The effects of the accelerations on the state after a step.
struct Effects<'a> {
    dt: Id,
    /// J, by columns.
    by_displacement: &'a [Id],
    /// The columns of derivatives that share lanes.
    groups: Vec<Vec<usize>>,
}

impl Effects<'_> {
    /// Returns the changes of q' and qd', by columns of both, from the changes of the accelerations
    /// and from the changes of q and qd with constant accelerations.
    fn columns(&self, all: &mut Composition, changes: &[Id], constant: [&[Id]; 2]) -> Vec<Id> {
        let n = changes.len().isqrt();
        let mut columns = vec![Vec::new(); n];
        for group in &self.groups {
            let row = |all: &mut Composition, matrix: &[Id], row: usize| {
                let lanes: Vec<Id> = group.iter().map(|&column| matrix[column * n + row]).collect();
                let is_zero = lanes.iter().all(|&x| all.graph.value(x) == Some(0.0));
                if is_zero { lanes[0] } else { all.pack(&lanes) }
            };
            let mut rates = Vec::new();
            for i in 0..n {
                let change = row(all, changes, i);
                let before = row(all, constant[1], i);
                let rate = all.product(self.dt, change);
                rates.push(all.sum(before, rate));
            }
            let mut moved = Vec::new();
            for i in 0..n {
                let by = self.by_displacement.iter().skip(i).step_by(n).copied();
                let sum = all.graph.sum_of_products(by.zip(rates.iter().copied()));
                let change = all.product(self.dt, sum);
                let before = row(all, constant[0], i);
                moved.push(all.sum(before, change));
            }
            for (lane, &column) in group.iter().enumerate() {
                let entries = moved.iter().chain(&rates);
                columns[column] = entries.map(|&entry| all.lane(entry, lane)).collect();
            }
        }
        columns.concat()
    }
}

impl Tracer<'_> {
    /// Returns the graph of the coordinates and velocities after a semi-implicit Euler step, and of
    /// their derivatives by the state and by `tau`, by columns. Inputs: `q`, `qd`, `tau` and the
    /// time. The mass matrix is factorized with `layout`.
    #[must_use]
    pub fn step_semi_implicit_derivatives(&self, layout: &UduLayout) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, qd, tau, dt] = [nq, nv, nv, 1].map(|count| all.inputs(count));
        let dt = dt[0];
        let parameters = all.inputs(self.parameters.len());
        let graph = self.forward_dynamics_derivatives(layout);
        let dynamics = all.add(&graph, &[&q, &qd, &tau, &parameters]);
        let (qdd, changes) = dynamics.split_at(nv);
        let [by_q, by_qd, by_tau] = [0, 1, 2].map(|m| &changes[m * nv * nv..][..nv * nv]);

        let change = all.scaled(dt, qdd);
        let next_qd = all.sums(&qd, &change);
        let displacement = all.scaled(dt, &next_qd);
        let moving = [&q[..], &displacement, &parameters];
        let next_q = all.add(&self.integrate(), &moving);
        let moved = all.add(&self.integrate_derivatives(), &moving);
        let (by_start, by_displacement) = moved.split_at(nv * nv);

        let groups = match self.limbs {
            // The columns of a lane have their own rows.
            Some(_) => (0..nv).map(|column| vec![column]).collect(),
            None => {
                let groups = self.column_groups().into_iter();
                groups.map(|group| group.into_iter().flatten().collect()).collect()
            }
        };
        let effects = Effects { dt, by_displacement, groups };
        let none = vec![all.constant(0.0); nv * nv];
        let unit: Vec<Id> = (0..nv).flat_map(|column| all.graph.unit_vector(nv, column)).collect();
        let columns = [
            effects.columns(&mut all, by_q, [by_start, &none]),
            effects.columns(&mut all, by_qd, [&none, &unit]),
            effects.columns(&mut all, by_tau, [&none, &none]),
        ];
        all.with_outputs(&[&next_q, &next_qd, &columns.concat()])
    }
}
