//! A whole-body controller: joint torques of a floating quadruped on its feet, by a quadratic program in each step.
//!
//! The unknowns are the accelerations qdd and the forces f on the feet. The program minimizes the squared error of the
//! base's acceleration, plus small weights on joint accelerations and forces, subject to
//!
//! ```text
//! M qdd + h - J^T f = 0                  in the rows of the base, which has no motor
//! J qdd + dJ/dt qd = -d J qd             the feet do not accelerate, and lose their speed
//! |f_x|, |f_y| <= friction / sqrt(2) f_z, f_z >= a least force     pyramids inside the friction cones
//! |M qdd + h - J^T f| <= limit           in the rows of the joints: their torques
//! ```
//!
//! The solver is Clarabel (Goulart and Chen 2024, "Clarabel: an interior-point solver for conic programs with quadratic
//! objectives"). The formulation is that of Escande, Mansard and Wieber 2014 ("Hierarchical quadratic programming") and
//! Herzog et al. 2016 ("Momentum control with hierarchical inverse dynamics on a torque-controlled humanoid") with weights
//! in place of a hierarchy.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver as _, NonnegativeConeT, SolverStatus, ZeroConeT,
};
use modyn::na::{DMatrix, DVector};
use modyn::simulate::{Gains, Reference, State};

use crate::robots::{Quadruped, TORQUE_LIMIT};
use crate::tangent::matrix;

/// The coefficient of friction that the controller may use.
pub(crate) const FRICTION: f64 = 0.6;
/// The least normal force on a foot, N.
pub(crate) const LEAST_FORCE: f64 = 0.5;
/// The rate at which a foot loses its speed, 1/s.
const FOOT_DAMPING: f64 = 20.0;
/// The weights of the squared joint accelerations and forces; that of the base's acceleration is 1.
const WEIGHTS: [f64; 2] = [1e-6, 1e-4];

/// The number of degrees of freedom, of unknowns, and of equations.
const NV: usize = Quadruped::NV;
const UNKNOWNS: usize = NV + 12;
const EQUATIONS: usize = 6 + 12;
/// The faces of a friction pyramid and the least force: five rows a foot. Then the upper and the lower torque limits.
const INEQUALITIES: usize = 4 * 5 + 2 * (NV - 6);

/// The result of the program.
pub(crate) struct Command {
    /// The joint forces, N m: zero for the base.
    pub(crate) tau: [f64; NV],
    /// The forces on the feet, N, in world axes.
    pub(crate) forces: [[f64; 3]; 4],
    /// The iterations of the solver.
    pub(crate) iterations: u32,
}

/// Returns the joint forces with which the base follows `reference`.
///
/// # Errors
///
/// Returns the solver's status if there is no solution: for example, if no torques within the limits hold the feet.
pub(crate) fn command(
    state: &State<Quadruped>,
    reference: &Reference<Quadruped>,
    gains: Gains,
) -> Result<Command, SolverStatus> {
    let (q, qd) = (&state.q, &state.qd);
    let mass = matrix(&Quadruped::mass_matrix(q));
    let bias = DVector::from_column_slice(&Quadruped::bias_forces(q, qd));
    let columns = Quadruped::constraint_jacobian(q);
    let jacobian = DMatrix::from_fn(12, NV, |row, j| columns[row / 3][j].linear[row % 3]);
    let jacobian_dot_qd = Quadruped::constraint_jacobian_dot_qd(q, qd);
    let jacobian_dot_qd = DVector::from_fn(12, |row, _| jacobian_dot_qd[row / 3].linear[row % 3]);
    let speed = &jacobian * DVector::from_column_slice(qd);

    // The joint forces are (M, -J^T) (qdd, f) + h.
    let mut dynamics = DMatrix::zeros(NV, UNKNOWNS);
    dynamics.columns_mut(0, NV).copy_from(&mass);
    dynamics.columns_mut(NV, 12).copy_from(&-jacobian.transpose());

    // Rows of A x + s = b with s = 0 for equations and s >= 0 for inequalities.
    let mut a = DMatrix::zeros(EQUATIONS + INEQUALITIES, UNKNOWNS);
    let mut b = DVector::zeros(EQUATIONS + INEQUALITIES);
    a.rows_mut(0, 6).copy_from(&dynamics.rows(0, 6));
    b.rows_mut(0, 6).copy_from(&-bias.rows(0, 6));
    a.view_mut((6, 0), (12, NV)).copy_from(&jacobian);
    b.rows_mut(6, 12).copy_from(&-(jacobian_dot_qd + speed * FOOT_DAMPING));
    for foot in 0..4 {
        let (row, force) = (EQUATIONS + 5 * foot, NV + 3 * foot);
        for (face, sign) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
            a[(row + face, force + face / 2)] = sign;
            a[(row + face, force + 2)] = -FRICTION * core::f64::consts::FRAC_1_SQRT_2;
        }
        a[(row + 4, force + 2)] = -1.0;
        b[row + 4] = -LEAST_FORCE;
    }
    let joints = NV - 6;
    for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
        let row = EQUATIONS + 20 + k * joints;
        a.rows_mut(row, joints).copy_from(&(dynamics.rows(6, joints) * sign));
        let room = bias.rows(6, joints).map(|h| TORQUE_LIMIT - sign * h);
        b.rows_mut(row, joints).copy_from(&room);
    }

    // The objective x^T P x / 2 + g^T x.
    let desired = accelerations(state, reference, gains);
    let weight = |i: usize| match i {
        0..6 => 1.0,
        6..NV => WEIGHTS[0],
        _ => WEIGHTS[1],
    };
    let hessian = DMatrix::from_fn(UNKNOWNS, UNKNOWNS, |i, j| if i == j { weight(i) } else { 0.0 });
    let gradient: Vec<f64> =
        (0..UNKNOWNS).map(|i| if i < NV { -weight(i) * desired[i] } else { 0.0 }).collect();

    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let cones = [ZeroConeT(EQUATIONS), NonnegativeConeT(INEQUALITIES)];
    let (hessian, a) = (sparse(&hessian), sparse(&a));
    let mut solver = DefaultSolver::new(&hessian, &gradient, &a, b.as_slice(), &cones, settings)
        .expect("the dimensions fit");
    solver.solve();
    if solver.solution.status != SolverStatus::Solved {
        return Err(solver.solution.status);
    }
    let x = DVector::from_column_slice(&solver.solution.x);
    let tau = &dynamics * &x + bias;
    Ok(Command {
        tau: core::array::from_fn(|i| if i < 6 { 0.0 } else { tau[i] }),
        forces: core::array::from_fn(|foot| core::array::from_fn(|k| x[NV + 3 * foot + k])),
        iterations: solver.solution.iterations,
    })
}

/// Returns the accelerations that bring the state to the reference: feedback in tangent space, in the base's own axes.
fn accelerations(
    state: &State<Quadruped>,
    reference: &Reference<Quadruped>,
    gains: Gains,
) -> [f64; NV] {
    let displacement = Quadruped::difference(&state.q, &reference.q);
    core::array::from_fn(|i| {
        let velocity = reference.qd[i] - state.qd[i];
        reference.qdd[i] + gains.kp * displacement[i] + gains.kd * velocity
    })
}

/// Returns the matrix in compressed columns.
fn sparse(dense: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut starts, mut rows, mut values) = (vec![0], vec![], vec![]);
    for column in dense.column_iter() {
        for (row, value) in column.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            rows.push(row);
            values.push(*value);
        }
        starts.push(values.len());
    }
    CscMatrix::new(dense.nrows(), dense.ncols(), starts, rows, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problems::{GAINS, Sway, move_on_ground};
    use crate::robots::{Settings, standing};

    fn assert_within_limits(commanded: &Command) {
        for [x, y, z] in commanded.forces {
            assert!(z > LEAST_FORCE - 1e-6 && x.hypot(y) < FRICTION * z + 1e-6, "{x} {y} {z}");
        }
        assert!(
            commanded.tau.iter().all(|tau| tau.abs() < TORQUE_LIMIT + 1e-6),
            "{:?}",
            commanded.tau
        );
    }

    /// A second of sway, on the ground of the simulation, whose contacts are unilateral.
    #[test]
    fn the_base_follows_a_motion() {
        let sway = Sway::default();
        let mut state = State::<Quadruped>::at_rest(standing());
        let feet = |q| {
            Quadruped::constraint_residual(q, &[0.0; NV], &Settings::<4>::DEFAULT).displacements
        };
        let (dt, steps) = (0.002, 1000);
        let (mut worst, mut moved) = (0.0_f64, 0.0_f64);
        for k in 0..steps {
            let time = dt * f64::from(k);
            let commanded = command(&state, &sway.at(time), GAINS).expect("solved");
            assert_within_limits(&commanded);
            let step = move_on_ground(&state, dt, &commanded.tau);
            state = step.state;
            // The ground pushes as planned, once the feet have settled in it.
            for (foot, force) in step.forces.iter().enumerate().filter(|_| k > 50) {
                for i in 0..3 {
                    let planned = commanded.forces[foot][i];
                    assert!(
                        (force[i] - planned).abs() < 0.5,
                        "step {k}: {force:?}, {:?}",
                        commanded.forces
                    );
                }
            }
            let error = Quadruped::difference(&sway.at(time + dt).q, &state.q);
            worst = error[..6].iter().fold(worst, |worst, x| worst.max(x.abs()));
            let away = Quadruped::difference(&standing(), &state.q);
            moved = away[..6].iter().fold(moved, |moved, x| moved.max(x.abs()));
        }
        assert!(worst < 2e-3 && moved > 0.02, "{worst} {moved}");
        for foot in feet(&state.q) {
            assert!(foot.linear[2].abs() < 1e-3, "{foot:?}");
        }
    }

    fn constrained(state: &State<Quadruped>, tau: &[f64; NV]) -> ([f64; NV], [[f64; 3]; 4]) {
        let contacts = crate::robots::QuadrupedContacts::ALL;
        let dynamics = Quadruped::constrained_forward_dynamics(
            &state.q,
            &state.qd,
            tau,
            contacts,
            &Settings::<4>::EXACT,
        );
        (dynamics.qdd, dynamics.wrenches.map(|wrench| wrench.force.0))
    }

    /// Under the torques, another function computes the desired accelerations and the forces of the program.
    #[test]
    fn torques_have_the_desired_effect() {
        let state = State::<Quadruped>::at_rest(standing());
        let reference = Sway::default().at(0.05);
        let commanded = command(&state, &reference, GAINS).expect("solved");
        let (qdd, forces) = constrained(&state, &commanded.tau);
        let desired = accelerations(&state, &reference, GAINS);
        for i in 0..6 {
            assert!((qdd[i] - desired[i]).abs() < 0.02, "{qdd:?} {desired:?}");
        }
        assert!(desired[..6].iter().any(|x| x.abs() > 1.0));
        for (force, planned) in forces.iter().zip(commanded.forces) {
            for i in 0..3 {
                assert!((force[i] - planned[i]).abs() < 1e-4, "{forces:?} {:?}", commanded.forces);
            }
        }
    }

    /// An acceleration that needs more friction than there is: the forces stay in the cones, and the base gets less.
    #[test]
    fn friction_bounds_the_acceleration() {
        let state = State::<Quadruped>::at_rest(standing());
        let mut reference = Reference::<Quadruped>::at_rest(state.q);
        reference.qdd[1] = 12.0;
        let commanded = command(&state, &reference, GAINS).expect("solved");
        assert_within_limits(&commanded);
        let used = commanded.forces.map(|[_, y, z]| y.abs() / z);
        let most = FRICTION * core::f64::consts::FRAC_1_SQRT_2;
        assert!(used.iter().any(|used| *used > 0.99 * most), "{used:?}");
        let (qdd, _) = constrained(&state, &commanded.tau);
        assert!(qdd[1] > 2.0 && qdd[1] < 10.0, "{qdd:?}");
    }

    /// A foot that would have to pull: there is no solution, and the error says so.
    #[test]
    fn a_task_without_solution_is_an_error() {
        let mut state = State::<Quadruped>::at_rest(standing());
        // The feet would have to be stopped by more force than there is.
        state.qd[2] = 50.0;
        let commanded = command(&state, &Reference::<Quadruped>::at_rest(state.q), GAINS);
        assert!(commanded.is_err_and(|status| status == SolverStatus::PrimalInfeasible));
    }
}
