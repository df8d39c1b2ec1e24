//! The options of reading a description, and joints that options add.

use std::path::PathBuf;

use modyn_runtime::ContactSurface;
use modyn_runtime::model::{ContactKind, JointFriction, LoopConstraintKind};

use super::file_store::FileStore;
use super::geometry::{contact_plane, normalized};
use crate::diagnostics::Severity;

/// The options of reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// The folder of the description, in which files that it names are looked for. `None`: no other
    /// file is read.
    pub folder: Option<PathBuf>,
    /// The place from which these files are read.
    pub files: FileStore,
    /// The acceleration of free fall in world axes, m/s^2. `None` takes the description's, if its
    /// format has it, else [`DEFAULT_GRAVITY`](modyn_runtime::model::DEFAULT_GRAVITY).
    pub gravity: Option<[f64; 3]>,
    /// The severity of inertias that no rigid body has.
    pub unphysical_inertia: Severity,
    /// The severity of forces that are not read: forces of fluids and tendons in an MJCF.
    pub unsupported_forces: Severity,
    /// The treatment of mimic joints.
    pub mimic: Mimic,
    /// Whether a root link is fixed or floats.
    pub base: Base,
    /// The armatures of joints; each replaces the armature in the description.
    pub armature: Vec<Armature>,
    /// The rotors of joints; each gives its joint an armature, in place of the description's.
    pub rotors: Vec<Rotor>,
    /// The actuators of joints. If there are some, they replace the actuators of the description.
    pub actuators: Vec<JointActuator>,
    /// The part of damping and friction that acts. `None` is [`JointFriction::None`], with a
    /// warning if the description has damping or friction.
    pub joint_friction: Option<JointFriction>,
    /// The joints that close loops, besides the description's.
    pub loops: Vec<Loop>,
    /// The frames of links that can touch the world.
    pub contacts: Vec<Contact>,
    /// The ground that the shapes of the description touch in steps; with contacts, the ground that
    /// their points touch. `None`: shapes touch the planes of the description, points the plane z = 0.
    pub ground: Option<Ground>,
    /// The folders of ROS packages, for `$(find ...)` and `package://`.
    pub packages: Vec<Package>,
    /// The arguments of a xacro, in place of its defaults.
    pub xacro_args: Vec<XacroArg>,
    /// Whether the shapes of the links are read, for pictures, with the files of their meshes. They
    /// do not change the robot.
    pub shapes: bool,
}

/// The treatment of mimic joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mimic {
    /// The joint follows its leader, and has no coordinate of its own.
    #[default]
    Follow,
    /// The joint is independent: it has a coordinate of its own. Constraints of an MJCF couple
    /// joints in steps with soft constraints, softly as in `MuJoCo`.
    Independent,
    /// A mimic joint is an error.
    Refuse,
}

/// The base of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Base {
    /// As the format says: the root link of a URDF is fixed; a link of an SDF or an MJCF floats
    /// where the file says so.
    #[default]
    Auto,
    /// The root link is fixed to the world, and so are links that float in the world by a joint of
    /// the file, where the file places them.
    Fixed,
    /// The root link floats: a joint of type floating, named `floating_base`, connects it to the
    /// world. A robot that floats by a joint of the file is refused, and so is an MJCF, which says
    /// itself what floats.
    Floating,
}

/// The inertia of a joint's drive after the gear.
#[derive(Clone, Debug, PartialEq)]
pub struct Armature {
    /// The joint's name.
    pub joint: String,
    /// The inertia of the drive that opposes the joint's acceleration, kg m^2 (or kg for a
    /// prismatic joint).
    pub inertia: f64,
}

impl Armature {
    /// Returns the armature of this joint.
    #[must_use]
    pub fn new(joint: impl Into<String>, inertia: f64) -> Self {
        Self { joint: joint.into(), inertia }
    }
}

/// The rotor of a joint's drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotor {
    /// The joint's name.
    pub joint: String,
    /// The rotor's inertia about its own axis, kg m^2 (or kg for a prismatic joint).
    pub inertia: f64,
    /// The gear ratio: the rotor's velocity divided by the joint's. The armature is its square
    /// times the inertia.
    pub gear_ratio: f64,
}

impl Rotor {
    /// Returns the rotor of the drive of this joint.
    #[must_use]
    pub fn new(joint: impl Into<String>, inertia: f64, gear_ratio: f64) -> Self {
        Self { joint: joint.into(), inertia, gear_ratio }
    }
}

/// An actuator for each joint of a name.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JointActuator {
    /// The name of a joint with one degree of freedom, or a pattern of such names, in which each `*`
    /// stands for any text. Mimic joints have an actuator only by their own name.
    pub joint: String,
    /// The force under the control, before limits.
    pub law: ControlLaw,
    /// The largest force, N m or N, which replaces the joint's effort limit; `None`: the effort limit
    /// of the description, if there is one.
    pub effort: Option<f64>,
    /// The stall force of the torque-speed line, N m or N; `None`: no line limits the force.
    pub saturation: Option<f64>,
    /// The no-load speed of the torque-speed line, rad/s or m/s; `None`: the velocity limit of the
    /// description.
    pub velocity: Option<f64>,
    /// The number of steps before a control acts.
    pub delay: usize,
}

/// The force of an actuator under its control, before limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ControlLaw {
    /// The control is the target position: the force is `kp * (ctrl - q) - kd * qd`.
    Position {
        /// The stiffness, N m/rad or N/m.
        kp: f64,
        /// The damping, N m s/rad or N s/m.
        kd: f64,
    },
    /// The control is the target velocity: the force is `kd * (ctrl - qd)`.
    Velocity {
        /// The damping, N m s/rad or N s/m.
        kd: f64,
    },
    /// The control is the force, N m or N.
    Motor,
}

impl JointActuator {
    /// Returns the actuator of these joints with a law, the limits of the description, and without a
    /// torque-speed line and a delay.
    #[must_use]
    pub fn new(joint: impl Into<String>, law: ControlLaw) -> Self {
        let joint = joint.into();
        Self { joint, law, effort: None, saturation: None, velocity: None, delay: 0 }
    }

    /// Returns the actuator whose control is the target position, with this stiffness and damping.
    #[must_use]
    pub fn position(joint: impl Into<String>, kp: f64, kd: f64) -> Self {
        Self::new(joint, ControlLaw::Position { kp, kd })
    }

    /// Returns the actuator whose control is the target velocity, with this damping.
    #[must_use]
    pub fn velocity(joint: impl Into<String>, kd: f64) -> Self {
        Self::new(joint, ControlLaw::Velocity { kd })
    }

    /// Returns the actuator whose control is the force.
    #[must_use]
    pub fn motor(joint: impl Into<String>) -> Self {
        Self::new(joint, ControlLaw::Motor)
    }

    /// Returns the actuator with this largest force, N m or N.
    #[must_use]
    pub fn with_effort(self, effort: f64) -> Self {
        Self { effort: Some(effort), ..self }
    }

    /// Returns the actuator with a torque-speed line of this stall force (N m or N), whose no-load
    /// speed is the velocity limit of the description.
    #[must_use]
    pub fn with_saturation(self, saturation: f64) -> Self {
        Self { saturation: Some(saturation), ..self }
    }

    /// Returns the actuator with this no-load speed of the torque-speed line, rad/s or m/s.
    #[must_use]
    pub fn with_velocity(self, velocity: f64) -> Self {
        Self { velocity: Some(velocity), ..self }
    }

    /// Returns the actuator whose controls act after this number of steps.
    #[must_use]
    pub fn with_delay(self, delay: usize) -> Self {
        Self { delay, ..self }
    }
}

/// The folder of a ROS package.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Package {
    /// The package's name.
    pub name: String,
    /// The folder; a relative path starts at the folder of `Cargo.toml`, or at the current folder.
    pub folder: String,
}

impl Package {
    /// Returns the package of this name in this folder.
    #[must_use]
    pub fn new(name: impl Into<String>, folder: impl Into<String>) -> Self {
        Self { name: name.into(), folder: folder.into() }
    }
}

/// An argument of a xacro: a value of `<xacro:arg>`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct XacroArg {
    /// The argument's name.
    pub name: String,
    /// The value.
    pub value: String,
}

impl XacroArg {
    /// Returns the argument of this name with this value.
    #[must_use]
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

/// A joint that closes a loop, as `<loop_joint>` does: a constraint between two frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// The name, which no other joint has.
    pub name: String,
    /// The relative motion that is allowed; an axis may have any length.
    pub kind: LoopConstraintKind,
    /// The two frames.
    pub ends: [LoopEnd; 2],
}

/// A frame of a [`Loop`] or a [`Contact`].
#[derive(Clone, Debug, PartialEq)]
pub struct LoopEnd {
    /// The link's name.
    pub link: String,
    /// The position of the frame's origin in the link's frame, m.
    pub xyz: [f64; 3],
    /// The rotation of the frame: roll, pitch and yaw, rad.
    pub rpy: [f64; 3],
}

/// A frame of a link that can touch the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The name, which no other constraint has.
    pub name: String,
    /// The motions that the contact stops.
    pub kind: ContactKind,
    /// The frame, on a link that moves.
    pub end: LoopEnd,
}

/// A plane that a robot touches in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ground {
    /// A point of the plane, m.
    pub point: [f64; 3],
    /// The normal of the plane, away from the ground; of any length.
    pub normal: [f64; 3],
    /// The coefficient of friction of all contacts with the plane; `None`: the coefficients of the
    /// description, else 1.
    pub friction: Option<f64>,
}

impl Default for Ground {
    /// Returns the plane z = 0.
    fn default() -> Self {
        Self::plane([0.0; 3], [0.0, 0.0, 1.0])
    }
}

impl Ground {
    /// Returns the plane through a point (m) with a normal, which points away from the ground and
    /// has any length.
    #[must_use]
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self { point, normal, friction: None }
    }

    /// Returns the ground with this coefficient of friction of all contacts.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        Self { friction: Some(friction), ..self }
    }

    /// Returns the surface of a contact with the ground.
    pub(crate) fn surface(&self) -> ContactSurface<f64> {
        let normal = normalized(self.normal).map_or([0.0, 0.0, 1.0], |(normal, _)| normal);
        let default = ContactSurface::<f64>::GROUND;
        ContactSurface {
            plane: contact_plane(self.point, normal),
            friction: self.friction.unwrap_or(default.friction),
            ..default
        }
    }
}
