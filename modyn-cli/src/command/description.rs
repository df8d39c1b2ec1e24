//! The text of a robot's description, and where it is.

use std::path::{Path, PathBuf};

use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics};
use modyn_codegen::read::file::{read_first, read_text};
use modyn_codegen::{ReadOptions, Reading, read};

/// A description.
#[derive(Clone, Debug)]
pub struct Description {
    /// The name, as the user wrote it.
    pub name: String,
    /// The text.
    pub text: String,
    /// The path; `None` for standard input.
    pub(super) path: Option<PathBuf>,
}

impl Description {
    /// Reads the text of the description.
    pub fn open(path: &Path) -> Result<Self, Diagnostics> {
        let name = path.display().to_string();
        if path == Path::new("-") {
            let name = String::from("standard input");
            let text = read_text(&name, std::io::stdin().lock())?;
            return Ok(Self { name, text, path: None });
        }
        if !path.exists() {
            let missing = Diagnostic::error(Code::MissingFile, format!("`{name}` does not exist"));
            let help = "give the path of a URDF, xacro, SDF or MJCF from the current folder, or `-` \
                for standard input";
            return Err(missing.with_help(help).into());
        }
        let (_, text) = read_first(&name, &[path.to_owned()])?;
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Ok(Self { name, text, path: Some(path) })
    }

    /// Returns the file of the description, if it is one, and the files that the reading names.
    pub fn inputs(&self, reading: Option<&Reading>) -> Vec<PathBuf> {
        let named = reading.map_or(&[][..], |reading| &reading.files);
        self.path.iter().chain(named).cloned().collect()
    }

    /// Reads the robot.
    pub fn read(&self, options: &ReadOptions) -> Result<Reading, Diagnostics> {
        let folder = self.path.as_deref().and_then(Path::parent).map(Path::to_owned);
        read(&self.text, &self.name, &ReadOptions { folder, ..options.clone() })
    }
}
