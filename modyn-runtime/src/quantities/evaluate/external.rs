//! The evaluation of functions with a wrench on each link.

use super::super::arguments::{Q, QD, QDD, TAU};
use super::call::Call;
use crate::Scalar;
use crate::equations::Forces;
use crate::interpreter::ShapeError;

impl<S: Scalar> Call<'_, S> {
    pub(super) fn forward_dynamics_external(self, forces: Forces<'_, S>) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        robot.forward_dynamics_external(&given[Q], &given[QD], &given[TAU], forces, out.numbers)
    }

    pub(super) fn inverse_dynamics_external(self, forces: Forces<'_, S>) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        robot.inverse_dynamics_external(&given[Q], &given[QD], &given[QDD], forces, out.numbers)
    }

    pub(super) fn generalized_forces(self, forces: Forces<'_, S>) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [tau, dtau_dq] = out.parts();
        robot.generalized_forces(&given[Q], forces, tau, dtau_dq)
    }
}
