//! Functions without machine code: their programs, evaluated operation by operation, or the
//! interpreter where a program is too long.

use std::sync::{Mutex, PoisonError};

use modyn_codegen::Function;
use modyn_codegen::plan::{Frames, Plan, Planned};
use modyn_runtime::Interpreter;
use modyn_runtime::model::Model;

use crate::change::Change;
use crate::number::Number;
use crate::parameters::ParameterNumbers;

/// A function that is evaluated.
pub enum Evaluated<S> {
    /// The programs of a planned function.
    Programs(Box<Programs<S>>),
    /// A function of the interpreter.
    Interpreted(Function, Box<Mutex<Interpreter<f64>>>),
}

/// The programs of a planned function.
pub struct Programs<S> {
    planned: Planned,
    frames: Frames,
    parameters: ParameterNumbers<S>,
}

impl<S: Number> Evaluated<S> {
    /// Returns the programs of a planned function.
    pub fn new(planned: Planned, plan: Plan, gravity: [f64; 3]) -> Self {
        let parameters = ParameterNumbers::new(&plan, gravity, planned.parameters > 0);
        Self::Programs(Box::new(Programs { planned, frames: plan.frames, parameters }))
    }

    /// Applies a change of the robot's run-time parameters, a valid one.
    ///
    /// # Errors
    ///
    /// If the robot does not have the parameter.
    pub fn apply(&mut self, change: &Change, model: &Model) -> Result<(), String> {
        match self {
            Self::Programs(programs) => programs.parameters.apply(change, model),
            Self::Interpreted(_, robot) => {
                change.set(robot.get_mut().unwrap_or_else(PoisonError::into_inner))
            }
        }
    }

    /// Computes the result of one state; `link` is the link of a function of one link.
    ///
    /// # Errors
    ///
    /// If the interpreter refuses the function.
    pub fn one(&self, link: usize, arguments: &[&[S]], result: &mut [S]) -> Result<(), String> {
        match self {
            Self::Programs(programs) => {
                let Programs { planned, frames, parameters } = &**programs;
                let mut numbers = arguments.concat();
                numbers.extend_from_slice(parameters.as_slice());
                result.copy_from_slice(&planned.evaluate(frames, link, &numbers));
            }
            Self::Interpreted(function, robot) => {
                let wide = |numbers: &&[S]| numbers.iter().map(|&x| x.into()).collect();
                let wide_arguments: Vec<Vec<f64>> = arguments.iter().map(wide).collect();
                let arguments: Vec<&[f64]> = wide_arguments.iter().map(Vec::as_slice).collect();
                let mut numbers = vec![0.0; result.len()];
                let mut robot = robot.lock().unwrap_or_else(PoisonError::into_inner);
                let done = robot.evaluate(*function, &arguments, link, &mut numbers);
                done.map_err(|error| error.to_string())?;
                result.iter_mut().zip(numbers).for_each(|(place, x)| *place = S::from_f64(x));
            }
        }
        Ok(())
    }
}
