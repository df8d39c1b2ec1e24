//! Discrete dynamics: the state after a time step, and its derivatives.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::brge::UduLayout;
use crate::equations::dynamics::Elimination;
pub use crate::equations::steps::StepOutputs;
use crate::equations::{
    MidpointWorkspace, NextState, RungeKuttaWorkspace, StepWorkspace, TimeStepInput, Workspace,
    steps,
};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;

/// A method that computes the coordinates and velocities after a time step, from q, qd, tau and dt.
type Method<S> = fn(
    &Mechanism<S>,
    &Elimination,
    TimeStepInput<'_, S>,
    &mut Workspace<S>,
    &mut StepWorkspace<S>,
    NextState<'_, S>,
);

impl<S: Scalar> Interpreter<S> {
    /// Computes the coordinates and velocities after the time `dt` (s) under the joint forces
    /// `tau`, by the semi-implicit Euler method: `next_qd` = qd + dt qdd, and `next_q` is `q` moved
    /// by dt `next_qd`. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_semi_implicit(
        &mut self,
        input: TimeStepInput<'_, S>,
        next_q: &mut [S],
        next_qd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.step_by(steps::step_semi_implicit, input, NextState { q: next_q, qd: next_qd })
    }

    /// Computes the state of [`step_semi_implicit`](Self::step_semi_implicit), and its derivatives
    /// A with respect to the state before and B with respect to `tau`. The first call allocates
    /// memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_semi_implicit_derivatives(
        &mut self,
        input: TimeStepInput<'_, S>,
        outputs: StepOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_linear_step(input, &outputs)?;
        let Self { mechanism, workspace, model, links, steps, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let memory = steps.get_or_insert_with(|| StepWorkspace::new(mechanism));
        steps::step_semi_implicit_derivatives(mechanism, layout, input, workspace, memory, outputs);
        Ok(())
    }

    /// Computes the coordinates and velocities after the time `dt` (s) under the joint forces
    /// `tau`, by a Runge-Kutta method of fourth order. Rotations and poses follow exponential maps,
    /// so quaternions keep length 1. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_rk4(
        &mut self,
        input: TimeStepInput<'_, S>,
        next_q: &mut [S],
        next_qd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.step_by(steps::step_rk4, input, NextState { q: next_q, qd: next_qd })
    }

    /// Computes the state of [`step_rk4`](Self::step_rk4), and its derivatives A with respect to
    /// the state before and B with respect to `tau`, through the four evaluations of forward
    /// dynamics. Takes time of order nv^3. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_rk4_derivatives(
        &mut self,
        input: TimeStepInput<'_, S>,
        outputs: StepOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_linear_step(input, &outputs)?;
        let Self { mechanism, workspace, model, links, runge_kutta, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let memory = runge_kutta.get_or_insert_with(|| RungeKuttaWorkspace::new(mechanism));
        steps::step_rk4_derivatives(mechanism, layout, input, workspace, memory, outputs);
        Ok(())
    }

    /// Computes the coordinates and velocities after the time `dt` (s) under the joint forces
    /// `tau`, by the implicit midpoint rule: its equations are solved by three iterations of
    /// simplified Newton. Rotations and poses follow exponential maps, so quaternions keep
    /// length 1. Takes time of order nv^3. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_implicit_midpoint(
        &mut self,
        input: TimeStepInput<'_, S>,
        next_q: &mut [S],
        next_qd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_step(input, next_q, next_qd)?;
        let Self { mechanism, workspace, midpoint, .. } = self;
        let memory = midpoint.get_or_insert_with(|| MidpointWorkspace::new(mechanism));
        let next = NextState { q: next_q, qd: next_qd };
        steps::step_implicit_midpoint(mechanism, input, workspace, memory, next);
        Ok(())
    }

    /// Computes the state of [`step_implicit_midpoint`](Self::step_implicit_midpoint), and the
    /// derivatives of the implicit midpoint rule: A with respect to the state before and B with
    /// respect to `tau`. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_implicit_midpoint_derivatives(
        &mut self,
        input: TimeStepInput<'_, S>,
        outputs: StepOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_linear_step(input, &outputs)?;
        let Self { mechanism, workspace, midpoint, .. } = self;
        let memory = midpoint.get_or_insert_with(|| MidpointWorkspace::new(mechanism));
        steps::step_implicit_midpoint_derivatives(mechanism, input, workspace, memory, outputs);
        Ok(())
    }

    /// Computes a step by one of the methods.
    fn step_by(
        &mut self,
        method: Method<S>,
        input: TimeStepInput<'_, S>,
        next: NextState<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_step(input, next.q, next.qd)?;
        let Self { mechanism, elimination, workspace, steps, .. } = self;
        let memory = steps.get_or_insert_with(|| StepWorkspace::new(mechanism));
        method(mechanism, elimination, input, workspace, memory, next);
        Ok(())
    }

    fn check_linear_step(
        &self,
        input: TimeStepInput<'_, S>,
        outputs: &StepOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        self.check_step(input, outputs.q, outputs.qd)?;
        check("a", outputs.a, 4 * n * n)?;
        check("b", outputs.b, 2 * n * n)
    }

    fn check_step(
        &self,
        input: TimeStepInput<'_, S>,
        next_q: &[S],
        next_qd: &[S],
    ) -> Result<(), ShapeError> {
        self.check_forward_input(input.forward_input())?;
        check("next_q", next_q, self.model.nq())?;
        self.check_vectors(&[("next_qd", next_qd)])
    }
}
