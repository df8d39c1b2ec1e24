//! The choices of a user that a plan depends on.

use modyn_runtime::model::Model;

use super::Function;
use super::code_form::{CodeChoices, CodeForm};
use super::fused::FusedFunction;
use super::user::TracedFunction;
use crate::trace::Parameters;

/// The choices of a user that a plan depends on.
#[derive(Clone, Debug, Default)]
pub struct Choices {
    /// The selected functions.
    pub functions: Vec<Function>,
    /// The fused functions.
    pub fused: Vec<FusedFunction>,
    /// The user's functions.
    pub user_functions: Vec<TracedFunction>,
    /// Whether equal limbs share one routine.
    pub share_limbs: bool,
    /// The form of the code of recursions.
    pub code: CodeForm,
    /// Whether the programs are for machine code.
    pub machine_code: bool,
    /// Whether gravity is an argument.
    pub runtime_gravity: bool,
    /// The links whose own inertia is an argument, as indices into the model's links.
    pub runtime_inertia: Vec<usize>,
    /// The links with a payload that is an argument, as indices into the model's links.
    pub payload: Vec<usize>,
}

impl Choices {
    /// Returns the choices for machine code: functions of one state in place of functions of many,
    /// without shared routines and loops.
    #[must_use]
    pub fn of_machine_code(mut self) -> Self {
        for function in &mut self.functions {
            *function = function.batched().unwrap_or(*function);
        }
        for fused in &mut self.fused {
            fused.batch = false;
        }
        for function in &mut self.user_functions {
            function.batch = false;
        }
        self.share_limbs = false;
        self.code = CodeForm::Unrolled;
        self.machine_code = true;
        self
    }

    /// Returns the choices about the code of all functions.
    pub(super) fn code(&self) -> CodeChoices {
        CodeChoices {
            share_limbs: self.share_limbs,
            form: self.code,
            machine_code: self.machine_code,
        }
    }

    /// Returns the run-time parameters of a model.
    pub(crate) fn parameters(&self, model: &Model) -> Parameters {
        Parameters::new(model, self.runtime_gravity, &self.runtime_inertia, &self.payload)
    }
}
