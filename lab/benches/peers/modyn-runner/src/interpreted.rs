//! modyn's interpreter: one of the programs, and the reference for the results of all others.

use modyn::equations::ForwardInput;
use modyn::equations::constraints::ConstrainedOutputs;
use modyn::{
    ConstrainedDerivatives, ConstraintSettings, ContactTarget, ForwardDerivatives, Interpreter,
    Twist, Wrench,
};

use crate::measure::Job;
use crate::{robots, states};

/// Computes a quantity at q, qd, tau, qdd.
type Function = fn(&mut Interpreter<f64>, [&[f64]; 4], &mut [f64]);

/// Returns the number of scalars of a quantity.
pub fn results(quantity: &str, nv: usize) -> usize {
    match quantity {
        "mass_matrix" => nv * nv,
        "forward_dynamics_derivatives" | "constrained_forward_dynamics_derivatives" => {
            nv + 3 * nv * nv
        }
        _ => nv,
    }
}

/// Returns settings without stabilization.
pub fn settings(contacts: usize) -> ConstraintSettings<f64, Vec<ContactTarget<f64>>> {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::EXACT;
    let contacts = vec![ContactTarget::<f64>::EXACT; contacts];
    ConstraintSettings { alpha, beta, tolerance, rounding, contacts }
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
        "constrained_forward_dynamics" => |robot, [q, qd, tau, _], out| {
            let count = robot.model().contacts().len();
            let (mut wrenches, mut residuals) =
                (vec![Wrench::zero(); count], vec![Twist::zero(); count]);
            let results =
                ConstrainedOutputs { qdd: out, wrenches: &mut wrenches, residuals: &mut residuals };
            robot
                .constrained_forward_dynamics(
                    ForwardInput { q, qd, tau },
                    &vec![true; count],
                    &settings(count),
                    results,
                )
                .expect("sizes");
        },
        "constrained_forward_dynamics_derivatives" => |robot, [q, qd, tau, _], out| {
            let (n, count) = (qd.len(), robot.model().contacts().len());
            let (qdd, out) = out.split_at_mut(n);
            let (dqdd_dq, out) = out.split_at_mut(n * n);
            let (dqdd_dqd, dqdd_dtau) = out.split_at_mut(n * n);
            let mut wrenches = vec![Wrench::zero(); count];
            let mut changes = [0; 3].map(|_| vec![Wrench::zero(); n * count]);
            let [dwrenches_dq, dwrenches_dqd, dwrenches_dtau] = &mut changes;
            let outputs = ConstrainedDerivatives {
                qdd,
                wrenches: &mut wrenches,
                dqdd_dq,
                dqdd_dqd,
                dqdd_dtau,
                dwrenches_dq,
                dwrenches_dqd,
                dwrenches_dtau,
            };
            robot
                .constrained_forward_dynamics_derivatives(
                    ForwardInput { q, qd, tau },
                    &vec![true; count],
                    &settings(count),
                    outputs,
                )
                .expect("sizes");
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
