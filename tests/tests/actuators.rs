//! Joint forces of actuators and their activations against MuJoCo: see the reference data's README.

use modyn_codegen::{ReadOptions, read_mjcf};
use modyn_runtime::equations::actuation::ActuatorInput;
use modyn_runtime::model::JointFriction;
use modyn_runtime::{ActuatorOutputs, Interpreter};
use serde_json::Value;

/// Of the largest force or activation of a state.
const TOLERANCE: f64 = 1e-12;

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().expect("a list");
    values.iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn forces_and_activations_are_mujocos() {
    let path = format!("{}/golden/actuators.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("reference data");
    let models: Value = serde_json::from_str(&text).expect("JSON");
    let mut compared = 0;
    for (k, file) in models.as_array().expect("a list").iter().enumerate() {
        let options =
            ReadOptions { joint_friction: Some(JointFriction::None), ..ReadOptions::default() };
        let reading = read_mjcf(file["xml"].as_str().expect("a text"), "m.xml", &options);
        let reading = reading.expect("an MJCF");
        let warning = reading.warnings.iter().find(|warning| warning.message.contains("actuator"));
        assert_eq!(warning, None);
        let mut robot = Interpreter::<f64>::new(reading.model);
        for state in file["states"].as_array().expect("a list") {
            let [q, qd, ctrl, act, tau, next_act] =
                ["q", "qd", "ctrl", "act", "tau", "next_act"].map(|name| numbers(&state[name]));
            let dt = file["step"].as_f64().expect("a number");
            let input = ActuatorInput { q: &q, qd: &qd, ctrl: &ctrl, act: &act, dt };
            let mut forces = vec![0.0; tau.len()];
            let mut activations = vec![0.0; act.len()];
            let outputs = ActuatorOutputs { tau: &mut forces, act: &mut activations };
            robot.actuate(input, outputs).expect("the robot's lengths");
            for (values, expected) in [(&forces, &tau), (&activations, &next_act)] {
                let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
                for (value, expected) in values.iter().zip(expected) {
                    let error = (value - expected).abs() / largest;
                    assert!(error < TOLERANCE, "model {k}: {values:?}, {expected:?}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 400, "{compared}");
}
