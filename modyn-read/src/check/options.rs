//! Checks the numbers in options.

use modyn_runtime::model::JointFriction;

use crate::description::{Ground, MAX_NUMBER};
use crate::diagnostics::{Code, Diagnostic};

/// Returns the error of an acceleration of free fall that is not finite, or too large to compute
/// with.
#[must_use]
pub fn gravity_error(gravity: [f64; 3]) -> Option<Diagnostic> {
    let what = if gravity.iter().all(|x| x.is_finite()) {
        "too large to compute with"
    } else {
        "not finite"
    };
    let message = format!("the gravity {gravity:?} is {what}");
    let help = "give three finite numbers in m/s^2, such as [0.0, 0.0, -9.81]";
    let good = gravity.iter().all(|x| x.abs() < MAX_NUMBER);
    (!good).then(|| Diagnostic::error(Code::Gravity, message).with_help(help))
}

/// Returns the error of an invalid friction.
pub fn friction_error(friction: JointFriction) -> Option<Diagnostic> {
    let JointFriction::Smooth(width) = friction else { return None };
    let message = format!("{width} is not a valid transition velocity of smooth friction");
    let help = "give a finite velocity above 0 in rad/s or m/s, such as 0.01";
    let good = width > 0.0 && width < MAX_NUMBER;
    (!good).then(|| Diagnostic::error(Code::Option, message).with_help(help))
}

/// Returns the error of an invalid ground.
pub fn ground_error(ground: Ground) -> Option<Diagnostic> {
    let Ground { point, normal, friction } = ground;
    let is_sound = |x: &f64| x.abs() < MAX_NUMBER;
    let [message, help] = if !point.iter().chain(&normal).all(is_sound) {
        [
            "a number of the ground is not finite, or too large to compute with",
            "write the point in m",
        ]
    } else if normal == [0.0; 3] {
        [
            "the normal of the ground is zero",
            "write the direction away from the ground, such as [0, 0, 1]",
        ]
    } else if !friction.is_none_or(|friction| is_sound(&friction) && friction >= 0.0) {
        [
            "the friction of the ground is not a finite number of at least 0",
            "write a coefficient such as 0.8",
        ]
    } else {
        return None;
    };
    Some(Diagnostic::error(Code::Option, message).with_help(help))
}
