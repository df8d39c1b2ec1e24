//! Derivatives of dynamics with damping, friction and armature, against central differences.
#![cfg(feature = "alloc")]

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Joint, JointDynamics, JointFriction, Model, MovingLink,
};
use modyn_runtime::{ForwardDerivatives, Inertial, Interpreter, Pose};

const N: usize = 4;

/// Returns a tree of four bodies in general position: a trunk with a chain of two bodies and a slide.
fn model() -> Model {
    let types =
        [JointType::Revolute, JointType::Revolute, JointType::Prismatic, JointType::Prismatic];
    let parents = [None, Some(0), Some(1), Some(0)];
    let axes = [[0.48, 0.6, 0.64], [-0.64, 0.48, 0.6], [0.6, -0.64, 0.48], [0.36, 0.48, -0.8]];
    let links = (0..N).map(|i| {
        let k = i as f64;
        let origin = Pose { translation: [0.3, -0.2 * k, 0.4], ..Pose::identity() };
        let mut joint = Joint::new(format!("joint{i}"), types[i], axes[i], origin);
        joint.dynamics = JointDynamics {
            armature: if i == 2 { 0.0 } else { 0.1 + 0.2 * k },
            damping: 0.7 - 0.1 * k,
            friction: 0.4 + 0.3 * k,
        };
        let inertial = Inertial {
            mass: 1.5 + 0.3 * k,
            center_of_mass: [0.1, 0.2 - 0.1 * k, -0.3],
            inertia: [0.3, 0.02, -0.01, 0.4, 0.03, 0.5],
        };
        MovingLink { name: format!("link{i}"), parent: parents[i], joint, inertial }
    });
    let model = Model::new("tree", DEFAULT_GRAVITY, links.collect(), Vec::new()).expect("good");
    model.with_joint_friction(JointFriction::Smooth(0.3)).expect("a transition velocity")
}

/// Returns the matrix of central differences of `f` by `x`, by columns.
fn differences(x: [f64; N], mut f: impl FnMut([f64; N]) -> [f64; N]) -> Vec<f64> {
    let h = 1e-5;
    let mut columns = Vec::new();
    for k in 0..N {
        let mut at = |step: f64| {
            let mut x = x;
            x[k] += step;
            f(x)
        };
        let (before, after) = (at(-h), at(h));
        columns.extend(before.iter().zip(after).map(|(a, b)| (b - a) / (2.0 * h)));
    }
    columns
}

fn assert_close(found: &[f64], expected: &[f64], what: &str) {
    for (found, expected) in found.iter().zip(expected) {
        let error = (found - expected).abs() / expected.abs().max(1.0);
        assert!(error < 1e-7, "{what}: {found} instead of {expected}");
    }
}

#[test]
fn derivatives_contain_dissipation_and_armature() {
    let mut robot = Interpreter::<f64>::new(model());
    // Fast, at the transition velocity, and slow.
    for qd in [[1.4, -0.9, 2.0, -1.7], [0.3, -0.3, 0.2, 0.4], [0.02, 0.0, -0.03, 0.01]] {
        let (q, x) = ([0.4, -1.1, 0.3, 0.7], [2.0, -3.0, 1.5, 4.0]);
        let mut by_q = [0.0; N * N];
        let mut by_qd = [0.0; N * N];
        let mut inverse = |q: [f64; N], qd: [f64; N]| {
            let mut tau = [0.0; N];
            robot.inverse_dynamics(&q, &qd, &x, &mut tau).expect("sizes");
            tau
        };
        let expected_by_q = differences(q, |q| inverse(q, qd));
        let expected_by_qd = differences(qd, |qd| inverse(q, qd));
        robot.inverse_dynamics_derivatives(&q, &qd, &x, &mut by_q, &mut by_qd).expect("sizes");
        assert_close(&by_q, &expected_by_q, "d tau / d q");
        assert_close(&by_qd, &expected_by_qd, "d tau / d qd");

        let mut forward = |q: [f64; N], qd: [f64; N], tau: [f64; N]| {
            let mut qdd = [0.0; N];
            robot.forward_dynamics(&q, &qd, &tau, &mut qdd).expect("sizes");
            qdd
        };
        let expected = [
            forward(q, qd, x).to_vec(),
            differences(q, |q| forward(q, qd, x)),
            differences(qd, |qd| forward(q, qd, x)),
            differences(x, |tau| forward(q, qd, tau)),
        ];
        let (mut qdd, mut by_tau) = ([0.0; N], [0.0; N * N]);
        let outputs = ForwardDerivatives {
            qdd: &mut qdd,
            dqdd_dq: &mut by_q,
            dqdd_dqd: &mut by_qd,
            dqdd_dtau: &mut by_tau,
        };
        robot.forward_dynamics_derivatives(&q, &qd, &x, outputs).expect("sizes");
        assert_close(&qdd, &expected[0], "qdd");
        assert_close(&by_q, &expected[1], "d qdd / d q");
        assert_close(&by_qd, &expected[2], "d qdd / d qd");
        assert_close(&by_tau, &expected[3], "d qdd / d tau");
    }
}
