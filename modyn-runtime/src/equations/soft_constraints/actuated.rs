//! The joint forces and the dampers of actuators in a step under controls.

use alloc::{vec, vec::Vec};

use super::damping::DampingMatrix;
use super::input::StepInput;
use crate::Scalar;
use crate::equations::TimeStepInput;
use crate::equations::actuation::{ActuationWorkspace, ActuatorInput, ActuatorOutputs, actuate};
use crate::mechanism::Mechanism;
use crate::model::Model;

/// The input of a step under the controls of actuators.
#[derive(Clone, Copy, Debug)]
pub struct ActuatedInput<'a, S> {
    /// The state, the controls, and the time of the step.
    pub actuators: ActuatorInput<'a, S>,
    /// The applied joint forces, beside the forces of the actuators, N m or N.
    pub applied: &'a [S],
    /// The accelerations from which the solver starts: zeros, or the accelerations of the last step.
    pub warm_start: &'a [S],
}

/// The joint forces in a step under controls, their dampers, and the activations after it.
#[derive(Clone, Debug)]
pub struct ActuatedForces<S> {
    /// The sums of the forces of actuators and of the applied forces, N m or N.
    pub tau: Vec<S>,
    /// The velocity gains of actuators that act with the velocities after the step.
    pub dampers: DampingMatrix<S>,
    /// The activations after the step.
    pub act: Vec<S>,
}

impl<'a, S: Scalar> ActuatedInput<'a, S> {
    /// Returns the joint forces and the activations after the step of a robot, whose `mechanism` is
    /// that of `model`.
    #[must_use]
    pub fn forces(
        &self,
        model: &Model,
        mechanism: &Mechanism<S>,
        workspace: &mut ActuationWorkspace<S>,
    ) -> ActuatedForces<S> {
        let mut tau = vec![S::zero(); model.nv()];
        let mut act = vec![S::zero(); self.actuators.act.len()];
        let outputs = ActuatorOutputs { tau: &mut tau, act: &mut act };
        actuate(model, self.actuators, workspace, outputs);
        for (tau, &applied) in tau.iter_mut().zip(self.applied) {
            *tau = *tau + applied;
        }
        let dampers = DampingMatrix::of_actuators(model, mechanism, workspace);
        ActuatedForces { tau, dampers, act }
    }

    /// Returns the input of the step under these joint forces.
    #[must_use]
    pub fn under<'b>(&self, tau: &'b [S]) -> StepInput<'b, S>
    where
        'a: 'b,
    {
        let ActuatorInput { q, qd, dt, .. } = self.actuators;
        let step = TimeStepInput { q, qd, tau, dt };
        StepInput { step, warm_start: self.warm_start }
    }
}
