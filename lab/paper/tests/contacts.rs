//! Contacts of a compiled robot: what the interpreter computes, and a robot that stands.

use modyn::equations::constraints::{ConstrainedOutputs, ProjectionOutputs, ResidualOutputs};
use modyn::equations::{ForwardInput, State};
use modyn::spatial::{Twist, Wrench};
use modyn::{ConstraintSettings, ContactSet, ContactTarget, Interpreter, Robot, functions};

modyn::modyn!(
    "../../robots/quadruped.urdf",
    base = floating,
    functions = [default, inverse_dynamics],
    contacts = [
        "front left": point("front_left_foot"),
        "front right": point("front_right_foot", [0.0, 0.0, -0.01]),
        "hind left": surface("hind_left_foot", [0.01, 0, -0.01], [0.1, 0.2, 0.3]),
        "hind right": point("hind_right_foot"),
    ]
);

type Settings = ConstraintSettings<f64, [ContactTarget<f64>; 4]>;

fn model() -> modyn::model::Model {
    let contact = |name: &str, kind, xyz, rpy| modyn_codegen::Contact {
        name: name.into(),
        kind,
        end: modyn_codegen::LoopEnd { link: name.replace(' ', "_") + "_foot", xyz, rpy },
    };
    let (point, surface) = (modyn_codegen::ContactKind::Point, modyn_codegen::ContactKind::Surface);
    let options = modyn_codegen::ReadOptions {
        base: modyn_codegen::Base::Floating,
        contacts: vec![
            contact("front left", point, [0.0; 3], [0.0; 3]),
            contact("front right", point, [0.0, 0.0, -0.01], [0.0; 3]),
            contact("hind left", surface, [0.01, 0.0, -0.01], [0.1, 0.2, 0.3]),
            contact("hind right", point, [0.0; 3], [0.0; 3]),
        ],
        ..Default::default()
    };
    let text = include_str!("../../../robots/quadruped.urdf");
    modyn_codegen::read(text, "quadruped.urdf", &options).expect("good").model
}

fn assert_near(found: &[f64], expected: &[f64]) {
    let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9 * scale, "{found:?} instead of {expected:?}");
    }
}

/// The quaternion has length one.
fn state() -> ([f64; 19], [f64; 18], [f64; 18]) {
    let mut q: [f64; 19] = core::array::from_fn(|i| 0.3 * (i as f64).sin());
    let (s, c) = 0.4_f64.sin_cos();
    q[3..7].copy_from_slice(&[0.6 * s, 0.0, 0.8 * s, c]);
    (
        q,
        core::array::from_fn(|i| (2.0 * i as f64).cos()),
        core::array::from_fn(|i| (i as f64).cos()),
    )
}

#[test]
fn compiled_contacts_are_the_interpreters() {
    let mut interpreter = Interpreter::new(model());
    let (q, qd, tau) = state();
    assert_eq!(Quadruped::CONTACT_NAMES, ["front left", "front right", "hind left", "hind right"]);
    assert_eq!(QuadrupedContacts::default(), QuadrupedContacts::NONE);
    let mut settings = Settings::DEFAULT;
    settings.targets[2].tangential = 0.5;
    settings.targets[1].velocity.linear.0[0] = 0.3;
    settings.targets[3].compliance = 0.01;
    for contacts in [
        QuadrupedContacts::ALL,
        QuadrupedContacts::NONE,
        QuadrupedContacts { front_left: true, hind_left: true, ..QuadrupedContacts::NONE },
    ] {
        let (mut qdd, mut wrenches, mut residuals) =
            ([0.0; 18], [Wrench::zero(); 4], [Twist::zero(); 4]);
        let into = ConstrainedOutputs {
            qdd: &mut qdd,
            wrenches: &mut wrenches,
            residuals: &mut residuals,
        };
        let active = contacts.to_array();
        assert_eq!(QuadrupedContacts::from_array(active), contacts);
        let state = ForwardInput { q: &q, qd: &qd, tau: &tau };
        let rank = interpreter.constrained_forward_dynamics(state, &active, &settings, into);
        let found = Quadruped::constrained_forward_dynamics(&q, &qd, &tau, contacts, &settings);
        assert_near(&found.qdd, &qdd);
        for (own, expected) in found.wrenches.iter().zip(&wrenches) {
            assert_near(&own.components(), &expected.components());
        }
        assert_eq!(Ok(found.rank), rank);

        let (mut dq, mut dqd) = ([0.0; 18], [0.0; 18]);
        let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
        let rank =
            interpreter.project_constraints(State { q: &q, qd: &qd }, &active, &settings, into);
        let found = Quadruped::project_constraints(&q, &qd, contacts, &settings);
        assert_near(&found.step_q, &dq);
        assert_near(&found.step_qd, &dqd);
        assert_eq!(Ok(found.rank), rank);
    }
    let (mut displacements, mut velocities) = ([Twist::zero(); 4], [Twist::zero(); 4]);
    let into = ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
    interpreter.constraint_residual(State { q: &q, qd: &qd }, &settings, into).expect("fits");
    let found = Quadruped::constraint_residual(&q, &qd, &settings);
    for k in 0..4 {
        assert_near(&found.displacements[k].components(), &displacements[k].components());
        assert_near(&found.velocities[k].components(), &velocities[k].components());
    }
}

/// Returns the upward force on all feet, N, of any robot with four contacts.
fn lift<R>(q: &R::Q<f64>, qd: &R::V<f64>, tau: &R::V<f64>) -> f64
where
    R: Robot<
            PerContact<ContactTarget<f64>> = [ContactTarget<f64>; 4],
            PerConstraint<Wrench<f64>> = [Wrench<f64>; 4],
        > + functions::Constraints,
{
    let all = <R::Contacts as ContactSet>::ALL;
    let found = R::constrained_forward_dynamics(q, qd, tau, all, &Settings::EXACT);
    found.wrenches.iter().map(|wrench| wrench.force[2]).sum()
}

/// At rest, under the torques that hold the legs still, the ground carries the weight.
#[test]
fn the_ground_carries_a_robot_that_stands() {
    let mut q = Quadruped::NEUTRAL;
    q[2] = 0.3;
    for leg in 0..4 {
        q[7 + 3 * leg + 1] = 0.7;
        q[7 + 3 * leg + 2] = -1.4;
    }
    let contacts = QuadrupedContacts::ALL;
    let held = Quadruped::constrained_forward_dynamics(
        &q,
        &[0.0; 18],
        &[0.0; 18],
        contacts,
        &Settings::EXACT,
    );
    // With all legs' joints held by torques that cancel the accelerations that are left, nothing moves.
    let mut tau = [0.0; 18];
    let step = |tau: &[f64; 18]| {
        Quadruped::constrained_forward_dynamics(&q, &[0.0; 18], tau, contacts, &Settings::EXACT)
    };
    let mass = Quadruped::mass_matrix(&q);
    for _ in 0..200 {
        let found = step(&tau);
        for i in 6..18 {
            tau[i] -= 0.9 * mass[i][i] * found.qdd[i];
        }
    }
    let found = step(&tau);
    assert!(found.qdd.iter().all(|x| x.abs() < 1e-6), "{found:?}");
    assert!(held.qdd.iter().any(|x| x.abs() > 1.0));
    let weight = 9.81 * modyn_codegen_mass();
    assert!((lift::<Quadruped>(&q, &[0.0; 18], &tau) - weight).abs() < 1e-4 * weight);
}

fn modyn_codegen_mass() -> f64 {
    Quadruped::PARAMETERS.chunks(10).map(|own| own[0]).sum()
}
