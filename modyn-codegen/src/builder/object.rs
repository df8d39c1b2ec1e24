//! The inputs of object files: the programs, and the texts beside the machine code.

use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics, Severity};
use modyn_runtime::model::ModuleTree;

use super::{Builder, Inputs, Planning};
use crate::emit::{
    EmitOptions, FloatType, MachineCode, PlannedRobot, Refused, emit_object_header, emit_wrapper,
};
use crate::plan::Function;

/// The options that the Rust text beside an object file does not have.
const REFUSED: [Refused; 3] = [
    Refused {
        option: "embed_model",
        message: "the Rust text beside an object file has no description",
        help: "remove the option `embed_model`",
    },
    Refused {
        option: "self_contained",
        message: "the Rust text beside an object file needs the crate `modyn`",
        help: "remove the option `self_contained`",
    },
    Refused {
        option: "c_functions",
        message: "the functions of an object file are C functions already",
        help: "remove the option `c_functions`",
    },
];

/// The programs of a robot whose machine code goes to an object file, and the texts beside it; see
/// [`Builder::plan_object`].
#[non_exhaustive]
pub struct ObjectPlanning {
    /// The programs, the model and the warnings.
    pub planning: Planning,
    modules: ModuleTree,
    options: EmitOptions,
}

impl Builder {
    /// Returns the programs of the robot's functions of one state, for back ends that write object
    /// files. Functions of many states become functions of one state.
    ///
    /// # Errors
    ///
    /// Returns all errors of the description and the options. The options `self_contained`,
    /// `embed_model` and `c_functions` are refused: the Rust text needs the crate `modyn` and has
    /// functions alone, and the object's functions are C functions already.
    pub fn plan_object(&self) -> Result<ObjectPlanning, Diagnostics> {
        let mut inputs = self.inputs_without(&REFUSED)?;
        let mut plan = inputs.machine_code()?;
        let Inputs { model, files, modules, mut options, .. } = inputs;
        let count = plan.functions.len();
        plan.functions.retain(|planned| planned.function != Some(Function::Brge));
        plan.factorization.clear();
        // `default` and `all` are requests for the functions that there are.
        let is_wanted = self.options.code.functions.as_ref().is_some_and(|selected| {
            Function::DEFAULT.iter().any(|function| !selected.contains(function))
        });
        if is_wanted && plan.functions.len() < count {
            let message = "`brge` has no form in object files, and is left out";
            let warning = Diagnostic::new(Severity::Warning, Code::Option, message);
            options.warnings.push(warning.with_help("use `mass_matrix` and `forward_dynamics`"));
        }
        let warnings = options.warnings.clone();
        let planning = Planning { plan, model, warnings, files };
        Ok(ObjectPlanning { planning, modules, options })
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
        emit_object_header(&self.robot(), code)
    }

    /// Returns the Rust text that calls the machine code: the robot's type with its functions of
    /// one state in its own scalar, as in the text of [`Builder::generate`]. The text has unsafe
    /// code: these calls.
    #[must_use]
    pub fn wrapper(&self, code: &MachineCode) -> String {
        emit_wrapper(&self.robot(), code)
    }

    fn robot(&self) -> PlannedRobot<'_> {
        let Planning { plan, model, .. } = &self.planning;
        let options = &self.options;
        PlannedRobot { model, modules: &self.modules, plan, options, stem: "" }
    }
}
