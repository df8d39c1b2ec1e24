//! Quaternions whose length is not 1: their effect on results, and the check that finds them.

use modyn::{ConfigurationError, Interpreter, Robot, Scalar};
use modyn_codegen::{ReadOptions, read};

modyn::modyn!(
    Zoo = "../../../robots/joint_zoo.urdf",
    joint_friction = none,
    functions = [forward_dynamics, normalize_configuration]
);
modyn::modyn!(
    Single = "../../../robots/joint_zoo.urdf",
    joint_friction = none,
    scalar = f32,
    functions = [forward_dynamics, normalize_configuration]
);

/// Returns coordinates in general position; the quaternion that begins at `at` has the given length.
fn coordinates(at: usize, length: f64) -> [f64; Zoo::NQ] {
    let q: [f64; Zoo::NQ] = std::array::from_fn(|i| 0.3 + 0.1 * i as f64);
    let mut q = Zoo::normalize_configuration(&q);
    q[at..at + 4].iter_mut().for_each(|x| *x *= length);
    q
}

#[test]
fn lengths_are_checked_by_joint() {
    let urdf = include_str!("../../../robots/joint_zoo.urdf");
    let model = read(urdf, "joint_zoo.urdf", &ReadOptions::default()).expect("good").model;
    let interpreter = Interpreter::<f64>::new(model);
    assert!(!Zoo::QUATERNIONS.is_empty());
    for (joint, at) in Zoo::QUATERNIONS {
        let names: Vec<&str> = Zoo::COORDINATE_NAMES[at..at + 4].to_vec();
        assert_eq!(names, ["qx", "qy", "qz", "qw"].map(|part| format!("{joint}.{part}")));
        for (length, good) in [
            (1.0, true),
            (1.0 + 1e-9, true),
            (1.0 - 1e-9, true),
            (1.1, false),
            (0.999, false),
            (0.0, false),
        ] {
            let q = coordinates(at, length);
            let found = [Zoo::check_configuration(&q), <Zoo as Robot>::check_configuration(&q)];
            let interpreted = interpreter.check_configuration(&q);
            assert_eq!(found[0], found[1]);
            if good {
                assert_eq!((found[0], interpreted), (Ok(()), Ok(())));
                continue;
            }
            let Err(ConfigurationError::Quaternion { joint: named, length: measured }) = found[0]
            else {
                panic!("{joint} of length {length}: {found:?}")
            };
            assert_eq!(named, joint);
            assert!((measured - length).abs() < 1e-12, "{measured}");
            let message = interpreted.expect_err("the same").to_string();
            assert_eq!(message, found[0].expect_err("an error").to_string());
            assert!(message.contains(&format!("`{joint}`")), "{message}");
            assert_eq!(Zoo::check_configuration(&Zoo::normalize_configuration(&q)), Ok(()));
        }
        let mut q = coordinates(at, 1.0);
        q[at + 1] = f64::NAN;
        assert!(Zoo::check_configuration(&q).is_err());
        // In single precision, the check allows the rounding of that precision.
        let single = coordinates(at, 1.0).map(|x| x as f32);
        assert_eq!(Single::check_configuration(&single), Ok(()));
        assert!(Single::check_configuration(&coordinates(at, 1.01).map(|x| x as f32)).is_err());
    }
    let short = interpreter.check_configuration(&[0.0; 3]);
    assert_eq!(short, Err(ConfigurationError::Shape { expected: Zoo::NQ, found: 3 }));
}

/// A quaternion of length 1.1 changes accelerations by more than a thousandth of the largest.
#[test]
fn a_long_quaternion_is_a_wrong_result() {
    let (qd, tau) = ([0.4; Zoo::NV], [0.2; Zoo::NV]);
    for (_, at) in Zoo::QUATERNIONS {
        let [right, wrong] = [1.0, 1.1].map(|length| {
            let q = coordinates(at, length);
            Zoo::forward_dynamics(&q, &qd, &tau)
        });
        let largest = right.iter().fold(0.0, |largest: f64, x| largest.max(Scalar::abs(*x)));
        let difference = right.iter().zip(wrong).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference > 1e-3 * largest, "{difference} of {largest}");
    }
}
