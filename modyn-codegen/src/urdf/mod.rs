//! From the text of a URDF to a [`Model`].
//!
//! ```text
//! text ─ document ─▶ XML ─ parts, joint ─▶ links and joints ─ tree ─▶ order ─ build ─▶ Model
//!                                              ├ mimics ─▶ leaders ──────────┤
//!                                              └ loops ─▶ loop constraints ──────────┘
//! ```
//!
//! Each step reports all that is wrong with it and goes on as far as it can, so that a user sees
//! everything at once. Every figure that is used is read strictly (`numbers`), every diagnostic
//! says where (`locate`). Meshes, visuals, collisions, transmissions and the like are never
//! looked into.
//!
//! The figures are not read with urdf-rs (measured with 0.10): it skips what is no number in a
//! list, takes NaN and infinities, cannot say whether or where something was written, and refuses
//! a whole file for a fault in a `<visual>`. Values from it could be used only where our own
//! reading has already found the very same values. It serves the tests as an independent witness
//! of what well-formed files say.

pub(crate) mod build;
mod circles;
pub(crate) mod document;
mod felt;
pub(crate) mod joint;
mod limits;
mod locate;
mod loops;
mod mimics;
pub(crate) mod nearest;
mod numbers;
pub(crate) mod parts;
mod physical;
pub(crate) mod report;
mod rotors;
mod tree;

pub(crate) use limits::MOST_BYTES;
use modyn_runtime::model::Model;
pub use modyn_runtime::model::{Friction, LoopConstraintKind};

use crate::error::{Code, Diagnostic, Diagnostics, Severity};
use parts::Parts;
use report::Report;

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

/// A frame that a [`Loop`] holds.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopEnd {
    /// The link's name.
    pub link: String,
    /// Where the frame's origin stands on it, m.
    pub xyz: [f64; 3],
    /// How it is turned: roll, pitch and yaw, rad.
    pub rpy: [f64; 3],
}

/// A robot that was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// The robot.
    pub model: Model,
    /// What probably is not as it was meant, in the order of the file.
    pub warnings: Vec<Diagnostic>,
}

/// Reads a URDF; `file` is what diagnostics call it.
///
/// # Errors
///
/// All that is wrong with the text, with the warnings.
pub fn read(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    reading(text, file, options, |options, report| {
        let text = document::bounded(text, report)?;
        let document = document::parse(&text, report)?;
        let robot = document::robot(&document, report)?;
        let parts = parts::read(robot, options, report);
        assemble(parts, options, report)
    })
}

/// What a reader makes of a text, with all that it reports.
pub(crate) fn reading(
    text: &str,
    file: &str,
    options: &ReadOptions,
    read: impl FnOnce(&ReadOptions, &mut Report<'_>) -> Option<Model>,
) -> Result<Reading, Diagnostics> {
    let mut report = Report::new(text, file);
    let mut options = options.clone();
    let gravity = options.gravity.and_then(gravity_error);
    let friction = options.friction.and_then(friction_error);
    // To find what else is wrong.
    if gravity.is_some() {
        options.gravity = None;
    }
    if friction.is_some() {
        options.friction = Some(Friction::None);
    }
    let model = read(&options, &mut report);
    let options = gravity.into_iter().chain(friction);
    let found = Diagnostics::new(report.finish().into_iter().chain(options).collect());
    match model {
        Some(model) if !found.has_errors() => Ok(Reading { model, warnings: found.into_vec() }),
        _ => Err(found),
    }
}

/// What is wrong with a gravity.
pub(crate) fn gravity_error(gravity: [f64; 3]) -> Option<Diagnostic> {
    let what = if gravity.iter().all(|x| x.is_finite()) {
        "too large to compute with"
    } else {
        "not finite"
    };
    let message = format!("the gravity {gravity:?} is {what}");
    let help = "give three finite numbers in m/s^2, such as [0.0, 0.0, -9.81]";
    let good = gravity.iter().all(|x| x.abs() < build::LARGEST);
    (!good).then(|| Diagnostic::error(Code::Gravity, message).with_help(help))
}

/// What is wrong with a friction.
pub(crate) fn friction_error(friction: Friction) -> Option<Diagnostic> {
    let Friction::Smooth(width) = friction else { return None };
    let message = format!("{width} is no velocity to smooth friction by");
    let help = "give a finite velocity above 0 in rad/s or m/s, such as 0.01";
    let good = width > 0.0 && width < build::LARGEST;
    (!good).then(|| Diagnostic::error(Code::Option, message).with_help(help))
}

/// Checks a model that was made by hand, or by other means, for what a description is checked for.
pub(crate) fn check(model: Model, unphysical_inertia: Severity) -> Result<Reading, Diagnostics> {
    let found = Diagnostics::new(
        physical::check(&model, unphysical_inertia)
            .into_iter()
            .chain(gravity_error(model.gravity()))
            .chain(friction_error(model.friction()))
            .collect(),
    );
    if found.has_errors() {
        return Err(found);
    }
    Ok(Reading { model, warnings: found.into_vec() })
}

/// The steps from parts to a model. What stops one of them is in the report.
pub(crate) fn assemble(
    mut parts: Parts,
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> Option<Model> {
    rotors::apply(&mut parts, &options.rotors, report);
    let leaders = mimics::leaders(&parts, options.mimic, report);
    let tree = tree::grow(&parts, report)?;
    build::build(&parts, &tree, &leaders, options, report)
}
