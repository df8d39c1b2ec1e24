//! The one door behind the three: from a description and options to text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use modyn_runtime::OperationCount;
use modyn_runtime::model::{DEFAULT_GRAVITY, Model, ModuleTree};

use crate::emit::{EmitOptions, Emitted, FloatType, emit};
use crate::error::{Code, Diagnostic, Diagnostics, Severity};
use crate::names;
use crate::source::read_first;
use crate::urdf::{self, Mimic, ReadOptions, Reading};

/// Most operations that a robot's functions may come to, by [`estimate`]; as many again would be
/// some 20 MB of text.
const MOST_OPERATIONS: usize = 500_000;

/// Roughly how many operations will be written out: elements of the mass matrix and rows of U grow
/// with each link's depth, a module's block and its inverse with the cube of its length.
fn estimate(model: &Model, modules: &ModuleTree) -> usize {
    let mut depths: Vec<usize> = Vec::with_capacity(model.links().len());
    for link in model.links() {
        depths.push(link.parent.map_or(0, |parent| depths[parent] + 1));
    }
    let rows: usize = depths.iter().map(|depth| 40 * (depth + 8)).sum();
    let cube = |length: usize| length.saturating_pow(3);
    let blocks: usize = modules.modules().iter().map(|module| cube(module.links.len())).sum();
    rows.saturating_add(blocks)
}

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
/// and in the crate `modyn::include_model!(gripper);`. To have the text itself:
///
/// ```
/// # fn main() -> Result<(), modyn_codegen::error::Diagnostics> {
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
    read: ReadOptions,
    gravity: Option<[f64; 3]>,
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

    /// The name of the generated type, in upper camel case; by default made from the robot's name.
    #[must_use]
    pub fn type_name(mut self, name: impl Into<String>) -> Self {
        self.type_name = Some(name.into());
        self
    }

    /// The visibility of the generated types, as Rust has it (`pub(crate)`; nothing for private);
    /// `pub` by default.
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
        self.gravity = Some(gravity);
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
        let mut errors = self.option_errors();
        let reading = self.read().map_err(|found| errors.extend(found)).ok();
        let modules = reading.as_ref().and_then(|reading| {
            self.module_tree(&reading.model).map_err(|found| errors.extend(found)).ok()
        });
        if let (Some(Reading { model, .. }), Some(modules)) = (&reading, &modules) {
            errors.extend(too_large(model, modules));
        }
        let (Some(Reading { model, warnings }), Some(modules), true) =
            (reading, modules, errors.is_empty())
        else {
            return Err(Diagnostics::new(errors));
        };
        let options = EmitOptions {
            type_name: self.type_name.clone(),
            visibility: self.visibility.clone().unwrap_or_else(|| "pub".into()),
            krate: self.krate.clone().unwrap_or_else(|| "::modyn".into()),
            float: self.float,
            warnings,
        };
        let Emitted { text, type_name, operations, partition: (partition, partition_costs) } =
            emit(&model, &modules, &options);
        let warnings = options.warnings;
        Ok(Generated { text, type_name, model, warnings, operations, partition, partition_costs })
    }

    /// From a build script: compiles to `OUT_DIR`, for `modyn::include_model!`, and has Cargo run
    /// the script again when the description changes. Warnings become Cargo's warnings.
    ///
    /// What to include is named after the type, if a name was [given](Self::type_name) (`LeftArm`
    /// is `include_model!(left_arm)`), else after the description's file (`my-robot.urdf` is
    /// `include_model!(my_robot)`).
    ///
    /// # Errors
    ///
    /// All that is wrong with the description and the options, or a file that cannot be written.
    pub fn compile(&self) -> Result<Generated, Diagnostics> {
        if let Source::File(path) = &self.source {
            // Also when it does not exist: Cargo then looks again.
            println!("cargo::rerun-if-changed={}", place(path).display());
        }
        let generated = self.generate()?;
        let error = |message: String, help: &str| {
            Diagnostics::from(Diagnostic::error(Code::Output, message).with_help(help))
        };
        let folder = std::env::var_os("OUT_DIR").ok_or_else(|| {
            error("OUT_DIR is not set: `compile` is for build scripts".into(), "call `generate`")
        })?;
        let stem = match (&self.type_name, &self.source) {
            (None, Source::File(path)) => path.file_stem().map(|stem| stem.to_string_lossy()),
            _ => None,
        };
        let name = names::snake(stem.as_deref().unwrap_or(&generated.type_name));
        let file = Path::new(&folder).join(format!("{name}.rs"));
        // What this process, a build script, has written: one robot must not replace another.
        static WRITTEN: Mutex<BTreeMap<PathBuf, String>> = Mutex::new(BTreeMap::new());
        let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        let text = written.entry(file.clone()).or_insert_with(|| generated.text.clone());
        if *text != generated.text {
            let message = format!("two robots would be `include_model!({name})`");
            return Err(error(message, "give one of them a `type_name`"));
        }
        std::fs::write(&file, &generated.text).map_err(|reason| {
            let message = format!("`{}` cannot be written: {reason}", file.display());
            error(message, "OUT_DIR must be a folder that can be written to")
        })?;
        for warning in &generated.warnings {
            println!("cargo::warning={}", warning.to_string().replace('\n', " "));
        }
        Ok(generated)
    }

    fn read(&self) -> Result<Reading, Diagnostics> {
        // A gravity that is none is reported with the options.
        let gravity = self.gravity.filter(|gravity| gravity.iter().all(|x| x.is_finite()));
        let options =
            ReadOptions { gravity: gravity.unwrap_or(DEFAULT_GRAVITY), ..self.read.clone() };
        match &self.source {
            Source::None => {
                let missing =
                    Diagnostic::error(Code::MissingFile, "no robot description was given");
                Err(missing.with_help("call `Builder::urdf` with the path of one").into())
            }
            Source::File(path) => {
                let (_, text) = read_first(path.display(), &[place(path)])?;
                urdf::read(&text, &path.display().to_string(), &options)
            }
            Source::Text { text, file } => urdf::read(text, file, &options),
            Source::Model(model) => {
                let model = match self.gravity {
                    None => model.as_ref().clone(),
                    Some(_) => model.with_gravity(options.gravity),
                };
                urdf::check(&model, self.read.unphysical_inertia)
                    .map(|warnings| Reading { model, warnings })
            }
        }
    }

    fn module_tree(&self, model: &Model) -> Result<ModuleTree, Diagnostics> {
        match &self.modules {
            ModuleChoice::Chains => Ok(ModuleTree::chains(model)),
            ModuleChoice::Links => Ok(ModuleTree::links(model)),
            ModuleChoice::List(list) => ModuleTree::from_names(model, list).map_err(|errors| {
                let diagnostics =
                    errors.iter().map(|error| Diagnostic::error(Code::Modules, error.to_string()));
                Diagnostics::new(diagnostics.collect())
            }),
        }
    }

    /// What is wrong with the options that become part of the text as they are.
    fn option_errors(&self) -> Vec<Diagnostic> {
        let mut errors = Vec::new();
        let mut error = |code, message: String, help: String| {
            errors.push(Diagnostic::error(code, message).with_help(help));
        };

        if let Some(name) = self.type_name.as_ref().filter(|&name| names::type_name(name) != *name)
        {
            error(
                Code::TypeName,
                format!("{name:?} is no type's name in upper camel case"),
                format!("`{}` is one", names::type_name(name)),
            );
        }
        if let Some(visibility) = self.visibility.as_ref().filter(|text| !is_visibility(text)) {
            error(
                Code::Option,
                format!("{visibility:?} is no visibility"),
                "`pub`, `pub(crate)`, `pub(super)`, `pub(in path)`, or nothing for private".into(),
            );
        }
        if let Some(krate) = self.krate.as_ref().filter(|text| !is_path(text)) {
            error(
                Code::Option,
                format!("{krate:?} is no path of a crate or module"),
                "give the path of `modyn`, such as `::modyn` or `crate::robots::modyn`".into(),
            );
        }
        errors.extend(self.gravity.and_then(urdf::gravity_error));
        errors
    }
}

fn too_large(model: &Model, modules: &ModuleTree) -> Option<Diagnostic> {
    let operations = estimate(model, modules);
    let longest = modules.modules().iter().map(|module| module.links.len()).max().unwrap_or(0);
    let message = format!(
        "the functions of {} moving joints, up to {longest} of them in one module, come to some \
         {operations} operations, which is too much code",
        model.nv()
    );
    let help = format!(
        "make joints `fixed`, choose shorter modules (`modules = links` has the shortest), or use \
         `modyn::Interpreter`; up to {MOST_OPERATIONS} operations are written out"
    );
    (operations > MOST_OPERATIONS)
        .then(|| Diagnostic::error(Code::TooLarge, message).with_help(help))
}

/// Where a file is: as given, or from the folder of the crate's `Cargo.toml`.
fn place(path: &Path) -> PathBuf {
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
        Some(inside) => inside.strip_prefix("in ").is_some_and(is_path),
    }
}

fn is_path(text: &str) -> bool {
    let text = text.trim();
    text.strip_prefix("::").unwrap_or(text).split("::").map(str::trim).enumerate().all(
        |(i, part)| {
            let name = part.strip_prefix("r#").unwrap_or(part);
            let letters = name.chars().all(|c| c == '_' || c.is_alphanumeric());
            let digit = name.starts_with(|c: char| c.is_numeric());
            // Keywords that may stand in a path do so at its start.
            let place = i == 0 || part == "super" || !matches!(part, "crate" | "self" | "Self");
            letters && place && !digit && !name.is_empty() && name != "_"
        },
    )
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
        for good in ["::modyn", "modyn", "crate::a::b", ":: a :: r#b", "self::a", "super::super::a"]
        {
            assert!(is_path(good), "{good}");
        }
        for bad in
            ["", "::", "a::", "a b", "a; b", "a-b", "1a", "a::crate", "_", "a::<b>", "$crate"]
        {
            assert!(!is_path(bad), "{bad}");
        }
    }

    #[test]
    fn a_robot_that_is_too_large_is_refused_at_once() {
        let mut urdf = String::from("<robot name='snake'><link name='0'/>");
        for i in 1..=1000 {
            urdf += &format!(
                "<joint name='{i}' type='continuous'><parent link='{}'/><child link='{i}'/></joint>\
                 <link name='{i}'><inertial><mass value='1'/>\
                 <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>",
                i - 1
            );
        }
        let errors = Builder::new().urdf_text(urdf + "</robot>", "snake.urdf").generate();
        let errors = errors.expect_err("too large").to_string();
        assert!(
            errors.starts_with(
                "error[too-large]: the functions of 1000 moving joints, up to 1000 of them"
            ),
            "{errors}"
        );
    }

    /// Arms of two links, all on the world.
    fn bush(arms: usize) -> Model {
        let text = |i: usize, parent: &str| {
            format!(
                "<joint name='{i}' type='continuous'><parent link='{parent}'/><child link='{i}'/></joint>\
                 <link name='{i}'><inertial><mass value='1'/>\
                 <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
            )
        };
        let arm = |i: usize| text(2 * i, "world") + &text(2 * i + 1, &(2 * i).to_string());
        let arms: String = (0..arms).map(arm).collect();
        let urdf = format!("<robot name='bush'><link name='world'/>{arms}</robot>");
        urdf::read(&urdf, "bush.urdf", &ReadOptions::default()).expect("a bush").model
    }

    #[test]
    fn many_short_branches_are_not_too_large() {
        let bush = bush(100);
        assert_eq!(bush.nv(), 200);
        assert!(too_large(&bush, &ModuleTree::chains(&bush)).is_none());
    }

    #[test]
    fn a_model_is_checked_as_a_file_is() {
        let bush = bush(2);
        let mut links = bush.links().to_vec();
        links[1].inertial = Default::default();
        links[3].inertial.inertia = [1.0, 0.0, 0.0, 1.0, 0.0, 5.0];
        let broken = Model::new("bush", [0.0; 3], links, bush.frames().to_vec()).expect("a tree");
        let errors = Builder::new().model(broken.clone()).generate().expect_err("unphysical");
        let codes: Vec<Code> = errors.iter().map(|error| error.code).collect();
        assert_eq!(codes, [Code::TriangleInequality, Code::NoInertiaFelt]);
        let lenient = Builder::new().model(broken).unphysical_inertia(Severity::Warning).generate();
        assert_eq!(lenient.expect_err("still singular").as_slice().len(), 2);
        let moon = Builder::new().model(bush).gravity([0.0, 0.0, -1.62]).generate();
        assert_eq!(moon.expect("physical").model.gravity(), [0.0, 0.0, -1.62]);
    }

    #[test]
    fn all_that_is_wrong_is_said_at_once() {
        let builder = Builder::new().urdf("no such.urdf").type_name("my arm");
        let errors = builder.krate("a b").visibility("x").gravity([f64::NAN; 3]).generate();
        let errors = errors.expect_err("all wrong");
        let codes: Vec<Code> = errors.iter().map(|error| error.code).collect();
        let expected =
            [Code::TypeName, Code::Option, Code::Option, Code::Gravity, Code::MissingFile];
        assert_eq!(codes, expected);
        assert!(errors.iter().all(|error| error.help.is_some()));
    }
}
