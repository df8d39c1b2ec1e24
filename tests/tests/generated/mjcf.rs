//! The macro reads MuJoCo's models: the generated robot equals the reader's model of the same text.

use modyn::EmbeddedModel;
use modyn_codegen::{ReadOptions, read};
use modyn_runtime::Interpreter;
use modyn_runtime::equations::derivatives::ForwardDerivatives;

modyn::modyn!(Arm = "../../../modyn-read/tests/mjcf/arm.xml", friction = viscous);

modyn::modyn! {
    Floating = "../../../modyn-read/tests/mjcf/floating.xml",
    friction = none,
    functions = [forward_dynamics, inverse_dynamics, gravity_torques, potential_energy, forward_dynamics_derivatives],
    embed_model = true,
}

#[test]
fn the_macro_recognises_an_mjcf() {
    let text = include_str!("../../../modyn-read/tests/mjcf/arm.xml");
    let options =
        ReadOptions { friction: Some(modyn_codegen::Friction::Viscous), ..ReadOptions::default() };
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
    let options =
        ReadOptions { friction: Some(modyn_codegen::Friction::None), ..ReadOptions::default() };
    let reading = read(text, "floating.xml", &options).expect("an MJCF");
    let model = Floating::model();
    assert_eq!(model, reading.model);
    assert!(model.springs().len() == 3 && model.gravity_compensation().contains(&0.8));

    let mut interpreter = Interpreter::<f64>::new(model);
    let mut q: [f64; Floating::NQ] = core::array::from_fn(|i| (1.3 * i as f64).sin());
    interpreter.normalize(&mut q).expect("lengths");
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
    close(found.dq.as_flattened(), &dq);
    close(found.dqd.as_flattened(), &dqd);
}
