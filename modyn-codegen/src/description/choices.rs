//! What a user may choose about a description, and what may be added to it.

use modyn_runtime::model::{ContactKind, Friction, LoopConstraintKind};

use crate::diagnostics::Severity;

/// What a user may choose about reading.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// The acceleration of free fall in world axes, m/s^2; by default what the description says,
    /// if its format can, else [`DEFAULT_GRAVITY`](modyn_runtime::model::DEFAULT_GRAVITY).
    pub gravity: Option<[f64; 3]>,
    /// How to take inertias that no rigid body has.
    pub unphysical_inertia: Severity,
    /// How to take joints that mimic another one.
    pub mimic: Mimic,
    /// What the root link stands on.
    pub base: Base,
    /// The rotors of joints; each replaces what the description says about its joint's.
    pub rotors: Vec<Rotor>,
    /// Which torques damping and friction exert; `None` (not chosen) is as [`Friction::None`], with a
    /// warning if the description has damping or friction.
    pub friction: Option<Friction>,
    /// What closes loops, besides what the description says.
    pub loops: Vec<Loop>,
    /// The frames of links that may touch the world.
    pub contacts: Vec<Contact>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            gravity: None,
            unphysical_inertia: Severity::Error,
            mimic: Mimic::default(),
            base: Base::default(),
            rotors: Vec::new(),
            friction: None,
            loops: Vec::new(),
            contacts: Vec::new(),
        }
    }
}

/// How to take joints that mimic another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mimic {
    /// As it is written: the joint follows, and has no coordinate of its own.
    #[default]
    Follow,
    /// As if the joint did not mimic: it has a coordinate of its own.
    Independent,
    /// As an error.
    Refuse,
}

/// What the root link stands on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Base {
    /// It is fixed to the world.
    #[default]
    Fixed,
    /// Nothing: a joint of type floating, called `floating_base`, is between it and the world.
    Floating,
}

/// The rotor that drives a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotor {
    /// The joint's name.
    pub joint: String,
    /// Its inertia about its own axis, kg m^2 (or kg, for a joint that slides).
    pub inertia: f64,
    /// How many times faster it turns than the joint; the joint feels the square of that times the
    /// inertia.
    pub gear_ratio: f64,
}

/// A joint that closes a loop of joints, as `<loop_joint>` does: two frames that are held together.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Its name, which no other joint has.
    pub name: String,
    /// What it holds; an axis may be of any length.
    pub kind: LoopConstraintKind,
    /// The two frames.
    pub ends: [LoopEnd; 2],
}

/// A frame that a [`Loop`] holds, or that a [`Contact`] is.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopEnd {
    /// The link's name.
    pub link: String,
    /// Where the frame's origin stands on it, m.
    pub xyz: [f64; 3],
    /// How it is turned: roll, pitch and yaw, rad.
    pub rpy: [f64; 3],
}

/// A frame of a link that may touch the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Its name, which no other contact has.
    pub name: String,
    /// The motions that it prevents.
    pub kind: ContactKind,
    /// The frame, on a link that moves.
    pub end: LoopEnd,
}
