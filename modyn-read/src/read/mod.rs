//! From a text to a [`Reading`]: a model and its warnings.
//!
//! ```text
//! text ─ xml ─▶ XML ─ urdf, xacro, mjcf, sdf ─▶ Description ─ assemble, check ─▶ Model
//! ```
//!
//! Each format has a folder, which produces a description and does not know the model. One table
//! has the formats: the macro, the builder, the command and the Python package find a text's format
//! by [`Format::of`].

mod collision;
pub mod file;
mod mesh;
pub(crate) mod mjcf;
mod packages;
mod sdf;
mod urdf;
mod visual;
mod xacro;
pub(crate) mod xml;

use std::path::{Path, PathBuf};

use modyn_runtime::model::{JointFriction, Model};

use crate::assemble::assemble;
use crate::check::{check_model, friction_error, gravity_error, ground_error};
use crate::description::{Base, Description, ReadOptions, Shapes};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Report, Severity};
pub use packages::PACKAGE_PATHS;

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
    /// The shapes of the links, if they were [asked for](ReadOptions::shapes).
    pub shapes: Shapes,
}

impl Reading {
    /// Checks a model that was built in code as a description is checked, and returns it with the
    /// warnings. `unphysical` is the severity of inertias that no rigid body has.
    ///
    /// # Errors
    ///
    /// Returns all errors of the model, and its warnings.
    pub fn of_model(model: Model, unphysical: Severity) -> Result<Self, Diagnostics> {
        let warnings = check_model(&model, unphysical)?;
        Ok(Self { model, warnings, files: Vec::new(), shapes: Shapes::default() })
    }
}

/// The formats of descriptions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// URDF.
    #[default]
    Urdf,
    /// A xacro, which is expanded to a URDF.
    Xacro,
    /// `MuJoCo`'s models (MJCF).
    Mjcf,
    /// Gazebo's models and worlds (SDF).
    Sdf,
}

/// A row of the table of formats.
struct Row {
    format: Format,
    /// The name in lower case.
    name: &'static str,
    /// The name of the outermost element.
    root: &'static str,
    /// A text that tells a format from others with the same outermost element.
    mark: Option<&'static str>,
    /// The extension of files. It decides if the text has no element, or several formats have its
    /// element.
    extension: &'static str,
    describe: Describe,
}

/// Makes a description of a text; `None` with errors in the report.
type Describe = fn(&str, &ReadOptions, &mut Report<'_>) -> Option<Description>;

/// The formats. The first row that fits a text is its format; a text that fits none is read as a
/// URDF, whose reader reports what is wrong.
const FORMATS: &[Row] = &[
    Row {
        format: Format::Xacro,
        name: "xacro",
        root: "robot",
        mark: Some("<xacro:"),
        extension: "xacro",
        describe: xacro::describe,
    },
    Row {
        format: Format::Urdf,
        name: "urdf",
        root: "robot",
        mark: None,
        extension: "urdf",
        describe: urdf::describe,
    },
    Row {
        format: Format::Mjcf,
        name: "mjcf",
        root: "mujoco",
        mark: None,
        extension: "mjcf",
        describe: mjcf::describe,
    },
    Row {
        format: Format::Sdf,
        name: "sdf",
        root: "sdf",
        mark: None,
        extension: "sdf",
        describe: sdf::describe,
    },
];

impl Row {
    /// Returns whether a text with this outermost element, in a file with this extension, is of the
    /// format.
    fn fits(&self, text: &str, element: Option<&str>, extension: &str) -> bool {
        let named = extension.eq_ignore_ascii_case(self.extension);
        let marked = || self.mark.is_none_or(|mark| text.contains(mark));
        element.map_or(named, |element| element == self.root && (named || marked()))
    }
}

impl Format {
    /// Returns the format of a text, by its first element, or by the file's extension if it has no
    /// element. Unknown formats are read as URDF, whose reader reports what is wrong.
    #[must_use]
    pub fn of(text: &str, file: &str) -> Self {
        Self::found(text, file).unwrap_or(Self::Urdf)
    }

    /// Returns the format of a text, as [`Format::of`]; `None` if the text has no format of the
    /// table.
    #[must_use]
    pub fn found(text: &str, file: &str) -> Option<Self> {
        let element = xml::document::first_element(text);
        let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
        FORMATS.iter().find(|row| row.fits(text, element, extension)).map(|row| row.format)
    }

    /// Returns the format's name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().name
    }

    fn row(self) -> &'static Row {
        FORMATS.iter().find(|row| row.format == self).unwrap_or(&FORMATS[0])
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
        let friction = options.joint_friction.and_then(friction_error);
        let ground = options.ground.and_then(ground_error);
        // Reading continues without it, to find other errors.
        if gravity.is_some() {
            options.gravity = None;
        }
        if friction.is_some() {
            options.joint_friction = Some(JointFriction::None);
        }
        if ground.is_some() {
            options.ground = None;
        }
        let mut shapes = Shapes::default();
        let model = xml::document::within_limits(text, 0, &mut report)
            .and_then(|text| (self.row().describe)(&text, &options, &mut report))
            .and_then(|mut description| {
                if options.shapes {
                    shapes = description.take_shapes();
                }
                // The readers of SDF and MJCF have connected the base to the world.
                let is_connected = matches!(self, Self::Sdf | Self::Mjcf);
                let base = if is_connected { Base::Auto } else { options.base };
                assemble(description, &ReadOptions { base, ..options.clone() }, &mut report)
            });
        let of_options = gravity.into_iter().chain(friction).chain(ground);
        let files = report.take_dependencies();
        let diagnostics = Diagnostics::new(report.finish().into_iter().chain(of_options).collect());
        match model {
            Some(model) if !diagnostics.has_errors() => {
                Ok(Reading { model, warnings: diagnostics.into_vec(), files, shapes })
            }
            _ => Err(diagnostics),
        }
    }
}

/// Reads a description of any supported format. Diagnostics name the file `file`. Other files that
/// the description names are read if the options have its [`folder`](ReadOptions::folder).
///
/// ```
/// let text = r#"<robot name="pendulum"><link name="base"/>
///     <joint name="pivot" type="continuous">
///       <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
///     </joint>
///     <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
///       <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
/// let reading = modyn_read::read(text, "pendulum.urdf", &Default::default())?;
/// assert_eq!((reading.model.nq(), reading.warnings.len()), (1, 0));
///
/// // Errors have their places: the mass is in line 5.
/// let wrong = text.replace("mass value=\"1\"", "mass value=\"-1\"");
/// let found = modyn_read::read(&wrong, "pendulum.urdf", &Default::default()).expect_err("refused");
/// assert!(found.to_string().contains("pendulum.urdf:5:"), "{found}");
/// # Ok::<(), modyn_read::diagnostics::Diagnostics>(())
/// ```
///
/// # Errors
///
/// Returns all errors of the text, and its warnings.
pub fn read(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::of(text, file).read(text, file, options)
}

/// Reads the file of a description of any supported format; a relative path starts at the current
/// folder. Diagnostics name the path. The files that the description names are found from its
/// folder, unless the options have another [`folder`](ReadOptions::folder).
///
/// ```no_run
/// # fn main() -> Result<(), modyn_read::diagnostics::Diagnostics> {
/// let reading = modyn_read::read_file("robot.urdf.xacro", &Default::default())?;
/// for warning in &reading.warnings {
///     eprintln!("{warning}");
/// }
/// # Ok(())
/// # }
/// ```
///
/// # Errors
///
/// Returns an error if the file cannot be read as text, or all errors of the text, and its
/// warnings.
pub fn read_file(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    let path = path.as_ref();
    let name = path.display().to_string();
    if !options.files.exists(path) {
        let missing = Diagnostic::error(Code::MissingFile, format!("`{name}` does not exist"));
        let help = "give the path of a URDF, xacro, SDF or MJCF from the current folder";
        return Err(missing.with_help(help).into());
    }
    let text = file::read_in(&options.files, &name, path)?;
    let folder = options.folder.clone().or_else(|| path.parent().map(Path::to_owned));
    read(&text, &name, &ReadOptions { folder, ..options.clone() })
}

/// Returns the URDF of a xacro, and the warnings. Diagnostics name the file `file`; the files that
/// it includes are read if the options have its [`folder`](ReadOptions::folder).
///
/// # Errors
///
/// Returns the error of the xacro, with its place and the macro calls that led there.
pub fn expand_xacro(
    text: &str,
    file: &str,
    options: &ReadOptions,
) -> Result<(String, Vec<Diagnostic>), Diagnostics> {
    let mut report = Report::new(text, file);
    let expanded = xml::document::within_limits(text, 0, &mut report)
        .and_then(|text| xacro::expand(&text, options, &mut report));
    let diagnostics = Diagnostics::new(report.finish());
    match expanded {
        Some(expanded) if !diagnostics.has_errors() => Ok((expanded, diagnostics.into_vec())),
        _ => Err(diagnostics),
    }
}

/// Reads a URDF. Diagnostics name the file `file`.
///
/// # Errors
///
/// Returns all errors of the text, and its warnings.
pub fn read_urdf(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::Urdf.read(text, file, options)
}

/// Reads a `MuJoCo` model (MJCF). Diagnostics name the file `file`. Included files, attached models
/// and meshes are read if the options have the [`folder`](ReadOptions::folder).
///
/// - Bodies become links of a tree whose root link is `world`. If a body has several joints, there
///   are massless links between them. A body's frame is its link's frame. Coordinates are the
///   coordinates of `docs/conventions.md`, not `MuJoCo`'s; `modyn::conventions::mujoco` converts
///   them. Named sites are frames.
/// - A body without `<inertial>` has the inertia of its geoms. A mesh is only read if its mass is
///   needed.
/// - Constraints of `<equality>` are exact: mimic joints and loops.
/// - Gravity is the gravity of `<option>`, unless the options set another one.
/// - Geoms touch planes of the world in steps. Sensors and visual elements are ignored. Controllers
///   of actuators do not act, with a warning. Springs of joints and `gravcomp` act. Damping and
///   friction act if the options say so, as in a URDF.
///
/// # Errors
///
/// Returns all errors and unsupported elements of the text, and its warnings.
pub fn read_mjcf(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    Format::Mjcf.read(text, file, options)
}
