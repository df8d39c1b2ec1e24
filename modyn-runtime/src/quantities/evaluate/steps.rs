//! The evaluation of time steps and actuators.

use super::super::arguments::{
    ACT_COTANGENT, ACTIVE, STATE_COTANGENT, TANGENT_ACT, TANGENT_CTRL, TANGENT_Q, TANGENT_QD,
    TANGENT_TAU,
};
use super::call::Call;
use super::components::{read, write};
use crate::Scalar;
use crate::interpreter::{
    ActuatorOutputs, ConstrainedKnotOutputs, KnotOutputs, ShapeError, StateChange,
    StateDerivatives, StateGradients, StepHessianOutputs, StepOutputs, StepSolutionOutputs,
};

/// Returns the outputs of the solver of a step.
fn solution<S>(parts: [&mut [S]; 6]) -> StepSolutionOutputs<'_, S> {
    let [q, qd, qdd, forces, residual, iterations] = parts;
    let [residual, iterations] = [residual, iterations].map(|number| &mut number[0]);
    StepSolutionOutputs { q, qd, qdd, forces, residual, iterations }
}

impl<S: Scalar> Call<'_, S> {
    pub(super) fn step_semi_implicit(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd] = out.parts();
        robot.step_semi_implicit(given.time_step(), q, qd)
    }

    pub(super) fn step_semi_implicit_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, a, b] = out.parts();
        robot.step_semi_implicit_derivatives(given.time_step(), StepOutputs { q, qd, a, b })
    }

    pub(super) fn knot(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [qd, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv] = out.parts();
        let outputs = KnotOutputs { qd, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv };
        robot.knot(given.time_step(), outputs)
    }

    pub(super) fn constrained_knot(self) {
        let Self { robot, given, out } = self;
        let [qd, wrenches, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv, changes @ .., rank] =
            out.parts::<11>();
        robot.activate(&given[ACTIVE]);
        let mut held = read(wrenches);
        let mut changes_of_wrenches = changes.each_ref().map(|numbers| read(numbers));
        let [dwrenches_dq, dwrenches_dqd, dwrenches_dtau] = &mut changes_of_wrenches;
        let outputs = ConstrainedKnotOutputs {
            knot: KnotOutputs { qd, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv },
            wrenches: &mut held,
            dwrenches_dq,
            dwrenches_dqd,
            dwrenches_dtau,
        };
        rank[0] = robot.solve_knot(given.time_step(), &given.settings(), outputs);
        write(&held, wrenches);
        for (wrenches, place) in changes_of_wrenches.iter().zip(changes) {
            write(wrenches, place);
        }
    }

    pub(super) fn step_semi_implicit_hessian(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, grad_x, grad_tau, hess_x_x, hess_x_tau, hess_tau_tau] = out.parts();
        let outputs =
            StepHessianOutputs { q, qd, grad_x, grad_tau, hess_x_x, hess_x_tau, hess_tau_tau };
        robot.step_semi_implicit_hessian(given.time_step(), &given[STATE_COTANGENT], outputs)
    }

    pub(super) fn step_rk4(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd] = out.parts();
        robot.step_rk4(given.time_step(), q, qd)
    }

    pub(super) fn step_rk4_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, a, b] = out.parts();
        robot.step_rk4_derivatives(given.time_step(), StepOutputs { q, qd, a, b })
    }

    pub(super) fn step_implicit_midpoint(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd] = out.parts();
        robot.step_implicit_midpoint(given.time_step(), q, qd)
    }

    pub(super) fn step_implicit_midpoint_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, a, b] = out.parts();
        robot.step_implicit_midpoint_derivatives(given.time_step(), StepOutputs { q, qd, a, b })
    }

    pub(super) fn touching_points(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [gaps, positions, velocities] = out.parts();
        let points = robot.touching_points(given.state(), &given.step_settings())?;
        let vectors = positions.chunks_exact_mut(3).zip(velocities.chunks_exact_mut(3));
        for ((point, gap), (position, velocity)) in points.iter().zip(gaps).zip(vectors) {
            *gap = point.gap;
            position.copy_from_slice(&point.place.0);
            velocity.copy_from_slice(&point.velocity.0);
        }
        Ok(())
    }

    pub(super) fn actuate(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [tau, act] = out.parts();
        robot.actuate(given.actuator_input(), ActuatorOutputs { tau, act })
    }

    pub(super) fn step(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, qdd, forces, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        robot.step(given.step_input(), &given.step_settings(), outputs)
    }

    pub(super) fn step_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, qdd, forces, a, b, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        let derivatives = StateDerivatives { a, b };
        robot.step_derivatives(given.step_input(), &given.step_settings(), outputs, derivatives)
    }

    pub(super) fn step_vjp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, qdd, forces, grad_x, grad_u, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        let gradients = StateGradients {
            state_cotangent: &given[STATE_COTANGENT],
            act_cotangent: &[],
            grad_x,
            grad_u,
        };
        robot.step_vjp(given.step_input(), &given.step_settings(), outputs, gradients)
    }

    pub(super) fn step_jvp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, qdd, forces, tangent_x, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        let [tangent_q, tangent_qd, tangent_u] =
            [TANGENT_Q, TANGENT_QD, TANGENT_TAU].map(|argument| &given[argument]);
        let change = StateChange { tangent_q, tangent_qd, tangent_act: &[], tangent_u, tangent_x };
        robot.step_jvp(given.step_input(), &given.step_settings(), outputs, change)
    }

    pub(super) fn step_actuated(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, act, qdd, forces, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        robot.step_actuated(given.actuated_input(), &given.step_settings(), outputs, act)
    }

    pub(super) fn step_actuated_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, act, qdd, forces, a, b, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        let derivatives = StateDerivatives { a, b };
        let input = given.actuated_input();
        robot.step_actuated_derivatives(input, &given.step_settings(), outputs, act, derivatives)
    }

    pub(super) fn step_actuated_vjp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, act, qdd, forces, grad_x, grad_u, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        let [state_cotangent, act_cotangent] =
            [STATE_COTANGENT, ACT_COTANGENT].map(|argument| &given[argument]);
        let gradients = StateGradients { state_cotangent, act_cotangent, grad_x, grad_u };
        let input = given.actuated_input();
        robot.step_actuated_vjp(input, &given.step_settings(), outputs, act, gradients)
    }

    pub(super) fn step_actuated_jvp(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [q, qd, act, qdd, forces, tangent_x, residual, iterations] = out.parts();
        let outputs = solution([q, qd, qdd, forces, residual, iterations]);
        let [tangent_q, tangent_qd, tangent_act, tangent_u] =
            [TANGENT_Q, TANGENT_QD, TANGENT_ACT, TANGENT_CTRL].map(|argument| &given[argument]);
        let change = StateChange { tangent_q, tangent_qd, tangent_act, tangent_u, tangent_x };
        let input = given.actuated_input();
        robot.step_actuated_jvp(input, &given.step_settings(), outputs, act, change)
    }
}
