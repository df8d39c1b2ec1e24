//! The builder: from a description and options to text. The macro, build scripts and the command
//! line use it.

mod build_script;
pub(crate) mod checks;
mod file;
mod object;
mod source;
pub(crate) mod syntax;

use std::path::PathBuf;

use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics, Severity};
use modyn_read::{
    Armature, Base, Contact, FileStore, Format, Ground, JointActuator, Loop, Mimic, Package,
    ReadOptions, Reading, Rotor, XacroArg, conditioning_warning, joints_without_inertia,
};
use modyn_runtime::model::{JointFriction, Model, ModuleTree};
use modyn_runtime::{OperationCount, UserFunction};

use crate::emit::{
    EmitOptions, File, FloatType, GpuKernel, GpuLanguage, PlannedRobot, Refused, RolloutOptions,
    RolloutSource, Target, emit_rollouts, emit_rows,
};
use crate::options::{
    FusedFunction, ModuleChoice, OptionError, Options, Value, option_table, user,
};
use crate::plan::{
    Choices, CodeForm, EntryFunction, EntrySource, Function, NamedFunction, Plan, TooLong,
    TracedFunction,
};
use crate::program::Execution;
use checks::{
    invalid_programs, left_out, links_that_move, needs_inertia, no_fused_function, too_long,
    too_long_entries, without_hessian, without_inertia,
};
pub use object::ObjectPlanning;
use source::Source;

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

/// The generated text of a robot in a language.
#[non_exhaustive]
pub struct Emitted {
    /// The language.
    pub target: Target,
    /// The files, the main one first.
    pub files: Vec<File>,
    /// The kernels, in the order of the text, if the language is one of graphics processors.
    pub kernels: Vec<GpuKernel>,
    /// The name of the type in Rust.
    pub type_name: String,
    /// The prefix of names outside of Rust.
    pub prefix: String,
    /// The programs.
    pub plan: Plan,
    /// The robot.
    pub model: Model,
    /// The warnings about the description.
    pub warnings: Vec<Diagnostic>,
    /// The files that were read.
    pub read: Vec<PathBuf>,
}

impl Emitted {
    /// Returns the text of the main file.
    #[must_use]
    pub fn text(&self) -> &str {
        self.files.first().map_or("", |file| &file.text)
    }

    /// Returns the name by which [`Builder::write_as`] writes the files: the name of the main file,
    /// or of the folder of all files.
    #[must_use]
    pub fn output(&self) -> &str {
        let name = self.files.first().map_or("", |file| &file.name);
        name.split_once('/').map_or(name, |(folder, _)| folder)
    }
}

/// The generated Rust of a robot.
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
    /// The other files that were read, which the description names: the text changes with them.
    pub files: Vec<PathBuf>,
    /// The operations of one call of each function.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// The operations of one call of each function that has a program on vectors, on vectors.
    pub operations_in_lanes: Vec<(&'static str, OperationCount)>,
    /// The operations in the text of each function of one state; [`operations`](Self::operations)
    /// has the operations of one call.
    ///
    /// For a function of one link they include all links. Equal limbs count once if they share
    /// their code. If they are packed into vectors, the packed code and the scalar code count,
    /// both.
    pub static_operations: Vec<(&'static str, OperationCount)>,
    /// The functions that have loops in place of straight-line code: which loops, and why.
    pub loops: Vec<(&'static str, String)>,
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
    /// The other files that were read, which the description names.
    pub files: Vec<PathBuf>,
}

/// The inputs of the plan and of the back ends.
struct Inputs {
    model: Model,
    modules: ModuleTree,
    choices: Choices,
    options: EmitOptions,
    files: Vec<PathBuf>,
}

impl Inputs {
    /// Returns the error that the functions take too many operations.
    fn too_long(&self, reason: &TooLong) -> Diagnostics {
        Diagnostics::new(vec![too_long(&self.model, &self.modules, reason)])
    }

    /// Returns the plan for machine code, after adding its warnings to the description's warnings.
    fn machine_code(&mut self) -> Result<Plan, Diagnostics> {
        self.choices = std::mem::take(&mut self.choices).of_machine_code();
        let planned = Plan::new(&self.model, &self.modules, &self.choices, Execution::Simd);
        let plan = planned.map_err(|reason| self.too_long(&reason))?;
        self.options.warnings.extend(invalid_programs(&plan));
        Ok(plan)
    }
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

    /// Sets the option `option` to `value`, with the syntax of the macro and the command line.
    ///
    /// # Errors
    ///
    /// If there is no such option, or the value has another form.
    pub fn set(mut self, option: &str, value: &Value) -> Result<Self, OptionError> {
        self.options.set(option, value)?;
        Ok(self)
    }

    /// Adds a function of the user's own, such as a cost: it is compiled with its derivatives. It
    /// is a function `name` of the generated type, over the function's arguments. Its derivatives
    /// are functions whose names begin with `name`:
    ///
    /// - `.._jvp`: the value, and its tangent along the tangents `tangent_q`, ... of the variables
    /// - `.._gradient`: the value, and the gradient with respect to each variable, of a function of
    ///   one result
    /// - `.._vjp`: the value, and the gradients of `cotangent`^T value, of a function of several
    ///   results
    /// - `.._jacobian`: the value, and its derivatives with respect to each variable by columns, of
    ///   a function of several results
    /// - `.._hessian`: the value, and the gradients and the Hessian of `cotangent`^T value (of the
    ///   value, if that is one number): a block `hess_q_qd` has a row for each entry of the
    ///   variable `q` and a column for each entry of `qd`
    ///
    /// Derivatives with respect to coordinates are in tangent space. A result is a type of the
    /// robot's own.
    ///
    /// ```no_run
    /// use modyn_codegen::{Builder, Scalar, UserArgument, UserError, UserFunction};
    /// use modyn_codegen::Interpreter;
    ///
    /// /// The squared distance from a link to a target.
    /// struct Reach;
    ///
    /// impl UserFunction<2> for Reach {
    ///     fn docs(&self) -> String {
    ///         "Returns the squared distance (m^2) from the hand to `target` (m, world axes).".into()
    ///     }
    ///
    ///     fn arguments(&self) -> [UserArgument; 2] {
    ///         [UserArgument::Q, UserArgument::numbers("target", 3)]
    ///     }
    ///
    ///     fn evaluate<S: Scalar>(
    ///         &self,
    ///         robot: &mut Interpreter<S>,
    ///         [q, target]: [&[S]; 2],
    ///     ) -> Result<Vec<S>, UserError> {
    ///         let hand = robot.model().link_index("hand").ok_or("there is no link `hand`")?;
    ///         let pose = robot.link_pose(q, hand)?;
    ///         let squares = pose.translation.iter().zip(target).map(|(&x, &t)| (x - t) * (x - t));
    ///         Ok(vec![squares.fold(S::zero(), |sum, square| sum + square)])
    ///     }
    /// }
    ///
    /// fn main() -> Result<(), modyn_codegen::diagnostics::Diagnostics> {
    ///     Builder::new().urdf("robots/arm.urdf").function("reach_cost", Reach).compile()?;
    ///     Ok(())
    /// }
    /// ```
    #[must_use]
    pub fn function<const N: usize>(
        mut self,
        name: impl Into<String>,
        function: impl UserFunction<N> + Send + Sync + 'static,
    ) -> Self {
        self.options.user_functions.push(NamedFunction::new(name.into(), function, false));
        self
    }

    /// Adds a function of the user's own, as [`function`](Self::function), with forms for many
    /// states of its value and its derivatives.
    #[must_use]
    pub fn function_batch<const N: usize>(
        mut self,
        name: impl Into<String>,
        function: impl UserFunction<N> + Send + Sync + 'static,
    ) -> Self {
        self.options.user_functions.push(NamedFunction::new(name.into(), function, true));
        self
    }

    /// Sets the folder of a description that is given as [text](Self::text), in which files that it
    /// names are looked for. The folder of a [file](Self::file) is known; without a folder, no
    /// other file is read.
    #[must_use]
    pub fn folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.options.read.folder = Some(folder.into());
        self
    }

    /// Sets the place from which the files that a [text](Self::text) names are read.
    #[must_use]
    pub fn files(mut self, files: FileStore) -> Self {
        self.options.read.files = files;
        self
    }

    /// The options about reading, for [`read`](crate::read()) alone.
    #[must_use]
    pub fn read_options(&self) -> &ReadOptions {
        &self.options.read
    }

    /// Returns the generated text in a language, without writing a file.
    ///
    /// Names outside of Rust begin with the type's name in snake case. Options of other languages
    /// have no effect.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), modyn_codegen::diagnostics::Diagnostics> {
    /// use modyn_codegen::{Builder, Target};
    ///
    /// let emitted = Builder::new().urdf("robots/arm.urdf").emit(Target::C)?;
    /// let [source, header] = &*emitted.files else { panic!("two files") };
    /// assert_eq!((&*source.name, &*header.name), ("arm.c", "arm.h"));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, and an error for each option that the
    /// language refuses.
    pub fn emit(&self, target: Target) -> Result<Emitted, Diagnostics> {
        self.emit_as(target, None)
    }

    /// Returns the generated text in files with this name, without an ending; `None` takes the
    /// prefix of names.
    fn emit_as(&self, target: Target, stem: Option<&str>) -> Result<Emitted, Diagnostics> {
        let backend = target.backend();
        let (plan, inputs) = self.planned(target)?;
        let Inputs { model, modules, options, files: read, .. } = inputs;
        let prefix = options.prefix(&model);
        let stem = stem.unwrap_or(&prefix);
        let robot =
            PlannedRobot { model: &model, modules: &modules, plan: &plan, options: &options, stem };
        let files = backend.print(&robot);
        let kernels = backend.kernels(&robot);
        let type_name = options.type_name(&model);
        let warnings = options.warnings;
        Ok(Emitted { target, files, kernels, type_name, prefix, plan, model, warnings, read })
    }

    /// Returns the plan for a language, and its inputs.
    fn planned(&self, target: Target) -> Result<(Plan, Inputs), Diagnostics> {
        let backend = target.backend();
        let builder = self.clone().scalar(backend.scalar(self.options.code.scalar));
        let mut inputs = builder.inputs_without(backend.refused())?;
        inputs.choices.functions.retain(|function| backend.lacks(*function).is_none());
        let Inputs { model, modules, choices, options, .. } = &inputs;
        let planned = backend.plan(model, modules, choices, options);
        let plan = planned.map_err(|reason| inputs.too_long(&reason))?;
        let lacking = left_out(target, self.selected());
        let casadi = without_hessian(&plan.casadi.without_hessian, &options.prefix(model));
        inputs.options.warnings.extend(lacking.into_iter().chain(casadi));
        inputs.options.warnings.extend(invalid_programs(&plan));
        Ok((plan, inputs))
    }

    /// Returns the generated Rust, without writing a file: [`emit`](Self::emit) for
    /// [`Target::Rust`].
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn generate(&self) -> Result<Generated, Diagnostics> {
        let Emitted { files, type_name, model, plan, warnings, read, .. } =
            self.emit(Target::Rust)?;
        let mut texts = files.into_iter().map(|file| file.text);
        Ok(Generated {
            text: texts.next().unwrap_or_default(),
            c_header: texts.next(),
            type_name,
            model,
            warnings,
            files: read,
            operations: plan.operations_per_call(),
            operations_in_lanes: plan.operations_in_lanes(),
            static_operations: plan.static_operations(),
            loops: plan.loops(),
            partition: plan.elimination_modules,
            partition_costs: plan.candidates,
        })
    }

    /// Returns the programs of the robot's functions with its model and the warnings, for back ends
    /// that print no text. Functions of many states have no programs of their own:
    /// [`Kernels`](crate::plan::Kernels) of one state can be run on vectors with a state in each
    /// lane. Options about text have no effect. Programs of contacts and closed loops may have
    /// [equations of dependent rows](crate::program::RowEquations), and the program of `step` has
    /// [loops](crate::program::Loops), which
    /// [`around_loops`](crate::program::Program::around_loops) sets apart.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options.
    pub fn plan(&self) -> Result<Planning, Diagnostics> {
        let mut inputs = self.inputs()?;
        let plan = inputs.machine_code()?;
        let Inputs { model, files, options, .. } = inputs;
        Ok(Planning { plan, model, warnings: options.warnings, files })
    }

    /// Returns the program of one function of arrays of plain numbers, or of a derivative of one,
    /// for back ends that print no text: for libraries that differentiate by every entry of their
    /// arrays. The program has one argument and one result, in which the arrays follow one another.
    /// The option `functions` has no effect; `fused` has the fused functions that `function` can
    /// name.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, and an error if the function has too
    /// many operations, or is a fused function that there is not.
    pub fn plan_entries(&self, function: &EntryFunction) -> Result<Planning, Diagnostics> {
        self.planned_entries(function, Execution::Simd)
    }

    /// Returns CUDA text for one function of arrays of plain numbers, or for a derivative of one:
    /// the kernel `modyn_rows`, whose arrays have a row of numbers for each state. Its parameters are
    /// the arrays of arguments, the arrays of results, the numbers `every`, `rows` and `stride` of
    /// each argument (`unsigned int`), and the number of states. The argument of state `i` is row
    /// `i / every % rows` of its array, whose rows are `stride` numbers apart. `lengths` are the
    /// numbers of a row of each argument and of each result. A block has at most 128 threads. The
    /// option `functions` has no effect; `fused` has the fused functions that `function` can name.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, and an error if the function has too
    /// many operations, or is a fused function that there is not.
    pub fn emit_rows(
        &self,
        function: &EntryFunction,
        lengths: [&[usize]; 2],
    ) -> Result<String, Diagnostics> {
        let Planning { plan, .. } = self.planned_entries(function, Execution::Threads)?;
        let text = |planned| emit_rows(planned, lengths, self.options.code.scalar);
        Ok(plan.functions.first().map(text).unwrap_or_default())
    }

    /// Returns the program of one function of arrays, for programs that run in this way.
    fn planned_entries(
        &self,
        function: &EntryFunction,
        execution: Execution,
    ) -> Result<Planning, Diagnostics> {
        let Inputs { model, modules, choices, options, files } =
            self.clone().functions([]).inputs()?;
        let choices = match execution {
            Execution::Threads => choices,
            _ => choices.of_machine_code(),
        };
        let planned = Plan::for_entries(&model, &modules, &choices, execution, function);
        let plan = planned.map_err(|reason| {
            let derivatives = function.derivatives.len();
            Diagnostics::new(vec![too_long_entries(&model, &modules, &reason, derivatives)])
        })?;
        if let (EntrySource::Fused(name), []) = (&function.source, &*plan.functions) {
            let names = choices.fused.iter().map(|fused| fused.name);
            return Err(Diagnostics::new(vec![no_fused_function(name, names)]));
        }
        let warnings = options.warnings.into_iter().chain(invalid_programs(&plan)).collect();
        Ok(Planning { plan, model, warnings, files })
    }

    /// Returns kernels for graphics processors that integrate motions over many time steps, without
    /// writing anything, and the warnings. Each function of a time step among the robot's functions
    /// (such as `step_semi_implicit`) becomes a kernel. The other functions become device
    /// functions, which the functions of `rollouts` may call.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options, also if there is no function of a
    /// time step or no control.
    pub fn emit_rollouts(
        &self,
        language: GpuLanguage,
        rollouts: &RolloutOptions,
    ) -> Result<(RolloutSource, Vec<Diagnostic>), Diagnostics> {
        let error = |message: &str, help: &str| {
            Diagnostics::new(vec![Diagnostic::error(Code::Option, message).with_help(help)])
        };
        if rollouts.forces.as_ref().is_some_and(|forces| forces.controls == 0) {
            let message = "a rollout whose forces are a function of controls has no control";
            return Err(error(message, "give the number of controls of a step, at least 1"));
        }
        let (plan, Inputs { model, modules, options, .. }) = self.planned(language.into())?;
        let model = &model;
        let stem = "";
        let robot = PlannedRobot { model, modules: &modules, plan: &plan, options: &options, stem };
        let source = emit_rollouts(&robot, language, rollouts);
        let holds = Function::ConstrainedForwardDynamics.name();
        if rollouts.active_contacts.is_some()
            && !source.rollouts.iter().any(|one| one.step == holds)
        {
            let message =
                "a rollout holds contacts by constrained forward dynamics, and there is none";
            let help = "give the robot contacts by the option `contacts`, and add `constrained_forward_dynamics` and \
                        `integrate` to the option `functions`";
            return Err(error(message, help));
        }
        if source.rollouts.is_empty() {
            let (message, help) = match rollouts.forces {
                None => (
                    "a rollout needs a function of a time step, and there is none",
                    "add `step_semi_implicit` (or `step`, for steps on the ground) to the option `functions`",
                ),
                Some(_) => (
                    "a rollout with `forces` needs a function of a time step under joint forces, and there is none",
                    "add `step_semi_implicit` or `step` to the option `functions`; or leave `forces` out for \
                     `step_actuated`, which has the controls of the actuators",
                ),
            };
            return Err(error(message, help));
        }
        Ok((source, options.warnings))
    }

    /// Returns the inputs of the plan and of the back ends, for a back end that refuses these
    /// options.
    fn inputs_without(&self, refused: &[Refused]) -> Result<Inputs, Diagnostics> {
        let refused = refused.iter().filter(|refused| self.options.has(refused.option));
        let error =
            |one: &Refused| Diagnostic::error(Code::Option, one.message).with_help(one.help);
        let mut errors: Vec<Diagnostic> = refused.map(error).collect();
        match self.inputs() {
            Ok(inputs) if errors.is_empty() => return Ok(inputs),
            Ok(_) => {}
            Err(diagnostics) => errors.extend(diagnostics),
        }
        Err(Diagnostics::new(errors))
    }

    /// Returns the functions that the options select.
    fn selected(&self) -> &[Function] {
        self.options.code.functions.as_deref().unwrap_or(Function::DEFAULT)
    }

    /// Returns the inputs of the plan and of the back ends.
    fn inputs(&self) -> Result<Inputs, Diagnostics> {
        let code = &self.options.code;
        let mut errors = self.option_errors();
        let reading = self.read().map_err(|diagnostics| errors.extend(diagnostics)).ok();
        let modules = reading.as_ref().and_then(|reading| {
            self.module_tree(&reading.model).map_err(|diagnostics| errors.extend(diagnostics)).ok()
        });
        let mut functions = self.selected().to_vec();
        let fused: Vec<Function> = code.fused.iter().flat_map(FusedFunction::functions).collect();
        let mut singular = Vec::new();
        if let Some(Reading { model, .. }) = &reading {
            singular = joints_without_inertia(model);
            if !singular.is_empty() {
                let error;
                (functions, error) = without_inertia(model, &singular, &functions, &fused);
                errors.extend(error);
            }
        }
        let inertias = [
            ("runtime_inertia", Code::RuntimeInertia, &code.runtime_inertia),
            ("payload", Code::Payload, &code.payload),
        ];
        let [runtime_inertia, payload] = inertias.map(|(option, code, names)| {
            reading.as_ref().and_then(|reading| {
                let links = links_that_move(&reading.model, option, code, names);
                links.map_err(|diagnostics| errors.extend(diagnostics)).ok()
            })
        });
        let mut choices = Choices {
            functions,
            fused: Vec::new(),
            user_functions: Vec::new(),
            share_limbs: code.share_limbs,
            code: code.code,
            machine_code: false,
            runtime_gravity: code.runtime_gravity,
            runtime_inertia: runtime_inertia.unwrap_or_default(),
            payload: payload.unwrap_or_default(),
        };
        if let Some(Reading { model, .. }) = &reading {
            // The options with errors may select the functions.
            let functions =
                errors.is_empty().then(|| self.traced_functions(model, &singular, &choices));
            let traced = functions
                .and_then(|traced| traced.map_err(|diagnostics| errors.extend(diagnostics)).ok());
            let planned = |fused: &FusedFunction| {
                fused
                    .of(model, traced.as_deref())
                    .map_err(|diagnostics| errors.extend(diagnostics))
                    .ok()
            };
            choices.fused = code.fused.iter().filter_map(planned).collect();
            choices.user_functions = traced.unwrap_or_default();
        }
        let without_errors = reading.zip(modules).filter(|_| errors.is_empty());
        let Some((Reading { model, mut warnings, files, .. }, modules)) = without_errors else {
            return Err(Diagnostics::new(errors));
        };
        warnings.extend(self.name_conflict(&model, &warnings));
        if code.scalar == FloatType::F32 {
            warnings.extend(conditioning_warning(&model));
        }
        let defaults = EmitOptions::default();
        let options = EmitOptions {
            type_name: code.type_name.clone(),
            visibility: code.visibility.clone().unwrap_or(defaults.visibility),
            crate_path: code.crate_path.clone().unwrap_or(defaults.crate_path),
            scalar: code.scalar,
            self_contained: code.self_contained,
            embed_model: code.embed_model,
            c_prefix: code.c_functions.clone(),
            warnings,
        };
        Ok(Inputs { model, modules, choices, options, files })
    }

    /// Returns the user's functions of a robot whose joints `singular` move no inertia.
    fn traced_functions(
        &self,
        model: &Model,
        singular: &[usize],
        choices: &Choices,
    ) -> Result<Vec<TracedFunction>, Diagnostics> {
        let mut traced = Vec::new();
        let mut errors = Vec::new();
        for function in &self.options.user_functions {
            if !singular.is_empty() && function.depends_on_inertia(model) {
                let names = format!("function `{}`", function.name);
                errors.push(needs_inertia(model, singular, &names, "needs"));
                continue;
            }
            match function.of(model, choices.parameters(model)) {
                Ok(one) => traced.push(one),
                Err(reason) => errors.push(user::plan_error(function, &reason)),
            }
        }
        if errors.is_empty() { Ok(traced) } else { Err(Diagnostics::new(errors)) }
    }
}
