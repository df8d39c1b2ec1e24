//! From the text of a URDF to a [`Model`].
//!
//! ```text
//! text ─ document ─▶ XML ─ parts ─▶ links and joints ─ tree ─▶ order ─ build ─▶ Model
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

mod build;
mod document;
mod felt;
mod locate;
mod nearest;
mod numbers;
mod parts;
mod physical;
mod report;
mod tree;

use modyn_runtime::model::{DEFAULT_GRAVITY, Model};

use crate::error::{Code, Diagnostic, Diagnostics, Severity};
use report::Report;

/// What a user may choose about reading.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// The acceleration of free fall in world axes, m/s^2.
    pub gravity: [f64; 3],
    /// How to take inertias that no rigid body has.
    pub unphysical_inertia: Severity,
    /// How to take joints that mimic another one.
    pub mimic: Mimic,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { gravity: DEFAULT_GRAVITY, unphysical_inertia: Severity::Error, mimic: Mimic::Refuse }
    }
}

/// How to take joints that mimic another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mimic {
    /// As an error.
    #[default]
    Refuse,
    /// As if the joint did not mimic: it has a coordinate of its own.
    Independent,
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
    let mut report = Report::new(text, file);
    let mut options = options.clone();
    let gravity = gravity_error(options.gravity);
    if gravity.is_some() {
        options.gravity = DEFAULT_GRAVITY; // To find what else is wrong.
    }
    let model = read_into(text, &options, &mut report);
    let found = Diagnostics::new(report.finish().into_iter().chain(gravity).collect());
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

/// Checks a model that was made by hand, or by other means, for what a description is checked for.
pub(crate) fn check(model: Model, unphysical_inertia: Severity) -> Result<Reading, Diagnostics> {
    let found = Diagnostics::new(
        physical::check(&model, unphysical_inertia)
            .into_iter()
            .chain(gravity_error(model.gravity()))
            .collect(),
    );
    if found.has_errors() {
        return Err(found);
    }
    Ok(Reading { model, warnings: found.into_vec() })
}

/// The steps. What stops one of them is in the report.
fn read_into(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Model> {
    let text = document::tidied(text);
    let document = document::parse(&text, report)?;
    let robot = document::robot(&document, report)?;
    let parts = parts::read(robot, options, report);
    let tree = tree::grow(&parts, report)?;
    build::build(&parts, &tree, options, report)
}
