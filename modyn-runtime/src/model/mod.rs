//! A robot: links, joints, inertias, the tree they form and its kinematic modules.
//!
//! A [`Model`] is validated when it is made, so the equations never meet a broken tree.
//! Link `i` is the moving link behind joint `i`, as in the paper: every moving link has exactly
//! one joint, towards its parent. Links that are fixed to another link are [`Frame`]s; what they
//! weigh has been merged into the link that carries them.

mod error;
mod inertial;
mod modules;
pub mod prepare;

pub use error::{ModelError, ModelErrorKind};
pub use inertial::{Inertial, InertialDefect};
pub use modules::{Module, ModuleError, ModuleTree};

use alloc::{string::String, vec::Vec};

use crate::joint::JointType;
use crate::spatial::Pose;

/// Standard gravity of the defaults, in m/s^2: 9.81 along -z of the world.
pub const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A joint: how a link moves against its parent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// The joint's name in the description.
    pub name: String,
    /// What motion it allows.
    pub joint_type: JointType,
    /// The axis, a unit vector in the joint's (and so the link's) frame.
    pub axis: [f64; 3],
    /// The joint's frame at coordinate zero, in the frame of the parent link (or of the world).
    pub origin: Pose<f64>,
    /// Limits, where the description states them.
    pub limits: Option<Limits>,
}

/// Limits of a joint, as the description states them: rad or m, rad/s or m/s, N m or N.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Smallest coordinate; `None` where there is no such limit (a continuous joint).
    pub lower: Option<f64>,
    /// Largest coordinate; `None` where there is no such limit (a continuous joint).
    pub upper: Option<f64>,
    /// Largest speed; `None` where it is not stated.
    pub velocity: Option<f64>,
    /// Largest effort; `None` where it is not stated.
    pub effort: Option<f64>,
}

/// A moving link, with the joint that moves it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// The link's name in the description.
    pub name: String,
    /// The moving link it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// The joint between the two.
    pub joint: Joint,
    /// Its inertia, together with all that is fixed to it, in its own frame.
    pub inertial: Inertial,
}

/// A link of the description, moving or not, as a frame fixed to a moving link (or to the world).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Frame {
    /// The link's name in the description.
    pub name: String,
    /// The moving link it is fixed to; `None` for the world.
    pub link: Option<usize>,
    /// Its pose in that link's frame (identity for the moving link itself), or in the world.
    pub pose: Pose<f64>,
}

/// A validated robot.
///
/// Links stand depth first, parents before children; that order is the order of all joint
/// vectors. SI units, radians.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Model {
    name: String,
    gravity: [f64; 3],
    links: Vec<Link>,
    frames: Vec<Frame>,
}

impl Model {
    /// Checks the parts and makes a model of them.
    ///
    /// `gravity` is the acceleration of free fall in world axes, m/s^2. `frames` are the links of
    /// the description in its own order; [`link_poses`](crate::Interpreter::link_poses) gives theirs.
    ///
    /// # Errors
    ///
    /// Every defect found: a name used twice, a parent that does not come before its child, links
    /// out of depth-first order, an axis that is not of unit length, a rotation that is none, a
    /// number that is not finite, a robot without a joint. Inertias are only required to be
    /// finite here; whether they are physical is [`Inertial::defect`]'s to say.
    pub fn new(
        name: impl Into<String>,
        gravity: [f64; 3],
        links: Vec<Link>,
        frames: Vec<Frame>,
    ) -> Result<Self, Vec<ModelError>> {
        let model = Self { name: name.into(), gravity, links, frames };
        let errors = error::check(&model);
        if errors.is_empty() { Ok(model) } else { Err(errors) }
    }

    /// The robot's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The acceleration of free fall in world axes, m/s^2.
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity
    }

    /// The moving links, depth first.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// All links of the description as frames, in the description's order.
    #[must_use]
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Length of the coordinate vector q.
    #[must_use]
    pub fn nq(&self) -> usize {
        self.links.len()
    }

    /// Length of the velocity vector qd: the degrees of freedom.
    #[must_use]
    pub fn nv(&self) -> usize {
        self.links.len()
    }

    /// The links that hang directly on each link, in order.
    #[must_use]
    pub fn children(&self) -> Vec<Vec<usize>> {
        let mut children = alloc::vec![Vec::new(); self.links.len()];
        for (i, link) in self.links.iter().enumerate() {
            if let Some(siblings) = link.parent.and_then(|p| children.get_mut(p)) {
                siblings.push(i);
            }
        }
        children
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Model {
    /// Reads the parts and validates them, as [`Model::new`] does.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        #[serde(rename = "Model")]
        struct Parts {
            name: String,
            gravity: [f64; 3],
            links: Vec<Link>,
            frames: Vec<Frame>,
        }
        let Parts { name, gravity, links, frames } = Parts::deserialize(deserializer)?;
        Self::new(name, gravity, links, frames).map_err(|errors| {
            let all: Vec<String> = errors.iter().map(alloc::string::ToString::to_string).collect();
            serde::de::Error::custom(all.join("; "))
        })
    }
}
