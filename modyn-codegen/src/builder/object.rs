//! The inputs of object files: the programs, and the texts beside the machine code.

use modyn_runtime::model::ModuleTree;

use super::{Builder, Inputs, Planning};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Severity};
use crate::emit::{EmitOptions, FloatType, MachineCode, emit_object_header, emit_wrapper};
use crate::plan::{Constants, Execution, Function};

/// The programs of a robot whose machine code goes to an object file, and the texts beside it; see
/// [`Builder::plan_object`].
#[non_exhaustive]
pub struct ObjectPlanning {
    /// The programs, the model and the warnings.
    pub planning: Planning,
    modules: ModuleTree,
    constants: Constants,
    options: EmitOptions,
}

impl Builder {
    /// Returns the programs of the robot's functions of one state, for back ends that write object files. Functions of
    /// many states become functions of one state.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options. The options `self_contained`, `embed_model` and
    /// `c_functions` are refused: the Rust text needs the crate `modyn` and has functions alone, and the object's functions
    /// are C functions already.
    pub fn plan_object(&self) -> Result<ObjectPlanning, Diagnostics> {
        let code = &self.options.code;
        let refused = [
            (
                code.embed_model,
                "embed_model",
                "the Rust text beside an object file has no description",
            ),
            (
                code.self_contained,
                "self_contained",
                "the Rust text beside an object file needs the crate `modyn`",
            ),
            (
                code.c_functions.is_some(),
                "c_functions",
                "the functions of an object file are C functions already",
            ),
        ];
        let refused = refused.into_iter().filter(|(given, ..)| *given);
        let mut errors: Vec<Diagnostic> = refused
            .map(|(_, option, message)| {
                let help = format!("remove the option `{option}`");
                Diagnostic::error(Code::Option, message).with_help(help)
            })
            .collect();
        let mut inputs = match self.inputs() {
            Ok(inputs) if errors.is_empty() => inputs,
            Ok(_) => return Err(Diagnostics::new(errors)),
            Err(found) => {
                errors.extend(found);
                return Err(Diagnostics::new(errors));
            }
        };
        let constants = Constants::new(&inputs.model, &inputs.choices);
        inputs.choices = inputs.choices.of_one_state();
        let mut plan = inputs.plan(Execution::Vectors);
        let Inputs { model, files, modules, mut options, .. } = inputs;
        let functions = plan.functions.len();
        plan.functions.retain(|planned| planned.function != Some(Function::Brge));
        plan.factorization.clear();
        // `default` and `all` are requests for the functions that there are.
        let is_wanted = code.functions.as_ref().is_some_and(|selected| {
            Function::DEFAULT.iter().any(|function| !selected.contains(function))
        });
        if plan.functions.len() < functions && is_wanted {
            let message = "`brge` has no form in object files, and is left out";
            options.warnings.push(
                Diagnostic::new(Severity::Warning, Code::Option, message)
                    .with_help("use `mass_matrix` and `forward_dynamics`"),
            );
        }
        let warnings = options.warnings.clone();
        let planning = Planning { plan, model, warnings, files };
        Ok(ObjectPlanning { planning, modules, constants, options })
    }
}

impl ObjectPlanning {
    /// Returns the type of the numbers.
    #[must_use]
    pub fn scalar(&self) -> FloatType {
        self.options.scalar
    }

    /// Returns the name of the robot's type in Rust.
    #[must_use]
    pub fn type_name(&self) -> String {
        self.options.type_name(&self.planning.model)
    }

    /// Returns the default prefix of C functions: the type's name in snake case.
    #[must_use]
    pub fn prefix(&self) -> String {
        self.options.prefix(&self.planning.model)
    }

    /// Returns the C header of the machine code.
    #[must_use]
    pub fn header(&self, code: &MachineCode) -> String {
        let Planning { plan, model, .. } = &self.planning;
        emit_object_header(model, plan, &self.options, code)
    }

    /// Returns the Rust text that calls the machine code: the robot's type with its functions of one state in its own
    /// scalar, as in the text of [`Builder::generate`]. The text has unsafe code: these calls.
    #[must_use]
    pub fn wrapper(&self, code: &MachineCode) -> String {
        let Planning { plan, model, .. } = &self.planning;
        emit_wrapper((model, &self.modules), plan, &self.constants, &self.options, code)
    }
}
