//! The source of the robot: a file, a text or a model.

use std::path::{Path, PathBuf};

use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics};
use modyn_read::read::file::read_first;
use modyn_read::{Format, ReadOptions, Reading, gravity_error};
use modyn_runtime::EmbeddedModel;
use modyn_runtime::model::Model;

use super::Builder;

/// The source of the robot.
#[derive(Clone, Debug, Default)]
pub(super) enum Source {
    #[default]
    None,
    File(PathBuf),
    Text {
        text: String,
        file: String,
    },
    Model(Box<Model>),
    Unread(Diagnostics),
}

impl Builder {
    /// Sets the file to read, of any format ([`Format::of`]); a relative path as for a
    /// [URDF](Self::urdf).
    #[must_use]
    pub fn file(mut self, path: impl Into<PathBuf>) -> Self {
        (self.source, self.format) = (Source::File(path.into()), None);
        self
    }

    /// Sets the text of a description, of any format ([`Format::of`]), and the file name for
    /// diagnostics.
    #[must_use]
    pub fn text(mut self, text: impl Into<String>, file: impl Into<String>) -> Self {
        self = self.urdf_text(text, file);
        self.format = None;
        self
    }

    /// Sets the URDF file to read. A relative path starts at the folder of the crate's
    /// `Cargo.toml`.
    #[must_use]
    pub fn urdf(mut self, path: impl Into<PathBuf>) -> Self {
        (self.source, self.format) = (Source::File(path.into()), Some(Format::Urdf));
        self
    }

    /// Sets the text of a URDF, and the file name for diagnostics.
    #[must_use]
    pub fn urdf_text(mut self, text: impl Into<String>, file: impl Into<String>) -> Self {
        self.source = Source::Text { text: text.into(), file: file.into() };
        self.format = Some(Format::Urdf);
        self
    }

    /// Sets the `MuJoCo` model to read, [as far as that is supported](crate::read_mjcf); a relative
    /// path as for a [URDF](Self::urdf).
    #[must_use]
    pub fn mjcf(mut self, path: impl Into<PathBuf>) -> Self {
        (self.source, self.format) = (Source::File(path.into()), Some(Format::Mjcf));
        self
    }

    /// Sets the text of a `MuJoCo` model, and the file name for diagnostics.
    #[must_use]
    pub fn mjcf_text(mut self, text: impl Into<String>, file: impl Into<String>) -> Self {
        self = self.urdf_text(text, file);
        self.format = Some(Format::Mjcf);
        self
    }

    /// Sets a model as the robot. It is checked as a description is, and keeps its own gravity
    /// unless [`gravity`](Self::gravity) is called.
    #[must_use]
    pub fn model(mut self, model: Model) -> Self {
        self.source = Source::Model(Box::new(model));
        self
    }

    /// Sets the robot of a generated type, which has its description by the option
    /// [`embed_model`](Self::embed_model). It keeps its own gravity unless
    /// [`gravity`](Self::gravity) is called. Its options about code are not taken over.
    #[must_use]
    pub fn robot<R: EmbeddedModel>(self) -> Self {
        self.model(R::model())
    }

    /// Sets the errors of a description that could not be read; `generate` returns them with the
    /// errors of the options.
    #[doc(hidden)]
    #[must_use]
    pub fn failed_to_read(mut self, why: Diagnostics) -> Self {
        self.source = Source::Unread(why);
        self
    }

    /// Returns the robot and the warnings about its description.
    pub(super) fn read(&self) -> Result<Reading, Diagnostics> {
        // An invalid gravity is among the errors of the options.
        let gravity = self.options.read.gravity.filter(|&gravity| gravity_error(gravity).is_none());
        let options = ReadOptions { gravity, ..self.options.read.clone() };
        match &self.source {
            Source::None => {
                let missing =
                    Diagnostic::error(Code::MissingFile, "no robot description was given");
                Err(missing.with_help("call `Builder::urdf` with the path of a URDF").into())
            }
            Source::File(path) => {
                let place = resolve_path(path);
                let folder = options.folder.or_else(|| place.parent().map(Path::to_owned));
                let options = ReadOptions { folder, ..options };
                let (_, text) = read_first(path.display(), &[place])?;
                self.read_text(&text, &path.display().to_string(), &options)
            }
            Source::Text { text, file } => self.read_text(text, file, &options),
            Source::Model(model) => {
                let mut model = model.as_ref().clone();
                if let Some(gravity) = gravity {
                    model = model.with_gravity(gravity).map_err(|errors| {
                        let help = "this is a fault of modyn: please report it with the model";
                        let diagnostic = |error: &dyn std::fmt::Display| {
                            Diagnostic::error(Code::InvalidModel, error.to_string()).with_help(help)
                        };
                        Diagnostics::new(errors.iter().map(|error| diagnostic(error)).collect())
                    })?;
                }
                Reading::of_model(model, options.unphysical_inertia)
            }
            Source::Unread(why) => Err(why.clone()),
        }
    }

    fn read_text(
        &self,
        text: &str,
        file: &str,
        options: &ReadOptions,
    ) -> Result<Reading, Diagnostics> {
        self.format.unwrap_or_else(|| Format::of(text, file)).read(text, file, options)
    }
}

/// Returns the path of a file: as given, or from the folder of the crate's `Cargo.toml`.
pub(super) fn resolve_path(path: &Path) -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| path.into(), |root| Path::new(&root).join(path))
}
