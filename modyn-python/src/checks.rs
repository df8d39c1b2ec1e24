//! The ranges of arguments that a call checks: settings of constraints, time steps on the ground,
//! and parts of ranges.

use modyn_codegen::Function;
use modyn_codegen::plan::{Argument, ArgumentKind};
use modyn_runtime::{SettingPlace, SettingRange, check_settings, check_step_settings};

use crate::number::Number;

/// The ranges of the numbers of an argument.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Check {
    /// The settings of constraints.
    Settings,
    /// The settings of steps.
    StepSettings,
    /// A time step on the ground, s: above zero.
    TimeStep,
    /// Parts of ranges: from zero to one. NaN gives NaN.
    Parts,
}

impl Check {
    /// Returns the check of an argument of a function; `None` if any number is allowed.
    pub fn of(function: Option<Function>, argument: &Argument) -> Option<Self> {
        match argument.kind {
            ArgumentKind::Settings => Some(Self::Settings),
            ArgumentKind::StepSettings => Some(Self::StepSettings),
            ArgumentKind::RandomNumbers => Some(Self::Parts),
            ArgumentKind::Time if function.is_some_and(|one| one.row().has_solver) => {
                Some(Self::TimeStep)
            }
            _ => None,
        }
    }

    /// Checks the numbers of the argument `name` in all states, of which each has `length` numbers.
    ///
    /// # Errors
    ///
    /// If a number is not finite or outside of its range. The message names the number, its value,
    /// its range and its state.
    pub fn run<S: Number>(
        self,
        name: &'static str,
        numbers: &[S],
        length: usize,
    ) -> Result<(), String> {
        let in_state = |numbers: &[S]| match self {
            Self::Settings => check_settings(numbers),
            Self::StepSettings => check_step_settings(numbers),
            Self::TimeStep => numbers.iter().try_for_each(|&number| {
                SettingRange::Positive.check(name, SettingPlace::Argument, number.into())
            }),
            Self::Parts => numbers.iter().map(|&number| number.into()).try_for_each(|part: f64| {
                let part = if part.is_nan() { 0.0 } else { part };
                SettingRange::UpToOne.check(name, SettingPlace::Argument, part)
            }),
        };
        let states = numbers.chunks_exact(length.max(1));
        let several = states.len() > 1;
        for (state, numbers) in states.enumerate() {
            in_state(numbers).map_err(|error| match several {
                true => format!("{error} (in state {state})"),
                false => error.to_string(),
            })?;
        }
        Ok(())
    }
}
