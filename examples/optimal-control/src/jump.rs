//! A floating quadruped jumps: a problem for [`ilqr`](crate::ilqr) with contacts that are active in the first steps.
//!
//! The derivatives of a step of semi-implicit Euler come from a knot: with contacts while the feet stand, without them in
//! the air. The sequence of contacts is given, the forces are not: a residual keeps each foot's force within its friction
//! cone, with the derivatives of the forces.

use core::ops::Range;

use modyn::na::{DMatrix, DVector};
use modyn::simulate::State;

use crate::ilqr::{LinearStep, Problem, Solution, Step};
use crate::problems::move_on_ground;
use crate::robots::{Quadruped, QuadrupedContacts, Settings, TORQUE_LIMIT};
use crate::tangent::{difference, matrix};

/// The problem: from a state, stand for some steps, fly for the others, and be at a posture at the end.
pub(crate) struct Jump {
    /// The state at the beginning, with the feet on the ground.
    pub(crate) start: State<Quadruped>,
    /// The coordinates at the end.
    pub(crate) goal: [f64; 19],
    /// The number of steps with the feet on the ground.
    pub(crate) standing: usize,
    /// The time step, s.
    pub(crate) dt: f64,
}

/// The number of degrees of freedom, and that of motors, which follow the six of the base.
const NV: usize = Quadruped::NV;
const MOTORS: usize = NV - 6;
/// The coefficient of friction that the plan may use.
pub(crate) const FRICTION: f64 = 0.6;
/// The distance to the faces of the friction cone below which a force has a cost, N.
const MARGIN: f64 = 0.5;
/// The faces of a pyramid inside the friction cone: a force whose products with these vectors are negative is within it.
const FACES: [[f64; 3]; 4] = {
    let normal = -FRICTION * core::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0, normal], [-1.0, 0.0, normal], [0.0, 1.0, normal], [0.0, -1.0, normal]]
};

// The factors of the residuals.
/// Of a torque, 1/(N m).
const EFFORT: f64 = 0.03;
/// Of the part of a torque beyond [`FREE`], 1/(N m).
const EXCESS: f64 = 3.0;
/// The torque without further cost, N m.
const FREE: f64 = 0.9 * TORQUE_LIMIT;
/// Of a joint's velocity, s/rad.
const SPEED: f64 = 0.01;
/// Of the part of a force beyond a face of the friction cone, 1/N.
const SLIP: f64 = 0.3;
/// Of the last displacement from the goal: of the base's position (1/m) and rotation, and of the joints (1/rad).
const GOAL: [f64; 3] = [100.0, 50.0, 3.0];
/// Of the last velocities.
const REST: f64 = 0.3;

/// The rows of the residuals of a step: torques, their excess, velocities of joints, faces of friction cones.
const ROWS: [Range<usize>; 4] = [
    0..MOTORS,
    MOTORS..2 * MOTORS,
    2 * MOTORS..3 * MOTORS,
    3 * MOTORS..3 * MOTORS + 4 * FACES.len(),
];

impl Jump {
    /// Returns the torques of the joints, with zeros for the base, which has no motor.
    pub(crate) fn tau(u: &DVector<f64>) -> [f64; NV] {
        core::array::from_fn(|i| if i < 6 { 0.0 } else { u[i - 6] })
    }

    /// Returns the residuals of a step; `forces` are those of the ground on the feet, N, in world axes.
    fn residuals(x: &State<Quadruped>, u: &DVector<f64>, forces: &[[f64; 3]; 4]) -> DVector<f64> {
        let mut residuals = DVector::zeros(ROWS[3].end);
        for i in 0..MOTORS {
            residuals[ROWS[0].start + i] = EFFORT * u[i];
            residuals[ROWS[1].start + i] = EXCESS * (u[i] - u[i].clamp(-FREE, FREE));
            residuals[ROWS[2].start + i] = SPEED * x.qd[6 + i];
        }
        for (k, force) in forces.iter().enumerate() {
            for (face, normal) in FACES.iter().enumerate() {
                let beyond = (dot(normal, force) + MARGIN).max(0.0);
                residuals[ROWS[3].start + FACES.len() * k + face] = SLIP * beyond;
            }
        }
        residuals
    }
}

/// Returns the last state of a planned jump with its feedback, on ground that the plan does not know.
pub(crate) fn simulate(problem: &Jump, plan: &Solution<Quadruped>) -> State<Quadruped> {
    let mut x = problem.start;
    for (k, u) in plan.inputs.iter().enumerate() {
        let u = u + &plan.gains[k] * difference(&plan.states[k], &x);
        x = move_on_ground(&x, problem.dt, &Jump::tau(&u)).state;
    }
    x
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Problem for Jump {
    type Robot = Quadruped;

    fn start(&self) -> State<Quadruped> {
        self.start
    }

    fn step(&self, k: usize, x: &State<Quadruped>, u: &DVector<f64>) -> Step<Quadruped> {
        let (tau, dt) = (Self::tau(u), self.dt);
        if k >= self.standing {
            let next = Quadruped::step_semi_implicit(&x.q, &x.qd, &tau, dt);
            let residuals = Self::residuals(x, u, &NO_FORCES);
            return Step { next: State { q: next.q, qd: next.qd }, residuals };
        }
        let contacts = QuadrupedContacts::ALL;
        let found = Quadruped::constrained_forward_dynamics(
            &x.q,
            &x.qd,
            &tau,
            contacts,
            &Settings::DEFAULT,
        );
        let residuals = Self::residuals(x, u, &found.wrenches.map(|wrench| wrench.force.0));
        Step { next: x.semi_implicit_euler(dt, |_| found.qdd), residuals }
    }

    fn linearize(&self, k: usize, x: &State<Quadruped>, u: &DVector<f64>) -> LinearStep {
        let (tau, dt) = (Self::tau(u), self.dt);
        let rows = ROWS[3].end;
        let mut by_state = DMatrix::zeros(rows, 2 * NV);
        let mut by_input = DMatrix::zeros(rows, MOTORS);
        for i in 0..MOTORS {
            by_input[(ROWS[0].start + i, i)] = EFFORT;
            by_input[(ROWS[1].start + i, i)] = if u[i].abs() > FREE { EXCESS } else { 0.0 };
            by_state[(ROWS[2].start + i, NV + 6 + i)] = SPEED;
        }
        if k >= self.standing {
            let knot = Quadruped::knot(&x.q, &x.qd, &tau, dt);
            let [a, b] = state_matrices(&knot, dt);
            let residuals = Self::residuals(x, u, &NO_FORCES);
            return LinearStep { a, b, residuals, by_state, by_input };
        }

        let found = Quadruped::constrained_knot(
            &x.q,
            &x.qd,
            &tau,
            dt,
            QuadrupedContacts::ALL,
            &Settings::DEFAULT,
        );
        let [a, b] = state_matrices(&found.knot(), dt);
        let residuals = Self::residuals(x, u, &found.wrenches.map(|wrench| wrench.force.0));
        for foot in 0..4 {
            for (face, normal) in FACES.iter().enumerate() {
                let row = ROWS[3].start + FACES.len() * foot + face;
                if residuals[row] == 0.0 {
                    continue;
                }
                for j in 0..NV {
                    let slope = |by: &[[modyn::Wrench<f64>; NV]; 4]| {
                        SLIP * dot(normal, &by[foot][j].force.0)
                    };
                    by_state[(row, j)] = slope(&found.dwrenches_dq);
                    by_state[(row, NV + j)] = slope(&found.dwrenches_dqd);
                    if j >= 6 {
                        by_input[(row, j - 6)] = slope(&found.dwrenches_dtau);
                    }
                }
            }
        }
        LinearStep { a, b, residuals, by_state, by_input }
    }

    fn end(&self, x: &State<Quadruped>) -> DVector<f64> {
        difference(&State::at_rest(self.goal), x).component_mul(&end_factors())
    }

    fn linearize_end(&self, x: &State<Quadruped>) -> DMatrix<f64> {
        let mut derivative = DMatrix::identity(2 * NV, 2 * NV);
        let by_coordinates = Quadruped::difference_derivatives(&self.goal, &x.q).dv_dto;
        derivative.view_mut((0, 0), (NV, NV)).copy_from(&matrix(&by_coordinates));
        DMatrix::from_diagonal(&end_factors()) * derivative
    }
}

/// A knot of the quadruped: its base has one quaternion.
type Knot = modyn::Knot<[f64; NV], [[f64; NV]; NV], [[[f64; 6]; 6]; 1]>;

/// Returns A and B of a step with this knot. The displacement of q after the step is J_q times the displacement before it,
/// plus dt J_v times the change of the velocities. J_q and J_v differ from 1 at the base only.
fn state_matrices(knot: &Knot, dt: f64) -> [DMatrix<f64>; 2] {
    let velocities = DMatrix::from_fn(NV, 2 * NV + MOTORS, |i, j| match j {
        0..NV => knot.dqd_dq[i][j],
        _ if j < 2 * NV => knot.dqd_dqd[i][j - NV],
        _ => knot.dqd_dtau[i][6 + j - 2 * NV],
    });
    let mut coordinates = &velocities * dt;
    let [[j_q], [j_v]] = [knot.dq_dq, knot.dq_dv];
    let base = DMatrix::from_fn(6, 6, |i, j| j_v[i][j]) * coordinates.rows(0, 6);
    coordinates.rows_mut(0, 6).copy_from(&base);
    for i in 0..6 {
        (0..6).for_each(|j| coordinates[(i, j)] += j_q[i][j]);
    }
    (6..NV).for_each(|i| coordinates[(i, i)] += 1.0);
    let both = [coordinates, velocities];
    let stacked = |first: usize, columns: usize| {
        DMatrix::from_fn(2 * NV, columns, |i, j| both[i / NV][(i % NV, first + j)])
    };
    [stacked(0, 2 * NV), stacked(2 * NV, MOTORS)]
}

/// The forces on the feet in the air: far within the friction cone, so that they cost nothing.
const NO_FORCES: [[f64; 3]; 4] = [[0.0, 0.0, 1e3]; 4];

/// Returns the factors of the last residuals.
fn end_factors() -> DVector<f64> {
    DVector::from_fn(2 * NV, |i, _| match i {
        0..3 => GOAL[0],
        3..6 => GOAL[1],
        6..NV => GOAL[2],
        _ => REST,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ilqr::{Options, check_derivatives, solve};
    use crate::problems::{jump, stand};
    use crate::tangent::moved;

    #[test]
    fn derivatives_are_those_of_differences() {
        let problem = jump();
        let by = DVector::from_fn(36, |i, _| 0.3 * (3.0 * i as f64 + 1.0).sin());
        let x = moved(&problem.start, &by);
        let u = DVector::from_fn(12, |i, _| 3.0 * (5.0 * i as f64).cos());
        for k in [0, problem.standing] {
            check_derivatives(&problem, k, &x, &u);
        }
    }

    #[test]
    fn the_base_reaches_its_goal_in_the_air() {
        let problem = jump();
        let solution = solve(&problem, stand(&problem), &Options::default());
        assert!(solution.converged, "{:?}", solution.costs);
        assert!(solution.costs.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", solution.costs);
        let last = &solution.states[solution.inputs.len()];
        let error = Quadruped::difference(&problem.goal, &last.q);
        assert!(error[..3].iter().all(|x| x.abs() < 5e-3), "{error:?}");
        assert!(error[3..6].iter().all(|x| x.abs() < 1e-2), "{error:?}");
        for (k, (x, u)) in solution.states.iter().zip(&solution.inputs).enumerate() {
            assert!(u.amax() < TORQUE_LIMIT, "{k}: {u}");
            if k < problem.standing {
                let tau = Jump::tau(u);
                let contacts = QuadrupedContacts::ALL;
                let found = Quadruped::constrained_forward_dynamics(
                    &x.q,
                    &x.qd,
                    &tau,
                    contacts,
                    &Settings::DEFAULT,
                );
                for [x, y, z] in found.wrenches.map(|wrench| wrench.force.0) {
                    assert!(z > 0.0 && x.hypot(y) < FRICTION * z, "{k}: {x} {y} {z}");
                }
            }
        }
        let simulated = simulate(&problem, &solution);
        let error = Quadruped::difference(&problem.goal, &simulated.q);
        assert!(error[..6].iter().all(|x| x.abs() < 0.03), "{error:?}");
    }
}
