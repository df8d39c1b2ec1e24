//! modyn's interpreter: one of the programs, and the reference for the results of all others.

use modyn::{ForwardDerivatives, Interpreter};

use crate::measure::Job;
use crate::{robots, states};

/// Computes a quantity at q, qd, tau, qdd.
type Function = fn(&mut Interpreter<f64>, [&[f64]; 4], &mut [f64]);

/// Returns the number of scalars of a quantity.
pub fn results(quantity: &str, nv: usize) -> usize {
    match quantity {
        "mass_matrix" => nv * nv,
        "forward_dynamics_derivatives" => nv + 3 * nv * nv,
        _ => nv,
    }
}

/// Returns the function of the quantity with this name; matrices by columns, derivatives as qdd, then by q, qd and tau.
pub fn function(quantity: &str) -> Function {
    match quantity {
        "forward_dynamics" => |robot, [q, qd, tau, _], out| {
            robot.forward_dynamics(q, qd, tau, out).expect("sizes");
        },
        "inverse_dynamics" => |robot, [q, qd, _, qdd], out| {
            robot.inverse_dynamics(q, qd, qdd, out).expect("sizes");
        },
        "mass_matrix" => |robot, [q, ..], out| robot.mass_matrix(q, out).expect("sizes"),
        "forward_dynamics_derivatives" => |robot, [q, qd, tau, _], out| {
            let n = qd.len();
            let (qdd, out) = out.split_at_mut(n);
            let (dqdd_dq, out) = out.split_at_mut(n * n);
            let (dqdd_dqd, dqdd_dtau) = out.split_at_mut(n * n);
            let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
            robot.forward_dynamics_derivatives(q, qd, tau, outputs).expect("sizes");
        },
        _ => panic!("no quantity `{quantity}`"),
    }
}

/// Measures the interpreter.
pub fn measure(job: &Job) {
    let robots = robots::all();
    let robot = robots.iter().find(|robot| robot.name == job.robot).expect("a robot");
    let mut interpreter = Interpreter::<f64>::new(states::model(robot));
    let states: Vec<[Vec<f64>; 4]> = job.states();
    let function = function(&job.quantity);
    let mut out = vec![0.0; results(&job.quantity, job.nv)];
    let mut run = |[q, qd, tau, qdd]: &[Vec<f64>; 4], out: &mut [f64]| {
        function(&mut interpreter, [q, qd, tau, qdd], out);
    };
    job.check(states.iter().map(|state| {
        run(state, &mut out);
        out.clone()
    }));
    job.time(&states, |state| {
        run(state, &mut out);
        std::hint::black_box(&out);
    });
}
