//! The builder: from a description and options to text. The macro, build scripts and the command line use it.

mod file;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use modyn_runtime::OperationCount;
use modyn_runtime::model::{Friction, Model, ModuleError, ModuleTree};

use crate::check::{check_model, conditioning_warning, gravity_error};
use crate::description::{Base, Contact, Loop, Mimic, ReadOptions, Rotor};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Severity, Subject, suggest};
use crate::emit::{
    CSource, EmitOptions, Emitted, FloatType, GpuLanguage, GpuSource, emit, emit_c, emit_gpu,
};
use crate::names;
use crate::options::{Bundle, Fault, ModuleChoice, Options, Value, option_table};
use crate::plan::{Function, Plan};
use crate::read::file::read_first;
use crate::read::{Format, Reading};
use crate::size::too_large;

/// Compiles a robot description.
///
/// In a build script:
///
/// ```no_run
/// fn main() -> Result<(), modyn_codegen::diagnostics::Diagnostics> {
///     modyn_codegen::Builder::new().urdf("robots/gripper.urdf").compile()?;
///     Ok(())
/// }
/// ```
///
/// and in the crate `modyn::include_model!(gripper);`. To have the text itself:
///
/// ```
/// # fn main() -> Result<(), modyn_codegen::diagnostics::Diagnostics> {
/// let urdf = r#"
///     <robot name="pendulum">
///       <link name="world"/>
///       <joint name="pivot" type="continuous">
///         <parent link="world"/> <child link="rod"/> <axis xyz="0 1 0"/>
///       </joint>
///       <link name="rod">
///         <inertial>
///           <origin xyz="0 0 -0.5"/> <mass value="1"/>
///           <inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/>
///         </inertial>
///       </link>
///     </robot>"#;
/// let generated = modyn_codegen::Builder::new().urdf_text(urdf, "pendulum.urdf").generate()?;
/// assert!(generated.text.contains("pub struct Pendulum;"));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Builder {
    source: Source,
    /// `None` detects the format from the text.
    format: Option<Format>,
    options: Options,
}

/// The source of the robot.
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
    Unread(Diagnostics),
}

/// The result of a compilation.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Generated {
    /// The Rust items: the type named [`type_name`](Self::type_name) and its other items.
    pub text: String,
    /// The header of the functions for C, if [`Builder::c_functions`] was called.
    pub c_header: Option<String>,
    /// The name of the generated type.
    pub type_name: String,
    /// The robot.
    pub model: Model,
    /// The warnings about the description.
    pub warnings: Vec<Diagnostic>,
    /// The operations of one call of each function.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// The operations in the text of each function of one state; [`operations`](Self::operations) has those of a call.
    ///
    /// For a function of one link they include all links. Equal limbs count once if they share their code. If they
    /// are packed into vectors, the packed code and the scalar code count, both.
    pub static_operations: Vec<(&'static str, OperationCount)>,
    /// The modules of forward dynamics.
    pub partition: ModuleTree,
    /// The operations of each partition that was considered; the chosen one is first.
    pub partition_costs: Vec<(&'static str, usize)>,
}

/// The programs of a robot; see [`Builder::plan`].
#[non_exhaustive]
pub struct Planning {
    /// The programs.
    pub plan: Plan,
    /// The robot.
    pub model: Model,
    /// The warnings about the description.
    pub warnings: Vec<Diagnostic>,
}

/// A method for each option of the table.
macro_rules! methods {
    ($($stage:ident { $(
        $(#[doc = $docs:literal])+
        $name:literal $method:ident($($argument:ident: $type:ty)?)
            $field:ident: $field_type:ty, $target:ident => $set:expr,
            $form:literal, $default:literal, $example:literal $(, $entries:ident)?;
    )* })*) => {
        /// The options, as in [`OPTIONS`](crate::options::OPTIONS).
        impl Builder {
            $($(
                $(#[doc = $docs])+
                #[doc = ""]
                #[doc = concat!("The default: ", $default, ".")]
                #[must_use]
                pub fn $method(mut self $(, $argument: $type)?) -> Self {
                    let $target = &mut self.options.$stage.$field;
                    $set;
                    self
                }
            )*)*
        }
    };
}

option_table!(methods);

impl Builder {
    /// Returns a builder with default options and without a robot.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the file to read, of any format ([`Format::of`]); a relative path as for a [URDF](Self::urdf).
    #[must_use]
    pub fn file(mut self, path: impl Into<PathBuf>) -> Self {
        (self.source, self.format) = (Source::File(path.into()), None);
        self
    }

    /// Sets the text of a description, of any format ([`Format::of`]), and the file name for diagnostics.
    #[must_use]
    pub fn text(mut self, text: impl Into<String>, file: impl Into<String>) -> Self {
        self = self.urdf_text(text, file);
        self.format = None;
        self
    }

    /// Sets the URDF file to read. A relative path starts at the folder of the crate's `Cargo.toml`.
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

    /// Sets the `MuJoCo` model to read, [as far as that is supported](crate::read_mjcf); a relative path as for a
    /// [URDF](Self::urdf).
    #[cfg(feature = "mjcf")]
    #[must_use]
    pub fn mjcf(mut self, path: impl Into<PathBuf>) -> Self {
        (self.source, self.format) = (Source::File(path.into()), Some(Format::Mjcf));
        self
    }

    /// Sets the text of a `MuJoCo` model, and the file name for diagnostics.
    #[cfg(feature = "mjcf")]
    #[must_use]
    pub fn mjcf_text(mut self, text: impl Into<String>, file: impl Into<String>) -> Self {
        self = self.urdf_text(text, file);
        self.format = Some(Format::Mjcf);
        self
    }

    /// Sets a model as the robot. It is checked as a description is, and keeps its own gravity unless
    /// [`gravity`](Self::gravity) is called.
    #[must_use]
    pub fn model(mut self, model: Model) -> Self {
        self.source = Source::Model(Box::new(model));
        self
    }

    /// Sets the errors of a description that could not be read; `generate` returns them with the errors of the options.
    #[doc(hidden)]
    #[must_use]
    pub fn failed_to_read(mut self, why: Diagnostics) -> Self {
        self.source = Source::Unread(why);
        self
    }

    /// Sets the option `option` to `value`, with the syntax of the macro and the command line.
    ///
    /// # Errors
    ///
    /// If there is no such option, or the value has another form.
    pub fn set(mut self, option: &str, value: &Value) -> Result<Self, Fault> {
        self.options.set(option, value)?;
        Ok(self)
    }

    /// The options about reading, for [`read`](crate::read()) alone.
    #[must_use]
    pub fn read_options(&self) -> &ReadOptions {
        &self.options.read
    }

    /// Returns the generated text, without writing a file.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn generate(&self) -> Result<Generated, Diagnostics> {
        let (model, modules, options) = self.compiled()?;
        let Emitted { text, c_header, type_name, operations, static_operations, partition } =
            emit(&model, &modules, &options);
        let (partition, partition_costs) = partition;
        let warnings = options.warnings;
        Ok(Generated {
            text,
            c_header,
            type_name,
            model,
            warnings,
            operations,
            static_operations,
            partition,
            partition_costs,
        })
    }

    /// Returns the generated C99 text, a header and a source file that need `<math.h>` only, and the warnings. Writes no
    /// file.
    ///
    /// Names start with the type's name in snake case. Options of Rust (visibility, crate,
    /// [`c_functions`](Self::c_functions)) have no effect.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn generate_c(&self) -> Result<(CSource, Vec<Diagnostic>), Diagnostics> {
        self.c_source(None)
    }

    /// Returns the programs of the robot's functions with its model and the warnings, for back ends that print no text.
    /// Functions of many states have no programs of their own: [`Kernels`](crate::plan::Kernels) of one state can be
    /// run on vectors with a state in each lane. Options about text have no effect.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn plan(&self) -> Result<Planning, Diagnostics> {
        let (model, modules, mut options) = self.compiled()?;
        for function in &mut options.functions {
            *function = function.batched().unwrap_or(*function);
        }
        for bundle in &mut options.bundles {
            bundle.batch = false;
        }
        (options.share, options.self_contained) = (false, false);
        let plan = options.plan(&model, &modules);
        Ok(Planning { plan, model, warnings: options.warnings })
    }

    /// Returns kernels for graphics processors, without writing anything, and the warnings. The text is CUDA C++ or WGSL,
    /// with a kernel for each function, which computes it for many states with a thread for each state.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options; WGSL has single precision alone.
    pub fn generate_gpu(
        &self,
        language: GpuLanguage,
    ) -> Result<(GpuSource, Vec<Diagnostic>), Diagnostics> {
        let builder = match language {
            GpuLanguage::Wgsl => self.clone().scalar(FloatType::F32),
            GpuLanguage::Cuda => self.clone(),
        };
        let (model, modules, options) = builder.compiled()?;
        Ok((emit_gpu(&model, &modules, &options, language), options.warnings))
    }

    /// Returns the C source whose header file has this name, and the warnings.
    fn c_source(&self, header: Option<&str>) -> Result<(CSource, Vec<Diagnostic>), Diagnostics> {
        let (model, modules, options) = self.compiled()?;
        Ok((emit_c(&model, &modules, &options, header), options.warnings))
    }

    /// Returns the inputs of the back ends: the model, its modules, and the options.
    fn compiled(&self) -> Result<(Model, ModuleTree, EmitOptions), Diagnostics> {
        let mut errors = self.option_errors();
        let reading = self.read().map_err(|found| errors.extend(found)).ok();
        let modules = reading.as_ref().and_then(|reading| {
            self.module_tree(&reading.model).map_err(|found| errors.extend(found)).ok()
        });
        if let (Some(Reading { model, .. }), Some(modules)) = (&reading, &modules) {
            let functions = self.options.code.functions.as_deref().unwrap_or(Function::DEFAULT);
            // Functions of one link in a bundle are short.
            let bundled = self.options.code.bundles.iter().flat_map(Bundle::functions);
            let functions: Vec<Function> = functions.iter().copied().chain(bundled).collect();
            errors.extend(too_large(model, modules, &functions));
        }
        let bundles = reading.as_ref().map(|reading| {
            let of = |bundle: &Bundle| {
                bundle.of(&reading.model).map_err(|found| errors.extend(found)).ok()
            };
            self.options.code.bundles.iter().filter_map(of).collect()
        });
        let inertias = [
            ("runtime_inertia", Code::RuntimeInertia, &self.options.code.runtime_inertia),
            ("payload", Code::Payload, &self.options.code.payload),
        ];
        let [runtime_inertia, payload] = inertias.map(|(option, code, names)| {
            reading.as_ref().and_then(|reading| {
                let frames = moving_frames(&reading.model, option, code, names);
                frames.map_err(|found| errors.extend(found)).ok()
            })
        });
        let (Some(Reading { model, mut warnings }), Some(modules), true) =
            (reading, modules, errors.is_empty())
        else {
            return Err(Diagnostics::new(errors));
        };
        warnings.extend(self.name_conflict(&model, &warnings));
        if self.options.code.scalar == FloatType::F32 {
            warnings.extend(conditioning_warning(&model));
        }
        let defaults = EmitOptions::default();
        let options = EmitOptions {
            type_name: self.options.code.type_name.clone(),
            visibility: self.options.code.visibility.clone().unwrap_or(defaults.visibility),
            crate_path: self.options.code.crate_path.clone().unwrap_or(defaults.crate_path),
            scalar: self.options.code.scalar,
            share: self.options.code.share,
            self_contained: self.options.code.self_contained,
            c_prefix: self.options.code.c_functions.clone(),
            functions: self.options.code.functions.clone().unwrap_or(defaults.functions),
            bundles: bundles.unwrap_or_default(),
            runtime_gravity: self.options.code.runtime_gravity,
            runtime_inertia: runtime_inertia.unwrap_or_default(),
            payload: payload.unwrap_or_default(),
            warnings,
        };
        Ok((model, modules, options))
    }

    /// Compiles to `OUT_DIR` from a build script, for `modyn::include_model!`. Cargo runs the script again when the
    /// description changes, and shows the warnings.
    ///
    /// The name for `include_model!` is derived from the type, if a name was [given](Self::type_name) (`LeftArm` is
    /// `include_model!(left_arm)`), else from the description's file (`my-robot.urdf` is `include_model!(my_robot)`).
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, or that a file cannot be written.
    pub fn compile(&self) -> Result<Generated, Diagnostics> {
        if let Source::File(path) = &self.source {
            // Also for a missing file: Cargo then checks again.
            println!("cargo::rerun-if-changed={}", resolve_path(path).display());
        }
        let generated = self.generate()?;
        let error = |message: String, help: &str| {
            Diagnostics::from(Diagnostic::error(Code::Output, message).with_help(help))
        };
        let folder = std::env::var_os("OUT_DIR").ok_or_else(|| {
            error("OUT_DIR is not set: `compile` is for build scripts".into(), "call `generate`")
        })?;
        let stem = match (&self.options.code.type_name, &self.source) {
            (None, Source::File(path)) => path.file_stem().map(|stem| stem.to_string_lossy()),
            _ => None,
        };
        let name = names::snake(stem.as_deref().unwrap_or(&generated.type_name));
        let file = Path::new(&folder).join(format!("{name}.rs"));
        // The files that this process, a build script, has written: a robot must not overwrite another.
        static WRITTEN: Mutex<BTreeMap<PathBuf, String>> = Mutex::new(BTreeMap::new());
        let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        let text = written.entry(file.clone()).or_insert_with(|| generated.text.clone());
        if *text != generated.text {
            let message = format!("two robots would be `include_model!({name})`");
            return Err(error(message, "give one of them a `type_name`"));
        }
        std::fs::write(&file, &generated.text).map_err(|reason| {
            let message = format!("`{}` cannot be written: {reason}", file.display());
            error(message, "OUT_DIR must be a writable folder")
        })?;
        let warnings = generated.warnings.iter().take(Diagnostics::SHOWN);
        let more = Diagnostics::count_hidden(generated.warnings.len());
        for warning in warnings.map(ToString::to_string).chain(more) {
            println!("cargo::warning={}", warning.replace(char::is_control, " "));
        }
        Ok(generated)
    }

    fn read(&self) -> Result<Reading, Diagnostics> {
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
                let (_, text) = read_first(path.display(), &[resolve_path(path)])?;
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
                let warnings = check_model(&model, options.unphysical_inertia)?;
                Ok(Reading { model, warnings })
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

    /// Returns a warning for a type `Robot`, which would collide with the trait that users import.
    fn name_conflict(&self, model: &Model, warnings: &[Diagnostic]) -> Option<Diagnostic> {
        let name = names::type_name(model.name());
        // A robot without a name already has a warning.
        let said = warnings.iter().any(|w| w.code == Code::MissingAttribute && w.subject.is_none());
        (self.options.code.type_name.is_none() && name == "Robot" && !said).then(|| {
            let message = "the type `Robot` will collide with `use modyn::Robot`";
            let help = "name it: `modyn!(pub MyArm = \"...\")`, or `Builder::type_name`";
            let subject = Subject::Robot(model.name().into());
            let warning = Diagnostic::new(Severity::Warning, Code::TypeName, message);
            warning.with_subject(subject).with_help(help)
        })
    }

    fn module_tree(&self, model: &Model) -> Result<ModuleTree, Diagnostics> {
        match &self.options.code.modules {
            ModuleChoice::Chains => Ok(ModuleTree::chains(model)),
            ModuleChoice::Links => Ok(ModuleTree::links(model)),
            ModuleChoice::List(list) => ModuleTree::from_names(model, list).map_err(|errors| {
                let names = || model.links().iter().map(|link| link.name.as_str());
                let diagnostic = |error: &ModuleError| {
                    let diagnostic = Diagnostic::error(Code::Modules, error.to_string());
                    let meant = match error {
                        ModuleError::UnknownLink { name, .. } => suggest(name, names()),
                        _ => None,
                    };
                    match meant {
                        Some(meant) => diagnostic.with_help(format!("did you mean `{meant}`?")),
                        None => diagnostic,
                    }
                };
                Diagnostics::new(errors.iter().map(diagnostic).collect())
            }),
        }
    }

    /// Returns the errors of options that are copied into the text.
    fn option_errors(&self) -> Vec<Diagnostic> {
        let mut errors = Vec::new();
        let mut error = |code, message: String, help: String| {
            errors.push(Diagnostic::error(code, message).with_help(help));
        };
        if let Some(name) =
            self.options.code.type_name.as_ref().filter(|&name| names::type_name(name) != *name)
        {
            error(
                Code::TypeName,
                format!("{name:?} is not a type name in upper camel case"),
                format!("`{}` is one", names::type_name(name)),
            );
        }
        if let Some(visibility) =
            self.options.code.visibility.as_ref().filter(|text| !is_visibility(text))
        {
            error(
                Code::Option,
                format!("{visibility:?} is not a visibility"),
                "`pub`, `pub(crate)`, `pub(super)`, `pub(in path)`, or nothing for private".into(),
            );
        }
        if let Some(path) = self.options.code.crate_path.as_ref().filter(|text| !is_path(text)) {
            error(
                Code::Option,
                format!("{path:?} is not the path of a crate or module"),
                "give the path of `modyn`, such as `::modyn` or `crate::robots::modyn`".into(),
            );
        }
        if let Some(prefix) =
            self.options.code.c_functions.as_ref().filter(|name| !is_c_prefix(name))
        {
            error(
                Code::Option,
                format!("{prefix:?} is not a prefix of C functions"),
                "use a letter, then letters, digits and underscores".into(),
            );
        }
        if self.options.code.self_contained && self.options.code.crate_path.is_some() {
            error(
                Code::Option,
                "a self-contained file does not use the crate `modyn`, so `crate` has no effect"
                    .into(),
                "remove `crate` or `self_contained`".into(),
            );
        }
        if matches!(self.source, Source::Model(_)) && !self.options.read.loops.is_empty() {
            error(
                Code::Option,
                "a `Model` has its own loop constraints".into(),
                "set them with `Model::with_loop_constraints`".into(),
            );
        }
        if matches!(self.source, Source::Model(_)) && !self.options.read.contacts.is_empty() {
            error(
                Code::Option,
                "a model that is given as one has its own contacts".into(),
                "set them with `Model::with_contacts`".into(),
            );
        }
        let read = &self.options.read;
        let of_reading = [
            ("base", read.base != Base::default()),
            ("mimic", read.mimic != Mimic::default()),
            ("rotors", !read.rotors.is_empty()),
            ("friction", read.friction.is_some()),
        ];
        let given = of_reading.iter().filter(|(_, given)| *given);
        for (option, _) in given.filter(|_| matches!(self.source, Source::Model(_))) {
            error(
                Code::Option,
                format!("`{option}` is an option for descriptions, but the robot is a `Model`"),
                "set it in the model: joints have their type and rotor, `Model::with_friction` sets the friction"
                    .into(),
            );
        }
        errors.extend(read.gravity.and_then(gravity_error));
        errors.extend(Bundle::errors(&self.options.code.bundles));
        errors
    }
}

fn is_c_prefix(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Returns the links of this `option`, as indices into the model's frames.
fn moving_frames(
    model: &Model,
    option: &str,
    code: Code,
    links: &[String],
) -> Result<Vec<usize>, Diagnostics> {
    let mut errors = Vec::new();
    let mut frames = Vec::new();
    let names = || model.frames().iter().map(|frame| frame.name.as_str());
    for name in links {
        let mut error = |message: String, help: String| {
            errors.push(Diagnostic::error(code, message).with_help(help));
        };
        match names().position(|other| other == name) {
            None => {
                let help = match suggest(name, names()) {
                    Some(meant) => format!("did you mean `{meant}`?"),
                    None => "name a link of the description".into(),
                };
                error(format!("`{name}` in `{option}` is not a link"), help);
            }
            Some(frame) if model.frames()[frame].link.is_none() => error(
                format!("link `{name}` in `{option}` does not move"),
                "remove it: a link that is fixed to the world has no effect on the dynamics".into(),
            ),
            Some(frame) if frames.contains(&frame) => {
                error(
                    format!("link `{name}` is listed in `{option}` twice"),
                    "name it once".into(),
                );
            }
            Some(frame) => frames.push(frame),
        }
    }
    if errors.is_empty() { Ok(frames) } else { Err(Diagnostics::new(errors)) }
}

/// Returns the path of a file: as given, or from the folder of the crate's `Cargo.toml`.
fn resolve_path(path: &Path) -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| path.into(), |root| Path::new(&root).join(path))
}

fn is_visibility(text: &str) -> bool {
    let text = text.trim();
    let Some(rest) = text.strip_prefix("pub").map(str::trim) else { return text.is_empty() };
    let inside = rest.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).map(str::trim);
    match inside {
        None => rest.is_empty(),
        Some("crate" | "super" | "self") => true,
        // The path of a visibility must be an enclosing module.
        Some(inside) => inside.strip_prefix("in ").is_some_and(|path| {
            let first = path.trim().split("::").next().unwrap_or_default();
            is_path_keyword(first.trim()) && is_path(&format!("{path}::name"))
        }),
    }
}

/// Returns whether a text is the path of a module that `use .. as` accepts.
fn is_path(text: &str) -> bool {
    let text = text.trim();
    let (global, path) = text.strip_prefix("::").map_or((false, text), |path| (true, path));
    let parts: Vec<&str> = path.split("::").map(str::trim).collect();
    // `self` and `super` alone cannot be imported.
    let Some((last, before)) = parts.split_last() else { return false };
    let mut ways = before.iter().take_while(|part| is_path_keyword(part)).count();
    if *last == "crate" && before.is_empty() {
        ways = 1;
    }
    let (ways, names) = parts.split_at(ways);
    let ways = ways.iter().enumerate().all(|(i, way)| *way == "super" || i == 0);
    ways && (!global || !is_path_keyword(parts[0])) && names.iter().all(|name| is_identifier(name))
}

/// Returns whether part of a path is a keyword that leads to a module.
fn is_path_keyword(part: &str) -> bool {
    matches!(part, "crate" | "self" | "super")
}

/// Returns whether a text is an identifier in every edition, possibly a raw one.
fn is_identifier(text: &str) -> bool {
    let name = text.strip_prefix("r#").unwrap_or(text);
    let mut letters = name.chars();
    let first = letters.next().is_some_and(|c| c == '_' || unicode_ident::is_xid_start(c));
    let keyword = match text.strip_prefix("r#") {
        Some(raw) => matches!(raw, "crate" | "self" | "super" | "Self"),
        None => names::KEYWORDS.contains(&name),
    };
    first && letters.all(unicode_ident::is_xid_continue) && name != "_" && !keyword
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visibilities_and_paths_are_checked() {
        for good in ["", " ", "pub", "pub(crate)", "pub ( in crate :: robots )", "pub(super)"] {
            assert!(is_visibility(good), "{good}");
        }
        for bad in ["public", "pub struct X; pub", "crate", "pub()", "pub(in)", "pub(in 1)", "pub("]
        {
            assert!(!is_visibility(bad), "{bad}");
        }
        for good in ["pub(in self)", "pub(in super::super)", "pub(in crate)", "pub(in super::a)"] {
            assert!(is_visibility(good), "{good}");
        }
        for bad in ["pub(in a)", "pub(in ::a)", "pub(in crate::fn)", "pub(in Self)"] {
            assert!(!is_visibility(bad), "{bad}");
        }
    }

    /// Accepted paths compile as imports, and paths that do not compile are rejected.
    #[test]
    fn paths_are_those_that_can_be_imported() {
        let good = [
            "::modyn",
            "modyn",
            "crate::a::b",
            ":: a :: r#b",
            "self::a",
            "super::super::a",
            "crate",
            "self::super::a",
            "r#fn::a",
            "union::auto",
            "\u{e9}t\u{e9}",
            "a::_b",
            "::r#gen",
        ];
        for path in good {
            assert!(is_path(path), "{path}");
            syn::parse_str::<syn::ItemUse>(&format!("use {path} as __modyn;")).expect(path);
        }
        let bad = [
            "",
            "::",
            "a::",
            "a b",
            "a; b",
            "a-b",
            "1a",
            "a::crate",
            "_",
            "a::<b>",
            "$crate",
            "fn",
            "a::fn",
            "::fn::a",
            "self",
            "super",
            "a::self",
            "a::super::b",
            "::crate",
            "::self::a",
            "::super",
            "Self",
            "Self::a",
            "crate::self::a",
            "r#crate",
            "r#self::a",
            "r#_",
            "gen",
            "a::dyn::b",
            "\u{24b6}",
            "a\u{b2}",
            "a::::b",
            "super::crate",
            "r#",
            "r# a",
            "a as b",
        ];
        for path in bad {
            assert!(!is_path(path), "{path}");
        }
        let keywords = names::KEYWORDS.iter().filter(|&&word| word != "crate");
        for word in keywords {
            assert!(!is_path(word) && !is_path(&format!("a::{word}")), "{word}");
        }
    }

    #[test]
    fn too_large_code_is_refused_at_once() {
        let refused = |model: Model, modules| {
            let errors = Builder::new().model(model).modules(modules).generate();
            errors.expect_err("too large").to_string()
        };
        let errors = refused(comb(1, 1000), ModuleChoice::Chains);
        assert!(errors.starts_with("error[too-large]: code for 1000 moving joints"), "{errors}");
        assert!(errors.contains("1000 links, from `1` to `1000`"), "{errors}");
        // Modules of one link would not help here.
        assert!(!errors.contains("modules = links"), "{errors}");
        let errors = refused(comb(1, 66), ModuleChoice::Chains);
        assert!(errors.contains("`brge` 2") && errors.contains("modules = links"), "{errors}");
        // The most expensive function is named, and a set of functions without it.
        let errors = refused(comb(600, 1), ModuleChoice::Links);
        assert!(errors.contains("`jacobian` 5"), "{errors}");
        assert!(errors.contains("leave `jacobian` out of the option `functions`"), "{errors}");
    }

    #[test]
    fn the_limit_is_about_cost_not_joints() {
        let refused = |model: &Model, modules: &ModuleTree, functions: &[Function]| {
            too_large(model, modules, functions).is_some()
        };
        for (model, chains, links) in [
            (comb(1, 60), false, false),
            (comb(1, 66), true, false),
            (comb(1, 150), true, true),
            (comb(40, 5), false, false),
            (comb(25, 8), false, false),
            (comb(300, 1), false, false),
        ] {
            let (by_chains, by_links) = (ModuleTree::chains(&model), ModuleTree::links(&model));
            let default = Function::DEFAULT;
            assert_eq!(refused(&model, &by_chains, default), chains, "{}", model.nv());
            assert_eq!(refused(&model, &by_links, default), links, "{}", model.nv());
            // A single function with linear code size is small.
            let one = [Function::ForwardDynamics];
            assert!(!refused(&model, &by_links, &one), "{}", model.nv());
        }
        // Derivatives of a chain grow with the cube of its length, and twice as fast with batches.
        let model = comb(1, 45);
        let links = ModuleTree::links(&model);
        let mut functions = vec![Function::ForwardDynamicsDerivatives];
        assert!(!refused(&model, &links, &functions));
        functions.push(Function::ForwardDynamicsDerivativesBatch);
        assert!(refused(&model, &links, &functions));
    }

    /// Returns a model of this number of chains with this number of links.
    fn comb(chains: usize, length: usize) -> Model {
        let mut urdf = String::from("<robot name='comb'><link name='0'/>");
        for i in 1..=chains * length {
            let parent = if i % length == 1 % length { 0 } else { i - 1 };
            urdf += &format!(
                "<joint name='{i}' type='continuous'><parent link='{parent}'/><child link='{i}'/></joint>\
                 <link name='{i}'><inertial><mass value='1'/>\
                 <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>",
            );
        }
        let read = crate::read_urdf(&(urdf + "</robot>"), "comb.urdf", &ReadOptions::default());
        read.expect("a good robot").model
    }

    /// Returns the model with its last link changed.
    fn changed(model: &Model, change: impl Fn(&mut modyn_runtime::model::Link)) -> Model {
        let mut links = model.links().to_vec();
        links.iter_mut().next_back().into_iter().for_each(change);
        Model::new(model.name(), model.gravity(), links, model.frames().to_vec()).expect("valid")
    }

    #[test]
    fn a_model_is_checked_as_a_description_is() {
        let good = comb(1, 2);
        let codes = |model, severity| -> Vec<Code> {
            let result = Builder::new().model(model).unphysical_inertia(severity).generate();
            match result {
                Ok(generated) => generated.warnings.iter().map(|found| found.code).collect(),
                Err(errors) => {
                    assert!(errors.has_errors());
                    assert!(errors.iter().all(|e| e.subject.is_some() && e.help.is_some()));
                    errors.iter().map(|found| found.code).collect()
                }
            }
        };
        let massless = changed(&good, |link| link.inertial = Default::default());
        let negative = changed(&good, |link| link.inertial.mass = -1.0);
        let unphysical = changed(&good, |link| link.inertial.inertia[0] = 3.0);
        let large = changed(&good, |link| link.inertial.center_of_mass[0] = 1e100);
        for severity in [Severity::Error, Severity::Warning] {
            assert_eq!(codes(good.clone(), severity), []);
            assert_eq!(codes(massless.clone(), severity), [Code::SingularJoint]);
            assert_eq!(codes(negative.clone(), severity), [Code::NegativeMass]);
            assert_eq!(codes(unphysical.clone(), severity), [Code::TriangleInequality]);
            assert_eq!(codes(large.clone(), severity), [Code::NotFinite]);
        }
        let builder = Builder::new().model(unphysical);
        assert!(builder.clone().generate().is_err());
        assert!(builder.unphysical_inertia(Severity::Warning).generate().is_ok());
    }

    #[test]
    fn gravity_is_a_models_own_unless_it_is_given() {
        let model = comb(1, 1);
        let moon = [0.0, 0.0, -1.62];
        let (links, frames) = (model.links().to_vec(), model.frames().to_vec());
        let on_moon = Model::new("m", moon, links, frames).expect("valid");
        let builder = Builder::new().model(on_moon);
        assert_eq!(builder.clone().generate().expect("good").model.gravity(), moon);
        let other = builder.clone().gravity([1.0, 0.0, 0.0]).generate().expect("good");
        assert_eq!(other.model.gravity(), [1.0, 0.0, 0.0]);
        let errors = builder.gravity([1e70, 0.0, 0.0]).generate().expect_err("too large");
        assert_eq!(errors.iter().map(|error| error.code).collect::<Vec<_>>(), [Code::Gravity]);
    }

    #[test]
    fn a_misspelt_link_of_a_module_is_suggested() {
        let model = || changed(&comb(1, 2), |link| link.name = "forearm".into());
        let list = |name: &str| ModuleChoice::List(vec![vec!["1".into(), name.into()]]);
        let refused = |name| {
            let builder = Builder::new().model(model()).modules(list(name));
            builder.generate().expect_err("no such link").to_string()
        };
        assert!(refused("fourarm").contains("help: did you mean `forearm`?"));
        assert!(!refused("hand").contains("did you mean"));
    }

    #[test]
    fn a_robot_called_robot_is_warned_of() {
        let text = |name: &str| {
            format!(
                "<robot{name}><link name='a'/><joint name='j' type='continuous'><parent link='a'/>\
                 <child link='b'/></joint><link name='b'><inertial><mass value='1'/>\
                 <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>"
            )
        };
        let warnings = |name: &str, builder: Builder| {
            let found = builder.urdf_text(text(name), "a.urdf").generate().expect("good");
            found.warnings.iter().map(|warning| warning.code).collect::<Vec<_>>()
        };
        let called = " name='robot'";
        assert_eq!(warnings(called, Builder::new()), [Code::TypeName]);
        assert_eq!(warnings("", Builder::new()), [Code::MissingAttribute]);
        assert_eq!(warnings(called, Builder::new().type_name("Arm")), []);
    }

    #[test]
    fn all_that_is_wrong_is_said_at_once() {
        let builder = Builder::new().urdf("no such.urdf").type_name("my arm");
        let errors = builder.crate_("a b").visibility("x").gravity([f64::NAN; 3]).generate();
        let errors = errors.expect_err("all wrong");
        let codes: Vec<Code> = errors.iter().map(|error| error.code).collect();
        let options = [Code::TypeName, Code::Option, Code::Option, Code::Gravity];
        assert_eq!(codes, [&options[..], &[Code::MissingFile]].concat());
        assert!(errors.iter().all(|error| error.help.is_some()));
    }
}
