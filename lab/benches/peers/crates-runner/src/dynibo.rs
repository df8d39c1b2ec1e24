//! The crate dynibo, which reads the description itself.

use std::hint::black_box;

use dynibo::Robot;

use crate::measure::Job;
use crate::{back, back_matrix, order, placed};

/// The ratio of the reference's gravity to dynibo's, which cannot be set.
const GRAVITY: f64 = 9.81 / 9.80665;

/// Measures the crate. Torques are corrected for the other gravity outside of what is timed.
pub fn measure(job: &Job, path: &str) {
    let mut robot = Robot::from_urdf(path).expect("a robot");
    let n = robot.joint_count();
    let names: Vec<String> =
        (0..n).map(|k| robot.joint_name(k).expect("a joint").to_owned()).collect();
    let order = order(job, names.iter().map(String::as_str));
    let states: Vec<[Vec<f64>; 4]> = job
        .states()
        .iter()
        .map(|state| state.each_ref().map(|numbers| placed(numbers, &order)))
        .collect();
    let missing: Vec<Vec<f64>> = states
        .iter()
        .map(|[q, ..]| {
            let mut torques = vec![0.0; n];
            robot.gravity(q, &[], &mut torques).expect("sizes");
            torques.iter().map(|torque| (GRAVITY - 1.0) * torque).collect()
        })
        .collect();
    let mut out = vec![0.0; n];
    match job.quantity.as_str() {
        "forward_dynamics" => {
            let mut states = states;
            for ([_, _, tau, _], missing) in states.iter_mut().zip(&missing) {
                tau.iter_mut().zip(missing).for_each(|(torque, missing)| *torque -= missing);
            }
            job.check(states.iter().map(|[q, qd, tau, _]| {
                robot.forward_dynamics(q, qd, tau, &[], &mut out).expect("sizes");
                back(out.iter().copied(), &order)
            }));
            job.time(&states, |[q, qd, tau, _]| {
                robot.forward_dynamics(q, qd, tau, &[], &mut out).expect("sizes");
                black_box(&out);
            });
        }
        "inverse_dynamics" => {
            job.check(states.iter().zip(&missing).map(|([q, qd, _, qdd], missing)| {
                robot.inverse_dynamics(q, qd, qdd, &[], &mut out).expect("sizes");
                back(out.iter().zip(missing).map(|(torque, missing)| torque + missing), &order)
            }));
            job.time(&states, |[q, qd, _, qdd]| {
                robot.inverse_dynamics(q, qd, qdd, &[], &mut out).expect("sizes");
                black_box(&out);
            });
        }
        "mass_matrix" => {
            let mut matrix = vec![0.0; n * n];
            job.check(states.iter().map(|[q, ..]| {
                robot.mass_matrix(q, &mut matrix).expect("sizes");
                back_matrix(|i, j| matrix[j * n + i], &order)
            }));
            job.time(&states, |[q, ..]| {
                robot.mass_matrix(q, &mut matrix).expect("sizes");
                black_box(&matrix);
            });
        }
        other => panic!("no quantity `{other}`"),
    }
}
