//! The evaluation of derivatives, their products with vectors, and Hessians.

use super::super::arguments::{
    COTANGENT, FROM, Q, QD, QDD, TANGENT_Q, TANGENT_QD, TANGENT_QDD, TANGENT_TAU, TAU, TO, V,
};
use super::call::Call;
use crate::Scalar;
use crate::interpreter::{ForwardDerivatives, HessianOutputs, ShapeError};

impl<S: Scalar> Call<'_, S> {
    pub(super) fn inverse_dynamics_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [dtau_dq, dtau_dqd] = out.parts();
        robot.inverse_dynamics_derivatives(&given[Q], &given[QD], &given[QDD], dtau_dq, dtau_dqd)
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
        let [tau, tangent] = out.parts();
        let change = [TANGENT_Q, TANGENT_QD, TANGENT_QDD].map(|argument| &given[argument]);
        robot.inverse_dynamics_jvp(given.motion(), change, tau, tangent)
    }

    pub(super) fn forward_dynamics_vjp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [qdd, gradients @ ..] = out.parts::<4>();
        robot.forward_dynamics_vjp(given.forward_input(), &given[COTANGENT], qdd, gradients)
    }

    pub(super) fn forward_dynamics_jvp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [qdd, tangent] = out.parts();
        let change = [TANGENT_Q, TANGENT_QD, TANGENT_TAU].map(|argument| &given[argument]);
        robot.forward_dynamics_jvp(given.forward_input(), change, qdd, tangent)
    }

    pub(super) fn inverse_dynamics_hessian(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [value, by_q, by_qd, by_last, hessian @ ..] = out.parts::<8>();
        let outputs = HessianOutputs { value, gradients: [by_q, by_qd, by_last], hessian };
        robot.inverse_dynamics_hessian(given.motion(), &given[COTANGENT], outputs)
    }

    pub(super) fn forward_dynamics_hessian(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [value, by_q, by_qd, by_last, hessian @ ..] = out.parts::<8>();
        let outputs = HessianOutputs { value, gradients: [by_q, by_qd, by_last], hessian };
        robot.forward_dynamics_hessian(given.forward_input(), &given[COTANGENT], outputs)
    }

    pub(super) fn integrate_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [dq_dq, dq_dv] = out.parts();
        robot.integrate_derivatives(&given[Q], &given[V], dq_dq, dq_dv)
    }

    pub(super) fn difference_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [dv_dfrom, dv_dto] = out.parts();
        robot.difference_derivatives(&given[FROM], &given[TO], dv_dfrom, dv_dto)
    }
}
