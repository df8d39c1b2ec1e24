//! The description of a robot: owned records with their places in the text, independent of the
//! format.
//!
//! A value that could not be read is replaced by its default, so that assembling can continue and
//! find the next error. The report has the reason, and no model is made of the description.

mod choices;
mod file_store;
mod geometry;
mod shape;
mod taken_names;

pub use choices::{
    Armature, Base, Contact, ControlLaw, Ground, JointActuator, Loop, LoopEnd, Mimic, Package,
    ReadOptions, Rotor, XacroArg,
};
pub use file_store::FileStore;
pub use geometry::{
    MAX_NUMBER, UNLIMITED, are_parallel, contact_plane, cross, normalized, roll_pitch_yaw,
};
pub use shape::{Geometry, Mesh, Shape, Shapes};
pub use taken_names::TakenNames;

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    Actuation, ContactKind, Inertial, JointDynamics, Limits, LoopConstraintKind, LoopSoftness,
    SoftConstraints, Softness,
};
use modyn_runtime::spatial::Pose;
use rustc_hash::FxHashMap;

use crate::diagnostics::Subject;
use crate::work::counted;

/// A robot as a collection of records.
#[derive(Clone)]
pub struct Description {
    /// The robot's name.
    pub name: String,
    /// The byte offset of the robot's element.
    pub at: usize,
    /// The acceleration of free fall in world axes, m/s^2; `None` if the format has no gravity.
    pub gravity: Option<[f64; 3]>,
    /// The links, in the order of the text.
    pub links: Vec<LinkRecord>,
    /// The links whose weight is compensated, as indices, with the part of it that is.
    pub compensated: Vec<(usize, f64)>,
    /// The joints, in the order of the text.
    pub joints: Vec<JointRecord>,
    /// The joints that close loops.
    pub loops: Vec<LoopRecord>,
    /// The frames that can touch the world.
    pub contacts: Vec<ContactRecord>,
    /// The named states, in the order of the text.
    pub keyframes: Vec<KeyframeRecord>,
    /// The actuators and their tendons, with indices of joints of the description in place of links.
    pub actuation: Actuation,
    /// A sentence for each shape that could not be read.
    pub shape_notes: Vec<String>,
    /// The shapes that touch the ground and the options of their contacts, without the softness of
    /// joints; `None` if the format has none.
    pub soft: Option<SoftConstraints>,
    /// The softness of joints, by their index.
    pub softnesses: Vec<(usize, SoftnessRecord)>,
    /// The softness of loops, with their indices in `loops`.
    pub loop_softnesses: Vec<LoopSoftness>,
}

impl Description {
    /// Takes the shapes of the links, in the order of the links.
    pub fn take_shapes(&mut self) -> Shapes {
        let of_links = self.links.iter_mut().map(|link| std::mem::take(&mut link.shapes));
        Shapes { of_frames: of_links.collect(), notes: std::mem::take(&mut self.shape_notes) }
    }

    /// Returns the joints' indices by their names; the first of equal names counts.
    pub fn joints_by_name(&self) -> FxHashMap<&str, usize> {
        let mut indices = FxHashMap::default();
        for (i, joint) in self.joints.iter().enumerate() {
            indices.entry(joint.name.text.as_str()).or_insert(i);
        }
        indices
    }

    /// Returns the names of all joints.
    pub fn joint_names(&self) -> impl Iterator<Item = &str> {
        counted(self.joints.iter()).map(|joint| joint.name.text.as_str())
    }

    /// Returns the names of all links.
    pub fn link_names(&self) -> impl Iterator<Item = &str> {
        counted(self.links.iter()).map(|link| link.name.text.as_str())
    }
}

/// A text and its byte offset.
#[derive(Clone)]
pub struct Located {
    pub text: String,
    pub at: usize,
}

/// A link.
#[derive(Clone)]
pub struct LinkRecord {
    pub name: Located,
    pub inertial: Option<InertialRecord>,
    /// Whether the reader added the link between two joints of one body; it is massless.
    pub auxiliary: bool,
    /// The shapes in the link's frame; empty if no shapes were asked for.
    pub shapes: Vec<Shape>,
}

impl LinkRecord {
    /// Returns a link of the description, without shapes.
    pub fn new(name: Located, inertial: Option<InertialRecord>) -> Self {
        Self { name, inertial, auxiliary: false, shapes: Vec::new() }
    }

    /// Returns the link as the subject of a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Link(self.name.text.clone())
    }
}

/// The inertia of a link, in the link's frame.
#[derive(Clone)]
pub struct InertialRecord {
    pub inertial: Inertial,
    /// The byte offset of the inertia.
    pub at: usize,
    /// The byte offset of the mass.
    pub mass_at: usize,
    /// Whether all its numbers could be read.
    pub sound: bool,
}

/// A joint.
#[derive(Clone)]
pub struct JointRecord {
    pub name: Located,
    pub kind: Kind,
    /// The parent link; `None` if it is missing.
    pub parent: Option<Located>,
    /// The child link; `None` if it is missing.
    pub child: Option<Located>,
    /// The joint's frame in the parent's frame.
    pub origin: Pose<f64>,
    /// The axis, of unit length.
    pub axis: [f64; 3],
    /// The second axis of a universal joint, of unit length.
    pub second_axis: [f64; 3],
    pub limits: Option<Limits>,
    pub mimic: Option<MimicRecord>,
    pub dynamics: JointDynamics,
    pub spring: Option<SpringRecord>,
    /// The range of the sum of actuator forces.
    pub actuator_forces: Option<[f64; 2]>,
    /// The byte offset of armature, damping and friction.
    pub dynamics_at: usize,
    /// Whether all its numbers could be read.
    pub sound: bool,
}

impl JointRecord {
    /// Returns the joint as the subject of a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Joint(self.name.text.clone())
    }
}

/// The spring of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringRecord {
    /// The stiffness, N m/rad or N/m.
    pub stiffness: f64,
    /// The coordinates without force, in modyn's order.
    pub reference: Vec<f64>,
}

/// The kind of a joint.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Fixed,
    Moving(JointType),
    /// A kind that could not be read.
    Unknown,
}

/// The mimic relation of a joint.
#[derive(Clone)]
pub struct MimicRecord {
    /// The name of the leader.
    pub leader: Located,
    pub multiplier: f64,
    pub offset: f64,
}

/// A joint that closes a loop, from the text or the options.
#[derive(Clone)]
pub struct LoopRecord {
    pub name: String,
    /// The byte offset; `None` for a joint of the options.
    pub at: Option<usize>,
    /// The relative motion that is allowed; `None` if it could not be read.
    pub kind: Option<LoopConstraintKind>,
    pub ends: [EndRecord; 2],
}

impl LoopRecord {
    /// Returns the joint as the subject of a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Joint(self.name.clone())
    }
}

/// A frame of a link that can touch the world, from the text or the options.
#[derive(Clone)]
pub struct ContactRecord {
    pub name: String,
    /// The byte offset; `None` for a contact of the options.
    pub at: Option<usize>,
    /// The motions that the contact stops; `None` if it could not be read.
    pub kind: Option<ContactKind>,
    pub end: EndRecord,
}

impl ContactRecord {
    /// Returns the contact as the subject of a diagnostic.
    pub fn subject(&self) -> Subject {
        Subject::Contact(self.name.clone())
    }
}

/// The softness of a joint's limits and dry friction.
#[derive(Clone)]
pub struct SoftnessRecord {
    pub limit: Softness<f64>,
    pub friction: Softness<f64>,
    /// The distance from which on a limit acts, rad or m.
    pub margin: f64,
}

/// A named state of the robot.
#[derive(Clone)]
pub struct KeyframeRecord {
    pub name: Located,
    /// For joints of the description, by their index: the coordinates in modyn's order, with
    /// quaternions of unit length. The coordinates of other joints are neutral.
    pub coordinates: Vec<(usize, Vec<f64>)>,
    /// The velocities in modyn's order, like the coordinates.
    pub velocities: Vec<(usize, Vec<f64>)>,
    /// The controls of the actuators; empty for zeros.
    pub ctrl: Vec<f64>,
    /// The activations of the actuators; empty for zeros.
    pub act: Vec<f64>,
}

/// One of the two frames of a loop joint, or the frame of a contact.
#[derive(Clone)]
pub struct EndRecord {
    /// The link's name; `None` if it is missing.
    pub link: Option<String>,
    pub at: Option<usize>,
    pub pose: Pose<f64>,
}
