//! Batches on each level of vector instructions that this machine has, beside the function for one state:
//! ns a state (an element). 1024 states a call; columns stand 1,040 numbers apart, since columns at
//! multiples of 4,096 bytes would hinder each other in the cache.
//!
//! `cargo bench --bench batch`; with `RUSTFLAGS="-C target-cpu=native"` the functions for one state use
//! this machine's instructions too (and lower levels are left out).

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use modyn::batch::{Level, force_level};

modyn::modyn! { Arm7 = "robots/arm7.urdf", functions = [
    forward_dynamics, forward_dynamics_batch, inverse_dynamics, inverse_dynamics_batch,
    mass_matrix, mass_matrix_batch
] }
modyn::modyn! { Arm7Single = "robots/arm7.urdf", scalar = f32, functions = [
    forward_dynamics, forward_dynamics_batch
] }
modyn::modyn! { Quadruped = "robots/quadruped.urdf", functions = [
    forward_dynamics, forward_dynamics_batch
] }
modyn::modyn! { Humanoid = "robots/humanoid.urdf", functions = [
    forward_dynamics, forward_dynamics_batch
] }

/// States a call.
const STATES: usize = 1024;
/// From one column to the next.
const STRIDE: usize = STATES + 16;

/// Columns in a row, and the same numbers state by state.
struct Numbers<T, const N: usize> {
    flat: Vec<T>,
    states: Vec<[T; N]>,
}

impl<T: modyn::Scalar, const N: usize> Numbers<T, N> {
    /// Numbers of that size, the same on every machine: a linear congruential generator.
    fn new(size: f64) -> Self {
        let mut seed = 1u64;
        let mut flat = vec![T::zero(); N * STRIDE];
        for x in &mut flat {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            *x = T::from_f64(size * ((seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0));
        }
        let state = |i| std::array::from_fn(|j| flat[j * STRIDE + i]);
        let states = (0..STATES).map(state).collect();
        Self { flat, states }
    }

    fn columns(&self) -> [&[T]; N] {
        std::array::from_fn(|j| &self.flat[j * STRIDE..][..STATES])
    }

    fn columns_mut(&mut self) -> [&mut [T]; N] {
        let mut columns = self.flat.chunks_exact_mut(STRIDE);
        std::array::from_fn(|_| &mut columns.next().expect("as many")[..STATES])
    }
}

/// Times `f` on every level.
fn levels(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, mut f: impl FnMut()) {
    for level in [Level::Sse2, Level::Avx2, Level::Avx512, Level::Neon] {
        if force_level(Some(level)) {
            group.bench_function(format!("{name}/{level:?}"), |bencher| bencher.iter(&mut f));
        }
    }
    force_level(None);
}

macro_rules! group {
    ($criterion:ident, $name:expr) => {{
        let mut group = $criterion.benchmark_group($name);
        group.throughput(Throughput::Elements(STATES as u64));
        group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
        group
    }};
}

macro_rules! dynamics {
    ($criterion:ident, $Robot:ident, $T:ty, $one:ident, $batch:ident, $each:ident) => {{
        const N: usize = $Robot::NV;
        let [q, qd, x]: [Numbers<$T, N>; 3] = [3.0, 2.0, 5.0].map(Numbers::new);
        let mut y: Numbers<$T, N> = Numbers::new(0.0);
        let mut group = group!($criterion, format!("{}/{}", stringify!($Robot), stringify!($one)));
        group.bench_function("one", |bencher| {
            bencher.iter(|| {
                for ((q, qd), x) in q.states.iter().zip(&qd.states).zip(&x.states) {
                    black_box($Robot::$one(black_box(q), qd, x));
                }
            });
        });
        levels(&mut group, "batch", || {
            $Robot::$batch(q.columns(), qd.columns(), x.columns(), y.columns_mut()).expect("sizes");
        });
        levels(&mut group, "each", || {
            $Robot::$each(&q.states, &qd.states, &x.states, &mut y.states).expect("sizes");
        });
        group.finish();
    }};
}

fn mass_matrix(criterion: &mut Criterion) {
    const N: usize = Arm7::NV;
    let q: Numbers<f64, N> = Numbers::new(3.0);
    let mut columns: Numbers<f64, { N * N }> = Numbers::new(0.0);
    let mut matrices = vec![[[0.0; N]; N]; STATES];
    let mut group = group!(criterion, "Arm7/mass_matrix");
    group.bench_function("one", |bencher| {
        bencher.iter(|| {
            for q in &q.states {
                black_box(Arm7::mass_matrix(black_box(q)));
            }
        });
    });
    levels(&mut group, "batch", || {
        let mut rest = columns.columns_mut().into_iter();
        let matrix = [[(); N]; N].map(|column| column.map(|()| rest.next().expect("as many")));
        Arm7::mass_matrix_batch(q.columns(), matrix).expect("sizes");
    });
    levels(&mut group, "each", || {
        Arm7::mass_matrix_each(&q.states, &mut matrices).expect("sizes");
    });
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let c = &mut criterion;
    dynamics!(c, Arm7, f64, forward_dynamics, forward_dynamics_batch, forward_dynamics_each);
    dynamics!(c, Arm7Single, f32, forward_dynamics, forward_dynamics_batch, forward_dynamics_each);
    dynamics!(c, Quadruped, f64, forward_dynamics, forward_dynamics_batch, forward_dynamics_each);
    dynamics!(c, Humanoid, f64, forward_dynamics, forward_dynamics_batch, forward_dynamics_each);
    dynamics!(c, Arm7, f64, inverse_dynamics, inverse_dynamics_batch, inverse_dynamics_each);
    mass_matrix(c);
    criterion.final_summary();
}
