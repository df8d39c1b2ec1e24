//! A robot that is compiled by the build script: `cargo run`.

modyn::include_model!(pendulum);

/// Returns the coordinates that reach a target, by Newton steps on the generated cost: its value, gradient and Hessian.
/// Damping of the steps keeps the Hessian positive definite.
fn reached(mut q: [f64; 2], target: &[f64; 3]) -> [f64; 2] {
    let mut damping = 1.0;
    for _ in 0..50 {
        let PendulumReachCostHessian { value, grad_q: [x, y], hess_q_q: [[a, b], [_, c]], .. } =
            Pendulum::reach_cost_hessian(&q, &[0.0; 2], target, 0.0);
        let (a, c) = (a + damping, c + damping);
        let determinant = a * c - b * b;
        let next = [q[0] - (c * x - b * y) / determinant, q[1] - (a * y - b * x) / determinant];
        let better = Pendulum::reach_cost(&next, &[0.0; 2], target, 0.0) < value;
        damping *= if better { 0.3 } else { 10.0 };
        q = if better { next } else { q };
    }
    q
}

fn main() {
    let (q, qd, qdd) = ([0.6, -0.3], [0.0; 2], [1.0, 0.0]);
    println!("torques of a motion: {:.3?} N m", Pendulum::inverse_dynamics(&q, &qd, &qdd));
    let target = Pendulum::link_pose(&[0.9, 0.4], PendulumLink::Tip).translation;
    println!("coordinates that reach {target:.3?}: {:.3?}", reached(q, &target));
}

#[test]
fn at_rest_only_gravity_is_left() {
    let (q, zero) = ([0.6, -0.3], [0.0; 2]);
    let (torques, gravity) =
        (Pendulum::inverse_dynamics(&q, &zero, &zero), Pendulum::gravity_torques(&q));
    assert!(torques.iter().zip(gravity).all(|(a, b)| (a - b).abs() < 1e-12), "{torques:?}");
}

/// The numbers of a cost at displaced states.
#[cfg(test)]
fn cost(q: [f64; 2], qd: [f64; 2], step: f64, dq: [f64; 2], dqd: [f64; 2]) -> f64 {
    let moved = |x: [f64; 2], dx: [f64; 2]| [x[0] + step * dx[0], x[1] + step * dx[1]];
    Pendulum::reach_cost(&moved(q, dq), &moved(qd, dqd), &[0.2, -0.1, 0.4], 0.3)
}

#[test]
fn derivatives_of_the_cost_are_those_of_its_differences() {
    let (q, qd, dq, dqd) = ([0.7, -1.1], [0.4, 0.9], [0.6, -0.8], [0.5, 0.3]);
    let at = |step| cost(q, qd, step, dq, dqd);
    let h = 1e-3;
    let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    let curvature =
        (16.0 * (at(h) + at(-h)) - at(2.0 * h) - at(-2.0 * h) - 30.0 * at(0.0)) / (12.0 * h * h);
    let target = [0.2, -0.1, 0.4];
    let found = Pendulum::reach_cost_jvp(&q, &qd, &target, 0.3, &dq, &dqd);
    assert!((found.tangent_value - slope).abs() < 1e-8, "{} {slope}", found.tangent_value);
    let all = Pendulum::reach_cost_hessian(&q, &qd, &target, 0.3);
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    assert!((dot(all.grad_q, dq) + dot(all.grad_qd, dqd) - slope).abs() < 1e-8, "{all:?} {slope}");
    // The blocks by columns.
    let times = |m: [[f64; 2]; 2], b: [f64; 2]| {
        [m[0][0] * b[0] + m[1][0] * b[1], m[0][1] * b[0] + m[1][1] * b[1]]
    };
    let product = dot(dq, times(all.hess_q_q, dq))
        + 2.0 * dot(dq, times(all.hess_q_qd, dqd))
        + dot(dqd, times(all.hess_qd_qd, dqd));
    assert!((product - curvature).abs() < 1e-6, "{product} {curvature}");
}

#[test]
fn a_knot_has_the_step_and_the_cost() {
    let (q, qd, target) = ([0.7, -1.1], [0.4, 0.9], [0.2, -0.1, 0.4]);
    let stage: PendulumStage = Pendulum::stage(&q, &qd, &[0.3, -0.2], 0.01, &target, 0.3);
    let step = stage.step_semi_implicit_derivatives;
    let expected = Pendulum::reach_cost_gradient(&q, &qd, &target, 0.3);
    assert!((stage.reach_cost_gradient.value - expected.value).abs() < 1e-12);
    assert!(
        (0..2).all(|k| (stage.reach_cost_gradient.grad_q[k] - expected.grad_q[k]).abs() < 1e-12)
    );
    // The step moves the joints by their velocities after it.
    assert!((0..2).all(|k| (step.q[k] - q[k] - 0.01 * step.qd[k]).abs() < 1e-12));
}

#[test]
fn many_states_have_the_costs_of_each() {
    let states: Vec<[f64; 2]> =
        (0..21).map(|i| [0.3 * f64::from(i), 1.0 - 0.2 * f64::from(i)]).collect();
    let (target, weight) = (vec![[0.2, -0.1, 0.4]; 21], vec![0.3; 21]);
    let mut found = vec![0.0; 21];
    Pendulum::reach_cost_each(&states, &states, &target, &weight, &mut found)
        .expect("equal lengths");
    for (state, found) in states.iter().zip(found) {
        let expected = Pendulum::reach_cost(state, state, &[0.2, -0.1, 0.4], 0.3);
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn newton_steps_reach_the_target() {
    let target = Pendulum::link_pose(&[0.9, 0.4], PendulumLink::Tip).translation;
    let q = reached([0.6, -0.3], &target);
    let tip = Pendulum::link_pose(&q, PendulumLink::Tip).translation;
    assert!(tip.iter().zip(target).all(|(x, t)| (x - t).abs() < 1e-9), "{tip:?} {target:?}");
}
