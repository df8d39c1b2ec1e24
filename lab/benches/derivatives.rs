//! Compares derivatives on the same states: generated in closed form, by dual numbers through the generated dynamics
//! (one pass with a tangent for each entry of q and qd), and interpreted.
//!
//! `cargo bench --manifest-path lab/Cargo.toml --bench derivatives`

mod numbers;

use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use modyn::num_dual::{Derivative, DualSVec64};
use modyn::{Array, ForwardDerivatives, Interpreter, Robot};
use numbers::numbers;

modyn::modyn! {
    "../../robots/arm7.urdf",
    joint_friction = none,
    functions = [inverse_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives]
}
modyn::modyn! {
    "../../robots/quadruped.urdf",
    functions = [inverse_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives]
}
modyn::modyn! {
    "../../robots/humanoid.urdf",
    functions = [inverse_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives]
}

const STATES: usize = 64;

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
        let mut vector = vec![0.0; N];
        let [mut dq, mut dqd, mut dtau] = [(); 3].map(|()| vec![0.0; N * N]);

        let mut group = $criterion.benchmark_group(<$Robot as Robot>::NAME);
        group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
        let mut next = 0;
        let mut state = || {
            next = (next + 1) % STATES;
            black_box(&states[next])
        };
        group.bench_function("inverse_dynamics_derivatives/generated", |bencher| {
            bencher.iter(|| {
                let [q, qd, qdd] = state();
                $Robot::inverse_dynamics_derivatives(q, qd, qdd)
            });
        });
        type Dual = DualSVec64<{ 2 * N }>;
        let dual = |x: f64, k: usize| {
            Dual::new(x, Derivative::derivative_generic(modyn::na::Const, modyn::na::U1, k))
        };
        group.bench_function("inverse_dynamics_derivatives/dual numbers", |bencher| {
            bencher.iter(|| {
                let [q, qd, qdd] = state();
                let q = Array::from_fn(|i| dual(q[i], i));
                let qd = Array::from_fn(|i| dual(qd[i], N + i));
                <$Robot as Robot>::inverse_dynamics::<Dual>(&q, &qd, &qdd.map(Dual::from_re))
            });
        });
        group.bench_function("inverse_dynamics_derivatives/interpreted", |bencher| {
            bencher.iter(|| {
                let [q, qd, qdd] = state();
                interpreter.inverse_dynamics_derivatives(q, qd, qdd, &mut dq, &mut dqd)
            });
        });
        group.bench_function("forward_dynamics_derivatives/generated", |bencher| {
            bencher.iter(|| {
                let [q, qd, tau] = state();
                $Robot::forward_dynamics_derivatives(q, qd, tau)
            });
        });
        group.bench_function("forward_dynamics_derivatives/interpreted", |bencher| {
            bencher.iter(|| {
                let [q, qd, tau] = state();
                let outputs = ForwardDerivatives {
                    qdd: &mut vector,
                    dqdd_dq: &mut dq,
                    dqdd_dqd: &mut dqd,
                    dqdd_dtau: &mut dtau,
                };
                interpreter.forward_dynamics_derivatives(q, qd, tau, outputs)
            });
        });
        group.finish();
    }};
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    robot!(criterion, Arm7, "arm7.urdf");
    robot!(criterion, Quadruped, "quadruped.urdf");
    robot!(criterion, Humanoid, "humanoid.urdf");
    criterion.final_summary();
}
