//! From a model to the text of a description: [`write`].
//!
//! ```text
//! Model ─ urdf, mjcf ─▶ elements (xml) ─▶ text, with notes about everything that the format has no words for
//! ```
//!
//! A format is a file here. The text has the links, joints, inertias, loops, contacts and shapes that
//! touch the ground, as far as the reader understood them, and in an MJCF the actuators. It has no
//! pictures and no sensors. Reading it again gives the same robot.

mod actuators;
mod mjcf;
mod shapes;
mod urdf;
mod xml;

use std::collections::BTreeSet;

use modyn_runtime::model::{DEFAULT_GRAVITY, Inertial, Integrator, JointFriction, Limits, Model};

use crate::description::UNLIMITED;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, listed};
use crate::read::Format;
use xml::{Element, number};

/// A description that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Written {
    /// The text.
    pub text: String,
    /// What the format has no words for, a sentence each. The text begins with them, too.
    pub notes: Vec<String>,
}

/// A robot as a document of a format.
struct Document {
    root: Element,
    notes: Vec<String>,
    errors: Vec<Diagnostic>,
}

impl Document {
    fn new(root: Element) -> Self {
        Self { root, notes: Vec::new(), errors: Vec::new() }
    }
}

/// Returns the description of a robot in a format, URDF or MJCF.
///
/// ```
/// # fn main() -> Result<(), modyn_read::diagnostics::Diagnostics> {
/// use modyn_read::{Format, read, write};
///
/// let sdf = r#"<sdf version="1.9"><model name="pendulum">
///     <link name="rod"><inertial><pose>0 0 -0.5 0 0 0</pose><mass>2</mass></inertial></link>
///     <joint name="pivot" type="continuous"><parent>world</parent><child>rod</child>
///       <axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"#;
/// let model = read(sdf, "pendulum.sdf", &Default::default())?.model;
/// let written = write(&model, Format::Urdf)?;
/// let again = read(&written.text, "pendulum.urdf", &Default::default())?.model;
/// assert_eq!(again.moving_links()[0].inertial, model.moving_links()[0].inertial);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
///
/// Returns an error for each part of the robot that the format has no words for, if the robot's
/// dynamics would differ without it; and an error for a format that is not written.
pub fn write(model: &Model, format: Format) -> Result<Written, Diagnostics> {
    let document = match format {
        Format::Urdf => urdf::document(model),
        Format::Mjcf => mjcf::document(model),
        other => {
            let message = format!("modyn does not write {}", other.name());
            let help = "write a URDF or an MJCF";
            return Err(Diagnostic::error(Code::Inexpressible, message).with_help(help).into());
        }
    };
    let Document { root, mut notes, mut errors } = document;
    notes.extend(notes_about_options(model, format));
    if let Some(text) = root.unwritable() {
        let message = format!("the name {text:?} has characters that XML has no words for");
        errors.push(Diagnostic::error(Code::Inexpressible, message).with_help("rename it"));
    }
    if !errors.is_empty() {
        return Err(Diagnostics::new(errors));
    }
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    xml::comment("Written by modyn, with what it understood of another description.", &mut text);
    for note in &notes {
        xml::comment(note, &mut text);
    }
    root.print(&mut text);
    Ok(Written { text, notes })
}

/// Returns notes about properties of a model that options of reading have, and not the format.
fn notes_about_options(model: &Model, format: Format) -> Vec<String> {
    let mut notes = Vec::new();
    if format == Format::Urdf && !model.keyframes().is_empty() {
        let names = model.keyframes().iter().map(|keyframe| &*keyframe.name);
        notes.push(format!("Left out: {}.", listed("keyframe", names)));
    }
    if format == Format::Urdf && !model.actuation().actuators.is_empty() {
        let names = model.control_names().into_iter();
        notes.push(format!("Left out: {}.", listed("actuator", names)));
    }
    if format == Format::Urdf && model.gravity() != DEFAULT_GRAVITY {
        let [x, y, z] = model.gravity().map(number);
        notes.push(format!(
            "The format has no gravity: read the robot with the option `gravity = [{x}, {y}, {z}]`."
        ));
    }
    if format == Format::Urdf && model.soft_constraints().integrator != Integrator::Euler {
        notes.push("Left out: the integrator of `step`, which is `Euler` for a URDF.".into());
    }
    let friction = match model.joint_friction() {
        JointFriction::None => return notes,
        JointFriction::Viscous => "viscous".into(),
        JointFriction::Coulomb => "coulomb".into(),
        JointFriction::Smooth(velocity) => format!("smooth({})", number(velocity)),
        _ => return notes,
    };
    notes.push(format!(
        "Damping and friction act if the robot is read with the option `joint_friction = {friction}`."
    ));
    notes
}

/// The names that a document already has, to which unique ones are added.
struct Names(BTreeSet<String>);

impl Names {
    fn new<'n>(names: impl Iterator<Item = &'n str>) -> Self {
        Self(names.map(String::from).collect())
    }

    /// Returns a name that no other part has: this one, or this one with a number.
    fn unique(&mut self, name: String) -> String {
        let numbered = (2..).map(|n| format!("{name}_{n}"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        let name = names.find(|name| !self.0.contains(name)).unwrap_or(name.clone());
        self.0.insert(name.clone());
        name
    }
}

/// Returns whether a link has neither mass nor rotational inertia.
fn is_massless(inertial: &Inertial) -> bool {
    inertial.mass == 0.0 && inertial.inertia == [0.0; 6]
}

/// Returns the position limits, if there are any.
fn range(limits: Option<&Limits>) -> Option<[f64; 2]> {
    let limits = limits?;
    let bounds = [limits.lower, limits.upper];
    bounds
        .iter()
        .any(Option::is_some)
        .then(|| [bounds[0].unwrap_or(-UNLIMITED), bounds[1].unwrap_or(UNLIMITED)])
}
