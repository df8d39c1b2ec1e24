//! A robot as a description has it: owned records with their places in the text, in the form of no format.
//!
//! What could not be read stands in as its default, so that assembling can go on and find the next error; the report
//! holds the reason, and no model is made of it.

mod choices;
mod geometry;

pub use choices::{Base, Contact, Loop, LoopEnd, Mimic, ReadOptions, Rotor};
pub use geometry::{LARGEST, normalized, roll_pitch_yaw};

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, JointDynamics, Limits, LoopConstraintKind};
use modyn_runtime::spatial::Pose;
use rustc_hash::FxHashMap;

use crate::diagnostics::Subject;

/// A robot in parts.
pub struct Description {
    /// The robot's name.
    pub name: String,
    /// Where the robot begins, a byte offset.
    pub at: usize,
    /// The acceleration of free fall in world axes, m/s^2, if the format can say so.
    pub gravity: Option<[f64; 3]>,
    /// The links, in the order of the text.
    pub links: Vec<LinkRecord>,
    /// The joints, in the order of the text.
    pub joints: Vec<JointRecord>,
    /// The joints that close loops.
    pub loops: Vec<LoopRecord>,
}

impl Description {
    /// The joints' indices by their names; the first of a name counts.
    pub fn joints_by_name(&self) -> FxHashMap<&str, usize> {
        let mut indices = FxHashMap::default();
        for (i, joint) in self.joints.iter().enumerate() {
            indices.entry(joint.name.text.as_str()).or_insert(i);
        }
        indices
    }

    /// The names of all joints.
    pub fn joint_names(&self) -> impl Iterator<Item = &str> {
        self.joints.iter().map(|joint| joint.name.text.as_str())
    }

    /// The names of all links.
    pub fn link_names(&self) -> impl Iterator<Item = &str> {
        self.links.iter().map(|link| link.name.text.as_str())
    }
}

/// A text and the byte offset where it stands.
#[derive(Clone)]
pub struct Located {
    pub text: String,
    pub at: usize,
}

/// A link.
pub struct LinkRecord {
    pub name: Located,
    pub inertial: Option<InertialRecord>,
    /// Whether the text does not have it: it stands between two joints of one body, and is massless.
    pub auxiliary: bool,
}

impl LinkRecord {
    /// The link, for a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Link(self.name.text.clone())
    }
}

/// The inertia of a link, in the link's frame.
pub struct InertialRecord {
    pub inertial: Inertial,
    /// Where it stands.
    pub at: usize,
    /// Where the mass stands.
    pub mass_at: usize,
    /// Whether all of it could be read.
    pub sound: bool,
}

/// A joint.
pub struct JointRecord {
    pub name: Located,
    pub kind: Kind,
    /// The parent link; `None` where it is missing.
    pub parent: Option<Located>,
    /// The child link; `None` where it is missing.
    pub child: Option<Located>,
    /// The joint's frame in that of the parent.
    pub origin: Pose<f64>,
    /// Of unit length.
    pub axis: [f64; 3],
    /// A universal joint's; of unit length.
    pub second_axis: [f64; 3],
    pub limits: Option<Limits>,
    pub mimic: Option<MimicRecord>,
    pub drive: JointDynamics,
    /// Where the drive stands.
    pub drive_at: usize,
    /// Whether all of it could be read.
    pub sound: bool,
}

impl JointRecord {
    /// The joint, for a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Joint(self.name.text.clone())
    }
}

/// What a joint does.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Fixed,
    Moving(JointType),
    /// It could not be read.
    Unknown,
}

/// That a joint follows another one.
pub struct MimicRecord {
    /// The joint that is followed.
    pub leader: Located,
    pub multiplier: f64,
    pub offset: f64,
}

/// A joint that closes a loop, from the text or the options.
pub struct LoopRecord {
    pub name: String,
    /// Where it stands; `None` for an option's.
    pub at: Option<usize>,
    /// `None` where it could not be read.
    pub kind: Option<LoopConstraintKind>,
    pub ends: [EndRecord; 2],
}

impl LoopRecord {
    /// The joint, for a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Joint(self.name.clone())
    }
}

/// One of the two frames that a loop joint holds.
pub struct EndRecord {
    /// The link's name; `None` where it is missing.
    pub link: Option<String>,
    pub at: Option<usize>,
    pub pose: Pose<f64>,
}
