//! Compares generated and interpreted code on the same states: forward dynamics, inverse dynamics, mass matrix and BRGE
//! of the robots in `robots/`.
//!
//! `cargo bench --manifest-path lab/Cargo.toml --bench dynamics`; with `RUSTFLAGS="-C target-cpu=native"` for this
//! machine's instructions.

mod numbers;

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion};
use modyn::{Interpreter, Robot};
use numbers::numbers;

modyn::modyn!("../../robots/gripper.urdf");
modyn::modyn!("../../robots/arm6.urdf");
modyn::modyn!("../../robots/arm7.urdf", joint_friction = none);
modyn::modyn!("../../robots/quadruped.urdf");
modyn::modyn!("../../robots/humanoid.urdf");

/// The number of states of a benchmark, which are used in turn.
const STATES: usize = 64;

/// Measures `f` on one state after the other.
fn time<const N: usize, R>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    states: &[[[f64; N]; 3]],
    mut f: impl FnMut(&[[f64; N]; 3]) -> R,
) {
    let mut next = 0;
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            next = (next + 1) % states.len();
            black_box(f(black_box(&states[next])))
        });
    });
}

macro_rules! robot {
    ($criterion:ident, $Robot:ident, $file:literal) => {{
        const N: usize = $Robot::NV;
        let mut number = numbers();
        let states: Vec<[[f64; N]; 3]> = (0..STATES)
            .map(|_| [3.0, 2.0, 5.0].map(|size| core::array::from_fn(|_| size * number())))
            .collect();
        let text = include_str!(concat!("../../robots/", $file));
        let reading = modyn_codegen::read(text, $file, &modyn_codegen::ReadOptions::default())
            .expect("a robot");
        let mut interpreter = Interpreter::<f64>::new(reading.model);
        let (mut vector, mut matrix) = ([0.0; N], vec![0.0; N * N]);
        let mut factors = interpreter.brge(&states[0][0]).expect("sizes");

        let mut group = $criterion.benchmark_group(<$Robot as Robot>::NAME);
        group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
        time(&mut group, "forward_dynamics/generated", &states, |[q, qd, tau]| {
            $Robot::forward_dynamics(q, qd, tau)
        });
        time(&mut group, "forward_dynamics/interpreted", &states, |[q, qd, tau]| {
            interpreter.forward_dynamics(q, qd, tau, &mut vector)
        });
        time(&mut group, "inverse_dynamics/generated", &states, |[q, qd, qdd]| {
            $Robot::inverse_dynamics(q, qd, qdd)
        });
        time(&mut group, "inverse_dynamics/interpreted", &states, |[q, qd, qdd]| {
            interpreter.inverse_dynamics(q, qd, qdd, &mut vector)
        });
        time(&mut group, "mass_matrix/generated", &states, |[q, ..]| $Robot::mass_matrix(q));
        time(&mut group, "mass_matrix/interpreted", &states, |[q, ..]| {
            interpreter.mass_matrix(q, &mut matrix)
        });
        time(&mut group, "brge/generated", &states, |[q, ..]| $Robot::brge(q));
        time(&mut group, "brge/interpreted", &states, |[q, ..]| factors.update(&interpreter, q));
        group.finish();
    }};
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    robot!(criterion, Gripper, "gripper.urdf");
    robot!(criterion, Arm6, "arm6.urdf");
    robot!(criterion, Arm7, "arm7.urdf");
    robot!(criterion, Quadruped, "quadruped.urdf");
    robot!(criterion, Humanoid, "humanoid.urdf");
    criterion.final_summary();
}
