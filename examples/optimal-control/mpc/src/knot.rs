//! A time step as the solver needs it: the derivatives of the velocities, and the cost to second order.
//!
//! All displacements are in tangent space, and matrices are by rows.

use modyn::Robot;

use crate::matrix::{Matrix, add_outer, add_scaled};

/// A cost of a state to second order: its gradient and its Hessian.
#[derive(Clone, Copy, Debug)]
pub struct StateCost<const NV: usize> {
    /// The gradient with respect to q.
    pub q: [f64; NV],
    /// The gradient with respect to the velocities.
    pub qd: [f64; NV],
    /// The Hessian with respect to q.
    pub q_q: Matrix<NV, NV>,
    /// The second derivatives: a row for each entry of q, a column for each velocity.
    pub q_qd: Matrix<NV, NV>,
    /// The Hessian with respect to the velocities.
    pub qd_qd: Matrix<NV, NV>,
}

impl<const NV: usize> StateCost<NV> {
    /// No cost.
    pub const ZERO: Self = Self {
        q: [0.0; NV],
        qd: [0.0; NV],
        q_q: [[0.0; NV]; NV],
        q_qd: [[0.0; NV]; NV],
        qd_qd: [[0.0; NV]; NV],
    };

    /// Adds `weight` residual^2 / 2 for a residual of the coordinates with the derivative `by_q`.
    #[inline(always)]
    pub fn add_of_coordinates(&mut self, weight: f64, residual: f64, by_q: &[f64; NV]) {
        add_scaled(&mut self.q, weight * residual, by_q);
        add_outer(&mut self.q_q, weight, by_q, by_q);
    }

    /// Adds `weight` residual^2 / 2 for a residual that is coordinate `i` plus a constant.
    #[inline(always)]
    pub fn add_of_coordinate(&mut self, i: usize, weight: f64, residual: f64) {
        self.q[i] += weight * residual;
        self.q_q[i][i] += weight;
    }

    /// Adds `weight` residual^2 / 2 for a residual that is velocity `i` plus a constant.
    #[inline(always)]
    pub fn add_of_velocity(&mut self, i: usize, weight: f64, residual: f64) {
        self.qd[i] += weight * residual;
        self.qd_qd[i][i] += weight;
    }
}

/// The part of a cost that depends on the inputs, to second order.
#[derive(Clone, Copy, Debug)]
pub struct InputCost<const NV: usize, const NU: usize> {
    /// The gradient with respect to the inputs.
    pub u: [f64; NU],
    /// The second derivatives: a row for each input, a column for each entry of q.
    pub u_q: Matrix<NU, NV>,
    /// The second derivatives: a row for each input, a column for each velocity.
    pub u_qd: Matrix<NU, NV>,
    /// The Hessian with respect to the inputs.
    pub u_u: Matrix<NU, NU>,
}

impl<const NV: usize, const NU: usize> InputCost<NV, NU> {
    /// No cost.
    pub const ZERO: Self =
        Self { u: [0.0; NU], u_q: [[0.0; NV]; NU], u_qd: [[0.0; NV]; NU], u_u: [[0.0; NU]; NU] };

    /// Adds `weight` residual^2 / 2 for a residual that is input `i` plus a constant.
    #[inline(always)]
    pub fn add_of_input(&mut self, i: usize, weight: f64, residual: f64) {
        self.u[i] += weight * residual;
        self.u_u[i][i] += weight;
    }
}

/// The derivatives of the velocities after a step, and of a floating base's displacement.
#[derive(Clone, Copy, Debug)]
pub struct StepDerivatives<const NV: usize, const NU: usize> {
    /// The derivatives of the velocities after the step with respect to q before it.
    pub dqd_dq: Matrix<NV, NV>,
    /// The derivatives with respect to the velocities before the step.
    pub dqd_dqd: Matrix<NV, NV>,
    /// The derivatives with respect to the inputs.
    pub dqd_du: Matrix<NV, NU>,
    /// The derivatives of the displacement of a floating base with respect to its displacement before the step.
    pub dq_dq: Matrix<6, 6>,
    /// The derivatives with respect to the displacement in the step.
    pub dq_dv: Matrix<6, 6>,
}

impl<const NV: usize, const NU: usize> StepDerivatives<NV, NU> {
    /// Takes the derivatives from a knot of the robot, whose motors are the last of its joints.
    #[inline(always)]
    pub fn set<R: Robot<V<f64> = [f64; NV]>>(&mut self, knot: &StepOf<R>) {
        self.dqd_dq.copy_from_slice(knot.dqd_dq.as_ref());
        self.dqd_dqd.copy_from_slice(knot.dqd_dqd.as_ref());
        for (to, from) in self.dqd_du.iter_mut().zip(knot.dqd_dtau.as_ref()) {
            to.copy_from_slice(&from[NV - NU..]);
        }
        if let ([dq_dq], [dq_dv]) = (knot.dq_dq.as_ref(), knot.dq_dv.as_ref()) {
            self.dq_dq = *dq_dq;
            self.dq_dv = *dq_dv;
        }
    }
}

/// A knot of robot `R`.
pub type StepOf<R> = modyn::Knot<
    <R as Robot>::V<f64>,
    <R as Robot>::M<f64>,
    <R as Robot>::PerQuaternion<[[f64; 6]; 6]>,
>;

/// A time step with its cost: the derivatives of the dynamics, and the cost to second order.
#[derive(Clone, Copy, Debug)]
pub struct Knot<const NV: usize, const NU: usize> {
    /// The derivatives of the dynamics.
    pub step: StepDerivatives<NV, NU>,
    /// The cost of the state.
    pub state: StateCost<NV>,
    /// The cost of the inputs.
    pub input: InputCost<NV, NU>,
}

impl<const NV: usize, const NU: usize> Knot<NV, NU> {
    /// A knot without motion and cost.
    pub const ZERO: Self = Self {
        step: StepDerivatives {
            dqd_dq: [[0.0; NV]; NV],
            dqd_dqd: [[0.0; NV]; NV],
            dqd_du: [[0.0; NU]; NV],
            dq_dq: [[0.0; 6]; 6],
            dq_dv: [[0.0; 6]; 6],
        },
        state: StateCost::ZERO,
        input: InputCost::ZERO,
    };

    /// Adds `weight` residual^2 / 2 for a residual with these derivatives.
    #[inline(always)]
    pub fn add(&mut self, weight: f64, residual: f64, slope: &Slope<NV, NU>) {
        let Slope { by_q, by_qd, by_u } = slope;
        let Self { state, input, .. } = self;
        state.add_of_coordinates(weight, residual, by_q);
        add_scaled(&mut state.qd, weight * residual, by_qd);
        add_outer(&mut state.q_qd, weight, by_q, by_qd);
        add_outer(&mut state.qd_qd, weight, by_qd, by_qd);
        add_scaled(&mut input.u, weight * residual, by_u);
        add_outer(&mut input.u_q, weight, by_u, by_q);
        add_outer(&mut input.u_qd, weight, by_u, by_qd);
        add_outer(&mut input.u_u, weight, by_u, by_u);
    }
}

/// The derivatives of a residual.
#[derive(Clone, Copy, Debug)]
pub struct Slope<const NV: usize, const NU: usize> {
    /// With respect to q.
    pub by_q: [f64; NV],
    /// With respect to the velocities.
    pub by_qd: [f64; NV],
    /// With respect to the inputs.
    pub by_u: [f64; NU],
}
