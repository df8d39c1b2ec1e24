//! The Coriolis matrix and the time derivatives of Jacobians, of random robots with all joint types: compared with forces,
//! bias accelerations, and differences along the motion.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{JointFriction, Model};
use modyn_runtime::spatial::Twist;
use modyn_tests::close::assert_close;
use modyn_tests::random::{self, State};

/// The tolerance for two computations of one quantity.
const EXACT: f64 = 1e-10;

/// The tolerance for central differences with the first error term removed.
const DIFFERENCES: f64 = 1e-7;

/// Returns robots in general position: trees, all joint types, mimic joints, rotors.
fn robots() -> impl Iterator<Item = (u64, Model)> {
    (0..12).flat_map(|seed| {
        let models = [
            random::general_tree(seed, 6),
            random::general_zoo(seed, 6),
            random::mixed_zoo(seed, 7),
            random::mixed_tree(seed, 5),
        ];
        models.map(|model| (seed, model.with_joint_friction(JointFriction::None).expect("valid")))
    })
}

/// Returns the time derivative of numbers that depend on the coordinates, at `q` and velocities `qd`.
fn along(
    robot: &mut Interpreter,
    (q, qd): (&[f64], &[f64]),
    numbers: impl Fn(&mut Interpreter, &[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let mut at = |time: f64| {
        let mut moved = q.to_vec();
        let step: Vec<f64> = qd.iter().map(|rate| time * rate).collect();
        robot.integrate(q, &step, &mut moved).expect("lengths");
        numbers(robot, &moved)
    };
    let mut slope = |h: f64| -> Vec<f64> {
        let (after, before) = (at(h), at(-h));
        after.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * h)).collect()
    };
    let (coarse, fine) = (slope(2e-3), slope(1e-3));
    coarse.iter().zip(fine).map(|(coarse, fine)| (4.0 * fine - coarse) / 3.0).collect()
}

#[test]
fn the_coriolis_matrix_has_the_forces_and_the_symmetry() {
    let mut several = 0;
    for (seed, model) in robots() {
        let State { q, qd, .. } = random::state(seed, &model);
        several += usize::from(model.nq() != model.nv());
        let n = model.nv();
        let mut robot = Interpreter::<f64>::new(model);
        let mut c = vec![0.0; n * n];
        robot.coriolis_matrix(&q, &qd, &mut c).expect("lengths");
        let (mut bias, mut gravity) = (vec![0.0; n], vec![0.0; n]);
        robot.bias_forces(&q, &qd, &mut bias).expect("lengths");
        robot.gravity_torques(&q, &mut gravity).expect("lengths");
        let expected: Vec<f64> = bias.iter().zip(&gravity).map(|(h, g)| h - g).collect();
        let found: Vec<f64> = (0..n).map(|i| (0..n).map(|j| c[j * n + i] * qd[j]).sum()).collect();
        assert_close(&format!("C qd of {seed}"), &found, &expected, EXACT);

        // dM/dt - 2 C is skew if dM/dt = C + C^T.
        let rate = along(&mut robot, (&q, &qd), |robot, q| {
            let mut mass = vec![0.0; n * n];
            robot.mass_matrix(q, &mut mass).expect("lengths");
            mass
        });
        let sum: Vec<f64> = (0..n * n).map(|k| c[k] + c[(k % n) * n + k / n]).collect();
        assert_close(&format!("dM/dt of {seed}"), &sum, &rate, DIFFERENCES);
    }
    assert!(several > 10, "robots with spherical or floating joints: {several}");
}

#[test]
fn time_derivatives_of_jacobians_are_the_differences_along_the_motion() {
    for (seed, model) in robots() {
        let State { q, qd, .. } = random::state(seed, &model);
        let (n, links) = (model.nv(), model.links().len());
        let mut robot = Interpreter::<f64>::new(model);
        for link in 0..links {
            for local in [false, true] {
                let name = format!("link {link} of {seed}, in its axes: {local}");
                let numbers = |columns: &[Twist<f64>]| -> Vec<f64> {
                    columns.iter().flat_map(Twist::components).collect()
                };
                let mut columns = vec![Twist::zero(); n];
                let derive = match local {
                    false => Interpreter::jacobian_time_derivative,
                    true => Interpreter::jacobian_time_derivative_local,
                };
                derive(&mut robot, &q, &qd, link, &mut columns).expect("lengths");
                let rate = along(&mut robot, (&q, &qd), |robot, q| {
                    let mut columns = vec![Twist::zero(); n];
                    let jacobian = match local {
                        false => Interpreter::jacobian,
                        true => Interpreter::jacobian_local,
                    };
                    jacobian(robot, q, link, &mut columns).expect("lengths");
                    numbers(&columns)
                });
                assert_close(&name, &numbers(&columns), &rate, DIFFERENCES);
                let bias = match local {
                    false => robot.jacobian_dot_qd(&q, &qd, link),
                    true => robot.jacobian_dot_qd_local(&q, &qd, link),
                };
                let mut found = [0.0; 6];
                for (column, rate) in columns.iter().zip(&qd) {
                    let scaled = column.scale(*rate).components();
                    found.iter_mut().zip(scaled).for_each(|(sum, x)| *sum += x);
                }
                assert_close(&name, &found, &bias.expect("lengths").components(), EXACT);
            }
        }
    }
}
