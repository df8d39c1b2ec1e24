//! A crate whose robots are compiled by its build script.
#![forbid(unsafe_code)]
#![deny(warnings, missing_docs)]

modyn::include_model!(my_robot);
modyn::include_model!(light_arm);

mod inner {
    modyn::include_model!(odd);
}

/// Returns the torque that holds the robot.
#[must_use]
pub fn hold() -> (f64, f32, f64) {
    let torque = inner::Odd::gravity_torques(&[0.0]);
    (MyRobot::gravity_torques(&[0.0])[0], LightArm::gravity_torques(&[0.0])[0], torque[0])
}

#[test]
fn it_holds() {
    let (double, single, odd) = hold();
    assert!((double + 0.5 * 9.81).abs() < 1e-12, "{double}");
    assert!((single + 0.5 * 9.81).abs() < 1e-5, "{single}");
    assert!((double - odd).abs() < f64::EPSILON, "{odd}");
}
