//! The places of quaternions among the coordinates, and random coordinates of joints of all kinds.
#![cfg(feature = "alloc")]

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{DEFAULT_GRAVITY, Joint, Limits, Model, MovingLink};
use modyn_runtime::{Inertial, Interpreter, Pose};

/// Returns a chain: a revolute joint with limits, a spherical joint, a prismatic joint with limits, a floating joint.
fn model() -> Model {
    let types =
        [JointType::Revolute, JointType::Spherical, JointType::Prismatic, JointType::Floating];
    let limits = [Some((-1.5, 2.5)), None, Some((0.2, 0.6)), None];
    let links = (0..types.len()).map(|i| {
        let name = format!("joint{i}");
        let mut joint = Joint::new(name, types[i], [0.48, 0.6, 0.64], Pose::identity());
        joint.limits = limits[i].map(|(lower, upper)| Limits {
            lower: Some(lower),
            upper: Some(upper),
            velocity: None,
            effort: None,
        });
        let inertial =
            Inertial { mass: 1.0, inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0], ..Inertial::default() };
        MovingLink { name: format!("link{i}"), parent: i.checked_sub(1), joint, inertial }
    });
    Model::new("chain", DEFAULT_GRAVITY, links.collect(), Vec::new()).expect("good")
}

/// The names of the coordinates tell where the quaternions are.
#[test]
fn quaternions_are_where_the_names_say() {
    let model = model();
    let names = model.coordinate_names();
    let expected: Vec<(&str, usize)> = names
        .iter()
        .enumerate()
        .filter_map(|(i, name)| Some((name.strip_suffix(".qx")?, i)))
        .collect();
    assert_eq!(expected.iter().map(|(joint, _)| *joint).collect::<Vec<_>>(), ["joint1", "joint3"]);
    assert_eq!(model.quaternions().collect::<Vec<_>>(), expected);
    let interpreter = Interpreter::<f64>::new(model.clone());
    let mut q = vec![0.5; model.nq()];
    assert_eq!(interpreter.check_configuration(&q), Ok(()));
    for (joint, at) in expected {
        q[at + 3] = 0.6;
        let error = interpreter.check_configuration(&q).expect_err("too long").to_string();
        assert!(error.contains(&format!("`{joint}`")), "{error}");
        q[at + 3] = 0.5;
    }
}

/// Lines between the limits, or between -1 and 1; rotations as Shoemake 1992 writes them.
#[test]
fn random_coordinates_follow_from_their_numbers() {
    let interpreter = Interpreter::<f64>::new(model());
    let random = |numbers: [f64; 11]| {
        let mut numbers = numbers.into_iter();
        let mut q = [0.0; 13];
        interpreter
            .random_configuration(|| numbers.next().expect("nv numbers"), &mut q)
            .expect("the size");
        assert_eq!(numbers.next(), None);
        q
    };
    // Two numbers are angles, as parts of a full rotation.
    let rotation = [0.36, 0.25, 0.5];
    let other = [0.64, 0.125, 0.75];
    let half = 0.5_f64.sqrt();
    let expected_rotation = [0.8, 0.0, 0.0, -0.6];
    let expected_other = [0.6 * half, 0.6 * half, -0.8, 0.0];
    for (part, line, slide, position) in [
        (0.0, -1.5, 0.2, -1.0),
        (0.25, -0.5, 0.3, -0.5),
        (0.5, 0.5, 0.4, 0.0),
        (0.75, 1.5, 0.5, 0.5),
    ] {
        let numbers = [&[part][..], &rotation, &[part], &[part; 3], &other].concat();
        let expected =
            [&[line][..], &expected_rotation, &[slide], &[position; 3], &expected_other].concat();
        let found = random(numbers.try_into().expect("eleven"));
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!((found - expected).abs() < 1e-14, "entry {i} at {part}: {found} {expected}");
        }
    }
    // The upper limits are not exceeded, whatever the rounding.
    for k in 0..1000 {
        let q = random([1.0 - f64::EPSILON * f64::from(k); 11]);
        assert!(q[0] <= 2.5 && q[5] <= 0.6 && q[6] <= 1.0, "{q:?}");
    }
}
