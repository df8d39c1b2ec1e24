//! The Runge-Kutta method of fourth order, free of commutators: Celledoni, Marthinsen and Owren 2003,
//! "Commutator-free Lie group methods". For robots whose coordinates are numbers it is the classical method.

use super::{StepWorkspace, add_scaled, scale};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::dynamics::{Elimination, forward_dynamics};
use crate::equations::kinematics::coordinates::integrate;
use crate::mechanism::Mechanism;

/// Computes the coordinates and velocities after the time `dt`, with an error of order dt^5.
pub fn step_rk4<S: Scalar>(
    model: &Mechanism<S>,
    elimination: &Elimination,
    (q, qd, tau, dt): (&[S], &[S], &[S], S),
    (workspace, memory): (&mut Workspace<S>, &mut StepWorkspace<S>),
    (next_q, next_qd): (&mut [S], &mut [S]),
) {
    let StepWorkspace { q: at, displacement, velocities: [v2, v3, v4], accelerations, .. } = memory;
    let [a1, a2, a3, a4] = accelerations;
    let half = S::from_f64(0.5) * dt;
    let mut accelerate = |q: &[S], qd: &[S], qdd: &mut [S]| {
        forward_dynamics(model, elimination, (q, qd, tau), None, workspace, qdd);
    };
    accelerate(q, qd, a1);

    add_scaled(qd, half, a1, v2);
    scale(half, qd, displacement);
    integrate(model, (q, displacement), at);
    accelerate(at, v2, a2);
    next_q.copy_from_slice(at);

    add_scaled(qd, half, a2, v3);
    scale(half, v2, displacement);
    integrate(model, (q, displacement), at);
    accelerate(at, v3, a3);

    // From the second evaluation on.
    add_scaled(qd, dt, a3, v4);
    for ((x, &first), &third) in displacement.iter_mut().zip(qd).zip(&*v3) {
        *x = dt * third - half * first;
    }
    integrate(model, (next_q, displacement), at);
    accelerate(at, v4, a4);

    // A displacement for each half of the step.
    let twelfth = S::from_f64(1.0 / 12.0) * dt;
    let mut half_step = |[first, last]: [&[S]; 2], from: &[S], to: &mut [S]| {
        for (i, x) in displacement.iter_mut().enumerate() {
            let (middle, threefold) = (v2[i] + v3[i], first[i] + first[i] + first[i]);
            *x = twelfth * (threefold + (middle + middle) - last[i]);
        }
        integrate(model, (from, displacement), to);
    };
    half_step([qd, v4], q, at);
    half_step([v4, qd], at, next_q);

    let sixth = twelfth + twelfth;
    for (i, next) in next_qd.iter_mut().enumerate() {
        let middle = a2[i] + a3[i];
        *next = qd[i] + sixth * (a1[i] + (middle + middle) + a4[i]);
    }
}
