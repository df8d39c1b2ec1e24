//! The evaluation of functions whose results have objects beside numbers.

use super::super::arguments::{ACTIVE, COTANGENT, Q, WRENCH_COTANGENT};
use super::call::Call;
use super::components::{read, write};
use crate::Scalar;
use crate::equations::constraints::{
    ConstrainedCotangent, ConstrainedInverseOutputs, ConstrainedOutputs, ImpulseOutputs,
    OperationalSpaceInertiaOutputs, ProjectionOutputs, ResidualOutputs,
};
use crate::equations::derivatives::CentroidalOutputs;
use crate::interpreter::{ConstrainedDerivatives, ConstrainedHessianOutputs, ShapeError};
use crate::spatial::Momentum;

impl<S: Scalar> Call<'_, S> {
    pub(super) fn centroidal_composite_inertia(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let mut columns = [Momentum::zero(); 6];
        robot.centroidal_composite_inertia(&given[Q], &mut columns)?;
        write(&columns, out.numbers);
        Ok(())
    }

    pub(super) fn centroidal_momentum_derivatives(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [momentum, rate, dmomentum_dq, drate_dq, drate_dqd] = out.parts();
        let mut values = [Momentum::zero(); 2];
        let mut columns = [&*dmomentum_dq, drate_dq, drate_dqd].map(read);
        let [first, second] = &mut values;
        let [by_q, rate_by_q, rate_by_qd] = &mut columns;
        let outputs = CentroidalOutputs {
            momentum: first,
            rate: second,
            dmomentum_dq: by_q,
            drate_dq: rate_by_q,
            drate_dqd: rate_by_qd,
        };
        robot.centroidal_momentum_derivatives(given.motion(), outputs)?;
        write(&values[..1], momentum);
        write(&values[1..], rate);
        for (columns, place) in columns.iter().zip([dmomentum_dq, drate_dq, drate_dqd]) {
            write(columns, place);
        }
        Ok(())
    }

    pub(super) fn constrained_forward_dynamics(self) {
        let Self { robot, given, out } = self;
        let [qdd, wrenches, residuals, rank] = out.parts();
        robot.activate(&given[ACTIVE]);
        let mut held = read(wrenches);
        let mut unmet = read(residuals);
        let outputs = ConstrainedOutputs { qdd, wrenches: &mut held, residuals: &mut unmet };
        rank[0] = robot.solve_constrained(given.forward_input(), &given.settings(), outputs);
        write(&held, wrenches);
        write(&unmet, residuals);
    }

    pub(super) fn constraint_residual(self) -> Result<(), ShapeError> {
        let Self { robot, given, out } = self;
        let [displacements, velocities] = out.parts();
        let mut displaced = read(displacements);
        let mut moving = read(velocities);
        let outputs = ResidualOutputs { displacements: &mut displaced, velocities: &mut moving };
        robot.constraint_residual(given.state(), &given.settings(), outputs)?;
        write(&displaced, displacements);
        write(&moving, velocities);
        Ok(())
    }

    pub(super) fn project_constraints(self) {
        let Self { robot, given, out } = self;
        let [step_q, step_qd, rank] = out.parts();
        robot.activate(&given[ACTIVE]);
        let outputs = ProjectionOutputs { step_q, step_qd };
        rank[0] = robot.solve_projection(given.state(), &given.settings(), outputs);
    }

    pub(super) fn constrained_forward_dynamics_derivatives(self) {
        let Self { robot, given, out } = self;
        let [qdd, wrenches, dqdd_dq, dqdd_dqd, dqdd_dtau, changes @ .., rank] = out.parts::<9>();
        robot.activate(&given[ACTIVE]);
        let mut held = read(wrenches);
        let mut changes_of_wrenches = changes.each_ref().map(|numbers| read(numbers));
        let [dwrenches_dq, dwrenches_dqd, dwrenches_dtau] = &mut changes_of_wrenches;
        let outputs = ConstrainedDerivatives {
            qdd,
            wrenches: &mut held,
            dqdd_dq,
            dqdd_dqd,
            dqdd_dtau,
            dwrenches_dq,
            dwrenches_dqd,
            dwrenches_dtau,
        };
        rank[0] = robot.solve_derivatives(given.forward_input(), &given.settings(), outputs);
        write(&held, wrenches);
        for (wrenches, place) in changes_of_wrenches.iter().zip(changes) {
            write(wrenches, place);
        }
    }

    pub(super) fn constrained_forward_dynamics_hessian(self) {
        let Self { robot, given, out } = self;
        let [qdd, wrenches, by_q, by_qd, by_tau, hessian @ .., rank] = out.parts::<10>();
        robot.activate(&given[ACTIVE]);
        let mut held = read(wrenches);
        let gradients = [by_q, by_qd, by_tau];
        let outputs = ConstrainedHessianOutputs { qdd, wrenches: &mut held, gradients, hessian };
        let wrench_weights = read(&given[WRENCH_COTANGENT]);
        let weights = ConstrainedCotangent { qdd: &given[COTANGENT], wrenches: &wrench_weights };
        rank[0] = robot.solve_hessian(given.forward_input(), weights, &given.settings(), outputs);
        write(&held, wrenches);
    }

    pub(super) fn impact_dynamics(self) {
        let Self { robot, given, out } = self;
        let [qd, impulses, rank] = out.parts();
        robot.activate(&given[ACTIVE]);
        let mut transmitted = read(impulses);
        let outputs = ImpulseOutputs { qd, impulses: &mut transmitted };
        rank[0] = robot.solve_impulse(given.state(), &given.settings(), outputs);
        write(&transmitted, impulses);
    }

    pub(super) fn constrained_inverse_dynamics(self) {
        let Self { robot, given, out } = self;
        let [tau, wrenches, rank] = out.parts();
        robot.activate(&given[ACTIVE]);
        let mut transmitted = read(wrenches);
        let outputs = ConstrainedInverseOutputs { tau, wrenches: &mut transmitted };
        rank[0] = robot.solve_torques(given.motion(), &given.settings(), outputs);
        write(&transmitted, wrenches);
    }

    pub(super) fn operational_space_inertia(self) {
        let Self { robot, given, out } = self;
        let [delassus, inertia, rank] = out.parts();
        robot.activate(&given[ACTIVE]);
        let outputs = OperationalSpaceInertiaOutputs { delassus, inertia };
        rank[0] = robot.solve_inertia(&given[Q], &given.settings(), outputs);
    }
}
