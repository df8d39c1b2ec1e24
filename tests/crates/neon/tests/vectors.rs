//! Generated code on vectors compared with the interpreter, which uses no vectors.

use modyn::{EmbeddedModel, Interpreter, batch::SimdLevel};
use modyn_neon::{Arm, Flying, Humanoid, Quadruped, SingleArm, SingleFlying};

/// The tolerance relative to the largest number of a result: for `f64`, and for `f32` against `f64` at the same state.
const DOUBLE: f64 = 1e-11;
const SINGLE: f64 = 2e-3;

/// Returns numbers in 0..1.
fn uniform() -> impl FnMut() -> f64 {
    let mut state = 11u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 12) as f64 / (1u64 << 52) as f64
    }
}

#[track_caller]
fn close(what: &str, found: &[impl Into<f64> + Copy], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        let found: f64 = (*found).into();
        let within = (found - expected).abs() <= tolerance * largest;
        assert!(within, "{what}: {found:e}, expected {expected:e}");
    }
}

/// Compares functions of one state, and batches with each remainder, of a robot in a precision.
macro_rules! check {
    ($Robot:ident, $T:ty, $tolerance:expr $(, $batches:ident)?) => {{
        const NV: usize = $Robot::NV;
        let mut interpreter = Interpreter::new($Robot::model());
        let mut number = uniform();
        let states = 9;
        let q: Vec<_> = (0..states).map(|_| $Robot::random_configuration(|| number() as $T)).collect();
        let mut vectors = |size: f64| -> Vec<[$T; NV]> {
            let mut vector = || std::array::from_fn(|_| (size * (2.0 * number() - 1.0)) as $T);
            (0..states).map(|_| vector()).collect()
        };
        let (qd, x) = (vectors(2.0), vectors(5.0));
        let mut expected = Vec::new();
        for i in 0..states {
            let double = |x: &[$T]| x.iter().map(|&x| f64::from(x)).collect::<Vec<f64>>();
            let (q64, qd64, x64) = (double(&q[i]), double(&qd[i]), double(&x[i]));
            let (mut qdd, mut tau, mut mass) = ([0.0; NV], [0.0; NV], vec![0.0; NV * NV]);
            interpreter.forward_dynamics(&q64, &qd64, &x64, &mut qdd).expect("sizes");
            interpreter.inverse_dynamics(&q64, &qd64, &x64, &mut tau).expect("sizes");
            interpreter.mass_matrix(&q64, &mut mass).expect("sizes");
            let found = $Robot::forward_dynamics(&q[i], &qd[i], &x[i]);
            close("forward dynamics", &found, &qdd, $tolerance);
            let found = $Robot::inverse_dynamics(&q[i], &qd[i], &x[i]);
            close("inverse dynamics", &found, &tau, $tolerance);
            let found = $Robot::mass_matrix(&q[i]);
            close("the mass matrix", found.as_flattened(), &mass, $tolerance);
            expected.push((qdd, tau));
        }
        $(check!($batches $Robot, $T, $tolerance, NV, (q, qd, x), expected);)?
    }};
    (batches $Robot:ident, $T:ty, $tolerance:expr, $NV:ident, ($q:ident, $qd:ident, $x:ident), $expected:ident) => {{
        for count in 0..=$q.len() {
            let (q, qd, x) = (&$q[..count], &$qd[..count], &$x[..count]);
            let mut found = vec![[<$T>::NAN; $NV]; count];
            $Robot::forward_dynamics_each(q, qd, x, &mut found).expect("sizes");
            for (found, (qdd, _)) in found.iter().zip(&$expected) {
                close("forward dynamics of a batch", found, qdd, $tolerance);
            }
            $Robot::inverse_dynamics_each(q, qd, x, &mut found).expect("sizes");
            for (found, (_, tau)) in found.iter().zip(&$expected) {
                close("inverse dynamics of a batch", found, tau, $tolerance);
            }
        }
    }};
}

/// Compares the derivatives of forward dynamics.
macro_rules! derivatives {
    ($Robot:ident) => {{
        const NV: usize = $Robot::NV;
        let mut interpreter = Interpreter::new($Robot::model());
        let mut number = uniform();
        for _ in 0..3 {
            let [q, qd, tau]: [[f64; NV]; 3] =
                [3.0, 2.0, 5.0].map(|size| std::array::from_fn(|_| size * (2.0 * number() - 1.0)));
            let mut qdd = [0.0; NV];
            let [mut dq, mut dqd, mut dtau] = [(); 3].map(|()| vec![0.0; NV * NV]);
            let outputs = modyn::ForwardDerivatives {
                qdd: &mut qdd,
                dqdd_dq: &mut dq,
                dqdd_dqd: &mut dqd,
                dqdd_dtau: &mut dtau,
            };
            let called = interpreter.forward_dynamics_derivatives(&q, &qd, &tau, outputs);
            called.expect("sizes");
            let found = $Robot::forward_dynamics_derivatives(&q, &qd, &tau);
            close("accelerations", &found.qdd, &qdd, DOUBLE);
            close("d qdd / dq", found.dqdd_dq.as_flattened(), &dq, DOUBLE);
            close("d qdd / dqd", found.dqdd_dqd.as_flattened(), &dqd, DOUBLE);
            close("d qdd / dtau", found.dqdd_dtau.as_flattened(), &dtau, DOUBLE);
        }
    }};
}

#[test]
fn the_level_is_the_targets() {
    let level = modyn::batch::level();
    assert_eq!(level == SimdLevel::Neon, cfg!(target_arch = "aarch64"), "{level:?}");
}

#[test]
fn arms() {
    check!(Arm, f64, DOUBLE, batches);
    check!(SingleArm, f32, SINGLE, batches);
}

#[test]
fn equal_limbs() {
    check!(Quadruped, f64, DOUBLE, batches);
    check!(Humanoid, f64, DOUBLE);
}

#[test]
fn equal_limbs_on_a_floating_base() {
    check!(Flying, f64, DOUBLE, batches);
    check!(SingleFlying, f32, SINGLE, batches);
}

#[test]
fn columns_of_derivatives() {
    derivatives!(Arm);
    derivatives!(Quadruped);
}
