//! Measures functions of many states on each level of vector instructions of this machine, beside one state after the
//! other without vectors, in ns for each state. docs/batch.md has the table; `lab/record` makes `docs/data/batch.tsv`
//! from it. Each time is the minimum of many runs, so that other load of the machine has little effect.
//!
//! `cargo bench --manifest-path lab/Cargo.toml --bench batch`; with `RUSTFLAGS="-C target-cpu=native"` functions of
//! one state also use fused products, and lower levels are left out.

#[path = "../../tests/src/plain.rs"]
mod plain;

mod numbers;

use std::array::from_fn;
use std::hint::black_box;
use std::time::{Duration, Instant};

use modyn::batch::{SimdLevel, force_level};
use modyn::{ForwardDynamicsDerivatives, InverseDynamicsDerivatives, Robot};
use plain::{Plain, plain};

modyn::modyn! { Arm7 = "../../robots/arm7.urdf", joint_friction = none, functions = [
    forward_dynamics, forward_dynamics_batch, inverse_dynamics, inverse_dynamics_batch,
    mass_matrix, mass_matrix_batch, brge, brge_batch,
    inverse_dynamics_derivatives, inverse_dynamics_derivatives_batch,
    forward_dynamics_derivatives, forward_dynamics_derivatives_batch
] }
modyn::modyn! { Arm7Single = "../../robots/arm7.urdf", joint_friction = none, scalar = f32, functions = [
    forward_dynamics, forward_dynamics_batch
] }
modyn::modyn! { Quadruped = "../../robots/quadruped.urdf", functions = [
    forward_dynamics, forward_dynamics_batch
] }
modyn::modyn! { Humanoid = "../../robots/humanoid.urdf", functions = [
    forward_dynamics, forward_dynamics_batch
] }

/// The number of states of a call. Columns at this distance do not share cache sets.
const STATES: usize = 1000;

/// Returns numbers of at most this magnitude, the same on every machine.
fn numbers<T: modyn::Scalar, const N: usize>(size: f64) -> Vec<[T; N]> {
    let mut number = numbers::numbers();
    (0..STATES).map(|_| from_fn(|_| T::from_f64(size * number()))).collect()
}

/// Returns one column for each number of a state, one after the other.
fn columns<T: Copy, const N: usize>(states: &[[T; N]]) -> Vec<T> {
    (0..N).flat_map(|j| states.iter().map(move |state| state[j])).collect()
}

fn slices<T, const N: usize>(columns: &[T]) -> [&[T]; N] {
    from_fn(|j| &columns[j * STATES..][..STATES])
}

/// Returns the next columns of the result.
fn vector<'a, T, const N: usize>(rest: &mut impl Iterator<Item = &'a mut [T]>) -> [&'a mut [T]; N] {
    from_fn(|_| rest.next().expect("as many"))
}

fn matrix<'a, T, const N: usize>(
    rest: &mut impl Iterator<Item = &'a mut [T]>,
) -> [[&'a mut [T]; N]; N] {
    from_fn(|_| vector(rest))
}

/// The duration of the measurement in each round; a test calls each function once.
struct Bench {
    levels: Vec<SimdLevel>,
    round: Duration,
}

const ROUNDS: usize = 3;

impl Bench {
    fn new() -> Self {
        let all = [
            SimdLevel::Single,
            SimdLevel::Sse2,
            SimdLevel::Avx2,
            SimdLevel::Avx512,
            SimdLevel::Neon,
        ];
        let levels: Vec<SimdLevel> =
            all.into_iter().filter(|&level| force_level(Some(level))).collect();
        let measured = std::env::args().any(|argument| argument == "--bench");
        let names: Vec<String> = levels.iter().map(|level| format!("{level:?}")).collect();
        println!("| | one by one | {} | slices of states |", names.join(" | "));
        println!("|{}", "---|".repeat(levels.len() + 3));
        Self { levels, round: Duration::from_millis(if measured { 300 } else { 0 }) }
    }

    /// Updates the minimal time of many calls, ns for each state.
    fn time(&self, f: &mut dyn FnMut(), best: &mut f64) {
        let start = Instant::now();
        loop {
            let call = Instant::now();
            f();
            *best = best.min(call.elapsed().as_nanos() as f64 / STATES as f64);
            if start.elapsed() >= self.round {
                return;
            }
        }
    }

    /// Prints a row: all levels by columns, and the last level also by states.
    fn row(
        &self,
        name: &str,
        mut one: impl FnMut(),
        mut batch: impl FnMut(),
        mut each: impl FnMut(),
    ) {
        let mut best = vec![f64::MAX; self.levels.len() + 2];
        for _ in 0..ROUNDS {
            self.time(&mut one, &mut best[0]);
            for (level, best) in self.levels.iter().zip(&mut best[1..]) {
                assert!(force_level(Some(*level)));
                self.time(&mut batch, best);
            }
            force_level(None);
            let last = best.len() - 1;
            self.time(&mut each, &mut best[last]);
        }
        let cells = best[1..].iter().map(|ns| format!("{ns:.1} ({:.1})", best[0] / ns));
        println!("| {name} | {:.0} | {} |", best[0], cells.collect::<Vec<_>>().join(" | "));
    }
}

/// Measures a function of `$state`s. Its results, initially `$empty`, have `$numbers` each; the arguments `$out` of the
/// remaining columns receive them.
macro_rules! row {
    (
        $bench:ident, $name:literal, $Robot:ident on $T:ty;
        $one:ident, $batch:ident, $each:ident ($($state:ident),+);
        $empty:expr, $numbers:expr, |$rest:ident| $out:tt
    ) => {{
        const N: usize = $Robot::NV;
        $(let $state: (Vec<[$T; N]>, Vec<$T>) = {
            let states = numbers(match stringify!($state) { "q" => 3.0, "qd" => 2.0, _ => 5.0 });
            let columns = columns(&states);
            (states, columns)
        };)+
        let mut results = vec![$empty; STATES];
        let mut result_columns: Vec<$T> = vec![0.0; STATES * $numbers];
        $bench.row(
            $name,
            || for i in 0..STATES {
                black_box(<$Robot as Robot>::$one::<Plain<$T>>($(black_box(&plain(&$state.0[i]))),+));
            },
            || {
                let mut columns = result_columns.chunks_exact_mut(STATES);
                let $rest = &mut columns;
                row!(call $Robot::$batch, ($(slices(&$state.1)),+), $out);
            },
            || $Robot::$each($(&$state.0,)+ black_box(&mut results)).expect("sizes"),
        );
    }};
    (call $Robot:ident::$batch:ident, ($($in:expr),+), ($($out:expr),+)) => {
        $Robot::$batch($($in,)+ $($out),+).expect("sizes")
    };
}

fn main() {
    let bench = Bench::new();
    const N: usize = Arm7::NV;
    const ZERO: [[f64; N]; N] = [[0.0; N]; N];
    const FACTORS: usize = Arm7UduFactorization::<f64>::FACTORS;
    row!(bench, "`arm7`, forward dynamics", Arm7 on f64;
        forward_dynamics, forward_dynamics_batch, forward_dynamics_each (q, qd, tau);
        [0.0; N], N, |rest| (vector(rest)));
    row!(bench, "the same in `f32`", Arm7Single on f32;
        forward_dynamics, forward_dynamics_batch, forward_dynamics_each (q, qd, tau);
        [0.0; N], N, |rest| (vector(rest)));
    row!(bench, "`arm7`, inverse dynamics", Arm7 on f64;
        inverse_dynamics, inverse_dynamics_batch, inverse_dynamics_each (q, qd, qdd);
        [0.0; N], N, |rest| (vector(rest)));
    row!(bench, "`arm7`, mass matrix", Arm7 on f64;
        mass_matrix, mass_matrix_batch, mass_matrix_each (q);
        ZERO, N * N, |rest| (matrix(rest)));
    row!(bench, "`arm7`, BRGE", Arm7 on f64;
        brge, brge_batch, brge_each (q);
        Arm7UduFactorization::from_factors([0.0; FACTORS]), FACTORS, |rest| (vector(rest)));
    row!(bench, "`arm7`, derivatives of inverse dynamics", Arm7 on f64;
        inverse_dynamics_derivatives, inverse_dynamics_derivatives_batch,
        inverse_dynamics_derivatives_each (q, qd, qdd);
        InverseDynamicsDerivatives { dtau_dq: ZERO, dtau_dqd: ZERO }, 2 * N * N,
        |rest| (matrix(rest), matrix(rest)));
    row!(bench, "`arm7`, derivatives of forward dynamics", Arm7 on f64;
        forward_dynamics_derivatives, forward_dynamics_derivatives_batch,
        forward_dynamics_derivatives_each (q, qd, tau);
        ForwardDynamicsDerivatives { qdd: [0.0; N], dqdd_dq: ZERO, dqdd_dqd: ZERO, dqdd_dtau: ZERO }, N + 3 * N * N,
        |rest| (vector(rest), matrix(rest), matrix(rest), matrix(rest)));
    row!(bench, "`quadruped`, forward dynamics", Quadruped on f64;
        forward_dynamics, forward_dynamics_batch, forward_dynamics_each (q, qd, tau);
        [0.0; N], N, |rest| (vector(rest)));
    row!(bench, "`humanoid`, forward dynamics", Humanoid on f64;
        forward_dynamics, forward_dynamics_batch, forward_dynamics_each (q, qd, tau);
        [0.0; N], N, |rest| (vector(rest)));
}
