//! Keyframes: named coordinates of a robot.

use alloc::{string::String, vec::Vec};

use super::Model;

/// Named coordinates of a robot, such as its home position.
///
/// ```
/// use modyn_runtime::joint::JointType;
/// use modyn_runtime::model::{DEFAULT_GRAVITY, Joint, Keyframe, Link, Model};
/// use modyn_runtime::{Inertial, Pose};
///
/// let joint = Joint::new("pivot", JointType::Continuous, [0.0, 1.0, 0.0], Pose::identity());
/// let inertial = Inertial { mass: 2.0, center_of_mass: [0.0, 0.0, -0.5], inertia: [0.0; 6] };
/// let rod = Link { name: "rod".into(), parent: None, joint, inertial };
/// let model = Model::new("pendulum", DEFAULT_GRAVITY, vec![rod], vec![]).expect("a valid model");
/// let up = Keyframe { name: "up".into(), q: vec![3.14] };
/// let model = model.with_keyframes(vec![up]).expect("one coordinate");
/// assert_eq!(model.keyframe("up"), Some(&[3.14][..]));
/// assert_eq!(model.keyframe("down"), None);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Keyframe {
    /// The name, which no other keyframe has.
    pub name: String,
    /// The coordinates, nq.
    pub q: Vec<f64>,
}

impl Model {
    /// Returns the coordinates of the keyframe named `name`, nq; `None` if there is no such
    /// keyframe.
    #[must_use]
    pub fn keyframe(&self, name: &str) -> Option<&[f64]> {
        self.keyframes().iter().find(|key| key.name == name).map(|key| key.q.as_slice())
    }
}
