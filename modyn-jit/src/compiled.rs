//! The robot as machine code.

use std::fmt;

use modyn_codegen::diagnostics::Diagnostic;
use modyn_codegen::{Builder, Function, Planning};
use modyn_runtime::model::{Inertial, Model};

use crate::assembly::Assembly;
use crate::call::Call;
use crate::error::{CallError, CompileError};
use crate::function::CompiledFunction;
use crate::helper::{Helpers, Linkage};
use crate::instruction_set::InstructionSet;
use crate::machine::Pages;
use crate::parameters::{ParameterError, RunTimeParameters};
use crate::real::Real;

/// The options of machine code; the options of the robot belong to a [`Builder`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// The vector instructions; `None` for the best instruction set of the processor.
    pub instruction_set: Option<InstructionSet>,
    /// Whether functions can be called for many states at a time; false by default.
    pub batches: bool,
}

/// The functions of a robot as machine code of this processor, for numbers of type `S`.
///
/// Arguments and results are slices; those with a structure (wrenches, poses, twists) are their
/// numbers in a row, as [`Call::arguments`] and [`Call::result`] describe them. Matrices are by
/// columns. All of modyn's conventions hold.
pub struct Compiled<S> {
    model: Model,
    warnings: Vec<Diagnostic>,
    instruction_set: InstructionSet,
    pages: Pages,
    functions: Vec<CompiledFunction>,
    parameters: RunTimeParameters<S>,
    /// The placements of links that share code, one row for each.
    placements: Vec<Vec<S>>,
}

impl<S: Real> Compiled<S> {
    /// Compiles these functions of a robot for this processor.
    ///
    /// # Errors
    ///
    /// If the model is invalid, machine code is not made for this processor, a function has too
    /// many arguments, or the system gives no executable memory.
    pub fn new(
        model: &Model,
        functions: impl IntoIterator<Item = Function>,
    ) -> Result<Self, CompileError> {
        Self::build(&Builder::new().model(model.clone()).functions(functions), Options::default())
    }

    /// Compiles the robot of a [`Builder`] with all of its options, except those about text.
    ///
    /// # Errors
    ///
    /// If the description or an option is invalid, this processor lacks the instruction set, a
    /// function has too many arguments, or the system gives no executable memory.
    pub fn build(builder: &Builder, options: Options) -> Result<Self, CompileError> {
        Self::from_plan(&builder.plan()?, options)
    }

    /// Compiles programs that [`Builder::plan`] has made, so that several types of numbers and
    /// instruction sets can share them.
    ///
    /// # Errors
    ///
    /// If this processor lacks the instruction set, a function has too many arguments, or the
    /// system gives no executable memory.
    pub fn from_plan(planning: &Planning, options: Options) -> Result<Self, CompileError> {
        let available = InstructionSet::detect().ok_or(CompileError::Architecture)?;
        let instruction_set = options.instruction_set.unwrap_or(available);
        if !instruction_set.is_available() {
            return Err(CompileError::InstructionSet { wanted: instruction_set, available });
        }
        let Planning { plan, model, warnings, .. } = planning;
        let linkage = Linkage::Addresses(Helpers::new::<S>());
        let mut assembly = Assembly::<S>::new(instruction_set, options.batches, linkage);
        let functions = assembly.functions(plan)?;
        let pages = Pages::new(&assembly.code).map_err(CompileError::Memory)?;
        let number = |x: f64| S::from_f64(x);
        Ok(Self {
            instruction_set,
            pages,
            functions,
            parameters: RunTimeParameters::new(plan, model),
            placements: plan.frames.placements().map(|row| row.map(number).to_vec()).collect(),
            model: model.clone(),
            warnings: warnings.clone(),
        })
    }

    /// Returns the robot.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the warnings about the description.
    #[must_use]
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// Returns the vector instructions that the code uses.
    #[must_use]
    pub fn instruction_set(&self) -> InstructionSet {
        self.instruction_set
    }

    /// Returns the functions that can be called.
    pub fn functions(&self) -> impl Iterator<Item = Function> {
        self.functions.iter().filter_map(|compiled| compiled.function)
    }

    /// Returns the names of the fused functions that can be called.
    pub fn fused_names(&self) -> impl Iterator<Item = &'static str> {
        let fused = self.functions.iter().filter(|compiled| compiled.function.is_none());
        fused.map(|compiled| compiled.name)
    }

    /// Returns a function, to call it or to ask for its arguments and its size.
    ///
    /// # Errors
    ///
    /// If it was not compiled.
    pub fn function(&self, function: Function) -> Result<Call<'_, S>, CallError> {
        self.call(function.name(), |compiled| compiled.function == Some(function))
    }

    /// Returns the fused function of this name ([`Builder::fused`]), to call it or to ask for its
    /// arguments and its size. The results of its functions follow one another, as [`Call::result`]
    /// describes them.
    ///
    /// # Errors
    ///
    /// If there is no such fused function.
    pub fn fused(&self, name: &str) -> Result<Call<'_, S>, CallError> {
        self.call(name, |compiled| compiled.function.is_none() && compiled.name == name)
    }

    fn call(
        &self,
        name: &str,
        is_wanted: impl Fn(&CompiledFunction) -> bool,
    ) -> Result<Call<'_, S>, CallError> {
        match self.functions.iter().find(|compiled| is_wanted(compiled)) {
            Some(compiled) => Ok(Call {
                compiled,
                pages: &self.pages,
                parameters: &self.parameters.numbers,
                placements: &self.placements,
                lanes: self.instruction_set.vector(true) / size_of::<S>(),
            }),
            None => Err(CallError::NotCompiled {
                function: name.into(),
                compiled: self.functions.iter().map(|compiled| compiled.name).collect(),
            }),
        }
    }

    /// Sets the gravitational acceleration in world axes, m/s^2.
    ///
    /// # Errors
    ///
    /// If [`Builder::runtime_gravity`] was not called, or a component is not finite.
    pub fn set_gravity(&mut self, gravity: [S; 3]) -> Result<(), ParameterError<S>> {
        self.parameters.set_gravity(gravity)
    }

    /// Sets the inertia of a link, in its own frame, in place of the description's.
    ///
    /// # Errors
    ///
    /// If the link was not named in [`Builder::runtime_inertia`], no rigid body has this inertia,
    /// or a joint would have no inertia.
    pub fn set_inertia(
        &mut self,
        link: &str,
        inertial: &Inertial<S>,
    ) -> Result<(), ParameterError<S>> {
        self.parameters.set_inertial(&self.model, false, link, inertial)
    }

    /// Sets the payload of a link, in the link's frame: an inertia that is added to the link's. The
    /// default is zero.
    ///
    /// # Errors
    ///
    /// If the link was not named in [`Builder::payload`], no rigid body has this inertia, or a
    /// joint would have no inertia.
    pub fn set_payload(
        &mut self,
        link: &str,
        inertial: &Inertial<S>,
    ) -> Result<(), ParameterError<S>> {
        self.parameters.set_inertial(&self.model, true, link, inertial)
    }

    /// Computes the joint accelerations `qdd` at coordinates `q` and velocities `qd` under the
    /// joint torques or forces `tau`.
    ///
    /// # Errors
    ///
    /// If the function was not compiled, or a length is wrong.
    pub fn forward_dynamics(
        &self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        qdd: &mut [S],
    ) -> Result<(), CallError> {
        self.function(Function::ForwardDynamics)?.one(&[q, qd, tau], qdd)
    }

    /// Computes the joint torques or forces `tau` for the accelerations `qdd` at coordinates `q`
    /// and velocities `qd`.
    ///
    /// # Errors
    ///
    /// If the function was not compiled, or a length is wrong.
    pub fn inverse_dynamics(
        &self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        tau: &mut [S],
    ) -> Result<(), CallError> {
        self.function(Function::InverseDynamics)?.one(&[q, qd, qdd], tau)
    }

    /// Computes the mass matrix at coordinates `q`, by columns.
    ///
    /// # Errors
    ///
    /// If the function was not compiled, or a length is wrong.
    pub fn mass_matrix(&self, q: &[S], mass_matrix: &mut [S]) -> Result<(), CallError> {
        self.function(Function::MassMatrix)?.one(&[q], mass_matrix)
    }
}

impl<S: Real> fmt::Debug for Compiled<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let functions: Vec<&str> = self.functions.iter().map(|compiled| compiled.name).collect();
        f.debug_struct("Compiled")
            .field("robot", &self.model.name())
            .field("instruction_set", &self.instruction_set)
            .field("functions", &functions)
            .finish_non_exhaustive()
    }
}
