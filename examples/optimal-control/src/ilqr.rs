//! iLQR: trajectory optimization by linear-quadratic problems, for any robot.
//!
//! The cost of a motion is half of the sum of its squared residuals. An iteration linearizes the time steps and the
//! residuals along the motion. The backward pass solves the linear-quadratic problem that results, and returns a change
//! of the inputs and a feedback gain for each step. The forward pass applies them with a line search, so the cost falls
//! in every iteration.
//!
//! - Li and Todorov 2004, "Iterative linear quadratic regulator design for nonlinear biological movement systems": the
//!   method, which is differential dynamic programming (Mayne 1966) with the Hessians of Gauss and Newton.
//! - Tassa, Erez and Todorov 2012, "Synthesis and stabilization of complex behaviors through online trajectory
//!   optimization": the regularization and the line search used here.
//!
//! States are displaced in tangent space ([`tangent`](crate::tangent)), so floating bases need no special treatment.

use modyn::na::{Cholesky, DMatrix, DVector};
use modyn::simulate::State;
use modyn::{Robot, functions};

use crate::tangent;

/// A problem of optimal control with a fixed number of steps.
pub(crate) trait Problem {
    /// The robot that moves.
    type Robot: Robot + functions::Difference;

    /// Returns the state at the beginning.
    fn start(&self) -> State<Self::Robot>;

    /// Returns the state after step `k` with the inputs `u`, and the residuals of the step.
    fn step(&self, k: usize, x: &State<Self::Robot>, u: &DVector<f64>) -> Step<Self::Robot>;

    /// Returns the derivatives of [`step`](Self::step).
    fn linearize(&self, k: usize, x: &State<Self::Robot>, u: &DVector<f64>) -> LinearStep;

    /// Returns the residuals of the last state.
    fn end(&self, x: &State<Self::Robot>) -> DVector<f64>;

    /// Returns the derivative of [`end`](Self::end) with respect to the state, in tangent space.
    fn linearize_end(&self, x: &State<Self::Robot>) -> DMatrix<f64>;
}

/// A time step and its cost.
pub(crate) struct Step<R: Robot> {
    /// The state after the step.
    pub(crate) next: State<R>,
    /// The residuals: the cost of the step is half of the sum of their squares.
    pub(crate) residuals: DVector<f64>,
}

/// The derivatives of a time step. States are displaced in tangent space.
pub(crate) struct LinearStep {
    /// The derivative of the state after the step with respect to the state before.
    pub(crate) a: DMatrix<f64>,
    /// The derivative of the state after the step with respect to the inputs.
    pub(crate) b: DMatrix<f64>,
    /// The residuals.
    pub(crate) residuals: DVector<f64>,
    /// The derivative of the residuals with respect to the state before.
    pub(crate) by_state: DMatrix<f64>,
    /// The derivative of the residuals with respect to the inputs.
    pub(crate) by_input: DMatrix<f64>,
}

/// When the iterations end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// The greatest number of iterations.
    pub(crate) iterations: usize,
    /// The iterations have converged when the linear-quadratic problem promises a decrease below this part of the cost.
    pub(crate) tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { iterations: 200, tolerance: 1e-6 }
    }
}

/// A motion, and how it was found.
pub(crate) struct Solution<R: Robot> {
    /// The states: one more than inputs.
    pub(crate) states: Vec<State<R>>,
    /// The inputs of each step.
    pub(crate) inputs: Vec<DVector<f64>>,
    /// The feedback gain of each step, from displacements of the state to inputs.
    pub(crate) gains: Vec<DMatrix<f64>>,
    /// The cost at the beginning and after each iteration that lowered it.
    pub(crate) costs: Vec<f64>,
    /// The number of backward passes.
    pub(crate) iterations: usize,
    /// Whether the iterations converged.
    pub(crate) converged: bool,
}

/// The smallest regularization other than zero, and the one at which the method gives up.
const DAMPING: [f64; 2] = [1e-6, 1e10];
/// The factor of the regularization after a step that failed, and its inverse after one that succeeded.
const DAMPING_FACTOR: f64 = 8.0;
/// The halvings of the line search.
const HALVINGS: i32 = 10;
/// The part of the promised decrease that a step must reach.
const SUFFICIENT: f64 = 1e-4;

/// Returns the motion with the least cost that the method finds from the motion of these inputs.
pub(crate) fn solve<P: Problem>(
    problem: &P,
    inputs: Vec<DVector<f64>>,
    options: &Options,
) -> Solution<P::Robot> {
    let mut motion = roll_out(problem, &[problem.start()], &inputs, None);
    let mut solution = Solution {
        states: vec![],
        inputs: vec![],
        gains: vec![],
        costs: vec![motion.cost],
        iterations: 0,
        converged: false,
    };
    let (mut linear, mut damping) = (linearize(problem, &motion), 0.0);
    while solution.iterations < options.iterations {
        solution.iterations += 1;
        let mut better = None;
        if let Some(plan) = backward(&linear, damping) {
            // A cost of zero has converged, too.
            solution.converged = -plan.change(1.0) <= options.tolerance * motion.cost;
            if !solution.converged {
                better = forward(problem, &motion, &plan);
            }
            solution.gains = plan.gains;
        }
        if let Some(better) = better {
            motion = better;
            solution.costs.push(motion.cost);
            linear = linearize(problem, &motion);
            damping = if damping > DAMPING[0] { damping / DAMPING_FACTOR } else { 0.0 };
        } else {
            damping = DAMPING[0].max(damping * DAMPING_FACTOR);
        }
        if solution.converged || damping > DAMPING[1] {
            break;
        }
    }
    Solution { states: motion.states, inputs: motion.inputs, ..solution }
}

/// A motion with its cost.
struct Motion<R: Robot> {
    states: Vec<State<R>>,
    inputs: Vec<DVector<f64>>,
    cost: f64,
}

/// Returns the motion of `inputs`; with a plan, of the inputs that the plan adds at displacements from `states`, with
/// its changes times a factor.
fn roll_out<P: Problem>(
    problem: &P,
    states: &[State<P::Robot>],
    inputs: &[DVector<f64>],
    plan: Option<(&Plan, f64)>,
) -> Motion<P::Robot> {
    let mut x = problem.start();
    let mut motion = Motion { states: vec![x], inputs: vec![], cost: 0.0 };
    for (k, nominal) in inputs.iter().enumerate() {
        let mut u = nominal.clone();
        if let Some((plan, length)) = plan {
            let away = tangent::difference(&states[k], &x);
            u += &plan.changes[k] * length + &plan.gains[k] * away;
        }
        let step = problem.step(k, &x, &u);
        x = step.next;
        motion.cost += 0.5 * step.residuals.norm_squared();
        motion.states.push(x);
        motion.inputs.push(u);
    }
    motion.cost += 0.5 * problem.end(&x).norm_squared();
    motion
}

/// The derivatives along a motion.
struct Linear {
    steps: Vec<LinearStep>,
    end: DVector<f64>,
    end_by_state: DMatrix<f64>,
}

fn linearize<P: Problem>(problem: &P, motion: &Motion<P::Robot>) -> Linear {
    let last = &motion.states[motion.inputs.len()];
    let steps = motion.states.iter().zip(&motion.inputs).enumerate();
    Linear {
        steps: steps.map(|(k, (x, u))| problem.linearize(k, x, u)).collect(),
        end: problem.end(last),
        end_by_state: problem.linearize_end(last),
    }
}

/// The solution of the linear-quadratic problem.
struct Plan {
    changes: Vec<DVector<f64>>,
    gains: Vec<DMatrix<f64>>,
    /// The coefficients of the change of the cost in powers of the length of the step.
    decrease: [f64; 2],
}

impl Plan {
    /// Returns the change of the cost that the linear-quadratic problem promises for a step of this length.
    fn change(&self, length: f64) -> f64 {
        length * (self.decrease[0] + length * self.decrease[1])
    }
}

/// Returns the solution of the linear-quadratic problem; `None` if a Hessian by the inputs is not positive definite.
///
/// `damping` is a cost of the squared displacement of the states from the motion (Tassa et al. 2012, eq. 10). It is a
/// part of the gains, and not of the value function.
fn backward(linear: &Linear, damping: f64) -> Option<Plan> {
    let count = linear.steps.len();
    let mut plan = Plan {
        changes: Vec::with_capacity(count),
        gains: Vec::with_capacity(count),
        decrease: [0.0; 2],
    };
    // The gradient and the Hessian of the cost from here to the end.
    let mut gradient = linear.end_by_state.tr_mul(&linear.end);
    let mut hessian = linear.end_by_state.tr_mul(&linear.end_by_state);
    for LinearStep { a, b, residuals, by_state, by_input } in linear.steps.iter().rev() {
        // Products of matrices run fastest as plain products; `tr_mul` is for vectors.
        let (to_a, to_b) = (a.transpose(), b.transpose());
        let hessian_a = &hessian * a;
        let x = by_state.tr_mul(residuals) + a.tr_mul(&gradient);
        let u = by_input.tr_mul(residuals) + b.tr_mul(&gradient);
        let xx = by_state.transpose() * by_state + &to_a * &hessian_a;
        let ux = by_input.transpose() * by_state + &to_b * hessian_a;
        let uu = by_input.transpose() * by_input + &to_b * &hessian * b;
        let (change, gain) = if damping > 0.0 {
            let damped = Cholesky::new(&uu + &to_b * b * damping)?;
            (-damped.solve(&u), -damped.solve(&(&ux + &to_b * a * damping)))
        } else {
            let factors = Cholesky::new(uu.clone())?;
            (-factors.solve(&u), -factors.solve(&ux))
        };
        let curvature = &uu * &change;
        plan.decrease[0] += change.dot(&u);
        plan.decrease[1] += 0.5 * change.dot(&curvature);
        gradient = x + gain.tr_mul(&(curvature + u)) + ux.tr_mul(&change);
        hessian = xx + gain.transpose() * (uu * &gain + &ux) + ux.transpose() * &gain;
        hessian = (&hessian + hessian.transpose()) * 0.5;
        plan.changes.push(change);
        plan.gains.push(gain);
    }
    plan.changes.reverse();
    plan.gains.reverse();
    Some(plan)
}

/// Returns the motion of the longest step that lowers the cost enough; `None` if no step does.
fn forward<P: Problem>(
    problem: &P,
    motion: &Motion<P::Robot>,
    plan: &Plan,
) -> Option<Motion<P::Robot>> {
    (0..=HALVINGS).find_map(|halvings| {
        let length = 0.5_f64.powi(halvings);
        let found = roll_out(problem, &motion.states, &motion.inputs, Some((plan, length)));
        // A cost that is not a number lowers nothing.
        (found.cost < motion.cost + SUFFICIENT * plan.change(length)).then_some(found)
    })
}

/// Compares the derivatives of step `k` and of the last state's residuals with differences of second order.
#[cfg(test)]
pub(crate) fn check_derivatives<P: Problem>(
    problem: &P,
    k: usize,
    x: &State<P::Robot>,
    u: &DVector<f64>,
) where
    P::Robot: functions::Integrate,
{
    const SMALL: f64 = 1e-6;
    let linear = problem.linearize(k, x, u);
    let at = problem.step(k, x, u);
    assert!((&linear.residuals - &at.residuals).amax() < 1e-10);
    let compare =
        |name: &str, found: [modyn::na::DVectorView<'_, f64>; 2], plus: Step<_>, minus: Step<_>| {
            let next = tangent::difference(&at.next, &plus.next)
                - tangent::difference(&at.next, &minus.next);
            let residuals = plus.residuals - minus.residuals;
            for (found, expected) in found.into_iter().zip([next, residuals]) {
                let expected = expected / (2.0 * SMALL);
                let error = (found - &expected).amax() / expected.amax().max(1.0);
                assert!(error < 1e-6, "step {k}, {name}: {error:e}, {found} instead of {expected}");
            }
        };
    let columns =
        |j: usize, size: usize| DVector::from_fn(size, |i, _| if i == j { SMALL } else { 0.0 });
    let end = problem.linearize_end(x);
    for j in 0..linear.a.ncols() {
        let by = columns(j, linear.a.ncols());
        let [plus, minus] = [&by, &-&by].map(|by| tangent::moved(x, by));
        let found = [linear.a.column(j), linear.by_state.column(j)];
        compare("state", found, problem.step(k, &plus, u), problem.step(k, &minus, u));
        let expected = (problem.end(&plus) - problem.end(&minus)) / (2.0 * SMALL);
        let error = (end.column(j) - &expected).amax() / expected.amax().max(1.0);
        assert!(error < 1e-6, "end: {error:e}");
    }
    for j in 0..linear.b.ncols() {
        let by = columns(j, linear.b.ncols());
        let found = [linear.b.column(j), linear.by_input.column(j)];
        compare("input", found, problem.step(k, x, &(u + &by)), problem.step(k, x, &(u - &by)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lqr::Regulator;
    use crate::problems::{WEIGHTS, regulator};
    use crate::robots::Arm;

    /// The arm stays where a regulator keeps it: the cost is the regulator's.
    struct Stay(Regulator<Arm>);

    impl Stay {
        /// The factors of the residuals: displacements, velocities, torques.
        fn factors() -> [DVector<f64>; 2] {
            let square = |i| if i < 7 { WEIGHTS.displacement } else { WEIGHTS.velocity };
            let of_state = DVector::from_fn(14, |i, _| f64::sqrt(square(i)));
            let of_input =
                DVector::from_fn(7, |i, _| WEIGHTS.effort.sqrt() / Arm::LIMITS.effort[i]);
            [of_state, of_input]
        }
    }

    impl Problem for Stay {
        type Robot = Arm;

        fn start(&self) -> State<Arm> {
            self.0.rest
        }

        fn step(&self, _: usize, x: &State<Arm>, u: &DVector<f64>) -> Step<Arm> {
            let next = Arm::step_semi_implicit(&x.q, &x.qd, &core::array::from_fn(|i| u[i]), 0.01);
            let [of_state, of_input] = Self::factors();
            let away = tangent::difference(&self.0.rest, x).component_mul(&of_state);
            let effort = (u - DVector::from_column_slice(&self.0.tau)).component_mul(&of_input);
            let residuals = DVector::from_iterator(21, away.iter().chain(effort.iter()).copied());
            Step { next: State { q: next.q, qd: next.qd }, residuals }
        }

        fn linearize(&self, k: usize, x: &State<Arm>, u: &DVector<f64>) -> LinearStep {
            let tau = core::array::from_fn(|i| u[i]);
            let found = Arm::step_semi_implicit_derivatives(&x.q, &x.qd, &tau, 0.01);
            let [of_state, of_input] =
                Self::factors().map(|factors| DMatrix::from_diagonal(&factors));
            let (mut by_state, mut by_input) = (DMatrix::zeros(21, 14), DMatrix::zeros(21, 7));
            by_state.rows_mut(0, 14).copy_from(&of_state);
            by_input.rows_mut(14, 7).copy_from(&of_input);
            let residuals = self.step(k, x, u).residuals;
            let (a, b) = (tangent::matrix(&found.a), tangent::matrix(&found.b));
            LinearStep { a, b, residuals, by_state, by_input }
        }

        fn end(&self, x: &State<Arm>) -> DVector<f64> {
            tangent::difference(&self.0.rest, x)
        }

        fn linearize_end(&self, _: &State<Arm>) -> DMatrix<f64> {
            DMatrix::identity(14, 14)
        }
    }

    /// Far from the end, the feedback gain is that of the linear-quadratic regulator, which another recursion computes.
    #[test]
    fn gains_are_those_of_the_regulator() {
        let problem = Stay(regulator());
        let inputs = vec![DVector::from_column_slice(&problem.0.tau); 200];
        // One backward pass: the motion is the best already, but for rounding errors.
        let solution = solve(&problem, inputs, &Options { iterations: 1, ..Options::default() });
        let expected = &problem.0.gain;
        let error = (&solution.gains[0] + expected).amax() / expected.amax();
        assert!(error < 1e-8, "{error:e}");
        assert!((&solution.gains[199] + expected).amax() > 0.01 * expected.amax());
    }
}
