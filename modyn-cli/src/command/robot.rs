//! The robot that a command is about: where its description is, and how it is to be read.

use std::path::{Path, PathBuf};

use clap::Args;
use modyn_codegen::Builder;
use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics};
use modyn_codegen::read::file::{read_first, read_text};
use modyn_codegen::{Format, ReadOptions, Reading, read};

use crate::command::diagnostics;
use crate::command::options::ReadingOptions;
use crate::command::outcome::{Failure, to_stderr};

/// A description, and how to read it.
#[derive(Args)]
pub struct Robot {
    /// The description (URDF or MJCF); `-` for standard input
    #[arg(value_name = "ROBOT.urdf")]
    pub path: PathBuf,
    #[command(flatten)]
    pub options: ReadingOptions,
}

/// A description that was found.
pub struct Description {
    /// What the user calls it.
    pub name: String,
    /// What stands in it.
    pub text: String,
    /// Where it is, unless it came through standard input.
    path: Option<PathBuf>,
}

impl Description {
    /// Finds the description that the user means.
    pub fn open(path: &Path) -> Result<Self, Diagnostics> {
        let name = path.display().to_string();
        if path == Path::new("-") {
            let name = String::from("standard input");
            let text = read_text(&name, std::io::stdin().lock())?;
            return Ok(Self { name, text, path: None });
        }
        if !path.exists() {
            let missing = Diagnostic::error(Code::MissingFile, format!("`{name}` does not exist"));
            let help = "give the path of a URDF file, or `-` for standard input";
            return Err(missing.with_help(help).into());
        }
        let (_, text) = read_first(&name, &[path.to_owned()])?;
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Ok(Self { name, text, path: Some(path) })
    }

    /// Reads it.
    pub fn read(&self, options: &ReadOptions) -> Result<Reading, Diagnostics> {
        read(&self.text, &self.name, options)
    }

    /// Tells the user what is odd in it.
    pub fn warn(&self, warnings: Diagnostics) {
        to_stderr(&diagnostics::render(warnings.as_slice(), Some(&self.text)));
    }

    /// What went wrong with it, for the user.
    pub fn failure(&self, found: Diagnostics) -> Failure {
        Failure::Diagnostics(found, Some(self.text.clone()))
    }
}

impl Robot {
    /// Finds the description.
    pub fn open(&self) -> Result<Description, Failure> {
        Description::open(&self.path).map_err(|found| Failure::Diagnostics(found, None))
    }

    /// The compiler with these options, for this description.
    pub fn builder(&self, description: &Description) -> Builder {
        let Description { name, text, path } = description;
        let builder = Builder::new();
        // With its path, a kept file says what a build script's would.
        let builder = match (path, Format::of(text, name)) {
            (Some(path), Format::Mjcf) => builder.mjcf(path),
            (Some(path), _) => builder.urdf(path),
            (None, _) => builder.text(text, name),
        };
        self.options.configure(builder)
    }
}

impl Robot {
    /// The same, with the description called as the user calls it: compilers are given its full path.
    pub fn named(&self, found: Diagnostics) -> Diagnostics {
        let name = self.path.display().to_string();
        let mut found = found.into_vec();
        found
            .iter_mut()
            .filter_map(|one| one.file.as_mut())
            .for_each(|file| file.clone_from(&name));
        Diagnostics::new(found)
    }
}
