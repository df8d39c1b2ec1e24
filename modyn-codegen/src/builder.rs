//! The one door behind the three: from a description and options to text.

use std::path::{Path, PathBuf};

use modyn_runtime::model::{Model, ModuleTree};

use crate::emit::{EmitOptions, Emitted, FloatType, emit};
use crate::error::{Code, Diagnostic, Diagnostics, Severity};
use crate::names;
use crate::urdf::{self, Mimic, ReadOptions};
use modyn_runtime::OperationCount;

/// Which kinematic modules a robot is divided into; see [`ModuleTree`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ModuleChoice {
    /// Maximal serial chains.
    #[default]
    Chains,
    /// Every link its own module.
    Links,
    /// These, by link names, each from its parent outwards.
    List(Vec<Vec<String>>),
}

/// Compiles a robot description.
///
/// In a build script:
///
/// ```no_run
/// fn main() -> Result<(), modyn_codegen::error::Diagnostics> {
///     modyn_codegen::Builder::new().urdf("robots/gripper.urdf").compile()?;
///     Ok(())
/// }
/// ```
///
/// and in the crate `modyn::include_model!(gripper);`.
#[derive(Clone, Debug, Default)]
pub struct Builder {
    source: Source,
    read: ReadOptions,
    modules: ModuleChoice,
    type_name: Option<String>,
    visibility: Option<String>,
    krate: Option<String>,
    float: FloatType,
}

/// Where the robot comes from.
#[derive(Clone, Debug, Default)]
enum Source {
    #[default]
    None,
    File(PathBuf),
    Text {
        text: String,
        file: String,
    },
    Model(Box<Model>),
}

/// What was compiled.
#[derive(Clone, Debug)]
pub struct Generated {
    /// Rust items: the type named [`type_name`](Self::type_name) and what belongs to it.
    pub text: String,
    /// The name of the generated type.
    pub type_name: String,
    /// The robot.
    pub model: Model,
    /// What was found odd, but taken.
    pub warnings: Vec<Diagnostic>,
    /// The operations that each function takes.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// The modules that forward dynamics is eliminated by.
    pub partition: ModuleTree,
    /// What each partition that was considered costs, the chosen one first.
    pub partition_costs: Vec<(&'static str, usize)>,
}

impl Builder {
    /// With default options and no robot.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The URDF file to read; a relative path is one from the folder of the crate's `Cargo.toml`.
    #[must_use]
    pub fn urdf(mut self, path: impl Into<PathBuf>) -> Self {
        self.source = Source::File(path.into());
        self
    }

    /// The text of a URDF, and what to call the file in diagnostics.
    #[must_use]
    pub fn urdf_text(mut self, text: impl Into<String>, file: impl Into<String>) -> Self {
        self.source = Source::Text { text: text.into(), file: file.into() };
        self
    }

    /// A model that is there already; the options about reading have no effect on it.
    #[must_use]
    pub fn model(mut self, model: Model) -> Self {
        self.source = Source::Model(Box::new(model));
        self
    }

    /// The name of the generated type; by default made from the robot's name.
    #[must_use]
    pub fn type_name(mut self, name: impl Into<String>) -> Self {
        self.type_name = Some(name.into());
        self
    }

    /// The visibility of the generated types, as Rust has it; `pub` by default.
    #[must_use]
    pub fn visibility(mut self, visibility: impl Into<String>) -> Self {
        self.visibility = Some(visibility.into());
        self
    }

    /// The path of the crate `modyn` where the text goes; `::modyn` by default.
    #[must_use]
    pub fn krate(mut self, path: impl Into<String>) -> Self {
        self.krate = Some(path.into());
        self
    }

    /// The acceleration of free fall in world axes, m/s^2; (0, 0, -9.81) by default.
    #[must_use]
    pub fn gravity(mut self, gravity: [f64; 3]) -> Self {
        self.read.gravity = gravity;
        self
    }

    /// The kinematic modules; maximal serial chains by default.
    #[must_use]
    pub fn modules(mut self, modules: ModuleChoice) -> Self {
        self.modules = modules;
        self
    }

    /// How to take inertias that no rigid body has; as errors by default.
    #[must_use]
    pub fn unphysical_inertia(mut self, severity: Severity) -> Self {
        self.read.unphysical_inertia = severity;
        self
    }

    /// How to take joints that mimic another one; refused by default.
    #[must_use]
    pub fn mimic(mut self, mimic: Mimic) -> Self {
        self.read.mimic = mimic;
        self
    }

    /// The scalar of the type's own functions; `f64` by default.
    #[must_use]
    pub fn float(mut self, float: FloatType) -> Self {
        self.float = float;
        self
    }

    /// Compiles to text, without writing anything.
    ///
    /// # Errors
    ///
    /// All that is wrong with the description and the options.
    pub fn generate(&self) -> Result<Generated, Diagnostics> {
        let reading = match &self.source {
            Source::None => {
                let missing =
                    Diagnostic::error(Code::MissingFile, "no robot description was given");
                return Err(missing.with_help("call `Builder::urdf` with the path of one").into());
            }
            Source::File(path) => {
                let found = self.locate(path)?;
                let text = std::fs::read_to_string(&found).map_err(|error| {
                    let message = format!("`{}` cannot be read: {error}", path.display());
                    Diagnostics::from(Diagnostic::error(Code::MissingFile, message))
                })?;
                urdf::read(&text, &path.display().to_string(), &self.read)?
            }
            Source::Text { text, file } => urdf::read(text, file, &self.read)?,
            Source::Model(model) => {
                urdf::Reading { model: model.as_ref().clone(), warnings: Vec::new() }
            }
        };
        let (model, warnings) = (reading.model, reading.warnings);
        let modules = match &self.modules {
            ModuleChoice::Chains => ModuleTree::chains(&model),
            ModuleChoice::Links => ModuleTree::links(&model),
            ModuleChoice::List(list) => ModuleTree::from_names(&model, list).map_err(|errors| {
                let diagnostics =
                    errors.iter().map(|error| Diagnostic::error(Code::Modules, error.to_string()));
                Diagnostics::new(diagnostics.collect())
            })?,
        };
        if let Some(name) = self.type_name.as_ref().filter(|name| names::type_name(name) != **name)
        {
            let message = format!("`{name}` is no name for a type");
            let help = format!("`{}` would be one", names::type_name(name));
            return Err(Diagnostic::error(Code::TypeName, message).with_help(help).into());
        }
        let options = EmitOptions {
            type_name: self.type_name.clone(),
            visibility: self.visibility.clone().unwrap_or_else(|| "pub".into()),
            krate: self.krate.clone().unwrap_or_else(|| "::modyn".into()),
            float: self.float,
        };
        let Emitted { text, type_name, operations, partition: (partition, partition_costs) } =
            emit(&model, &modules, &options);
        Ok(Generated { text, type_name, model, warnings, operations, partition, partition_costs })
    }

    /// From a build script: compiles to `OUT_DIR`, for `modyn::include_model!`, and has Cargo run
    /// the script again when the description changes. The file is named after the description's.
    /// Warnings become Cargo's warnings.
    ///
    /// # Errors
    ///
    /// All that is wrong with the description and the options, or a file that cannot be written.
    pub fn compile(&self) -> Result<Generated, Diagnostics> {
        if let Source::File(path) = &self.source {
            let watched = self.locate(path).unwrap_or_else(|_| path.clone());
            println!("cargo::rerun-if-changed={}", watched.display());
        }
        let generated = self.generate()?;
        let folder = std::env::var_os("OUT_DIR").ok_or_else(|| {
            let message = "OUT_DIR is not set: `compile` is for build scripts";
            Diagnostics::from(Diagnostic::error(Code::Output, message).with_help("call `generate`"))
        })?;
        let stem = match &self.source {
            Source::File(path) => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
            _ => None,
        };
        let stem = stem.unwrap_or_else(|| names::snake(&generated.type_name));
        let file = Path::new(&folder).join(format!("{stem}.rs"));
        std::fs::write(&file, &generated.text).map_err(|error| {
            let message = format!("`{}` cannot be written: {error}", file.display());
            Diagnostics::from(Diagnostic::error(Code::Output, message))
        })?;
        for warning in &generated.warnings {
            println!("cargo::warning={}", warning.to_string().replace('\n', " "));
        }
        Ok(generated)
    }

    /// Where a file is: as given, or from the folder of the crate's `Cargo.toml`.
    fn locate(&self, path: &Path) -> Result<PathBuf, Diagnostics> {
        let root = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
        let mut tried: Vec<PathBuf> = root.iter().map(|root| root.join(path)).collect();
        if root.is_none() {
            tried.push(path.into());
        }
        tried.iter().find(|place| place.is_file()).cloned().ok_or_else(|| {
            let places: Vec<_> = tried.iter().map(|place| place.display()).collect();
            Diagnostic::missing_file(path.display(), &places).into()
        })
    }
}
