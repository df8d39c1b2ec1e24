//! Steps, differences, time derivatives and random values of the coordinates.

use std::f64::consts::PI;
use std::iter::zip;

use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::mechanism::coordinates::CoordinateSpace;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Inertial, Joint, Limits, Link, Mimic, Model, MovingLink,
};
use modyn_runtime::spatial::Pose;
use modyn_runtime::{Interpreter, Scalar, ShapeError};
use modyn_tests::close::assert_close;
use modyn_tests::quantities::{Quantities as _, numbers};
use modyn_tests::random::Random;
use nalgebra::{DMatrix, Matrix3};

/// Returns a chain of joints of all types, with one mimic joint; link 0 floats.
fn robot() -> Interpreter<f64> {
    let limits = |lower, upper| Some(Limits { lower, upper, velocity: None, effort: None });
    let types = [
        (JointType::Floating, None, None),
        (JointType::Spherical, None, None),
        (JointType::Universal, None, None),
        (JointType::Revolute, limits(Some(-0.3), Some(1.7)), None),
        (JointType::Planar, None, None),
        (JointType::Revolute, limits(Some(-0.1), Some(0.1)), Some(3)),
        (JointType::Prismatic, limits(Some(0.2), Some(0.4)), None),
        (JointType::Continuous, limits(None, None), None),
        (JointType::Prismatic, None, None),
        (JointType::Spherical, None, None),
    ];
    let links: Vec<MovingLink> = types
        .into_iter()
        .enumerate()
        .map(|(i, (joint_type, limits, leader))| {
            let origin = Pose { translation: [0.1, -0.2, 0.3], ..Pose::identity() };
            let mimic = leader.map(|leader| Mimic { leader, multiplier: -2.0, offset: 0.5 });
            let joint = Joint::new(format!("joint{i}"), joint_type, [0.0, 0.6, 0.8], origin);
            let joint = Joint { limits, mimic, ..joint };
            let name = format!("link{i}");
            MovingLink { name, parent: i.checked_sub(1), joint, inertial: Inertial::default() }
        })
        .collect();
    let frames = links.iter().enumerate().map(|(i, link)| Link {
        name: link.name.clone(),
        moving_link: Some(i),
        pose: Pose::identity(),
        inertial: link.inertial,
    });
    let frames = frames.collect();
    Interpreter::new(Model::new("all", DEFAULT_GRAVITY, links, frames).expect("a valid model"))
}

const LENGTHS: &str = "the lengths are right";

fn moved<S: Scalar>(robot: &Interpreter<S>, q: &[S], v: &[S]) -> Vec<S> {
    let mut moved = vec![S::zero(); q.len()];
    robot.integrate(q, v, &mut moved).expect(LENGTHS);
    moved
}

fn between<S: Scalar>(robot: &Interpreter<S>, from: &[S], to: &[S]) -> Vec<S> {
    let mut v = vec![S::zero(); robot.model().nv()];
    robot.difference(from, to, &mut v).expect(LENGTHS);
    v
}

fn rates(robot: &Interpreter<f64>, q: &[f64], qd: &[f64]) -> Vec<f64> {
    let mut rates = vec![0.0; q.len()];
    robot.velocity_to_qdot(q, qd, &mut rates).expect(LENGTHS);
    rates
}

fn random_q(robot: &Interpreter<f64>, random: &mut Random) -> Vec<f64> {
    let mut q = vec![0.0; robot.model().nq()];
    robot.random_configuration(|| random.between(0.0, 1.0), &mut q).expect(LENGTHS);
    q
}

fn vector(random: &mut Random, n: usize, size: f64) -> Vec<f64> {
    (0..n).map(|_| random.between(-size, size)).collect()
}

/// Returns the indices of the rotations: of the quaternions in q, and of the rotation vectors in qd.
fn rotations(model: &Model) -> Vec<(usize, usize)> {
    let blocks = Mechanism::new(model).coordinates;
    let place = |block: &modyn_runtime::mechanism::coordinates::Coordinates<f64>| match block.space
    {
        CoordinateSpace::Line { .. } => None,
        CoordinateSpace::Rotation => Some((block.q, block.v)),
        CoordinateSpace::Pose => Some((block.q + 3, block.v + 3)),
    };
    blocks.iter().filter_map(place).collect()
}

/// Scales the rotation vectors in `v` to this length.
fn stretch(model: &Model, v: &mut [f64], length: f64) {
    for (_, at) in rotations(model) {
        let w = &mut v[at..at + 3];
        let own = w.iter().map(|x| x * x).sum::<f64>().sqrt();
        w.iter_mut().for_each(|x| *x *= length / own);
    }
}

/// Returns the same rotations, with quaternions whose w is not negative.
fn one_sided(model: &Model, mut q: Vec<f64>) -> Vec<f64> {
    for (at, _) in rotations(model) {
        let sign = 1.0_f64.copysign(q[at + 3]);
        q[at..at + 4].iter_mut().for_each(|x| *x *= sign);
    }
    q
}

fn length(quaternion: &[f64]) -> f64 {
    quaternion.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn differences_undo_steps_of_any_size() {
    let robot = robot();
    let random = &mut Random::new(1);
    for angle in [0.0, 1e-300, 1e-16, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1.0, 3.0, 3.1, PI - 1e-7] {
        for _ in 0..20 {
            let q = random_q(&robot, random);
            let mut v = vector(random, robot.model().nv(), 1.0);
            stretch(robot.model(), &mut v, angle);
            let found = between(&robot, &q, &moved(&robot, &q, &v));
            assert_close(&format!("rotates by {angle}"), &found, &v, 4e-15);
        }
    }
}

#[test]
fn tiny_turns_are_relatively_accurate_from_the_identity() {
    let robot = robot();
    let random = &mut Random::new(2);
    let mut q = vec![0.0; robot.model().nq()];
    robot.neutral(&mut q).expect(LENGTHS);
    for angle in [1e-14, 1e-9, 1e-6, 1e-3] {
        let mut v = vector(random, robot.model().nv(), 1.0);
        stretch(robot.model(), &mut v, angle);
        let found = between(&robot, &q, &moved(&robot, &q, &v));
        for (_, at) in rotations(robot.model()) {
            let mut pairs = zip(&found[at..at + 3], &v[at..at + 3]);
            assert!(pairs.all(|(a, b)| (a - b).abs() < 4e-16 * angle), "{angle}");
        }
    }
}

#[test]
fn steps_undo_differences() {
    let robot = robot();
    let random = &mut Random::new(3);
    for _ in 0..200 {
        let (from, to) = (random_q(&robot, random), random_q(&robot, random));
        let v = between(&robot, &from, &to);
        for (_, at) in rotations(robot.model()) {
            assert!(length(&v[at..at + 3]) <= PI + 1e-12, "the shortest rotation");
        }
        let found = one_sided(robot.model(), moved(&robot, &from, &v));
        assert_close("there", &found, &one_sided(robot.model(), to), 1e-14);
    }
}

#[test]
fn single_precision_is_as_good_as_it_can_be() {
    #[allow(clippy::cast_possible_truncation)]
    let single = |x: &[f64]| -> Vec<f32> { x.iter().map(|x| *x as f32).collect() };
    let double = |x: Vec<f32>| -> Vec<f64> { x.into_iter().map(f64::from).collect() };
    let (robot, random) = (robot(), &mut Random::new(4));
    let small = Interpreter::<f32>::new(robot.model().clone());
    for angle in [0.0, 1e-20, 1e-6, 1e-3, 0.1, 1.0, 3.1] {
        let q = random_q(&robot, random);
        let mut v = vector(random, robot.model().nv(), 1.0);
        stretch(robot.model(), &mut v, angle);
        let (q, v) = (single(&q), single(&v));
        let found = between(&small, &q, &moved(&small, &q, &v));
        assert_close(&format!("rotates by {angle}"), &double(found), &double(v), 2e-6);
    }
}

#[test]
fn a_step_is_the_integral_of_the_rates() {
    let robot = robot();
    let random = &mut Random::new(5);
    let q = random_q(&robot, random);
    let qd = vector(random, robot.model().nv(), 1.5);
    let plus =
        |a: &[f64], h: f64, b: &[f64]| -> Vec<f64> { zip(a, b).map(|(a, b)| a + h * b).collect() };
    // Steps of the classical fourth-order Runge-Kutta method.
    let (steps, h) = (1000, 1e-3);
    let mut at = q.clone();
    for _ in 0..steps {
        let k1 = rates(&robot, &at, &qd);
        let k2 = rates(&robot, &plus(&at, h / 2.0, &k1), &qd);
        let k3 = rates(&robot, &plus(&at, h / 2.0, &k2), &qd);
        let k4 = rates(&robot, &plus(&at, h, &k3), &qd);
        at = plus(&plus(&at, h / 6.0, &k1), h / 6.0, &k4);
        at = plus(&plus(&at, h / 3.0, &k2), h / 3.0, &k3);
    }
    let found = moved(&robot, &q, &qd);
    assert_close("one step", &found, &at, 1e-11);
}

#[test]
fn a_floating_body_follows_the_exponential_of_its_twist() {
    let mut robot = robot();
    let random = &mut Random::new(6);
    for size in [1e-9, 1e-3, 1.0, 6.0] {
        let q = random_q(&robot, random);
        let v = vector(random, robot.model().nv(), size);
        let [x, y, z, a, b, c] = v[..6] else { unreachable!() };
        #[rustfmt::skip]
        let twist = DMatrix::from_row_slice(4, 4, &[
            0.0, -c, b, x,
            c, 0.0, -a, y,
            -b, a, 0.0, z,
            0.0, 0.0, 0.0, 0.0,
        ]);
        let matrix = |pose: &Pose<f64>| {
            let (r, p) = (pose.rotation, pose.translation);
            let mut m = DMatrix::identity(4, 4);
            (0..3).for_each(|i| (0..3).for_each(|j| m[(i, j)] = r[i][j]));
            (0..3).for_each(|i| m[(i, 3)] = p[i]);
            m
        };
        let there = moved(&robot, &q, &v);
        let expected = matrix(&robot.poses(&q)[0]) * twist.exp();
        let found = matrix(&robot.poses(&there)[0]);
        assert_close("the pose", found.as_slice(), expected.as_slice(), 1e-13);
    }
}

#[test]
fn quaternions_stay_of_length_one_over_many_steps() {
    let robot = robot();
    let random = &mut Random::new(7);
    let mut q = random_q(&robot, random);
    for _ in 0..10_000 {
        let v = vector(random, robot.model().nv(), 0.1);
        q = moved(&robot, &q, &v);
    }
    for (at, _) in rotations(robot.model()) {
        assert!((length(&q[at..at + 4]) - 1.0).abs() < 1e-15);
    }
}

#[test]
#[allow(clippy::cast_precision_loss)]
fn random_coordinates_are_within_limits_and_evenly_spread() {
    let mut robot = robot();
    let random = &mut Random::new(8);
    let blocks = Mechanism::new(robot.model()).coordinates;
    let lines: Vec<(usize, f64, f64)> = blocks
        .iter()
        .filter_map(|block| match block.space {
            CoordinateSpace::Line { low, high } => Some((block.q, low, high)),
            _ => None,
        })
        .collect();
    let ranges: Vec<(f64, f64)> = lines.iter().map(|&(_, low, high)| (low, high)).collect();
    let (angle, displacement) = ((-PI, PI), (-1.0, 1.0));
    assert_eq!(
        ranges,
        [
            angle,
            angle,
            // The limits of the mimic joint, -0.1 <= -2 q + 0.5 <= 0.1.
            (0.2, 0.3),
            displacement,
            displacement,
            angle,
            (0.2, 0.4),
            angle,
            displacement
        ]
    );
    let mut sums = vec![(0.0, 0.0); robot.model().nq()];
    let mut rotation = Matrix3::zeros();
    let count = 20_000;
    for _ in 0..count {
        let q = random_q(&robot, random);
        for &(at, low, high) in &lines {
            assert!((low..=high).contains(&q[at]));
        }
        for (at, _) in rotations(robot.model()) {
            assert!((length(&q[at..at + 4]) - 1.0).abs() < 4e-16);
        }
        assert!(q[..3].iter().all(|x| x.abs() <= 1.0));
        for (sum, x) in zip(&mut sums, &q) {
            *sum = (sum.0 + x, sum.1 + x * x);
        }
        rotation += Matrix3::from_row_slice(&numbers(&robot.poses(&q)[0])[..9]);
    }
    let n = f64::from(count);
    // The mean of a uniformly distributed rotation matrix is 0, the variance of its entries 1/3; five standard
    // deviations.
    assert!((rotation / n).amax() < 5.0 * (1.0 / (3.0 * n)).sqrt(), "{rotation}");
    for &(at, low, high) in &lines {
        let (mean, square) = (sums[at].0 / n, sums[at].1 / n);
        let (middle, deviation) = ((low + high) / 2.0, (high - low) / 12.0_f64.sqrt());
        assert!((mean - middle).abs() < 5.0 * deviation / n.sqrt());
        let variance = square - mean * mean;
        assert!((variance / deviation.powi(2) - 1.0).abs() < 0.04);
    }
    for (at, _) in rotations(robot.model()) {
        for (mean, square) in &sums[at..at + 4] {
            assert!((mean / n).abs() < 5.0 * 0.5 / n.sqrt());
            assert!((square / n - 0.25).abs() < 0.01);
        }
    }
}

#[test]
fn random_coordinates_take_one_number_a_degree_of_freedom() {
    let robot = robot();
    let mut q = vec![f64::NAN; robot.model().nq()];
    for number in [0.0, 1.0 - f64::EPSILON / 2.0] {
        let mut calls = 0;
        let uniform = || {
            calls += 1;
            number
        };
        robot.random_configuration(uniform, &mut q).expect(LENGTHS);
        assert_eq!(calls, robot.model().nv());
        assert!(q.iter().all(|x| x.is_finite()));
    }
}

#[test]
fn limits_on_one_side_leave_a_range_on_the_other() {
    let range_of = |joint_type, lower, upper| {
        let joint = Joint::new("joint", joint_type, [0.0, 0.0, 1.0], Pose::identity());
        let limits = Some(Limits { lower, upper, velocity: None, effort: None });
        let joint = Joint { limits, ..joint };
        let name = "link".into();
        let links = vec![MovingLink { name, parent: None, joint, inertial: Inertial::default() }];
        let model = Model::new("one", DEFAULT_GRAVITY, links, vec![]).expect("a valid model");
        match Mechanism::new(&model).coordinates[0].space {
            CoordinateSpace::Line { low, high } => (low, high),
            other => panic!("{other:?}"),
        }
    };
    let range = |lower, upper| range_of(JointType::Prismatic, lower, upper);
    assert_eq!(range(Some(3.0), None), (3.0, 5.0));
    assert_eq!(range(None, Some(-3.0)), (-5.0, -3.0));
    assert_eq!(range(Some(f64::NEG_INFINITY), Some(f64::INFINITY)), (-1.0, 1.0));
    let revolute = |lower, upper| range_of(JointType::Revolute, lower, upper);
    assert_eq!(revolute(Some(1.0), None), (1.0, 1.0 + 2.0 * PI));
    assert_eq!(revolute(None, Some(-1.0)), (-1.0 - 2.0 * PI, -1.0));
}

/// Chains of mimic joints narrow the range of their leader; contradictory limits of a mimic joint do not.
#[test]
fn limits_of_mimic_joints_are_limits_of_their_leader() {
    let range_of = |own: [f64; 2], followers: [(usize, f64, f64, [f64; 2]); 2]| {
        let joints = [(None, own)].into_iter().chain(followers.map(
            |(leader, multiplier, offset, range)| {
                (Some(Mimic { leader, multiplier, offset }), range)
            },
        ));
        let links: Vec<MovingLink> = joints
            .enumerate()
            .map(|(i, (mimic, [lower, upper]))| {
                let joint = Joint::new(
                    format!("joint{i}"),
                    JointType::Revolute,
                    [0.0, 0.0, 1.0],
                    Pose::identity(),
                );
                let bound = |x: f64| x.is_finite().then_some(x);
                let (lower, upper) = (bound(lower), bound(upper));
                let limits = Some(Limits { lower, upper, velocity: None, effort: None });
                let joint = Joint { limits, mimic, ..joint };
                let name = format!("link{i}");
                MovingLink { name, parent: i.checked_sub(1), joint, inertial: Inertial::default() }
            })
            .collect();
        let model = Model::new("mimics", DEFAULT_GRAVITY, links, vec![]).expect("a valid model");
        let ranges = [0, 1, 2].map(|link| model.coordinate_range(link));
        assert_eq!(ranges, [ranges[0]; 3], "a mimic joint has the range of its leader");
        ranges[0]
    };
    const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    // -1 <= -2 q + 3 <= 1, and the second follows the first: -9 <= 4 (-2 q + 3) - 1 <= 1.
    let chain = |own| range_of(own, [(0, -2.0, 3.0, [-1.0, 1.0]), (1, 4.0, -1.0, [-9.0, 1.0])]);
    assert_close("chain", &chain(FREE), &[1.25, 2.0], 1e-15);
    assert_close("chain", &chain([1.5, 9.0]), &[1.5, 2.0], 1e-15);
    // The first leaves one point, and does not count; the second does.
    assert_eq!(chain([2.0, 3.0]), [2.0, 2.5]);
    assert_eq!(chain([5.0, 6.0]), [5.0, 6.0]);
    let free = range_of(FREE, [(0, -2.0, 3.0, FREE), (0, 1.0, 0.0, [f64::NEG_INFINITY, 0.5])]);
    assert_eq!(free, [f64::NEG_INFINITY, 0.5]);
}

#[test]
fn normalizing_leaves_rotations_and_gives_zeros_the_identity() {
    let robot = robot();
    let random = &mut Random::new(9);
    let expected = random_q(&robot, random);
    for scale in [1e-9, 0.5, 1.0, 1e9] {
        let mut q = expected.clone();
        for (at, _) in rotations(robot.model()) {
            q[at..at + 4].iter_mut().for_each(|x| *x *= scale);
        }
        robot.normalize_configuration(&mut q).expect(LENGTHS);
        assert_close("normalized", &q, &expected, 1e-15);
    }
    let (mut q, mut neutral) = (vec![0.0; expected.len()], vec![f64::NAN; expected.len()]);
    robot.normalize_configuration(&mut q).expect(LENGTHS);
    robot.neutral(&mut neutral).expect(LENGTHS);
    assert_eq!(q, neutral);
    let ones = rotations(robot.model()).into_iter().map(|(at, _)| at + 3);
    let ones: Vec<usize> = ones.collect();
    let expected: Vec<f64> =
        (0..q.len()).map(|i| if ones.contains(&i) { 1.0 } else { 0.0 }).collect();
    assert_eq!(q, expected);
}

#[test]
fn lengths_are_checked() {
    let robot = robot();
    let (nq, nv) = (robot.model().nq(), robot.model().nv());
    let (q, v, short) = (vec![0.0; nq], vec![0.0; nv], [0.0]);
    let (mut to_q, mut to_v) = (q.clone(), v.clone());
    let error = |parameter, expected| Err(ShapeError::new(parameter, expected, 1));
    assert_eq!(robot.integrate(&short, &v, &mut to_q), error("q", nq));
    assert_eq!(robot.integrate(&q, &short, &mut to_q), error("v", nv));
    assert_eq!(robot.integrate(&q, &v, &mut [0.0]), error("moved", nq));
    assert_eq!(robot.difference(&short, &q, &mut to_v), error("from", nq));
    assert_eq!(robot.difference(&q, &short, &mut to_v), error("to", nq));
    assert_eq!(robot.difference(&q, &q, &mut [0.0]), error("v", nv));
    assert_eq!(robot.velocity_to_qdot(&short, &v, &mut to_q), error("q", nq));
    assert_eq!(robot.velocity_to_qdot(&q, &short, &mut to_q), error("qd", nv));
    assert_eq!(robot.velocity_to_qdot(&q, &v, &mut [0.0]), error("rates", nq));
    assert_eq!(robot.normalize_configuration(&mut [0.0]), error("q", nq));
    assert_eq!(robot.neutral(&mut [0.0]), error("q", nq));
    assert_eq!(robot.random_configuration(|| 0.5, &mut [0.0]), error("q", nq));
}
