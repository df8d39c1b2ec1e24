//! The macro reads MuJoCo's models: the generated robot equals the reader's model of the same text.

use modyn::EmbeddedModel;
use modyn::simulate::{HeightField, State};
use modyn_codegen::diagnostics::Severity;
use modyn_codegen::{ReadOptions, read};
use modyn_runtime::equations::derivatives::ForwardDerivatives;
use modyn_runtime::quantities::Function;
use modyn_runtime::{ContactSurface, Interpreter, StepSettings};
use modyn_tests::arguments::interpreted;

modyn::modyn!(Arm = "../../../modyn-read/tests/mjcf/arm.xml", joint_friction = viscous);

modyn::modyn! {
    Floating = "../../../modyn-read/tests/mjcf/floating.xml",
    joint_friction = none,
    functions = [forward_dynamics, inverse_dynamics, gravity_torques, potential_energy, forward_dynamics_derivatives],
    embed_model = true,
}

modyn::modyn! {
    Standing = "../../../modyn-read/tests/mjcf/floor.xml",
    functions = [step, link_poses],
    unsupported_forces = warn,
    embed_model = true,
}

/// On a height field that is a ramp, steps are the steps on its plane.
#[test]
fn steps_on_a_ramp_are_steps_on_its_plane() {
    let heights = [[-0.7_f64, 0.1], [-0.5, 0.3], [-0.3, 0.5]].as_flattened();
    let field = HeightField::new([-4.0, -2.0], [8.0, 2.0], 2, heights).expect("a grid");
    let settings = Standing::model().step_settings();
    let surfaces: [ContactSurface<f64>; 3] = settings.surfaces.try_into().expect("three");
    let StepSettings { impratio, coulomb, .. } = settings;
    let settings = StepSettings { tolerance: 1e-12, impratio, coulomb, surfaces };
    let mut q = Standing::NEUTRAL;
    (q[0], q[1], q[2]) = (0.3, -0.4, 0.6);
    let start = State::<Standing>::at_rest(q);
    let below = field.plane([q[0], q[1]]);
    let mut on_plane = settings;
    for surface in &mut on_plane.surfaces {
        surface.plane = below;
    }
    let tau = [0.0; Standing::NV];
    let mut step = start.step(0.002, &tau, &on_plane);
    let mut on_field = start.step(0.002, &tau, &field.under::<Standing>(&q, &settings));
    for _ in 0..400 {
        step = step.step(0.002, &tau, &on_plane);
        let under = field.under::<Standing>(&on_field.state.q, &settings);
        on_field = on_field.step(0.002, &tau, &under);
        assert!(on_field.residual <= 1e-12);
    }
    assert!(step.forces.iter().any(|force| force[2] > 1.0) && step.state.q[2] < 0.3);
    let pairs = step.state.q.iter().zip(&on_field.state.q);
    for (a, b) in pairs.chain(step.state.qd.iter().zip(&on_field.state.qd)) {
        assert!((a - b).abs() < 1e-6, "{a} is not {b}");
    }
    // The solver starts from the accelerations of the last step.
    let State { q, qd } = step.state;
    let next = step.step(0.002, &tau, &on_plane);
    let expected = Standing::step(&q, &qd, &tau, 0.002, &step.qdd, &on_plane);
    assert_eq!((next.state.q, next.iterations), (expected.q, expected.iterations));
}

/// What touches the ground, a tendon and a coupling are in the embedded model and in the step.
#[test]
fn shapes_on_a_floor_are_generated() {
    let text = include_str!("../../../modyn-read/tests/mjcf/floor.xml");
    let options = ReadOptions { unsupported_forces: Severity::Warning, ..ReadOptions::default() };
    let model = read(text, "floor.xml", &options).expect("an MJCF").model;
    let soft = model.soft_constraints();
    assert_eq!([soft.tendons.len(), soft.couplings.len(), soft.references.len()], [1; 3]);
    assert_eq!(Standing::model(), model);
    assert_eq!(Standing::TOUCHING_SHAPE_NAMES, ["belly", "shank", "heel"]);
    let settings = model.step_settings();
    let surfaces: [ContactSurface<f64>; 3] = settings.surfaces.try_into().expect("three");
    let StepSettings { impratio, coulomb, .. } = settings;
    let settings = StepSettings { tolerance: 1e-12, impratio, coulomb, surfaces };
    let mut interpreter = Interpreter::<f64>::new(model);
    let mut q = [0.1, 0.2, -0.35, 0.1, 0.2, 0.3, 0.9, 1.2];
    interpreter.normalize_configuration(&mut q).expect("lengths");
    let [qd, tau]: [[f64; Standing::NV]; 2] =
        [0.7, 1.9].map(|k| core::array::from_fn(|i| (k * i as f64 + k).cos()));
    let zeros = [0.0; Standing::NV];
    let step = Standing::step(&q, &qd, &tau, 0.002, &zeros, &settings);
    let forces: Vec<f64> = step.forces.iter().flat_map(|force| force.0).collect();
    assert!(step.forces.len() == 10 && forces.iter().filter(|force| **force != 0.0).count() > 2);
    let surfaces = settings.surfaces.iter().flat_map(ContactSurface::numbers);
    let settings = settings.numbers().into_iter().chain(surfaces).collect();
    let given = [q.to_vec(), qd.to_vec(), tau.to_vec(), vec![0.002], zeros.to_vec(), settings];
    let expected = interpreted(&mut interpreter, Function::Step, &given);
    let mut rest = &expected[..];
    for generated in [&step.q[..], &step.qd, &step.qdd, &forces] {
        let (expected, others) = rest.split_at(generated.len());
        rest = others;
        let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (a, b) in generated.iter().zip(expected) {
            assert!((a - b).abs() <= 1e-9 * size, "{a} is not {b}");
        }
    }
}

#[test]
fn the_macro_recognises_an_mjcf() {
    let text = include_str!("../../../modyn-read/tests/mjcf/arm.xml");
    let options = ReadOptions {
        joint_friction: Some(modyn_codegen::JointFriction::Viscous),
        ..ReadOptions::default()
    };
    let reading = read(text, "arm.xml", &options).expect("an MJCF");
    let mut interpreter = Interpreter::<f64>::new(reading.model);
    let (q, qd, tau) = ([0.4, -0.9, 0.05], [0.7, -0.3, 0.2], [1.0, -2.0, 0.5]);
    let mut expected = [0.0; 3];
    interpreter.forward_dynamics(&q, &qd, &tau, &mut expected).expect("sizes");
    let found: [f64; 3] = Arm::forward_dynamics(&q, &qd, &tau);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} {expected}");
    }
}

/// Springs and gravity compensation are in the generated functions as in the interpreter, and in the embedded model.
#[test]
fn springs_and_gravity_compensation_are_generated() {
    let text = include_str!("../../../modyn-read/tests/mjcf/floating.xml");
    let options = ReadOptions {
        joint_friction: Some(modyn_codegen::JointFriction::None),
        ..ReadOptions::default()
    };
    let reading = read(text, "floating.xml", &options).expect("an MJCF");
    let model = Floating::model();
    assert_eq!(model, reading.model);
    assert!(model.springs().len() == 3 && model.gravity_compensation().contains(&0.8));

    let mut interpreter = Interpreter::<f64>::new(model);
    let mut q: [f64; Floating::NQ] = core::array::from_fn(|i| (1.3 * i as f64).sin());
    interpreter.normalize_configuration(&mut q).expect("lengths");
    let [qd, qdd, tau]: [[f64; Floating::NV]; 3] =
        [0.7, 1.9, 2.3].map(|k| core::array::from_fn(|i| (k * i as f64 + k).cos()));
    let close = |found: &[f64], expected: &[f64]| {
        let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-10 * size, "{found} is not {expected}");
        }
    };
    let mut expected = [0.0; Floating::NV];
    interpreter.forward_dynamics(&q, &qd, &tau, &mut expected).expect("lengths");
    close(&Floating::forward_dynamics(&q, &qd, &tau), &expected);
    interpreter.inverse_dynamics(&q, &qd, &qdd, &mut expected).expect("lengths");
    close(&Floating::inverse_dynamics(&q, &qd, &qdd), &expected);
    interpreter.gravity_torques(&q, &mut expected).expect("lengths");
    close(&Floating::gravity_torques(&q), &expected);
    let energy = interpreter.potential_energy(&q).expect("lengths");
    close(&[Floating::potential_energy(&q)], &[energy]);

    let found = Floating::forward_dynamics_derivatives(&q, &qd, &tau);
    let [mut dq, mut dqd, mut dtau] = [(); 3].map(|()| vec![0.0; Floating::NV * Floating::NV]);
    let outputs = ForwardDerivatives {
        qdd: &mut expected,
        dqdd_dq: &mut dq,
        dqdd_dqd: &mut dqd,
        dqdd_dtau: &mut dtau,
    };
    interpreter.forward_dynamics_derivatives(&q, &qd, &tau, outputs).expect("lengths");
    close(found.dqdd_dq.as_flattened(), &dq);
    close(found.dqdd_dqd.as_flattened(), &dqd);
}
