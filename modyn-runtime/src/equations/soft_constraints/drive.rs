//! What drives a robot in a step, and its changes with the variables of the step.

use alloc::{vec, vec::Vec};

use super::actuated::{ActuatedForces, ActuatedInput};
use super::damping::DampingMatrix;
use crate::Scalar;
use crate::equations::TimeStepInput;
use crate::equations::actuation::{ActuationWorkspace, ActuatorInput};
use crate::equations::kinematics::coordinates::velocity_to_qdot;
use crate::mechanism::Mechanism;
use crate::model::Model;
use crate::scalar::Tangent;

/// What drives a robot in a step.
///
/// The variables of a step are the coordinates, in tangent space, and the velocities; then the joint
/// forces, or the activations and the controls of actuators.
#[derive(Clone, Copy, Debug)]
pub enum StepDrive<'a, S> {
    /// Joint forces.
    Forces(&'a [S]),
    /// The actuators of a model.
    Actuators(&'a Model, ActuatedInput<'a, S>),
}

/// A state with its derivatives by a variable.
pub(super) struct VaryingState<S> {
    pub q: Vec<Tangent<S>>,
    pub qd: Vec<Tangent<S>>,
}

impl<S: Scalar> StepDrive<'_, S> {
    /// Returns the number of variables beside the coordinates and the velocities.
    pub(super) fn variables(self) -> usize {
        match self {
            Self::Forces(tau) => tau.len(),
            Self::Actuators(_, input) => input.actuators.act.len() + input.actuators.ctrl.len(),
        }
    }

    /// Returns the state before a step with its derivatives by a variable.
    pub(super) fn state(
        self,
        model: &Mechanism<S>,
        step: TimeStepInput<'_, S>,
        variable: usize,
    ) -> VaryingState<S> {
        let nv = model.nv;
        let mut rates = vec![S::zero(); model.nq];
        velocity_to_qdot(model, step.q, &unit(nv, Some(variable)), &mut rates);
        let velocities = unit(nv, variable.checked_sub(nv));
        VaryingState { q: varying(step.q, &rates), qd: varying(step.qd, &velocities) }
    }

    /// Returns the joint forces and the activations after a step, with their derivatives by a
    /// variable, by which `state` varies. `model` is the robot.
    pub(super) fn forces(
        self,
        model: &Mechanism<Tangent<S>>,
        state: &VaryingState<S>,
        dt: Tangent<S>,
        variable: usize,
    ) -> ActuatedForces<Tangent<S>> {
        let place = variable.checked_sub(2 * model.nv);
        match self {
            Self::Forces(tau) => ActuatedForces {
                tau: varying(tau, &unit(tau.len(), place)),
                dampers: DampingMatrix::zero(model.nv),
                act: Vec::new(),
            },
            Self::Actuators(described, input) => {
                let ActuatorInput { act, ctrl, .. } = input.actuators;
                let of_controls = place.and_then(|place| place.checked_sub(act.len()));
                let act = varying(act, &unit(act.len(), place));
                let ctrl = varying(ctrl, &unit(ctrl.len(), of_controls));
                let applied = varying(input.applied, &unit(model.nv, None));
                let VaryingState { q, qd } = state;
                let actuators = ActuatorInput { q, qd, ctrl: &ctrl, act: &act, dt };
                let workspace = &mut ActuationWorkspace::new(described);
                ActuatedInput { actuators, applied: &applied, warm_start: &[] }
                    .forces(described, model, workspace)
            }
        }
    }

    /// Returns the changes of the joint forces, of the dampers and of the activations with each
    /// variable.
    pub(super) fn changes(
        self,
        model: &Mechanism<S>,
        step: TimeStepInput<'_, S>,
    ) -> Vec<ActuatedForces<S>> {
        let varying = &model.map(Tangent::constant);
        let dt = Tangent::constant(step.dt);
        let change = |variable: usize| {
            let state = self.state(model, step, variable);
            let ActuatedForces { tau, dampers, act } = self.forces(varying, &state, dt, variable);
            let rates = |x: Vec<Tangent<S>>| x.into_iter().map(|x| x.dx).collect();
            ActuatedForces { tau: rates(tau), dampers: dampers.map(|x| x.dx), act: rates(act) }
        };
        (0..2 * model.nv + self.variables()).map(change).collect()
    }
}

/// Returns zeros with a one in this place, if it is there.
fn unit<S: Scalar>(count: usize, place: Option<usize>) -> Vec<S> {
    let entry = |k| if Some(k) == place { S::one() } else { S::zero() };
    (0..count).map(entry).collect()
}

/// Returns numbers with these derivatives.
fn varying<S: Scalar>(numbers: &[S], rates: &[S]) -> Vec<Tangent<S>> {
    numbers.iter().zip(rates).map(|(&x, &dx)| Tangent { x, dx }).collect()
}
