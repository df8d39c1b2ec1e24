//! The graph of the contracted Hessian of forward dynamics with loop constraints and contacts.
//!
//! The accelerations qdd and the wrenches l solve N(q, qd, tau, qdd, l) = 0: the equations of
//! motion, and the derivatives of the constrained accelerations. N is linear in qdd and l. With the
//! solution z = (a, b) of the adjoint equations for the weights, and Phi = z^T N at constant z, the
//! gradient by x = (q, qd) is -Phi_x. With y = (qdd, l) and its derivatives Y, the Hessian is
//!
//! ```text
//! H_{q q}   = -(Phi_{q q} + Phi_{q y} Y_q + (Phi_{q y} Y_q)^T)    H_{q tau} = -Phi_{q y} Y_tau
//! H_{q qd}  = -(Phi_{q qd} + Phi_{q y} Y_qd)                      H_{qd tau} = H_{tau tau} = 0
//! H_{qd qd} = -Phi_{qd qd}
//! ```
//!
//! So neither the factorizations nor the selections of independent rows are differentiated.
//!
//! Where rows depend on others, l and b have the smallest norms. Then N_y Y = -N_x still holds, and
//! N_y^T z = w for weights w of the accelerations alone: these two are all that the Hessian follows
//! from, so it is exact. Weights of wrenches are not in the range of N_y^T then.

use std::ops::Range;

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::{
    ConstrainedCotangent, ConstraintInput, ConstraintWorkspaces, ResidualOutputs,
};
use modyn_runtime::equations::kinematics::{self, Axes};
use modyn_runtime::equations::{
    ConstraintWorkspace, Motion, State, Workspace, constraints, dynamics,
};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::spatial::{Twist, Wrench};
use modyn_runtime::{ContactTarget, Scalar};

use super::Tracer;
use super::composition::Composition;
use super::constraints::{settings_count, settings_of};
use super::tangent::{TangentGraphs, TangentInput};
use crate::graph::{Expr, Graph, Id};
use crate::passes::optimize;

/// The number of scalars of a wrench.
const WRENCH: usize = 6;

impl Tracer<'_> {
    /// Returns the graph of the accelerations, a wrench for each constraint, the gradients of their
    /// weighted sum by `q` (in tangent space), `qd` and `tau`, the blocks (q, q), (q, qd), (qd, qd)
    /// and (q, tau) of its Hessian, by columns, and the rank. Inputs: `q`, `qd`, `tau`, the weights
    /// of the accelerations and of the wrenches, active contacts and settings. The mass matrix is
    /// factorized with `layout`.
    #[must_use]
    pub fn constrained_forward_dynamics_hessian(&self, layout: &UduLayout) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let contacts = self.model.contacts();
        let constraints = self.model.constraints.len();
        let count = WRENCH * constraints;
        let mut all = Composition::new();
        let lengths = [nq, nv, nv, nv, count, contacts, settings_count(self.model)];
        let [q, qd, tau, x, y, active, settings] = lengths.map(|length| all.inputs(length));
        let parameters = all.inputs(self.parameters.len());

        let derivatives = self.constrained_forward_dynamics_derivatives(layout);
        let results = all.add(&derivatives, &[&q, &qd, &tau, &active, &settings, &parameters]);
        let (qdd, rest) = results.split_at(nv);
        let (wrenches, rest) = rest.split_at(count);
        let (accelerations, rest) = rest.split_at(3 * nv * nv);
        let (changes, rank) = rest.split_at(3 * nv * count);
        let graph = self.constraint_adjoint(layout);
        let adjoint = all.add(&graph, &[&q, &active, &settings, &x, &y, &parameters]);
        let (a, b) = adjoint.split_at(nv);

        let phi = TangentGraphs::new(self, self.phi_inputs(), optimize(self.phi(layout)));
        let [gradient, hessian] = phi.gradient_and_hessian(usize::MAX).expect("without a limit");
        let one = all.constant(1.0);
        let point = [&q[..], &qd, qdd, wrenches, a, b, &settings, &parameters, &[one]];
        let gradient = all.add(&gradient, &point);
        let hessian = all.add(&hessian, &point);
        // Phi has the rows and columns of q, qd, and y: the accelerations and the wrenches.
        let ny = nv + count;
        let size = 3 * nv + count;
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
                for constraint in 0..constraints {
                    let first = (variable * constraints + constraint) * nv + j;
                    y.extend(&changes[first * WRENCH..][..WRENCH]);
                }
            }
            all.multiply_rows(&by_y, nv, &y, ny, 0..nv)
        };
        let by_q = through(&mut all, 0);
        let transposed: Vec<Id> = (0..nv * nv).map(|k| by_q[k % nv * nv + k / nv]).collect();
        let by_q = all.sums(&by_q, &transposed);
        let by_qd = through(&mut all, 1);
        let by_q = all.sums(&block(0, nv, 0, nv), &by_q);
        let by_qd = all.sums(&block(0, nv, nv, nv), &by_qd);
        let by_tau = through(&mut all, 2);
        let upper = [by_q, by_qd, block(nv, nv, nv, nv), by_tau].concat();
        let blocks = all.negated(&upper);
        let gradients = all.negated(&gradient[..2 * nv]);
        all.with_outputs(&[qdd, wrenches, &gradients, a, &blocks, rank])
    }

    /// Returns the graph of the accelerations and the wrenches that solve the adjoint equations.
    /// Inputs: `q`, active contacts, settings, and the weights of the accelerations and of the
    /// wrenches.
    fn constraint_adjoint(&self, layout: &UduLayout) -> Graph {
        let nv = self.model.nv;
        let constraints = self.model.constraints.len();
        let contacts = self.model.contacts();
        let settings = settings_count(self.model);
        let lengths = [self.model.nq, contacts, settings, nv, WRENCH * constraints];
        self.trace_groups(lengths, |model, [q, active, settings, x, y]| {
            let adjoint = constraints::constraint_adjoint(
                model,
                layout,
                &q,
                ConstraintInput { active: &active, settings: &settings_of(&settings) },
                ConstraintWorkspaces {
                    workspace: &mut Workspace::new(model),
                    memory: &mut ConstraintWorkspace::new(model, layout),
                },
                ConstrainedCotangent { qdd: &x, wrenches: &wrenches_of(&y) },
            );
            let wrenches = adjoint.wrenches.iter().flat_map(Wrench::components);
            adjoint.accelerations.iter().copied().chain(wrenches).collect()
        })
    }

    /// Returns the arguments of Phi: `q`, `qd`, the accelerations and the wrenches, which vary, and
    /// a, b and the settings.
    fn phi_inputs(&self) -> Vec<TangentInput> {
        let nv = self.model.nv;
        let count = WRENCH * self.model.constraints.len();
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

    /// Returns the graph of Phi = a^T (ID(q, qd, qdd) - J^T l) + b^T c. c is the relative
    /// acceleration of the constraints' frames with their stabilization: (J qdd - gamma) without
    /// compliance, which has no effect on the derivatives by q and qd.
    fn phi(&self, layout: &UduLayout) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let constraints = self.model.constraints.len();
        let count = WRENCH * constraints;
        let lengths = [nq, nv, nv, count, nv, count, settings_count(self.model)];
        self.trace_groups(lengths, |model, [q, qd, qdd, l, a, b, settings]| {
            let workspaces = &mut ConstraintWorkspaces {
                workspace: &mut Workspace::new(model),
                memory: &mut ConstraintWorkspace::new(model, layout),
            };
            let mut tau = self.vector();
            let state = State { q: &q, qd: &qd };
            let motion = state.with_accelerations(&qdd);
            dynamics::inverse_dynamics(
                model,
                state,
                Some(&qdd),
                None,
                workspaces.workspace,
                &mut tau,
            );
            let settings = settings_of(&settings);
            let targets = &*settings.targets;
            let moved = relative_velocities(model, targets, State { q: &q, qd: &a }, workspaces);
            let accelerations = relative_accelerations(model, targets, motion, workspaces);
            let [displacements, velocities] = residuals(model, targets, state, workspaces);
            let mut phi = dot(&a, &tau);
            for k in 0..constraints {
                let (alpha, beta) = match k.checked_sub(contacts(model).start) {
                    None => (settings.alpha, settings.beta),
                    Some(contact) => (targets[contact].alpha, targets[contact].beta),
                };
                let c = accelerations[k]
                    + velocities[k].scale(alpha + alpha)
                    + displacements[k].scale(beta * beta);
                let [l, b] = [&l, &b].map(|wrenches| &wrenches[WRENCH * k..][..WRENCH]);
                phi = phi - dot(l, &moved[k].components()) + dot(b, &c.components());
            }
            vec![phi]
        })
    }
}

/// Returns the displacements and the velocities of all constraints relative to their targets.
fn residuals(
    model: &Mechanism<Expr>,
    targets: &[ContactTarget<Expr>],
    state: State<'_, Expr>,
    workspaces: &mut ConstraintWorkspaces<'_, Expr>,
) -> [Vec<Twist<Expr>>; 2] {
    let mut results = [(); 2].map(|()| vec![Twist::zero(); model.constraints.len()]);
    let [displacements, velocities] = &mut results;
    let outputs = ResidualOutputs { displacements, velocities };
    constraints::constraint_residual(model, state, targets, workspaces.reborrow(), outputs);
    results
}

/// Returns J v: for each constraint the velocity of its second frame relative to its first, or to
/// the world, at the velocities v.
fn relative_velocities(
    model: &Mechanism<Expr>,
    targets: &[ContactTarget<Expr>],
    state: State<'_, Expr>,
    workspaces: &mut ConstraintWorkspaces<'_, Expr>,
) -> Vec<Twist<Expr>> {
    let [_, mut velocities] = residuals(model, targets, state, workspaces);
    let frames = with_second_frames(model);
    for k in contacts(model) {
        velocities[k] =
            kinematics::link_velocity(&frames, k, state, Axes::World, workspaces.workspace);
    }
    velocities
}

/// Returns the relative acceleration of each constraint's frames.
fn relative_accelerations(
    model: &Mechanism<Expr>,
    targets: &[ContactTarget<Expr>],
    motion: Motion<'_, Expr>,
    workspaces: &mut ConstraintWorkspaces<'_, Expr>,
) -> Vec<Twist<Expr>> {
    let changes = State { q: motion.q, qd: motion.qdd };
    let mut accelerations = relative_velocities(model, targets, changes, workspaces);
    let mut biases = vec![Twist::zero(); accelerations.len()];
    constraints::constraint_jacobian_dot_qd(
        model,
        motion.state(),
        workspaces.workspace,
        &mut biases,
    );
    for (acceleration, &bias) in accelerations.iter_mut().zip(&biases) {
        *acceleration = *acceleration + bias;
    }
    let frames = with_second_frames(model);
    for k in contacts(model) {
        let acceleration =
            kinematics::link_acceleration(&frames, k, motion, Axes::World, workspaces.workspace);
        accelerations[k] = acceleration;
    }
    accelerations
}

/// Returns the mechanism with the second frame of each constraint in place of its frames.
fn with_second_frames(model: &Mechanism<Expr>) -> Mechanism<Expr> {
    let ends = model.constraints.iter().map(|constraint| constraint.ends[1]);
    Mechanism { frames: ends.collect(), ..model.clone() }
}

/// Returns the constraints that are contacts.
fn contacts(model: &Mechanism<Expr>) -> Range<usize> {
    model.constraints.len() - model.contacts()..model.constraints.len()
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
