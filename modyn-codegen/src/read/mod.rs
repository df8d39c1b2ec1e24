//! From a text to a [`Reading`]: a model, and what probably is not as it was meant.
//!
//! ```text
//! text ─ xml ─▶ XML ─ urdf, mjcf ─▶ Description ─ assemble, check ─▶ Model
//! ```
//!
//! A format is a folder: it makes a description, and knows nothing of models. Which format a text has is decided here
//! alone ([`Format::of`]).

pub mod file;
#[cfg(feature = "mjcf")]
mod mjcf;
mod urdf;
mod xml;

use modyn_runtime::model::{Friction, Model};

use crate::assemble::assemble;
use crate::check::{friction_error, gravity_error};
use crate::description::{Description, ReadOptions};
use crate::diagnostics::{Diagnostic, Diagnostics, Report};

/// A robot that was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// The robot.
    pub model: Model,
    /// What probably is not as it was meant, in the order of the file.
    pub warnings: Vec<Diagnostic>,
}

/// The formats of descriptions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// URDF.
    #[default]
    Urdf,
    /// `MuJoCo`'s models (MJCF).
    #[cfg(feature = "mjcf")]
    Mjcf,
}

impl Format {
    /// The format of a text: that of its first element, or of its file's extension where it has no element. What is
    /// neither is read as a URDF, whose reader says what is wrong.
    #[must_use]
    pub fn of(text: &str, file: &str) -> Self {
        let extension = file.rsplit_once('.').map(|(_, extension)| extension);
        let is_mjcf = match xml::document::first_element(text) {
            Some(name) => name == "mujoco",
            None => extension.is_some_and(|name| name.eq_ignore_ascii_case("mjcf")),
        };
        match is_mjcf {
            #[cfg(feature = "mjcf")]
            true => Self::Mjcf,
            _ => Self::Urdf,
        }
    }

    /// Its name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            #[cfg(feature = "mjcf")]
            Self::Mjcf => "mjcf",
        }
    }

    /// Reads a text of this format; `file` is what diagnostics call it.
    ///
    /// # Errors
    ///
    /// All that is wrong with the text, with the warnings.
    pub fn read(
        self,
        text: &str,
        file: &str,
        options: &ReadOptions,
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
        let model = self
            .describe(text, &options, &mut report)
            .and_then(|description| assemble(description, &options, &mut report));
        let of_options = gravity.into_iter().chain(friction);
        let found = Diagnostics::new(report.finish().into_iter().chain(of_options).collect());
        match model {
            Some(model) if !found.has_errors() => Ok(Reading { model, warnings: found.into_vec() }),
            _ => Err(found),
        }
    }

    fn describe(
        self,
        text: &str,
        options: &ReadOptions,
        report: &mut Report<'_>,
    ) -> Option<Description> {
        let text = xml::document::within_limits(text, report)?;
        match self {
            Self::Urdf => urdf::describe(&text, options, report),
            #[cfg(feature = "mjcf")]
            Self::Mjcf => mjcf::describe(&text, options, report),
        }
    }
}

/// Reads a description of any format that is known; `file` is what diagnostics call it. No other file is read.
///
/// # Errors
///
/// All that is wrong with the text, with the warnings.
pub fn read(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::of(text, file).read(text, file, options)
}

/// Reads a URDF; `file` is what diagnostics call it.
///
/// # Errors
///
/// All that is wrong with the text, with the warnings.
pub fn read_urdf(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::Urdf.read(text, file, options)
}

/// Reads a `MuJoCo` model (MJCF); `file` is what diagnostics call it. No other file is read.
///
/// - Bodies are links, in a world that is the root link `world`; several joints of one body have links without mass
///   between them. A body's frame is its link's. Coordinates are those of `docs/conventions.md`, not `MuJoCo`'s:
///   `modyn::conventions::mujoco` has the conversions.
/// - Where no inertia is written (`<inertial>`), it is that of the geoms, unless these are meshes.
/// - Gravity is that of `<option>`, unless the options give another one.
/// - Contacts, actuators, sensors and what is only to be seen do not matter. Damping and friction act if the
///   options say so, as for a URDF.
///
/// # Errors
///
/// What is wrong with the text, or not supported, with the warnings.
#[cfg(feature = "mjcf")]
pub fn read_mjcf(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::Mjcf.read(text, file, options)
}

#[cfg(all(test, feature = "mjcf"))]
mod tests {
    use super::Format;

    #[test]
    fn a_format_is_recognised_by_the_text_then_by_the_name() {
        for (text, file, format) in [
            ("<mujoco/>", "robot.urdf", Format::Mjcf),
            (
                "<?xml version='1.0'?>\n<!-- <robot> --><mujoco model='m'>",
                "robot.xml",
                Format::Mjcf,
            ),
            ("<robot name='r'/>", "robot.xml", Format::Urdf),
            ("<robot name='mujoco'/>", "robot.mjcf", Format::Urdf),
            ("", "robot.MJCF", Format::Mjcf),
            ("", "robot.xml", Format::Urdf),
            ("<sdf/>", "-", Format::Urdf),
        ] {
            assert_eq!(Format::of(text, file), format, "{text} {file}");
        }
    }
}
