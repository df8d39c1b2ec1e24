//! The implicit midpoint rule on the space of the coordinates: Hairer, Lubich and Wanner 2006,
//! "Geometric Numerical Integration", sections II.1 and IV.8.
//!
//! With the acceleration a at the midpoint,
//!
//! ```text
//! v = qd + dt/2 a        ID(q (+) dt/2 v, v, a) = tau        q' = q (+) dt v        qd' = qd + dt a
//! ```
//!
//! and inverse dynamics ID. A step back from (q', qd') by -dt has the same midpoint, so the rule is
//! symmetric. It is of second order, and A-stable (Hairer and Wanner 1996, "Solving Ordinary
//! Differential Equations II", section IV.3).
//!
//! The equation for a has the derivative N = M + dt/2 (ID_qd + dt/2 ID_q J), with the mass matrix M
//! and the derivative J of (+) by the displacement. Newton's method with N at the start a = 0
//! (simplified Newton) takes one factorization. N changes by O(dt^2), since a moves the midpoint by
//! dt^2/4 a and its velocity by dt/2 a, on which N has the factor dt/2. So each iteration gains two
//! orders, and the first is exact for linear equations.

use alloc::{vec, vec::Vec};

use super::{StepOutputs, add_scaled, scale};
use crate::Scalar;
use crate::equations::derivatives::inverse_dynamics_derivatives_and_mass_matrix;
use crate::equations::dynamics::inverse_dynamics;
use crate::equations::factorization::{factor_ul, solve_ul};
use crate::equations::kinematics::coordinates::{integrate, integrate_derivatives};
use crate::equations::{ForwardInput, Motion, NextState, State, TimeStepInput, Workspace};
use crate::mechanism::Mechanism;

/// The number of iterations. The error of the velocities that they leave is of order dt^7, far
/// below the rule's error.
const ITERATIONS: usize = 3;

/// The memory of the implicit midpoint rule.
#[derive(Clone, Debug)]
pub struct MidpointWorkspace<S> {
    /// The coordinates at the midpoint.
    q: Vec<S>,
    /// The displacement from the start to the midpoint.
    displacement: Vec<S>,
    /// The velocities at the midpoint.
    qd: Vec<S>,
    /// The accelerations at the midpoint.
    qdd: Vec<S>,
    /// The unmet joint forces, or the mean change of the velocities.
    vector: Vec<S>,
    /// The derivatives of inverse dynamics by the coordinates at the midpoint.
    by_q: Vec<S>,
    /// The derivatives of inverse dynamics by the velocities at the midpoint, which also move the
    /// midpoint.
    by_qd: Vec<S>,
    /// The factors of the derivatives of inverse dynamics by the accelerations, which also move the
    /// midpoint.
    by_qdd: Vec<S>,
    /// The derivatives of displaced coordinates by the coordinates before, and by the displacement.
    transport: [Vec<S>; 2],
}

impl<S: Scalar> MidpointWorkspace<S> {
    /// Returns the memory for a mechanism.
    #[must_use]
    pub fn new(model: &Mechanism<S>) -> Self {
        let vector = || vec![S::zero(); model.nv];
        let matrix = || vec![S::zero(); model.nv * model.nv];
        Self {
            q: vec![S::zero(); model.nq],
            displacement: vector(),
            qd: vector(),
            qdd: vector(),
            vector: vector(),
            by_q: matrix(),
            by_qd: matrix(),
            by_qdd: matrix(),
            transport: [matrix(), matrix()],
        }
    }

    /// Moves to the midpoint of the accelerations.
    fn move_to_midpoint(&mut self, model: &Mechanism<S>, State { q, qd }: State<'_, S>, half: S) {
        add_scaled(qd, half, &self.qdd, &mut self.qd);
        scale(half, &self.qd, &mut self.displacement);
        integrate(model, q, &self.displacement, &mut self.q);
    }

    /// Computes the derivatives at the midpoint.
    fn linearize(&mut self, model: &Mechanism<S>, half: S, workspace: &mut Workspace<S>) {
        let Self { q, displacement, qd, qdd, by_q, by_qd, by_qdd, transport, .. } = self;
        let motion = Motion { q, qd, qdd };
        inverse_dynamics_derivatives_and_mass_matrix(model, motion, workspace, by_q, by_qd, by_qdd);
        let [by_start, by_displacement] = transport;
        integrate_derivatives(model, displacement, by_start, by_displacement);
        for (entry, moved) in block_products(model, by_q, by_displacement) {
            by_qd[entry] = by_qd[entry] + half * moved;
        }
        for (by_qdd, &by_qd) in by_qdd.iter_mut().zip(&*by_qd) {
            *by_qdd = *by_qdd + half * by_qd;
        }
        factor_ul(by_qdd, model.nv);
    }

    /// Computes the accelerations at the midpoint of a step.
    fn solve(
        &mut self,
        model: &Mechanism<S>,
        ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
        half: S,
        workspace: &mut Workspace<S>,
    ) {
        self.qdd.fill(S::zero());
        self.move_to_midpoint(model, State { q, qd }, half);
        self.linearize(model, half, workspace);
        for _ in 0..ITERATIONS {
            self.move_to_midpoint(model, State { q, qd }, half);
            let Self { q, qd, qdd, vector, .. } = self;
            inverse_dynamics(model, State { q, qd }, Some(qdd), None, workspace, vector);
            for (unmet, &tau) in self.vector.iter_mut().zip(tau) {
                *unmet = tau - *unmet;
            }
            solve_ul(&self.by_qdd, &mut self.vector);
            for (qdd, &change) in self.qdd.iter_mut().zip(&self.vector) {
                *qdd = *qdd + change;
            }
        }
    }

    /// Computes the state after a step from the accelerations at its midpoint. `displacement`
    /// becomes the displacement of the whole step.
    fn finish(
        &mut self,
        model: &Mechanism<S>,
        State { q, qd }: State<'_, S>,
        dt: S,
        NextState { q: next_q, qd: next_qd }: NextState<'_, S>,
    ) {
        add_scaled(qd, S::from_f64(0.5) * dt, &self.qdd, &mut self.qd);
        scale(dt, &self.qd, &mut self.displacement);
        integrate(model, q, &self.displacement, next_q);
        add_scaled(qd, dt, &self.qdd, next_qd);
    }
}

/// Returns the entries of the product of a matrix and the block-diagonal derivatives of the
/// coordinates, with their indices.
fn block_products<'a, S: Scalar>(
    model: &'a Mechanism<S>,
    matrix: &'a [S],
    blocks: &'a [S],
) -> impl Iterator<Item = (usize, S)> + 'a {
    let n = model.nv;
    let columns = model.coordinates.iter().flat_map(|block| {
        let group = block.v..block.v + block.velocities();
        group.clone().map(move |column| (group.clone(), column))
    });
    columns.flat_map(move |(group, column)| {
        (0..n).map(move |row| {
            let products = group.clone().map(|k| matrix[k * n + row] * blocks[column * n + k]);
            (column * n + row, products.reduce(|sum, x| sum + x).expect("a group has velocities"))
        })
    })
}

/// Computes the coordinates and velocities after the time `dt`.
pub fn step_implicit_midpoint<S: Scalar>(
    model: &Mechanism<S>,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut MidpointWorkspace<S>,
    next: NextState<'_, S>,
) {
    memory.solve(model, ForwardInput { q, qd, tau }, S::from_f64(0.5) * dt, workspace);
    memory.finish(model, State { q, qd }, dt, next);
}

/// Computes the state of [`step_implicit_midpoint`], and the derivatives of the midpoint rule in
/// tangent space.
///
/// The derivatives follow from the equation for a by the implicit function theorem, at the a that
/// was found.
pub fn step_implicit_midpoint_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut MidpointWorkspace<S>,
    outputs: StepOutputs<'_, S>,
) {
    let StepOutputs { q: next_q, qd: next_qd, a, b } = outputs;
    let n = model.nv;
    let half = S::from_f64(0.5) * dt;
    memory.solve(model, ForwardInput { q, qd, tau }, half, workspace);
    memory.move_to_midpoint(model, State { q, qd }, half);
    memory.linearize(model, half, workspace);
    memory.finish(model, State { q, qd }, dt, NextState { q: next_q, qd: next_qd });
    if n == 0 {
        return;
    }
    // The derivatives of the accelerations.
    let MidpointWorkspace { displacement, vector, by_q, by_qd, by_qdd, transport, .. } = memory;
    let [by_start, by_displacement] = transport;
    a.fill(S::zero());
    b.fill(S::zero());
    let (of_q, of_qd) = a.split_at_mut(2 * n * n);
    for (entry, moved) in block_products(model, by_q, by_start) {
        of_q[entry / n * 2 * n + n + entry % n] = -moved;
    }
    for (entry, &by_qd) in by_qd.iter().enumerate() {
        of_qd[entry / n * 2 * n + n + entry % n] = -by_qd;
    }
    for (j, column) in b.chunks_mut(2 * n).enumerate() {
        column[n + j] = S::one();
    }
    for column in a.chunks_mut(2 * n).chain(b.chunks_mut(2 * n)) {
        solve_ul(by_qdd, &mut column[n..]);
    }
    // The derivatives of the state.
    integrate_derivatives(model, displacement, by_start, by_displacement);
    for (j, column) in a.chunks_mut(2 * n).chain(b.chunks_mut(2 * n)).enumerate() {
        let (moved, rates) = column.split_at_mut(n);
        scale(half, rates, vector);
        rates.iter_mut().for_each(|rate| *rate = dt * *rate);
        if let Some(j) = j.checked_sub(n).filter(|&j| j < n) {
            vector[j] = S::one() + vector[j];
            rates[j] = S::one() + rates[j];
        }
        for block in &model.coordinates {
            let group = block.v..block.v + block.velocities();
            for row in group.clone() {
                let products = group.clone().map(|k| by_displacement[k * n + row] * vector[k]);
                moved[row] =
                    dt * products.reduce(|sum, x| sum + x).expect("a group has velocities");
            }
        }
    }
    for (column, by_start) in a.chunks_mut(2 * n).zip(by_start.chunks(n)) {
        for (moved, &by_start) in column.iter_mut().zip(by_start) {
            *moved = by_start + *moved;
        }
    }
}
