//! Functions without machine code: their programs, evaluated operation by operation.

use modyn_codegen::plan::{Frames, Plan, Planned};
use modyn_runtime::model::Model;

use crate::change::Change;
use crate::number::Number;
use crate::parameters::ParameterNumbers;

/// A function whose programs are evaluated.
pub struct Evaluated<S> {
    planned: Planned,
    frames: Frames,
    parameters: ParameterNumbers<S>,
}

impl<S: Number> Evaluated<S> {
    /// Returns the programs of a planned function.
    pub fn new(planned: Planned, plan: Plan, gravity: [f64; 3]) -> Self {
        let parameters = ParameterNumbers::new(&plan, gravity, planned.parameters > 0);
        Self { planned, frames: plan.frames, parameters }
    }

    /// Applies a change of the robot's run-time parameters, a valid one.
    ///
    /// # Errors
    ///
    /// If the robot does not have the parameter.
    pub fn apply(&mut self, change: &Change, model: &Model) -> Result<(), String> {
        self.parameters.apply(change, model)
    }

    /// Computes the result of one state; `link` is that of a function of one link.
    pub fn one(&self, link: usize, arguments: &[&[S]], result: &mut [S]) {
        let mut numbers = arguments.concat();
        numbers.extend_from_slice(self.parameters.as_slice());
        result.copy_from_slice(&self.planned.evaluate(&self.frames, link, &numbers));
    }
}
