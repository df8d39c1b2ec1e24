//! A call of a function: its arguments by name, and the parts of its result.

use alloc::vec::Vec;
use core::ops::Index;

use super::super::arguments::{
    ACT, APPLIED, Argument, CTRL, DT, FORCES, Q, QD, QDD, SETTINGS, STEP_SETTINGS, TAU, WARM_START,
};
use super::super::shape::{Record, Shape};
use super::components::{Components, read, write};
use crate::equations::actuation::ActuatorInput;
use crate::equations::soft_constraints::{ActuatedInput, StepInput};
use crate::equations::{ForwardInput, Motion, State, TimeStepInput};
use crate::interpreter::Interpreter;
use crate::spatial::Wrench;
use crate::{ConstraintSettings, ContactSurface, ContactTarget, Scalar, StepSettings};

/// The arguments of a call.
#[derive(Clone, Copy)]
pub(super) struct Given<'a, S> {
    /// The arguments of the row.
    pub arguments: &'static [Argument],
    /// The numbers of each argument.
    pub numbers: &'a [&'a [S]],
    /// The link of a function of one link.
    pub link: usize,
}

impl<S> Index<Argument> for Given<'_, S> {
    type Output = [S];

    fn index(&self, argument: Argument) -> &[S] {
        let place = self.arguments.iter().position(|other| *other == argument);
        self.numbers[place.expect("an argument of the row")]
    }
}

impl<S: Scalar> Given<'_, S> {
    pub fn state(&self) -> State<'_, S> {
        State { q: &self[Q], qd: &self[QD] }
    }

    pub fn motion(&self) -> Motion<'_, S> {
        self.state().with_accelerations(&self[QDD])
    }

    pub fn forward_input(&self) -> ForwardInput<'_, S> {
        ForwardInput { q: &self[Q], qd: &self[QD], tau: &self[TAU] }
    }

    pub fn time_step(&self) -> TimeStepInput<'_, S> {
        TimeStepInput { q: &self[Q], qd: &self[QD], tau: &self[TAU], dt: self[DT][0] }
    }

    pub fn step_input(&self) -> StepInput<'_, S> {
        StepInput { step: self.time_step(), warm_start: &self[WARM_START] }
    }

    pub fn actuator_input(&self) -> ActuatorInput<'_, S> {
        let State { q, qd } = self.state();
        ActuatorInput { q, qd, ctrl: &self[CTRL], act: &self[ACT], dt: self[DT][0] }
    }

    pub fn actuated_input(&self) -> ActuatedInput<'_, S> {
        ActuatedInput {
            actuators: self.actuator_input(),
            applied: &self[APPLIED],
            warm_start: &self[WARM_START],
        }
    }

    /// Returns the wrench on each link.
    pub fn forces(&self) -> Vec<Wrench<S>> {
        read(&self[FORCES])
    }

    /// Returns the settings of constraints, and the targets of contacts.
    pub fn settings(&self) -> ConstraintSettings<S, Vec<ContactTarget<S>>> {
        let (settings, targets) = self[SETTINGS].split_at(ConstraintSettings::<S>::COUNT);
        let (targets, _) = targets.as_chunks();
        let targets = targets.iter().map(|target| ContactTarget::from_numbers(*target)).collect();
        ConstraintSettings::from_numbers(core::array::from_fn(|i| settings[i]), targets)
    }

    /// Returns the settings of steps, and the surfaces of contacts.
    pub fn step_settings(&self) -> StepSettings<S, Vec<ContactSurface<S>>> {
        let (settings, surfaces) = self[STEP_SETTINGS].split_at(StepSettings::<S>::COUNT);
        let (surfaces, _) = surfaces.as_chunks();
        let surfaces =
            surfaces.iter().map(|surface| ContactSurface::from_numbers(*surface)).collect();
        StepSettings::from_numbers([settings[0], settings[1], settings[2]], surfaces)
    }
}

/// The numbers of a result.
pub(super) struct Output<'a, S> {
    /// The layout of the result.
    pub shape: &'a Shape,
    pub numbers: &'a mut [S],
}

impl<'a, S> Output<'a, S> {
    /// Returns the fields of the result of a function with several results.
    pub fn parts<const N: usize>(self) -> [&'a mut [S]; N] {
        let Self { shape, mut numbers } = self;
        let Shape::Record(Record::ResultsByType(_) | Record::ResultsByField(_), fields) = shape
        else {
            unreachable!("a function with several results")
        };
        core::array::from_fn(|k| {
            let (part, rest) = core::mem::take(&mut numbers).split_at_mut(fields[k].1.len());
            numbers = rest;
            part
        })
    }
}

/// A call of a function.
pub(super) struct Call<'a, S> {
    pub robot: &'a mut Interpreter<S>,
    pub given: Given<'a, S>,
    pub out: Output<'a, S>,
}

impl<S: Scalar> Call<'_, S> {
    /// Sets the result to the number that `compute` returns.
    pub fn number<E>(
        self,
        compute: impl FnOnce(&mut Interpreter<S>) -> Result<S, E>,
    ) -> Result<(), E> {
        self.out.numbers[0] = compute(self.robot)?;
        Ok(())
    }

    /// Sets the result to the numbers that `compute` assigns.
    pub fn numbers<E>(
        self,
        compute: impl FnOnce(&mut Interpreter<S>, &mut [S]) -> Result<(), E>,
    ) -> Result<(), E> {
        compute(self.robot, self.out.numbers)
    }

    /// Sets the result to the object that `compute` returns.
    pub fn object<X: Components<S>, E>(
        self,
        compute: impl FnOnce(&mut Interpreter<S>) -> Result<X, E>,
    ) -> Result<(), E> {
        compute(self.robot)?.write(self.out.numbers);
        Ok(())
    }

    /// Sets the result to the objects that `compute` assigns.
    pub fn objects<X: Components<S>, E>(
        self,
        compute: impl FnOnce(&mut Interpreter<S>, &mut [X]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut objects = read(self.out.numbers);
        compute(self.robot, &mut objects)?;
        write(&objects, self.out.numbers);
        Ok(())
    }
}
