//! The evaluation of derivatives, their products with vectors, and Hessians.

use super::super::arguments::{COTANGENT, DQ, DQD, DQDD, DTAU, FROM, Q, QD, QDD, TAU, TO, V};
use super::call::Call;
use crate::Scalar;
use crate::interpreter::{ForwardDerivatives, HessianOutputs, ShapeError};

impl<S: Scalar> Call<'_, S> {
    pub(super) fn inverse_dynamics_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [dq, dqd] = out.parts();
        robot.inverse_dynamics_derivatives(&given[Q], &given[QD], &given[QDD], dq, dqd)
    }

    pub(super) fn forward_dynamics_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [qdd, dqdd_dq, dqdd_dqd, dqdd_dtau] = out.parts();
        let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
        robot.forward_dynamics_derivatives(&given[Q], &given[QD], &given[TAU], outputs)
    }

    pub(super) fn inverse_dynamics_vjp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [tau, gradients @ ..] = out.parts::<4>();
        robot.inverse_dynamics_vjp(given.motion(), &given[COTANGENT], tau, gradients)
    }

    pub(super) fn inverse_dynamics_jvp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [tau, dtau] = out.parts();
        let change = [DQ, DQD, DQDD].map(|argument| &given[argument]);
        robot.inverse_dynamics_jvp(given.motion(), change, tau, dtau)
    }

    pub(super) fn forward_dynamics_vjp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [qdd, gradients @ ..] = out.parts::<4>();
        robot.forward_dynamics_vjp(given.forward_input(), &given[COTANGENT], qdd, gradients)
    }

    pub(super) fn forward_dynamics_jvp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [qdd, dqdd] = out.parts();
        let change = [DQ, DQD, DTAU].map(|argument| &given[argument]);
        robot.forward_dynamics_jvp(given.forward_input(), change, qdd, dqdd)
    }

    pub(super) fn inverse_dynamics_hessian(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [value, dx, dy, dz, hessian @ ..] = out.parts::<8>();
        let outputs = HessianOutputs { value, gradients: [dx, dy, dz], hessian };
        robot.inverse_dynamics_hessian(given.motion(), &given[COTANGENT], outputs)
    }

    pub(super) fn forward_dynamics_hessian(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [value, dx, dy, dz, hessian @ ..] = out.parts::<8>();
        let outputs = HessianOutputs { value, gradients: [dx, dy, dz], hessian };
        robot.forward_dynamics_hessian(given.forward_input(), &given[COTANGENT], outputs)
    }

    pub(super) fn integrate_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [dq, dv] = out.parts();
        robot.integrate_derivatives(&given[Q], &given[V], dq, dv)
    }

    pub(super) fn difference_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [dfrom, dto] = out.parts();
        robot.difference_derivatives(&given[FROM], &given[TO], dfrom, dto)
    }
}
