//! The functions of an object file and those in Rust have the same results: the same bits where products are rounded
//! alike.

use modyn::spatial::{Vector3, Wrench};
use modyn::{ConstraintSettings, ContactTarget, Inertial};

/// Returns all results as text, which has all digits of each number.
macro_rules! results {
    ($module:ident, $t:ty, $seed:expr, $scale:expr) => {{
        use user_object::$module::{Contacts, Leg, Link, Params};
        let mut state: u64 = $seed;
        let mut next = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 40) as f64 / f64::from(1 << 23) - 1.0) as $t
        };
        let mut q: [$t; Leg::NQ] = [0.0; Leg::NQ].map(|_: $t| next() * ($scale as $t));
        let (_, at) = Leg::QUATERNIONS[0];
        let quaternion = &mut q[at..at + 4];
        let length = quaternion.iter().map(|x| x * x).sum::<$t>().sqrt();
        quaternion.iter_mut().for_each(|x| *x /= length);
        let [qd, tau, other]: [[$t; Leg::NV]; 3] =
            [[0.0; Leg::NV]; 3].map(|x: [$t; Leg::NV]| x.map(|_| next()));
        let to = another(&q, &other);
        let mut vector = || Vector3([0.0; 3].map(|_: $t| next()));
        let forces =
            [(); Leg::LINK_NAMES.len()].map(|()| Wrench { moment: vector(), force: vector() });
        let mut params = <Params>::DEFAULT;
        params.set_gravity([0.3, -1.2, -5.0]);
        let (mass, inertia) = (0.7, [0.01, 0.001, 0.0, 0.02, 0.0, 0.015]);
        let load: Inertial<$t> = Inertial { mass, center_of_mass: [0.01, -0.02, 0.03], inertia };
        params.set_payload_of_foot(load).expect("a rigid body");
        let settings = ConstraintSettings::<$t, _> {
            alpha: 20.0,
            beta: 100.0,
            tolerance: 1e-5,
            rounding: 1e-6,
            targets: [ContactTarget { alpha: 3.0, compliance: 1e-3, ..ContactTarget::default() }],
        };
        let mut uniform = 0.05;
        let uniform = || {
            uniform = (uniform + 0.37) % 1.0;
            uniform
        };
        let mut all = vec![
            format!("{:?}", Leg::forward_dynamics(&q, &qd, &tau)),
            format!("{:?}", Leg::forward_dynamics_with(&params, &q, &qd, &tau)),
            format!("{:?}", Leg::forward_dynamics_external_local(&q, &qd, &tau, &forces)),
            format!("{:?}", Leg::forward_dynamics_derivatives_with(&params, &q, &qd, &tau)),
            format!("{:?}", Leg::kinetic_energy(&q, &qd)),
            format!("{:?}", Leg::difference(&q, &to)),
            format!("{:?}", Leg::step_semi_implicit_derivatives(&q, &qd, &tau, 0.01)),
            format!("{:?}", Leg::link_poses(&q)),
            format!("{:?}", Leg::random_configuration(uniform)),
        ];
        for contacts in [Contacts::NONE, Contacts::ALL] {
            let result = Leg::constrained_forward_dynamics(&q, &qd, &tau, contacts, &settings);
            all.push(format!("{result:?}"));
        }
        for link in Link::ALL {
            all.push(format!("{:?}", Leg::link_pose(&q, link)));
            all.push(format!("{:?}", Leg::link_velocity(&q, &qd, link)));
            all.push(format!("{:?}", Leg::jacobian(&q, link)));
        }
        let control = Leg::control(&q);
        all.push(format!("{:?} {:?}", control.mass_matrix, control.jacobian_foot));
        all
    }};
}

/// Returns other coordinates, with a quaternion of length 1.
fn another<T: Copy + std::ops::Add<Output = T>, const Q: usize, const V: usize>(
    q: &[T; Q],
    change: &[T; V],
) -> [T; Q] {
    std::array::from_fn(|i| if (3..7).contains(&i) { q[9 - i] } else { q[i] + change[i % V] })
}

/// The largest difference of the numbers in two texts, relative to the largest number.
fn difference(a: &str, b: &str) -> f64 {
    let numbers = |text: &str| -> Vec<f64> {
        let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
        words.filter_map(|word| word.parse().ok()).collect()
    };
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    assert!(a.iter().chain(&b).all(|x| x.is_finite()));
    let largest = a.iter().fold(1.0, |largest: f64, x| largest.max(x.abs()));
    a.iter().zip(&b).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs() / largest))
}

/// Compares the results of portable Rust with those of two objects: one that rounds products and sums separately, and one that
/// fuses them. All are close. Returns the functions of portable Rust that have the bits of neither; it fuses products where the
/// crate is compiled for such processors, or in vectors where the processor has them.
fn compare(
    portable: &[String],
    separate: &[String],
    fused: Option<&[String]>,
    tolerance: f64,
) -> Vec<usize> {
    assert_eq!(portable.len(), separate.len());
    assert_ne!(Some(separate), fused, "fused products differ");
    let mut others = Vec::new();
    for (k, portable) in portable.iter().enumerate() {
        let all = [Some(&separate[k]), fused.map(|fused| &fused[k])];
        if !all.into_iter().flatten().any(|found| found == portable) {
            others.push(k);
        }
        for found in all.into_iter().flatten() {
            let difference = difference(found, portable);
            assert!(difference < tolerance, "{k} {difference}\n{found}\n{portable}");
        }
    }
    others
}

/// The results of derivatives, whose columns are packed into vectors.
const DERIVATIVES: [usize; 2] = [3, 6];

/// Small angles, and angles beyond the fast reduction.
const SCALES: [f64; 3] = [1.5, 40.0, 1e7];

#[test]
fn the_results_are_those_of_rust() {
    for (seed, scale) in (1..).zip(SCALES) {
        let portable = results!(portable, f64, seed, scale);
        let object = results!(object, f64, seed, scale);
        assert_eq!(object, results!(copied, f64, seed, scale));
        let is_supported = user_object::fused::Leg::is_supported();
        let fused = is_supported.then(|| results!(fused, f64, seed, scale));
        assert_eq!(compare(&portable, &object, fused.as_deref(), 1e-9), []);
    }
}

#[test]
fn in_single_precision() {
    for (seed, scale) in (1..).zip(SCALES) {
        let portable = results!(single_portable, f32, seed, scale);
        let object = results!(single, f32, seed, scale);
        let is_supported = user_object::single_fused::Leg::is_supported();
        let fused = is_supported.then(|| results!(single_fused, f32, seed, scale));
        // Packed columns are only close in single precision.
        let others = compare(&portable, &object, fused.as_deref(), 5e-3);
        assert!(others.iter().all(|k| DERIVATIVES.contains(k)), "{others:?}");
    }
}

/// A processor without the instructions gets a message, no illegal instruction.
#[test]
fn a_missing_instruction_set_is_named() {
    use user_object::largest::Leg;
    let call = || Leg::link_poses(&Leg::NEUTRAL);
    if Leg::is_supported() {
        assert_eq!(call().len(), 5);
        return;
    }
    let error = std::panic::catch_unwind(call).expect_err("no AVX-512");
    let message = error.downcast_ref::<&str>().expect("a message");
    assert!(message.contains("AVX-512 (F, DQ and VL) and FMA; compile the robot for"), "{message}");
}
