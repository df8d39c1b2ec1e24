//! The Runge-Kutta method of fourth order, free of commutators: Celledoni, Marthinsen and Owren
//! 2003, "Commutator-free Lie group methods". For robots whose coordinates are numbers it is the
//! classical method.
//!
//! The stages are sums of vectors, displacements of coordinates and accelerations. Sums of vectors
//! are also the sums of their derivatives. So the method is written once, over vectors that may
//! have their derivatives after their entries ([`runge_kutta`]); a caller says how such vectors
//! displace coordinates, and what they accelerate.

use alloc::{vec, vec::Vec};

use super::{StepOutputs, StepWorkspace, add_scaled, scale};
use crate::Scalar;
use crate::equations::derivatives::{ForwardDerivatives, forward_dynamics_derivatives};
use crate::equations::dynamics::{Elimination, forward_dynamics};
use crate::equations::factorization::UduLayout;
use crate::equations::kinematics::coordinates::{integrate, integrate_derivatives};
use crate::equations::{ForwardInput, NextState, State, TimeStepInput, Workspace};
use crate::mechanism::Mechanism;

/// Computes the coordinates and velocities after the time `dt`, with an error of order dt^5.
pub fn step_rk4<S: Scalar>(
    model: &Mechanism<S>,
    elimination: &Elimination,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut StepWorkspace<S>,
    next: NextState<'_, S>,
) {
    runge_kutta(
        State { q, qd },
        dt,
        memory,
        |from, displacement, to| integrate(model, from, displacement, to),
        |q, qd, qdd| {
            forward_dynamics(model, elimination, ForwardInput { q, qd, tau }, None, workspace, qdd)
        },
        next,
    );
}

/// Computes the stages and the sums of the method. `displace` moves coordinates by a displacement,
/// and `accelerate` computes the accelerations of coordinates and velocities. All vectors of the
/// memory have the lengths of `q` and `qd`.
fn runge_kutta<S: Scalar>(
    State { q, qd }: State<'_, S>,
    dt: S,
    memory: &mut StepWorkspace<S>,
    mut displace: impl FnMut(&[S], &[S], &mut [S]),
    mut accelerate: impl FnMut(&[S], &[S], &mut [S]),
    NextState { q: next_q, qd: next_qd }: NextState<'_, S>,
) {
    let StepWorkspace { q: at, displacement, velocities: [v2, v3, v4], accelerations, .. } = memory;
    let [a1, a2, a3, a4] = accelerations;
    let half = S::from_f64(0.5) * dt;
    accelerate(q, qd, a1);

    add_scaled(qd, half, a1, v2);
    scale(half, qd, displacement);
    displace(q, displacement, at);
    accelerate(at, v2, a2);
    next_q.copy_from_slice(at);

    add_scaled(qd, half, a2, v3);
    scale(half, v2, displacement);
    displace(q, displacement, at);
    accelerate(at, v3, a3);

    // From the second evaluation on.
    add_scaled(qd, dt, a3, v4);
    for ((x, &first), &third) in displacement.iter_mut().zip(qd).zip(&*v3) {
        *x = dt * third - half * first;
    }
    displace(next_q, displacement, at);
    accelerate(at, v4, a4);

    // A displacement for each half of the step.
    let twelfth = S::from_f64(1.0 / 12.0) * dt;
    let mut half_step = |[first, last]: [&[S]; 2], from: &[S], to: &mut [S]| {
        for (i, x) in displacement.iter_mut().enumerate() {
            let middle = v2[i] + v3[i];
            let threefold = first[i] + first[i] + first[i];
            *x = twelfth * (threefold + (middle + middle) - last[i]);
        }
        displace(from, displacement, to);
    };
    half_step([qd, v4], q, at);
    half_step([v4, qd], at, next_q);

    let sixth = twelfth + twelfth;
    for (i, next) in next_qd.iter_mut().enumerate() {
        let middle = a2[i] + a3[i];
        *next = qd[i] + sixth * (a1[i] + (middle + middle) + a4[i]);
    }
}

/// The memory of the derivatives of a Runge-Kutta step.
///
/// Vectors of coordinates, velocities and accelerations have their derivatives after their entries:
/// by q (in tangent space), by qd and by tau, 3 nv columns of nv entries.
#[derive(Clone, Debug)]
pub struct RungeKuttaWorkspace<S> {
    /// The vectors of the stages.
    stages: StepWorkspace<S>,
    /// The coordinates and the velocities before the step.
    start: [Vec<S>; 2],
    /// The coordinates and the velocities after the step.
    next: [Vec<S>; 2],
    /// The derivatives of the accelerations of a stage by its coordinates, its velocities and tau.
    derivatives: [Vec<S>; 3],
    /// The derivatives of displaced coordinates by the coordinates before, and by the displacement.
    transport: [Vec<S>; 2],
}

impl<S: Scalar> RungeKuttaWorkspace<S> {
    /// Returns the memory for a mechanism.
    #[must_use]
    pub fn new(model: &Mechanism<S>) -> Self {
        let nq = model.nq;
        let nv = model.nv;
        let columns = 3 * nv * nv;
        let vectors = || [vec![S::zero(); nq + columns], vec![S::zero(); nv + columns]];
        let matrix = |_| vec![S::zero(); nv * nv];
        Self {
            stages: StepWorkspace::of_lengths(nq + columns, nv + columns, 0),
            start: vectors(),
            next: vectors(),
            derivatives: core::array::from_fn(matrix),
            transport: core::array::from_fn(matrix),
        }
    }
}

/// Computes the state of [`step_rk4`], and its derivatives in tangent space, through the stages.
///
/// With the derivatives F of forward dynamics at a stage, the derivatives of its accelerations are
/// F_q Q + F_qd V + F_tau T. Q and V are the derivatives of the stage's coordinates and velocities,
/// and T the derivatives of tau.
pub fn step_rk4_derivatives<S: Scalar>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
    workspace: &mut Workspace<S>,
    memory: &mut RungeKuttaWorkspace<S>,
    outputs: StepOutputs<'_, S>,
) {
    let StepOutputs { q: next_q, qd: next_qd, a, b } = outputs;
    let nq = model.nq;
    let n = model.nv;
    if n == 0 {
        next_q.copy_from_slice(q);
        return;
    }
    let RungeKuttaWorkspace { stages, start, next, derivatives, transport } = memory;
    for (first, (vector, values)) in start.iter_mut().zip([q, qd]).enumerate() {
        let (head, columns) = vector.split_at_mut(values.len());
        head.copy_from_slice(values);
        columns.fill(S::zero());
        columns[first * n * n..].iter_mut().step_by(n + 1).take(n).for_each(|x| *x = S::one());
    }
    let displace = |from: &[S], displacement: &[S], to: &mut [S]| {
        let (from, by_from) = from.split_at(nq);
        let (moved, by_moved) = displacement.split_at(n);
        let (to, by_to) = to.split_at_mut(nq);
        integrate(model, from, moved, to);
        let [by_start, by_displacement] = &mut *transport;
        integrate_derivatives(model, moved, by_start, by_displacement);
        let columns = by_from.chunks(n).zip(by_moved.chunks(n)).zip(by_to.chunks_mut(n));
        for ((from, moved), to) in columns {
            for block in &model.coordinates {
                let group = block.v..block.v + block.velocities();
                for row in group.clone() {
                    to[row] = group.clone().fold(S::zero(), |sum, k| {
                        let entry = k * n + row;
                        sum + (by_start[entry] * from[k] + by_displacement[entry] * moved[k])
                    });
                }
            }
        }
    };
    let accelerate = |q: &[S], qd: &[S], qdd: &mut [S]| {
        let (q, by_q) = q.split_at(nq);
        let (qd, by_qd) = qd.split_at(n);
        let (qdd, columns) = qdd.split_at_mut(n);
        let [dqdd_dq, dqdd_dqd, dqdd_dtau] = &mut *derivatives;
        let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
        forward_dynamics_derivatives(
            model,
            layout,
            ForwardInput { q, qd, tau },
            workspace,
            outputs,
        );
        let (by_state, by_tau) = columns.split_at_mut(2 * n * n);
        by_state.fill(S::zero());
        by_tau.copy_from_slice(dqdd_dtau);
        for ((column, q), qd) in columns.chunks_mut(n).zip(by_q.chunks(n)).zip(by_qd.chunks(n)) {
            for (matrix, factors) in [(&*dqdd_dq, q), (&*dqdd_dqd, qd)] {
                for (derivative, &factor) in matrix.chunks(n).zip(factors) {
                    for (sum, &derivative) in column.iter_mut().zip(derivative) {
                        *sum = *sum + derivative * factor;
                    }
                }
            }
        }
    };
    let [start_q, start_qd] = start;
    let [end_q, end_qd] = next;
    let before = State { q: start_q, qd: start_qd };
    let after = NextState { q: end_q, qd: end_qd };
    runge_kutta(before, dt, stages, displace, accelerate, after);

    let (moved, by_q) = end_q.split_at(nq);
    let (rates, by_qd) = end_qd.split_at(n);
    next_q.copy_from_slice(moved);
    next_qd.copy_from_slice(rates);
    let columns = a.chunks_mut(2 * n).chain(b.chunks_mut(2 * n));
    for ((column, q), qd) in columns.zip(by_q.chunks(n)).zip(by_qd.chunks(n)) {
        let (top, bottom) = column.split_at_mut(n);
        top.copy_from_slice(q);
        bottom.copy_from_slice(qd);
    }
}
