//! The models of a file before their names are resolved: scopes of names, frames, links and joints.

use std::path::PathBuf;

use modyn_runtime::model::{JointDynamics, Limits};
use modyn_runtime::spatial::Pose;
use rustc_hash::FxHashMap;

use crate::description::{Geometry, InertialRecord, Located, Shape, SpringRecord};
use crate::diagnostics::Diagnostic;
use crate::read::visual::Surfaces;

/// The index of the world among the scopes, and of its frame among the frames.
pub const WORLD: usize = 0;

/// A world with its models. A file with one model is a world with one model.
pub struct World {
    /// The name of the `<world>`; `None` in a file without one.
    pub name: Option<Located>,
    /// The scopes: the world, then each model.
    pub scopes: Vec<Scope>,
    /// Everything that has a pose: the world, then each model, link, joint and `<frame>`.
    pub frames: Vec<Frame>,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    pub ball_constraints: Vec<BallConstraint>,
    /// The acceleration of free fall, m/s^2; `None` in a file without a world.
    pub gravity: Option<[f64; 3]>,
    /// The meshes of visuals and collisions.
    pub surfaces: Surfaces,
    /// A sentence for each shape that could not be read.
    pub shape_notes: Vec<String>,
}

impl World {
    /// Returns a world without models, whose element is at this byte.
    pub fn new(at: usize) -> Self {
        let name = Located { text: "world".into(), at };
        let pose = Pose::identity();
        let relative_to = None;
        let frame = Frame { name, scope: WORLD, kind: FrameKind::World, pose, relative_to };
        Self {
            name: None,
            scopes: vec![Scope::new(WORLD, WORLD, String::new())],
            frames: vec![frame],
            links: Vec::new(),
            joints: Vec::new(),
            ball_constraints: Vec::new(),
            gravity: None,
            surfaces: Surfaces::default(),
            shape_notes: Vec::new(),
        }
    }

    /// Puts the name of the world's model before the full names of its parts, as in `arm::elbow`.
    pub fn qualify(&mut self) {
        // An enclosing scope comes first.
        for scope in 1..self.scopes.len() {
            let Scope { frame, outer, .. } = self.scopes[scope];
            let qualification = match outer {
                WORLD => format!("{}::", self.frames[frame].name.text),
                _ => self.scopes[outer].qualification.clone(),
            };
            self.scopes[scope].prefix.insert_str(0, &qualification);
            self.scopes[scope].qualification = qualification;
        }
        for frame in &mut self.frames {
            frame.name.text.insert_str(0, &self.scopes[frame.scope].qualification);
        }
    }

    /// Returns the frame that a name means in a scope: a sibling, or a part of a nested model, as
    /// in `model::link`.
    pub fn find(&self, scope: usize, name: &str) -> Option<usize> {
        let scope_record = &self.scopes[scope];
        match (name, scope) {
            ("world", WORLD) => return Some(WORLD),
            ("__model__", WORLD) => return None,
            ("__model__", _) => return Some(scope_record.frame),
            _ => {}
        }
        scope_record.names.get(name).copied().or_else(|| {
            let (model, rest) = name.split_once("::")?;
            match self.frames[*scope_record.names.get(model)?].kind {
                FrameKind::Model(inner) => self.find(inner, rest),
                _ => None,
            }
        })
    }

    /// Returns the frames whose poses, from last to first, lead from a scope's frame to a frame
    /// inside the scope.
    pub fn path(&self, scope: usize, frame: usize) -> Vec<usize> {
        let mut path = Vec::new();
        let mut at = frame;
        while at != self.scopes[scope].frame && at != WORLD {
            path.push(at);
            let owner = self.frames[at].scope;
            if owner == scope {
                break;
            }
            at = self.scopes[owner].frame;
        }
        path
    }
}

/// A model, or the world: the names that its elements can use.
pub struct Scope {
    /// The frame `__model__`.
    pub frame: usize,
    /// The enclosing scope.
    pub outer: usize,
    /// The frames by their names, with the frames of models that are merged into this one.
    pub names: FxHashMap<String, usize>,
    /// The frames in the order of the text, with the frames of merged models.
    pub content: Vec<usize>,
    /// The start of the full names, such as `arm::hand::`.
    pub prefix: String,
    /// The part of `prefix` that names the world's model, where the world has several.
    pub qualification: String,
    /// The frame that the model's pose is about.
    pub placement: Option<Located>,
    /// The link that the model's frame is attached to.
    pub canonical: Option<Located>,
    /// Whether the model, or one that it is nested in, does not move.
    pub is_static: bool,
}

impl Scope {
    pub fn new(frame: usize, outer: usize, prefix: String) -> Self {
        let names = FxHashMap::default();
        let content = Vec::new();
        let placement = None;
        let canonical = None;
        let is_static = false;
        let qualification = String::new();
        Self {
            frame,
            outer,
            names,
            content,
            prefix,
            qualification,
            placement,
            canonical,
            is_static,
        }
    }
}

/// A frame.
pub struct Frame {
    /// The full name, with the names of the models around it.
    pub name: Located,
    /// The scope that resolves its names.
    pub scope: usize,
    pub kind: FrameKind,
    /// The pose as it is written, in the frame `relative_to`.
    pub pose: Pose<f64>,
    /// The name of the frame of the pose; `None` for the default of its kind.
    pub relative_to: Option<Located>,
}

/// The element that a frame belongs to.
pub enum FrameKind {
    World,
    /// A model, by its scope.
    Model(usize),
    /// A link, by its index.
    Link(usize),
    /// A joint, by its index.
    Joint(usize),
    /// A `<frame>`, with the name that it is attached to.
    Frame(Option<Located>),
}

/// A link.
pub struct Link {
    pub frame: usize,
    pub inertial: Option<InertialRecord>,
    /// The shapes in the link's frame; empty if no shapes were asked for.
    pub shapes: Vec<Shape>,
    /// Whether gravity does not act on it.
    pub weightless: bool,
    pub collisions: Vec<Collision>,
}

/// A `<collision>` of a link.
pub struct Collision {
    /// The name, which is empty if it is missing.
    pub name: String,
    pub at: usize,
    /// The pose in the frame `relative_to`.
    pub pose: Pose<f64>,
    /// The name of the frame of the pose; `None` for the link's.
    pub relative_to: Option<Located>,
    pub geometry: CollisionGeometry,
    pub surface: Surface,
    /// The diagnostics of its elements, which count if it touches the ground.
    pub diagnostics: Vec<Diagnostic>,
}

/// The geometry of a [`Collision`].
pub enum CollisionGeometry {
    /// No geometry: `<empty>`, or an error in the diagnostics.
    Empty,
    /// A plane by its unit normal.
    Plane([f64; 3]),
    Solid(Geometry),
    Mesh(CollisionMesh),
    /// Another geometry, and why its contacts are not computed.
    Other(String),
}

/// The mesh of a [`Collision`], in a file that is not read yet.
pub struct CollisionMesh {
    pub uri: String,
    /// The place of the file; `None` if it is not found.
    pub place: Option<PathBuf>,
    pub scale: Option<String>,
}

/// The `<surface>` of a [`Collision`].
#[derive(Clone, Copy)]
pub struct Surface {
    /// The coefficients of friction along the two tangents, `<mu>` and `<mu2>`.
    pub friction: [f64; 2],
    /// Two collisions touch if their masks have a common bit, `<collide_bitmask>`.
    pub mask: u32,
    /// Whether it has a restitution or torsional friction, which are not read.
    pub has_more: bool,
}

/// A joint.
pub struct Joint {
    pub frame: usize,
    pub kind: Option<JointKind>,
    pub parent: Option<Located>,
    pub child: Option<Located>,
    /// The axis and the second axis.
    pub axes: [Option<Axis>; 2],
    /// The displacement of a screw, m/rad.
    pub pitch: f64,
    /// Whether the joint closes a loop.
    pub closes_loop: bool,
    /// Whether all its numbers could be read.
    pub sound: bool,
}

/// Drake's constraint that a point of one link coincides with a point of another.
pub struct BallConstraint {
    /// The scope that resolves the names of the links.
    pub scope: usize,
    pub at: usize,
    pub ends: [BallConstraintEnd; 2],
}

/// A point of a link.
pub struct BallConstraintEnd {
    /// The link's name; `None` if it is missing.
    pub link: Option<Located>,
    /// The point in the link's frame, m.
    pub point: [f64; 3],
}

/// The joint types of SDF.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Universal,
    Ball,
    Screw,
}

/// An axis of a joint.
pub struct Axis {
    /// The direction, of unit length.
    pub direction: [f64; 3],
    /// The frame of the direction; `None` for the joint's.
    pub expressed_in: Option<Located>,
    pub at: usize,
    pub limits: Limits,
    pub dynamics: JointDynamics,
    pub spring: Option<SpringRecord>,
    pub dynamics_at: usize,
    pub mimic: Option<Mimic>,
}

/// The relation of an axis to the axis of another joint.
pub struct Mimic {
    pub leader: Located,
    pub multiplier: f64,
    pub offset: f64,
}

/// The properties of a model that the `<include>` of its file sets.
#[derive(Default)]
pub struct Overrides {
    pub name: Option<Located>,
    /// The pose, and the name of its frame.
    pub pose: Option<(Pose<f64>, Option<Located>)>,
    pub placement: Option<Located>,
    pub is_static: Option<bool>,
    /// Whether the elements of the model become elements of the enclosing model.
    pub merge: bool,
}
