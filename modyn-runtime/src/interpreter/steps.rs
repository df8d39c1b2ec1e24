//! Discrete dynamics: the state after a time step, and its derivatives.

use super::Interpreter;
use super::constraints::ConstrainedDerivatives;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::equations::brge::UduLayout;
use crate::equations::dynamics::Elimination;
pub use crate::equations::steps::{KnotOutputs, StepOutputs};
use crate::equations::{
    MidpointWorkspace, NextState, RungeKuttaWorkspace, StepWorkspace, TimeStepInput, Workspace,
    steps,
};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::spatial::Wrench;

/// The results of [`Interpreter::constrained_knot`].
#[derive(Debug)]
pub struct ConstrainedKnotOutputs<'a, S> {
    /// The velocities after the step, and the derivatives of the step.
    pub knot: KnotOutputs<'a, S>,
    /// The wrench of each constraint.
    pub wrenches: &'a mut [Wrench<S>],
    /// The derivatives of the wrenches with respect to q, in tangent space.
    pub dwrenches_dq: &'a mut [Wrench<S>],
    /// The derivatives of the wrenches with respect to qd.
    pub dwrenches_dqd: &'a mut [Wrench<S>],
    /// The derivatives of the wrenches with respect to tau.
    pub dwrenches_dtau: &'a mut [Wrench<S>],
}

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

    /// Computes the velocities after the time `dt` (s) by the semi-implicit Euler method, and the
    /// derivatives of the step in blocks, by rows. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn knot(
        &mut self,
        input: TimeStepInput<'_, S>,
        outputs: KnotOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_forward_input(input.forward_input())?;
        self.check_knot(&outputs)?;
        let Self { mechanism, workspace, model, links, steps, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let memory = steps.get_or_insert_with(|| StepWorkspace::new(mechanism));
        steps::knot(mechanism, layout, input, workspace, memory, outputs);
        Ok(())
    }

    /// Computes the results of [`knot`](Self::knot) with the loops closed and the `active` contacts
    /// held, and the wrenches and their derivatives of
    /// [`constrained_forward_dynamics_derivatives`](Self::constrained_forward_dynamics_derivatives).
    /// Returns the number of independent constraint rows, an integer. The first call allocates
    /// memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_knot(
        &mut self,
        input: TimeStepInput<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedKnotOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        let count = self.model.constraints();
        self.check_forward_input(input.forward_input())?;
        self.check_knot(&outputs.knot)?;
        check("wrenches", outputs.wrenches, count)?;
        check("dwrenches_dq", outputs.dwrenches_dq, n * count)?;
        check("dwrenches_dqd", outputs.dwrenches_dqd, n * count)?;
        check("dwrenches_dtau", outputs.dwrenches_dtau, n * count)?;
        self.set_active(active, settings)?;
        Ok(self.solve_knot(input, settings, outputs))
    }

    /// Computes a knot with the set of active contacts that was stored last. Lengths are not
    /// checked.
    pub(crate) fn solve_knot(
        &mut self,
        input: TimeStepInput<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedKnotOutputs<'_, S>,
    ) -> S {
        let knot = outputs.knot;
        let derivatives = ConstrainedDerivatives {
            qdd: &mut *knot.qd,
            wrenches: outputs.wrenches,
            dqdd_dq: &mut *knot.dqd_dq,
            dqdd_dqd: &mut *knot.dqd_dqd,
            dqdd_dtau: &mut *knot.dqd_dtau,
            dwrenches_dq: outputs.dwrenches_dq,
            dwrenches_dqd: outputs.dwrenches_dqd,
            dwrenches_dtau: outputs.dwrenches_dtau,
        };
        let rank = self.solve_derivatives(input.forward_input(), settings, derivatives);
        let Self { mechanism, steps, .. } = self;
        let memory = steps.get_or_insert_with(|| StepWorkspace::new(mechanism));
        knot.complete(mechanism, input, memory);
        rank
    }

    fn check_knot(&self, outputs: &KnotOutputs<'_, S>) -> Result<(), ShapeError> {
        let entries = 36 * self.model.quaternions().count();
        self.check_vectors(&[("next_qd", outputs.qd)])?;
        self.check_matrices(&[
            ("dqd_dq", outputs.dqd_dq),
            ("dqd_dqd", outputs.dqd_dqd),
            ("dqd_dtau", outputs.dqd_dtau),
        ])?;
        check("dq_dq", outputs.dq_dq, entries)?;
        check("dq_dv", outputs.dq_dv, entries)
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
