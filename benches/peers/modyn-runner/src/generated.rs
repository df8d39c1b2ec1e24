//! modyn's generated code.

use std::hint::black_box;

use crate::measure::Job;

/// The array that those numbers are.
fn fixed<const N: usize>(numbers: &[f64]) -> [f64; N] {
    numbers.try_into().expect("as many numbers as the robot has")
}

/// A result as a list of numbers.
trait Flat {
    fn flat(&self) -> Vec<f64>;
}

impl<const N: usize> Flat for [f64; N] {
    fn flat(&self) -> Vec<f64> {
        self.to_vec()
    }
}

impl<const N: usize> Flat for [[f64; N]; N] {
    fn flat(&self) -> Vec<f64> {
        self.concat()
    }
}

impl<const N: usize> Flat for modyn::ForwardDynamicsDerivatives<[f64; N], [[f64; N]; N]> {
    fn flat(&self) -> Vec<f64> {
        let Self { qdd, dq, dqd, dtau } = self;
        [&qdd[..], &dq.concat(), &dqd.concat(), &dtau.concat()].concat()
    }
}

/// Checks a function and times it.
fn run<S, R: Flat>(job: &Job, states: &[S], mut function: impl FnMut(&S) -> R) {
    job.check(states.iter().map(|state| function(state).flat()));
    job.time(states, |state| {
        let result = function(state);
        black_box(&result);
    });
}

/// The call of a quantity.
macro_rules! call {
    ($Robot:ident inverse_dynamics $job:ident $states:ident) => {
        run($job, $states, |(q, qd, _, qdd)| $Robot::inverse_dynamics(q, qd, qdd))
    };
    ($Robot:ident mass_matrix $job:ident $states:ident) => {
        run($job, $states, |(q, _, _, _)| $Robot::mass_matrix(q))
    };
    ($Robot:ident $function:ident $job:ident $states:ident) => {
        run($job, $states, |(q, qd, tau, _)| $Robot::$function(q, qd, tau))
    };
}

/// All robots; the table's rows are the build script's.
macro_rules! generated {
    ($($name:literal $Robot:ident [$($function:ident)*];)*) => {
        /// Times the generated function.
        pub fn measure(job: &Job) {
            match job.robot.as_str() {
                $($name => {
                    type State = (
                        [f64; $Robot::NQ],
                        [f64; $Robot::NV],
                        [f64; $Robot::NV],
                        [f64; $Robot::NV],
                    );
                    let states: Vec<[Vec<f64>; 4]> = job.states();
                    let states: Vec<State> = states
                        .iter()
                        .map(|[q, qd, tau, qdd]| (fixed(q), fixed(qd), fixed(tau), fixed(qdd)))
                        .collect();
                    let states = &states[..];
                    match job.quantity.as_str() {
                        $(stringify!($function) => call!($Robot $function job states),)*
                        other => panic!("no quantity `{other}`"),
                    }
                })*
                other => panic!("no robot `{other}`"),
            }
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/robots.rs"));
