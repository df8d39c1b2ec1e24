//! Differential dynamic programming with fixed sizes, for any robot whose joints have one degree of freedom each, on a
//! fixed or a floating base.
//!
//! An iteration solves the linear-quadratic problem along the motion (the backward pass), and applies the changes and
//! the feedback gains of its solution with a line search (the forward pass). The motion always obeys the dynamics: it
//! is computed from the measured state, and its inputs are within their limits. A step of the line search is accepted
//! only if the cost falls enough.
//!
//! - Li and Todorov 2004, "Iterative linear quadratic regulator design for nonlinear biological movement systems": the
//!   method, which is differential dynamic programming (Mayne 1966) with the Hessians of Gauss and Newton.
//! - Tassa, Mansard and Todorov 2014, "Control-limited differential dynamic programming": limits of the inputs.
//!
//! The time step is semi-implicit Euler: q after the step depends on q before the step and on the velocities qd' after
//! it, so that a displacement becomes dq' = J_q dq + dt J_v dqd'. J_q and J_v are 1, except for the base. The backward
//! pass writes the cost of the next state as a function of (q, qd'), with J_q and J_v. Then only the derivatives of qd'
//! take part in products of matrices: about 40 % of the multiplications with dense A and B.

use modyn::simulate::State;
use modyn::{Robot, functions};

use crate::knot::{InputCost, Knot, StateCost, StepDerivatives};
use crate::limited::{Minimum, Quadratic};
use crate::matrix::{
    Matrix, add_scaled, add_transposed_product, add_transposed_vector, dot, mirror, transposed,
};

/// The limits of the inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const NU: usize> {
    /// The least inputs.
    pub lower: [f64; NU],
    /// The greatest inputs.
    pub upper: [f64; NU],
}

impl<const NU: usize> Limits<NU> {
    /// Returns the inputs with those beyond a limit moved to the limit.
    #[inline(always)]
    #[must_use]
    pub fn clamp(&self, u: &[f64; NU]) -> [f64; NU] {
        core::array::from_fn(|i| u[i].max(self.lower[i]).min(self.upper[i]))
    }

    /// Returns the limits of changes of `u`.
    #[inline(always)]
    fn around(&self, u: &[f64; NU]) -> Self {
        Self {
            lower: core::array::from_fn(|i| self.lower[i] - u[i]),
            upper: core::array::from_fn(|i| self.upper[i] - u[i]),
        }
    }

    #[inline(always)]
    pub(crate) fn contain(&self, u: &[f64; NU]) -> bool {
        (0..NU).all(|i| self.lower[i] <= u[i] && u[i] <= self.upper[i])
    }

    /// Returns which inputs can follow the negative gradient.
    #[inline(always)]
    pub(crate) fn free(&self, u: &[f64; NU], gradient: &[f64; NU]) -> [bool; NU] {
        core::array::from_fn(|i| {
            let stopped_below = u[i] <= self.lower[i] && gradient[i] > 0.0;
            let stopped_above = u[i] >= self.upper[i] && gradient[i] < 0.0;
            !(stopped_below || stopped_above)
        })
    }
}

/// A state after a step, and the cost of the step.
pub struct Step<R: Robot> {
    /// The state after the step.
    pub next: State<R>,
    /// The cost of the state before the step and of the inputs.
    pub cost: f64,
}

/// A problem of optimal control of a robot with `NV` velocities and `NU` motors.
pub trait Problem<const NV: usize, const NU: usize> {
    /// The robot that moves.
    type Robot: Robot<V<f64> = [f64; NV]> + functions::Difference + functions::Integrate;

    /// Returns the time step, s.
    fn dt(&self) -> f64;

    /// Returns the limits of the inputs.
    fn limits(&self) -> Limits<NU>;

    /// Returns the state after step `k`, by semi-implicit Euler, and the cost of the step.
    fn step(&self, k: usize, x: &State<Self::Robot>, u: &[f64; NU]) -> Step<Self::Robot>;

    /// Writes the derivatives of [`step`](Self::step), and adds its cost to the knot, whose cost is zero before.
    fn linearize(&self, k: usize, x: &State<Self::Robot>, u: &[f64; NU], knot: &mut Knot<NV, NU>);

    /// Returns the cost of the last state.
    fn end(&self, x: &State<Self::Robot>) -> f64;

    /// Adds the cost of the last state to `cost`.
    fn linearize_end(&self, x: &State<Self::Robot>, cost: &mut StateCost<NV>);
}

/// A motion of `N` steps.
pub struct Motion<R: Robot, const NU: usize, const N: usize> {
    /// The state before each step.
    pub states: [State<R>; N],
    /// The inputs of each step.
    pub inputs: [[f64; NU]; N],
    /// The state after the last step.
    pub end: State<R>,
    /// The cost.
    pub cost: f64,
}

/// The change of the inputs of a step, and their feedback of displacements of the state.
#[derive(Clone, Copy, Debug)]
pub struct Gain<const NV: usize, const NU: usize> {
    /// The change.
    pub change: [f64; NU],
    /// The feedback of the displacement of q.
    pub by_q: Matrix<NU, NV>,
    /// The feedback of the displacement of the velocities.
    pub by_qd: Matrix<NU, NV>,
}

impl<const NV: usize, const NU: usize> Gain<NV, NU> {
    const ZERO: Self = Self { change: [0.0; NU], by_q: [[0.0; NV]; NU], by_qd: [[0.0; NV]; NU] };
}

/// The change of the cost that the linear-quadratic problem promises: its coefficients in powers of the length of the
/// step.
#[derive(Clone, Copy, Debug, Default)]
struct Promise {
    linear: f64,
    quadratic: f64,
}

impl Promise {
    fn of(&self, length: f64) -> f64 {
        length * (self.linear + length * self.quadratic)
    }
}

/// The result of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Iteration {
    /// The cost fell.
    Improved,
    /// The linear-quadratic problem promises no lower cost.
    Converged,
    /// No step lowered the cost: the motion is as before, and the next iteration takes shorter steps.
    Unchanged,
}

/// The smallest damping other than zero, and the damping at which an iteration gives up.
const DAMPING: [f64; 2] = [1e-9, 1e6];
/// The factor of the damping after a step that failed, and its inverse after one that succeeded.
const DAMPING_FACTOR: f64 = 10.0;
/// The halvings of the line search.
const HALVINGS: usize = 10;
/// The part of the promised decrease that a step must reach.
const SUFFICIENT: f64 = 0.1;
/// A motion has converged when the promised decrease is below this part of its cost.
const TOLERANCE: f64 = 1e-12;

/// The solver of a problem with `N` steps. It holds all of its memory, and an iteration needs no heap.
pub struct Solver<P: Problem<NV, NU>, const NV: usize, const NU: usize, const N: usize> {
    motion: Motion<P::Robot, NU, N>,
    /// The motion of a step of the line search.
    trial: Motion<P::Robot, NU, N>,
    gains: [Gain<NV, NU>; N],
    /// A cost of the squared changes of the inputs.
    damping: f64,
}

impl<P: Problem<NV, NU>, const NV: usize, const NU: usize, const N: usize> Solver<P, NV, NU, N> {
    /// Whether the robot has a floating base, whose displacements come first.
    const FLOATING: bool = {
        let quaternions = <P::Robot as Robot>::QUATERNIONS;
        assert!(
            quaternions.is_empty() || quaternions.len() == 1 && quaternions[0].1 == 3 && NV >= 6,
            "a joint of this robot is spherical or floating, and is not the base"
        );
        assert!(N > 0, "a motion needs a step");
        !quaternions.is_empty()
    };

    /// Returns a solver whose motion starts from `start` with the inputs `u` in each step, such as the torques that hold
    /// the robot still. The inputs have a feedback that keeps the state near `start`.
    #[must_use]
    pub fn new(problem: &P, start: &State<P::Robot>, u: &[f64; NU]) -> Self {
        let guess =
            || Motion { states: [*start; N], inputs: [*u; N], end: *start, cost: f64::INFINITY };
        let mut solver =
            Self { motion: guess(), trial: guess(), gains: [Gain::ZERO; N], damping: 0.0 };
        // The gains do not depend on whether the guess obeys the dynamics; the changes do, and are not applied.
        solver.backward(problem);
        solver.restart(problem, start);
        solver
    }

    /// The present motion.
    pub fn motion(&self) -> &Motion<P::Robot, NU, N> {
        &self.motion
    }

    /// The feedback of each step at the present motion.
    pub fn gains(&self) -> &[Gain<NV, NU>; N] {
        &self.gains
    }

    /// Returns the inputs for a state that is measured within the first step, after the part `share` of the step, which
    /// is 0 at its beginning and 1 at its end.
    pub fn feedback(&self, problem: &P, share: f64, x: &State<P::Robot>) -> [f64; NU] {
        let from = &self.motion.states[0];
        let to = self.motion.states.get(1).unwrap_or(&self.motion.end);
        let dq = P::Robot::difference(&from.q, &to.q).map(|dq| share * dq);
        let qd = core::array::from_fn(|i| from.qd[i] + share * (to.qd[i] - from.qd[i]));
        let nominal = State { q: P::Robot::integrate(&from.q, &dq), qd };
        problem.limits().clamp(&self.inputs(0, &nominal, x, 0.0))
    }

    /// Moves the motion one step ahead. The inputs of the last step are repeated. Call [`restart`](Self::restart) before
    /// the next iteration.
    pub fn advance(&mut self) {
        let Motion { states, inputs, end, .. } = &mut self.motion;
        states.rotate_left(1);
        states[N - 1] = *end;
        inputs.copy_within(1.., 0);
        self.gains.copy_within(1.., 0);
    }

    /// Computes the motion from a measured state, with the feedback of the last iteration, and its cost. Call this
    /// function after each change of the problem.
    pub fn restart(&mut self, problem: &P, measured: &State<P::Robot>) {
        self.roll_out(problem, measured, 0.0);
        core::mem::swap(&mut self.motion, &mut self.trial);
    }

    /// Improves the motion.
    pub fn iterate(&mut self, problem: &P) -> Iteration {
        let promise = loop {
            if let Some(promise) = self.backward(problem) {
                break promise;
            }
            if self.damping > DAMPING[1] {
                return Iteration::Unchanged;
            }
            self.damp();
        };
        if -promise.of(1.0) <= TOLERANCE * self.motion.cost {
            return Iteration::Converged;
        }
        let start = self.motion.states[0];
        let mut length = 1.0;
        for _ in 0..=HALVINGS {
            self.roll_out(problem, &start, length);
            // A cost that is not a number is not accepted.
            if self.trial.cost < self.motion.cost + SUFFICIENT * promise.of(length) {
                core::mem::swap(&mut self.motion, &mut self.trial);
                let damping = self.damping / DAMPING_FACTOR;
                self.damping = if damping < DAMPING[0] { 0.0 } else { damping };
                return Iteration::Improved;
            }
            length *= 0.5;
        }
        self.damp();
        Iteration::Unchanged
    }

    fn damp(&mut self) {
        self.damping = (self.damping * DAMPING_FACTOR).max(DAMPING[0]);
    }

    /// Returns the inputs of step `k` with the feedback of the displacement of a state from the nominal state, and with
    /// the changes of the last backward pass times `length`.
    #[inline(always)]
    fn inputs(
        &self,
        k: usize,
        nominal: &State<P::Robot>,
        x: &State<P::Robot>,
        length: f64,
    ) -> [f64; NU] {
        let gain = &self.gains[k];
        let dq = P::Robot::difference(&nominal.q, &x.q);
        let dqd: [f64; NV] = core::array::from_fn(|i| x.qd[i] - nominal.qd[i]);
        core::array::from_fn(|i| {
            let feedback = dot(&gain.by_q[i], &dq) + dot(&gain.by_qd[i], &dqd);
            self.motion.inputs[k][i] + length * gain.change[i] + feedback
        })
    }

    /// Computes the trial motion from a state.
    fn roll_out(&mut self, problem: &P, start: &State<P::Robot>, length: f64) {
        let limits = problem.limits();
        let mut x = *start;
        let mut cost = 0.0;
        for k in 0..N {
            let u = limits.clamp(&self.inputs(k, &self.motion.states[k], &x, length));
            let step = problem.step(k, &x, &u);
            self.trial.states[k] = x;
            self.trial.inputs[k] = u;
            cost += step.cost;
            x = step.next;
        }
        self.trial.end = x;
        self.trial.cost = cost + problem.end(&x);
    }

    /// Computes the changes and the gains along the motion, from its end; `None` if the linear-quadratic problem needs
    /// more damping.
    fn backward(&mut self, problem: &P) -> Option<Promise> {
        let dt = problem.dt();
        let limits = problem.limits();
        let mut value = StateCost::ZERO;
        problem.linearize_end(&self.motion.end, &mut value);
        let mut knot = Knot::ZERO;
        let mut promise = Promise::default();
        for k in (0..N).rev() {
            let u = &self.motion.inputs[k];
            knot.state = StateCost::ZERO;
            knot.input = InputCost::ZERO;
            problem.linearize(k, &self.motion.states[k], u, &mut knot);
            if Self::FLOATING {
                by_velocities_floating(&mut value, &knot, dt);
            } else {
                by_velocities(&mut value, dt);
            }
            let room = limits.around(u);
            let part = riccati(&mut knot, &mut value, &room, self.damping, &mut self.gains[k])?;
            promise.linear += part.linear;
            promise.quadratic += part.quadratic;
        }
        Some(promise)
    }
}

/// Makes the cost of a state a function of the coordinates before the step and of the velocities after it.
#[inline(always)]
fn by_velocities<const NV: usize>(cost: &mut StateCost<NV>, dt: f64) {
    let StateCost { q, qd, q_q, q_qd, qd_qd } = cost;
    add_scaled(qd, dt, q);
    let qd_q = transposed(q_qd);
    for i in 0..NV {
        add_scaled(&mut q_qd[i], dt, &q_q[i]);
        add_scaled(&mut qd_qd[i], dt, &qd_q[i]);
        add_scaled(&mut qd_qd[i], dt, &q_qd[i]);
    }
}

/// As [`by_velocities`], with a floating base.
#[inline(always)]
fn by_velocities_floating<const NV: usize, const NU: usize>(
    cost: &mut StateCost<NV>,
    knot: &Knot<NV, NU>,
    dt: f64,
) {
    let StateCost { q, qd, q_q, q_qd, qd_qd } = cost;
    let StepDerivatives { dq_dq, dq_dv, .. } = &knot.step;
    add_scaled(qd, dt, &base_vector(q, dq_dv));
    *q = base_vector(q, dq_dq);
    let qd_q = transposed(q_qd);
    for i in 0..NV {
        add_scaled(&mut q_qd[i], dt, &base_vector(&q_q[i], dq_dv));
        add_scaled(&mut qd_qd[i], dt, &base_vector(&qd_q[i], dq_dv));
        q_q[i] = base_vector(&q_q[i], dq_dq);
    }
    let rows = base_rows(q_qd, dq_dv);
    for i in 0..NV {
        add_scaled(&mut qd_qd[i], dt, if i < 6 { &rows[i] } else { &q_qd[i] });
    }
    let rows = base_rows(q_qd, dq_dq);
    q_qd[..6].copy_from_slice(&rows);
    let rows = base_rows(q_q, dq_dq);
    q_q[..6].copy_from_slice(&rows);
}

/// Returns the vector times the block-diagonal matrix of `base` and ones.
#[inline(always)]
fn base_vector<const NV: usize>(x: &[f64; NV], base: &Matrix<6, 6>) -> [f64; NV] {
    let mut head = [0.0; 6];
    for (x, row) in x.iter().zip(base) {
        add_scaled(&mut head, *x, row);
    }
    let mut product = *x;
    product[..6].copy_from_slice(&head);
    product
}

/// Returns the first six rows of the product of the transposed block-diagonal matrix and `m`.
#[inline(always)]
fn base_rows<const NV: usize>(m: &Matrix<NV, NV>, base: &Matrix<6, 6>) -> Matrix<6, NV> {
    let mut rows = [[0.0; NV]; 6];
    for (m, base) in m.iter().zip(base) {
        for (row, factor) in rows.iter_mut().zip(base) {
            add_scaled(row, *factor, m);
        }
    }
    rows
}

/// A step of the Riccati recursion. `value` is the cost from the next state on, as a function of the coordinates before
/// the step and of the velocities after it; it becomes the cost from the state before the step on. The costs of the knot
/// are lost.
#[inline(never)]
fn riccati<const NV: usize, const NU: usize>(
    knot: &mut Knot<NV, NU>,
    value: &mut StateCost<NV>,
    limits: &Limits<NU>,
    damping: f64,
    gain: &mut Gain<NV, NU>,
) -> Option<Promise> {
    let Knot { step, state: cost, input } = knot;
    let StepDerivatives { dqd_dq: by_q, dqd_dqd: by_qd, dqd_du: by_u, .. } = step;

    // The Hessian with respect to the velocities after the step, times the derivatives of these velocities.
    let mut hessian_q = [[0.0; NV]; NV];
    add_transposed_product(&mut hessian_q, &value.qd_qd, by_q);
    let mut hessian_qd = [[0.0; NV]; NV];
    add_transposed_product(&mut hessian_qd, &value.qd_qd, by_qd);
    let mut hessian_u = [[0.0; NU]; NV];
    add_transposed_product(&mut hessian_u, &value.qd_qd, by_u);
    // Half of the first product and all of it, with the second derivatives of velocities and coordinates.
    let mut half = transposed(&value.q_qd);
    let mut whole = half;
    for i in 0..NV {
        add_scaled(&mut half[i], 0.5, &hessian_q[i]);
        add_scaled(&mut whole[i], 1.0, &hessian_q[i]);
    }

    // The cost as a function of the state before the step and of the inputs.
    add_scaled(&mut cost.q, 1.0, &value.q);
    add_transposed_vector(&mut cost.q, by_q, &value.qd);
    add_transposed_vector(&mut cost.qd, by_qd, &value.qd);
    add_transposed_product(&mut cost.q_qd, &whole, by_qd);
    add_transposed_product(&mut cost.qd_qd, by_qd, &hessian_qd);
    let mut product = [[0.0; NV]; NV];
    add_transposed_product(&mut product, &half, by_q);
    let opposite = transposed(&product);
    for i in 0..NV {
        for row in [&product[i], &opposite[i], &value.q_q[i]] {
            add_scaled(&mut cost.q_q[i], 1.0, row);
        }
    }
    let InputCost { u: gradient, u_q, u_qd, u_u } = input;
    add_transposed_vector(gradient, by_u, &value.qd);
    add_transposed_product(u_q, by_u, &whole);
    add_transposed_product(u_qd, by_u, &hessian_qd);
    add_transposed_product(u_u, by_u, &hessian_u);
    mirror(u_u);

    // The best change of the inputs, and the cost with the change.
    let quadratic = Quadratic { hessian: u_u, gradient, damping };
    let Minimum { change, factor } = quadratic.minimum(limits, &gain.change)?;
    gain.change = change;
    add_transposed_vector(&mut cost.q, u_q, &change);
    add_transposed_vector(&mut cost.qd, u_qd, &change);

    // Its feedback, and the cost with the feedback.
    factor.solve_lower(u_q);
    factor.solve_lower(u_qd);
    gain.by_q = factor.minus_divided(u_q);
    gain.by_qd = factor.minus_divided(u_qd);
    add_transposed_product(&mut cost.q_q, &gain.by_q, u_q);
    add_transposed_product(&mut cost.q_qd, &gain.by_q, u_qd);
    add_transposed_product(&mut cost.qd_qd, &gain.by_qd, u_qd);
    mirror(&mut cost.q_q);
    mirror(&mut cost.qd_qd);
    *value = *cost;
    factor.solve_upper(&mut gain.by_q);
    factor.solve_upper(&mut gain.by_qd);
    let curvature: f64 = u_u.iter().zip(&change).map(|(row, x)| x * dot(row, &change)).sum();
    Some(Promise { linear: dot(gradient, &change), quadratic: 0.5 * curvature })
}
