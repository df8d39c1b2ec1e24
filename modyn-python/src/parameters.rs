//! The run-time parameters of programs, as numbers after their arguments.

use modyn_codegen::plan::Plan;
use modyn_codegen::trace::Parameters;
use modyn_runtime::Inertial;
use modyn_runtime::model::Model;

use crate::change::Change;
use crate::number::Number;

/// The numbers of a robot's run-time parameters.
#[derive(Clone)]
pub struct ParameterNumbers<S> {
    parameters: Parameters,
    numbers: Vec<S>,
}

impl<S: Number> ParameterNumbers<S> {
    /// Returns the numbers of the description; `is_used` says whether there are programs that
    /// depend on them.
    pub fn new(plan: &Plan, gravity: [f64; 3], is_used: bool) -> Self {
        let all = Self::of(&plan.parameters, gravity);
        if is_used { all } else { Self { numbers: Vec::new(), ..all } }
    }

    /// Returns the numbers of the description.
    pub fn of(parameters: &Parameters, gravity: [f64; 3]) -> Self {
        let numbers = parameters.described(gravity).into_iter().map(S::from_f64).collect();
        Self { parameters: parameters.clone(), numbers }
    }

    /// Returns the numbers; none if no program depends on them.
    pub fn as_slice(&self) -> &[S] {
        &self.numbers
    }

    /// Applies a change of the robot's run-time parameters, a valid one.
    ///
    /// # Errors
    ///
    /// If the robot does not have the parameter.
    pub fn apply(&mut self, change: &Change, model: &Model) -> Result<(), String> {
        let index = |link: &str| model.link_index(link).unwrap_or(usize::MAX);
        let (place, new) = match change {
            Change::Gravity(gravity) => (self.parameters.gravity.then_some(0), gravity.to_vec()),
            Change::Inertia(link, inertial) => {
                let mut inertias = self.parameters.inertias.iter();
                let place = inertias.position(|(other, _)| *other == index(link));
                (place.map(|k| self.parameters.inertial(k)), numbers(inertial))
            }
            Change::Payload(link, inertial) => {
                let mut payloads = self.parameters.payloads.iter();
                let place = payloads.position(|other| *other == index(link));
                let first = self.parameters.inertias.len();
                (place.map(|k| self.parameters.inertial(first + k)), numbers(inertial))
            }
        };
        let place = place.ok_or_else(|| change.missing())?;
        if let Some(numbers) = self.numbers.get_mut(place..place + new.len()) {
            for (number, new) in numbers.iter_mut().zip(new) {
                *number = S::from_f64(new);
            }
        }
        Ok(())
    }
}

fn numbers(Inertial { mass, center_of_mass, inertia }: &Inertial) -> Vec<f64> {
    [*mass].into_iter().chain(*center_of_mass).chain(*inertia).collect()
}
