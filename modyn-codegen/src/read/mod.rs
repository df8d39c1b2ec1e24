//! From a text to a [`Reading`]: a model and its warnings.
//!
//! ```text
//! text ─ xml ─▶ XML ─ urdf, mjcf, sdf ─▶ Description ─ assemble, check ─▶ Model
//! ```
//!
//! Each format has a folder, which produces a description and does not know the model. Only [`Format::of`] decides which
//! format a text has.

pub mod file;
#[cfg(feature = "mjcf")]
mod mjcf;
mod sdf;
mod urdf;
pub(crate) mod xml;

use std::path::PathBuf;

use modyn_runtime::model::{Friction, Model};

use crate::assemble::assemble;
use crate::check::{friction_error, gravity_error};
use crate::description::{Base, Description, ReadOptions};
use crate::diagnostics::{Diagnostic, Diagnostics, Report};

/// A robot that was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// The robot.
    pub model: Model,
    /// The warnings, in the order of the file.
    pub warnings: Vec<Diagnostic>,
    /// The other files that were read: the robot changes with them.
    pub files: Vec<PathBuf>,
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
    /// Gazebo's models and worlds (SDF).
    Sdf,
}

impl Format {
    /// Returns the format of a text, by its first element, or by the file's extension if it has no element. Unknown
    /// formats are read as URDF, whose reader reports what is wrong.
    #[must_use]
    pub fn of(text: &str, file: &str) -> Self {
        let extension = file.rsplit_once('.').map(|(_, extension)| extension);
        let (name, extension) = (xml::document::first_element(text), extension.unwrap_or_default());
        match name.unwrap_or(&extension.to_ascii_lowercase()) {
            "sdf" => Self::Sdf,
            #[cfg(feature = "mjcf")]
            "mujoco" | "mjcf" => Self::Mjcf,
            _ => Self::Urdf,
        }
    }

    /// Returns the format's name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            #[cfg(feature = "mjcf")]
            Self::Mjcf => "mjcf",
            Self::Sdf => "sdf",
        }
    }

    /// Reads a text of this format. Diagnostics name the file `file`.
    ///
    /// # Errors
    ///
    /// Returns all errors of the text, and its warnings.
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
        // Reading continues without it, to find other errors.
        if gravity.is_some() {
            options.gravity = None;
        }
        if friction.is_some() {
            options.friction = Some(Friction::None);
        }
        let model = self.describe(text, &options, &mut report).and_then(|description| {
            // The reader of an SDF has connected the base to the world.
            let base = if self == Self::Sdf { Base::Described } else { options.base };
            assemble(description, &ReadOptions { base, ..options }, &mut report)
        });
        let of_options = gravity.into_iter().chain(friction);
        let files = report.take_dependencies();
        let found = Diagnostics::new(report.finish().into_iter().chain(of_options).collect());
        match model {
            Some(model) if !found.has_errors() => {
                Ok(Reading { model, warnings: found.into_vec(), files })
            }
            _ => Err(found),
        }
    }

    fn describe(
        self,
        text: &str,
        options: &ReadOptions,
        report: &mut Report<'_>,
    ) -> Option<Description> {
        let text = xml::document::within_limits(text, 0, report)?;
        match self {
            Self::Urdf => urdf::describe(&text, options, report),
            #[cfg(feature = "mjcf")]
            Self::Mjcf => mjcf::describe(&text, options, report),
            Self::Sdf => sdf::describe(&text, options, report),
        }
    }
}

/// Reads a description of any supported format. Diagnostics name the file `file`. Other files that the description names
/// are read if the options have its [`folder`](ReadOptions::folder).
///
/// ```
/// let text = r#"<robot name="pendulum"><link name="base"/>
///     <joint name="pivot" type="continuous">
///       <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
///     </joint>
///     <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
///       <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
/// let reading = modyn_codegen::read(text, "pendulum.urdf", &Default::default())?;
/// assert_eq!((reading.model.nq(), reading.warnings.len()), (1, 0));
///
/// // Errors have their places: the mass is in line 5.
/// let wrong = text.replace("mass value=\"1\"", "mass value=\"-1\"");
/// let found = modyn_codegen::read(&wrong, "pendulum.urdf", &Default::default()).expect_err("refused");
/// assert!(found.to_string().contains("pendulum.urdf:5:"), "{found}");
/// # Ok::<(), modyn_codegen::diagnostics::Diagnostics>(())
/// ```
///
/// # Errors
///
/// Returns all errors of the text, and its warnings.
pub fn read(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::of(text, file).read(text, file, options)
}

/// Reads a URDF. Diagnostics name the file `file`.
///
/// # Errors
///
/// Returns all errors of the text, and its warnings.
pub fn read_urdf(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::Urdf.read(text, file, options)
}

/// Reads a `MuJoCo` model (MJCF). Diagnostics name the file `file`. Included files, attached models and meshes are read if
/// the options have the [`folder`](ReadOptions::folder).
///
/// - Bodies become links of a tree whose root link is `world`. If a body has several joints, there are massless links
///   between them. A body's frame is its link's frame. Coordinates are those of `docs/conventions.md`, not `MuJoCo`'s;
///   `modyn::conventions::mujoco` converts them. Named sites are frames.
/// - A body without `<inertial>` has the inertia of its geoms. A mesh is only read if its mass is needed.
/// - Constraints of `<equality>` are exact: mimic joints and loops.
/// - Gravity is that of `<option>`, unless the options set another one.
/// - Contacts, sensors and visual elements are ignored. Controllers of actuators, springs and `gravcomp` do not act, with a
///   warning. Damping and friction act if the options say so, as in a URDF.
///
/// # Errors
///
/// Returns all errors and unsupported elements of the text, and its warnings.
#[cfg(feature = "mjcf")]
pub fn read_mjcf(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::Mjcf.read(text, file, options)
}
