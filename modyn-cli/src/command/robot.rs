//! The robot of a command: its description, and the options of reading.

use std::path::PathBuf;

use clap::Args;
use modyn_codegen::diagnostics::{Diagnostics, sanitize_for_display};
use modyn_codegen::{Builder, joints_without_inertia};
use modyn_runtime::model::Model;

use crate::command::description::Description;
use crate::command::diagnostics;
use crate::command::options::ReadingOptions;
use crate::command::outcome::{Failure, to_stderr};

/// A description, and the options of reading it.
#[derive(Args)]
pub struct Robot {
    /// The description (URDF, xacro, SDF or MJCF); `-` for standard input
    #[arg(value_name = "ROBOT.urdf")]
    pub path: PathBuf,
    #[command(flatten)]
    pub options: ReadingOptions,
}

/// Returns the failure of a command that needs dynamics, for a robot whose links have no inertia.
pub fn needs_dynamics(model: &Model, command: &str) -> Result<(), Failure> {
    let Some(&joint) = joints_without_inertia(model).first() else { return Ok(()) };
    let joint = sanitize_for_display(&model.moving_links()[joint].joint.name);
    Err(Failure::usage(format!(
        "error: `{command}` needs dynamics, and joint `{joint}` moves no inertia: write the \
         `<inertial>` of its link, or give \
         it an armature, `--armature '\"{joint}\": 1'`"
    )))
}

impl Description {
    /// Prints the warnings.
    pub fn warn(&self, warnings: Diagnostics) {
        to_stderr(&diagnostics::render(warnings.as_slice(), Some(self)));
    }

    /// Returns the failure of a description with these diagnostics.
    pub fn failure(&self, diagnostics: Diagnostics) -> Failure {
        Failure::Diagnostics(diagnostics, Some(self.clone()))
    }
}

impl Robot {
    /// Reads the text of the description.
    pub fn open(&self) -> Result<Description, Failure> {
        Description::open(&self.path).map_err(|diagnostics| Failure::Diagnostics(diagnostics, None))
    }

    /// Returns the builder with these options, for this description.
    pub fn builder(&self, description: &Description) -> Builder {
        let Description { name, text, path } = description;
        let empty = Builder::new();
        // The path gives a generated file the same comment as a build script does.
        let builder = match path {
            Some(path) => empty.file(path),
            None => empty.text(text, name),
        };
        self.options.configure(builder)
    }
}

impl Robot {
    /// Returns the diagnostics with the file's name as the user wrote it; the builder receives the
    /// full path.
    pub fn named(&self, diagnostics: Diagnostics) -> Diagnostics {
        let name = self.path.display().to_string();
        let path = std::path::absolute(&self.path).unwrap_or_else(|_| self.path.clone());
        let absolute = path.display().to_string();
        let mut renamed = diagnostics.into_vec();
        renamed
            .iter_mut()
            .filter_map(|one| one.file.as_mut())
            .filter(|file| **file == absolute)
            .for_each(|file| file.clone_from(&name));
        Diagnostics::new(renamed)
    }
}
