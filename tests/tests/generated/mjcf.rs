//! The macro reads MuJoCo's models: the generated robot equals the reader's model of the same text.

use modyn_codegen::{ReadOptions, read};
use modyn_runtime::Interpreter;

modyn::modyn!(Arm = "../../../modyn-codegen/tests/mjcf/arm.xml", friction = viscous);

#[test]
fn the_macro_recognises_an_mjcf() {
    let text = include_str!("../../../modyn-codegen/tests/mjcf/arm.xml");
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
