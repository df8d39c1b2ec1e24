//! The graph of the contracted Hessian of forward dynamics with contacts.
//!
//! The accelerations qdd and the wrenches l solve N(q, qd, tau, qdd, l) = 0: the equations of motion, and those of the
//! constrained accelerations. N is linear in qdd and l. With the solution z = (a, b) of the adjoint equations for the weights,
//! and Phi = z^T N at constant z, the gradient by x = (q, qd) is -Phi_x. With y = (qdd, l) and its derivatives Y, the Hessian is
//!
//! ```text
//! H_{q q}   = -(Phi_{q q} + Phi_{q y} Y_q + (Phi_{q y} Y_q)^T)    H_{q tau} = -Phi_{q y} Y_tau
//! H_{q qd}  = -(Phi_{q qd} + Phi_{q y} Y_qd)                      H_{qd tau} = H_{tau tau} = 0
//! H_{qd qd} = -Phi_{qd qd}
//! ```
//!
//! So neither the factorizations nor the selections of independent rows are differentiated.

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::kinematics::{self, Axes};
use modyn_runtime::equations::{ConstraintWorkspace, Workspace, constraints, dynamics};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::spatial::{Twist, Wrench};

use super::Tracer;
use super::composition::Composition;
use super::constraints::{settings_count, settings_of};
use super::tangent::{TangentGraphs, TangentInput};
use crate::graph::{Expr, Graph, Id};
use crate::passes::optimize;

/// The number of scalars of a wrench.
const WRENCH: usize = 6;

impl Tracer<'_> {
    /// Returns the graph of the accelerations, a wrench for each contact, the gradients of their weighted sum by `q` (in tangent
    /// space), `qd` and `tau`, the blocks (q, q), (q, qd), (qd, qd) and (q, tau) of its Hessian, by columns, and the rank.
    /// Inputs: `q`, `qd`, `tau`, the weights of the accelerations and of the wrenches, active contacts and settings. The mass
    /// matrix is factorized with `layout`.
    #[must_use]
    pub fn constrained_forward_dynamics_hessian(&self, layout: &UduLayout) -> Graph {
        let (nq, nv, contacts) = (self.model.nq, self.model.nv, self.model.contacts());
        let count = WRENCH * contacts;
        let mut all = Composition::new();
        let lengths = [nq, nv, nv, nv, count, contacts, settings_count(self.model)];
        let [q, qd, tau, x, y, active, settings] = lengths.map(|length| all.inputs(length));
        let parameters = all.inputs(self.parameters.len());

        let derivatives = self.constrained_forward_dynamics_derivatives(layout);
        let found = all.add(&derivatives, &[&q, &qd, &tau, &active, &settings, &parameters]);
        let (qdd, rest) = found.split_at(nv);
        let (wrenches, rest) = rest.split_at(count);
        let (accelerations, rest) = rest.split_at(3 * nv * nv);
        let (changes, rank) = rest.split_at(3 * nv * count);
        let adjoint = self.constraint_adjoint(layout);
        let adjoint = all.add(&adjoint, &[&q, &active, &settings, &x, &y, &parameters]);
        let (a, b) = adjoint.split_at(nv);

        let phi = TangentGraphs::new(self, self.phi_inputs(), optimize(self.phi(layout)));
        let [gradient, hessian] = phi.gradient_and_hessian(usize::MAX).expect("without a limit");
        let one = all.constant(1.0);
        let point = [&q[..], &qd, qdd, wrenches, a, b, &settings, &parameters, &[one]];
        let gradient = all.add(&gradient, &point);
        let hessian = all.add(&hessian, &point);
        // Phi has the rows and columns of q, qd, and y: the accelerations and the wrenches.
        let (ny, size) = (nv + count, 3 * nv + count);
        let block = |row: usize, rows: usize, column: usize, columns: usize| -> Vec<Id> {
            let columns = (column..column + columns).map(|j| &hessian[j * size + row..][..rows]);
            columns.flatten().copied().collect()
        };
        let by_y = block(0, nv, 2 * nv, ny);
        // By columns, the derivatives of y with respect to each of q, qd and tau.
        let through = |all: &mut Composition, variable: usize| -> Vec<Id> {
            let mut y = Vec::with_capacity(nv * ny);
            for j in 0..nv {
                y.extend(&accelerations[(variable * nv + j) * nv..][..nv]);
                for contact in 0..contacts {
                    let first = (variable * contacts + contact) * nv + j;
                    y.extend(&changes[first * WRENCH..][..WRENCH]);
                }
            }
            all.multiply_rows((&by_y, nv), &y, ny, 0..nv)
        };
        let by_q = through(&mut all, 0);
        let transposed: Vec<Id> = (0..nv * nv).map(|k| by_q[k % nv * nv + k / nv]).collect();
        let by_q = all.sums(&by_q, &transposed);
        let by_qd = through(&mut all, 1);
        let by_q = all.sums(&block(0, nv, 0, nv), &by_q);
        let by_qd = all.sums(&block(0, nv, nv, nv), &by_qd);
        let by_tau = through(&mut all, 2);
        let blocks = [by_q, by_qd, block(nv, nv, nv, nv), by_tau].concat();
        let blocks = all.negated(&blocks);
        let gradients = all.negated(&gradient[..2 * nv]);
        all.with_outputs(&[qdd, wrenches, &gradients, a, &blocks, rank])
    }

    /// Returns the graph of the accelerations and the wrenches that solve the adjoint equations. Inputs: `q`, active contacts,
    /// settings, and the weights of the accelerations and of the wrenches.
    fn constraint_adjoint(&self, layout: &UduLayout) -> Graph {
        let (nv, contacts) = (self.model.nv, self.model.contacts());
        let lengths = [self.model.nq, contacts, settings_count(self.model), nv, WRENCH * contacts];
        self.trace_groups(lengths, |model, [q, active, settings, x, y]| {
            let (mut a, mut b) = (self.vector(), vec![Wrench::zero(); contacts]);
            constraints::constraint_adjoint(
                model,
                layout,
                &q,
                (&active, &settings_of(&settings)),
                (&mut Workspace::new(model), &mut ConstraintWorkspace::new(model, layout)),
                (&x, &wrenches_of(&y)),
                (&mut a, &mut b),
            );
            a.into_iter().chain(b.iter().flat_map(Wrench::components)).collect()
        })
    }

    /// Returns the arguments of Phi: `q`, `qd`, the accelerations and the wrenches, which vary, and a, b and the settings.
    fn phi_inputs(&self) -> Vec<TangentInput> {
        let (nv, count) = (self.model.nv, WRENCH * self.model.contacts());
        let input = |len, varies| TangentInput { len, is_coordinates: false, varies };
        vec![
            TangentInput { len: self.model.nq, is_coordinates: true, varies: true },
            input(nv, true),
            input(nv, true),
            input(count, true),
            input(nv, false),
            input(count, false),
            input(settings_count(self.model), false),
        ]
    }

    /// Returns the graph of Phi = a^T (ID(q, qd, qdd) - J^T l) + b^T c. c is the acceleration of the contacts' frames with
    /// their stabilization: (J qdd - gamma) without compliance, which has no effect on the derivatives by q and qd.
    fn phi(&self, layout: &UduLayout) -> Graph {
        let (nq, nv, contacts) = (self.model.nq, self.model.nv, self.model.contacts());
        let count = WRENCH * contacts;
        let lengths = [nq, nv, nv, count, nv, count, settings_count(self.model)];
        self.trace_groups(lengths, |model, [q, qd, qdd, l, a, b, settings]| {
            let workspace = &mut Workspace::new(model);
            let mut tau = self.vector();
            let motion = (&*q, &*qd, Some(&*qdd));
            dynamics::inverse_dynamics(model, motion, None, workspace, &mut tau);
            let mut phi = dot(&a, &tau);
            let ends = model.constraints.iter().map(|constraint| constraint.ends[1]);
            let frames = Mechanism { frames: ends.collect(), ..model.clone() };
            let targets = settings_of(&settings).contacts;
            let twists = || vec![Twist::zero(); contacts];
            let (mut displacements, mut velocities) = (twists(), twists());
            let memory = &mut ConstraintWorkspace::new(model, layout);
            let results = (&mut *displacements, &mut *velocities);
            let rooms = (&mut *workspace, memory);
            constraints::constraint_residual(model, (&q, &qd), &targets, rooms, results);
            for (k, target) in targets.iter().enumerate() {
                let [l, b] = [&l, &b].map(|wrenches| &wrenches[WRENCH * k..][..WRENCH]);
                let state = (&*q, &*a);
                let moved = kinematics::link_velocity(&frames, k, state, Axes::World, workspace);
                phi = phi - dot(l, &moved.components());
                let (motion, axes) = ((&*q, &*qd, &*qdd), Axes::World);
                let mut c = kinematics::link_acceleration(&frames, k, motion, axes, workspace);
                c = c + velocities[k].scale(target.alpha + target.alpha);
                c = c + displacements[k].scale(target.beta * target.beta);
                phi = phi + dot(b, &c.components());
            }
            vec![phi]
        })
    }
}

fn dot(a: &[Expr], b: &[Expr]) -> Expr {
    let products = a.iter().zip(b).map(|(&a, &b)| a * b);
    products.reduce(|sum, product| sum + product).unwrap_or(Expr::zero())
}

/// Returns wrenches from their components.
fn wrenches_of(numbers: &[Expr]) -> Vec<Wrench<Expr>> {
    let (wrenches, _) = numbers.as_chunks::<WRENCH>();
    wrenches.iter().map(|&components| Wrench::from_components(components)).collect()
}
