//! modyn's generated code.

use std::hint::black_box;

use crate::measure::Job;
use crate::scalar_only::ScalarOnly;

/// Returns the numbers as an array.
fn fixed<const N: usize>(numbers: &[f64]) -> [f64; N] {
    numbers.try_into().expect("as many numbers as the robot has")
}

/// A result that can be flattened to a list of numbers.
trait Flat {
    fn flat(&self) -> Vec<f64>;
}

impl<const N: usize> Flat for [f64; N] {
    fn flat(&self) -> Vec<f64> {
        self.to_vec()
    }
}

impl<const N: usize> Flat for [ScalarOnly; N] {
    fn flat(&self) -> Vec<f64> {
        self.iter().map(|x| x.0).collect()
    }
}

impl<const N: usize> Flat for [[ScalarOnly; N]; N] {
    fn flat(&self) -> Vec<f64> {
        self.as_flattened().iter().map(|x| x.0).collect()
    }
}

impl<const N: usize> Flat for [[f64; N]; N] {
    fn flat(&self) -> Vec<f64> {
        self.concat()
    }
}

impl<const N: usize> Flat for modyn::ForwardDynamicsDerivatives<[f64; N], [[f64; N]; N]> {
    fn flat(&self) -> Vec<f64> {
        let Self { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau } = self;
        [&qdd[..], &dqdd_dq.concat(), &dqdd_dqd.concat(), &dqdd_dtau.concat()].concat()
    }
}

impl<const N: usize, W, R> Flat for modyn::ConstrainedForwardDynamics<[f64; N], W, R, f64> {
    fn flat(&self) -> Vec<f64> {
        self.qdd.to_vec()
    }
}

impl<const N: usize, W, D> Flat
    for modyn::ConstrainedForwardDynamicsDerivatives<[f64; N], W, [[f64; N]; N], D, f64>
{
    fn flat(&self) -> Vec<f64> {
        let Self { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau, .. } = self;
        [&qdd[..], &dqdd_dq.concat(), &dqdd_dqd.concat(), &dqdd_dtau.concat()].concat()
    }
}

/// Checks and measures a function.
fn run<S, R: Flat>(job: &Job, states: &[S], mut function: impl FnMut(&S) -> R) {
    job.check(states.iter().map(|state| function(state).flat()));
    job.time(states, |state| {
        let result = function(state);
        black_box(&result);
    });
}

/// Calls the function of a quantity.
macro_rules! call {
    ($Robot:ident inverse_dynamics $job:ident $states:ident) => {
        run($job, $states, |(q, qd, _, qdd)| $Robot::inverse_dynamics(q, qd, qdd))
    };
    ($Robot:ident mass_matrix $job:ident $states:ident) => {
        run($job, $states, |(q, _, _, _)| $Robot::mass_matrix(q))
    };
    ($Robot:ident constrained_forward_dynamics $job:ident $states:ident) => {
        constrained!($Robot constrained_forward_dynamics $job $states)
    };
    ($Robot:ident constrained_forward_dynamics_derivatives $job:ident $states:ident) => {
        constrained!($Robot constrained_forward_dynamics_derivatives $job $states)
    };
    ($Robot:ident $function:ident $job:ident $states:ident) => {
        run($job, $states, |(q, qd, tau, _)| $Robot::$function(q, qd, tau))
    };
}

/// Calls a function of contacts with all contacts active.
macro_rules! constrained {
    ($Robot:ident $function:ident $job:ident $states:ident) => {{
        let all = <<$Robot as modyn::Robot>::Contacts as modyn::ContactSet>::ALL;
        let settings = modyn::ConstraintSettings::<f64, _>::EXACT;
        run($job, $states, |(q, qd, tau, _)| {
            $Robot::$function(q, qd, tau, black_box(all), black_box(&settings))
        })
    }};
}

/// The columns of one result of a batch, or of all of its entries.
trait Columns<'a> {
    /// Takes as many of the columns as it needs.
    fn take(columns: &mut std::slice::IterMut<'a, Vec<f64>>) -> Self;
}

impl<'a> Columns<'a> for &'a mut [f64] {
    fn take(columns: &mut std::slice::IterMut<'a, Vec<f64>>) -> Self {
        columns.next().expect("as many columns as the result has")
    }
}

impl<'a, C: Columns<'a>, const N: usize> Columns<'a> for [C; N] {
    fn take(columns: &mut std::slice::IterMut<'a, Vec<f64>>) -> Self {
        std::array::from_fn(|_| C::take(columns))
    }
}

macro_rules! columns {
    ($($Type:ident { $($field:tt: $Field:ty),* })*) => {$(
        impl<'a, X: Columns<'a>> Columns<'a> for modyn::$Type<X> {
            fn take(columns: &mut std::slice::IterMut<'a, Vec<f64>>) -> Self {
                Self { $($field: <$Field>::take(columns)),* }
            }
        }
    )*};
}

columns! {
    Vector3 { 0: [X; 3] }
    Wrench { force: modyn::Vector3<X>, moment: modyn::Vector3<X> }
    Twist { linear: modyn::Vector3<X>, angular: modyn::Vector3<X> }
}

/// Measures forward dynamics of all states in one call.
macro_rules! batch {
    ($Robot:ident none $contacts:literal $job:ident) => {
        panic!("not timed in batches")
    };
    ($Robot:ident $kind:ident $contacts:literal $job:ident) => {{
        let states = $job.states();
        let count = states.len();
        let columns = |part: usize, j: usize| -> Vec<f64> {
            states.iter().map(|state| state[part][j]).collect()
        };
        let q: [Vec<f64>; $Robot::NQ] = std::array::from_fn(|j| columns(0, j));
        let qd: [Vec<f64>; $Robot::NV] = std::array::from_fn(|j| columns(1, j));
        let tau: [Vec<f64>; $Robot::NV] = std::array::from_fn(|j| columns(2, j));
        let arguments = || {
            (
                q.each_ref().map(|column| black_box(&column[..])),
                qd.each_ref().map(|column| &column[..]),
                tau.each_ref().map(|column| &column[..]),
            )
        };
        // Accelerations; wrenches and residuals of six numbers a contact, and the rank.
        let contacts = if $contacts > 0 { 12 * $contacts + 1 } else { 0 };
        let mut results = vec![vec![0.0; count]; $Robot::NV + contacts];
        let pass = |results: &mut [Vec<f64>]| {
            let (q, qd, tau) = arguments();
            let to = &mut results.iter_mut();
            batch_call!($Robot $kind count (q, qd, tau) to).expect("equal lengths");
            black_box(results);
        };
        pass(&mut results);
        let result = |i: usize| results[..$Robot::NV].iter().map(|column| column[i]).collect();
        $job.check((0..count).map(result));
        $job.time_all(count, || pass(&mut results));
    }};
}

/// Calls the batch of forward dynamics, with all contacts active.
macro_rules! batch_call {
    ($Robot:ident free $count:ident ($q:ident, $qd:ident, $tau:ident) $to:ident) => {
        $Robot::forward_dynamics_batch($q, $qd, $tau, Columns::take($to))
    };
    ($Robot:ident constrained $count:ident ($q:ident, $qd:ident, $tau:ident) $to:ident) => {{
        let settings = modyn::ConstraintSettings::<f64, _>::EXACT;
        let active = vec![true; $count];
        let (contacts, settings) = ([black_box(&active[..]); _], black_box(&settings));
        $Robot::constrained_forward_dynamics_batch(
            $q,
            $qd,
            $tau,
            contacts,
            settings,
            Columns::take($to),
            Columns::take($to),
            Columns::take($to),
            Columns::take($to),
        )
    }};
}

/// Calls the trait's function of a quantity, for numbers without vectors.
macro_rules! call_alone {
    ($Robot:ident inverse_dynamics $job:ident $states:ident) => {
        run($job, $states, |(q, qd, _, qdd)| <$Robot as modyn::Robot>::inverse_dynamics(q, qd, qdd))
    };
    ($Robot:ident mass_matrix $job:ident $states:ident) => {
        run($job, $states, |(q, _, _, _)| <$Robot as modyn::Robot>::mass_matrix(q))
    };
    ($Robot:ident forward_dynamics $job:ident $states:ident) => {
        run($job, $states, |(q, qd, tau, _)| <$Robot as modyn::Robot>::forward_dynamics(q, qd, tau))
    };
    ($Robot:ident $function:ident $job:ident $states:ident) => {{
        let _ = $states;
        panic!("not timed alone")
    }};
}

/// All robots; the build script writes the rows of the table.
macro_rules! generated {
    ($($name:literal $Robot:ident $batch:ident $contacts:literal [$($function:ident)*];)*) => {
        /// Measures the generated function.
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

        /// Measures the generated function with equal limbs one after the other.
        pub fn measure_alone(job: &Job) {
            match job.robot.as_str() {
                $($name => {
                    type State = (
                        [ScalarOnly; $Robot::NQ],
                        [ScalarOnly; $Robot::NV],
                        [ScalarOnly; $Robot::NV],
                        [ScalarOnly; $Robot::NV],
                    );
                    let states: Vec<State> = job
                        .states()
                        .iter()
                        .map(|[q, qd, tau, qdd]| {
                            (
                                fixed(q).map(ScalarOnly),
                                fixed(qd).map(ScalarOnly),
                                fixed(tau).map(ScalarOnly),
                                fixed(qdd).map(ScalarOnly),
                            )
                        })
                        .collect();
                    let states = &states[..];
                    match job.quantity.as_str() {
                        $(stringify!($function) => call_alone!($Robot $function job states),)*
                        other => panic!("no quantity `{other}`"),
                    }
                })*
                other => panic!("no robot `{other}`"),
            }
        }

        /// Measures forward dynamics of all states in one call: the quantity that has a batch here.
        pub fn measure_batch(job: &Job) {
            match job.robot.as_str() {
                $($name => {
                    batch!($Robot $batch $contacts job);
                })*
                other => panic!("no robot `{other}`"),
            }
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/robots.rs"));
