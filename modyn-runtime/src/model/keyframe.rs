//! Keyframes: named states of a robot.

use alloc::{string::String, vec::Vec};

use super::Model;

/// A named state of a robot with its controls, such as its home position.
///
/// ```
/// use modyn_runtime::joint::JointType;
/// use modyn_runtime::model::{DEFAULT_GRAVITY, Joint, Keyframe, MovingLink, Model};
/// use modyn_runtime::{Inertial, Pose};
///
/// let joint = Joint::new("pivot", JointType::Continuous, [0.0, 1.0, 0.0], Pose::identity());
/// let inertial = Inertial { mass: 2.0, center_of_mass: [0.0, 0.0, -0.5], inertia: [0.0; 6] };
/// let rod = MovingLink { name: "rod".into(), parent: None, joint, inertial };
/// let model = Model::new("pendulum", DEFAULT_GRAVITY, vec![rod], vec![]).expect("a valid model");
/// let up = Keyframe { name: "up".into(), q: vec![3.14], ..Keyframe::default() };
/// let model = model.with_keyframes(vec![up]).expect("one coordinate");
/// assert_eq!(model.keyframe("up").map(|up| &*up.q), Some(&[3.14][..]));
/// assert_eq!(model.keyframe("down"), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Keyframe {
    /// The name, which no other keyframe has.
    pub name: String,
    /// The coordinates, nq.
    pub q: Vec<f64>,
    /// The velocities, nv; empty for zeros.
    #[cfg_attr(feature = "serde", serde(default))]
    pub qd: Vec<f64>,
    /// The controls of the actuators; empty for zeros.
    #[cfg_attr(feature = "serde", serde(default))]
    pub ctrl: Vec<f64>,
    /// The states of the actuators, in the order of [`Model::activation_names`]; empty for zeros.
    #[cfg_attr(feature = "serde", serde(default))]
    pub act: Vec<f64>,
}

impl Model {
    /// Returns the keyframe named `name`; `None` if there is no such keyframe.
    #[must_use]
    pub fn keyframe(&self, name: &str) -> Option<&Keyframe> {
        self.keyframes().iter().find(|key| key.name == name)
    }
}
