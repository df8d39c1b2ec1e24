//! Derivatives of `integrate` and `difference`: against Pinocchio, against dual numbers, and each other's inverse.

use std::iter::zip;
use std::path::Path;

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{DEFAULT_GRAVITY, Inertial, Joint, Link, Model, MovingLink};
use modyn_runtime::spatial::Pose;
use modyn_runtime::{Interpreter, Scalar};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant};
use modyn_tests::random::Random;
use serde_json::Value;

const LENGTHS: &str = "the lengths are right";

/// A floating, a spherical, a revolute and a prismatic joint, as in `lab/golden/displacements.py`.
fn robot() -> Model {
    let types =
        [JointType::Floating, JointType::Spherical, JointType::Revolute, JointType::Prismatic];
    let link = |(i, joint_type): (usize, JointType)| {
        let joint = Joint::new(format!("joint{i}"), joint_type, [1.0, 0.0, 0.0], Pose::identity());
        let name = format!("link{i}");
        MovingLink { name, parent: i.checked_sub(1), joint, inertial: Inertial::default() }
    };
    let links: Vec<MovingLink> = types.into_iter().enumerate().map(link).collect();
    let frames = links.iter().enumerate().map(|(i, link)| Link {
        name: link.name.clone(),
        moving_link: Some(i),
        pose: Pose::identity(),
        inertial: link.inertial,
    });
    let frames = frames.collect();
    Model::new("spaces", DEFAULT_GRAVITY, links, frames).expect("a valid model")
}

fn moved<S: Scalar>(robot: &Interpreter<S>, q: &[S], v: &[S]) -> Vec<S> {
    let mut moved = q.to_vec();
    robot.integrate(q, v, &mut moved).expect(LENGTHS);
    moved
}

fn between<S: Scalar>(robot: &Interpreter<S>, from: &[S], to: &[S]) -> Vec<S> {
    let mut v = vec![S::zero(); robot.model().nv()];
    robot.difference(from, to, &mut v).expect(LENGTHS);
    v
}

/// Returns the derivatives of `integrate` by q, then by v.
fn of_integrate(robot: &Interpreter<f64>, q: &[f64], v: &[f64]) -> [Vec<f64>; 2] {
    let mut found = [0, 1].map(|_| vec![f64::NAN; v.len().pow(2)]);
    let [dq, dv] = &mut found;
    robot.integrate_derivatives(q, v, dq, dv).expect(LENGTHS);
    found
}

/// Returns the derivatives of `difference` by the first, then by the second coordinates.
fn of_difference(robot: &Interpreter<f64>, from: &[f64], to: &[f64]) -> [Vec<f64>; 2] {
    let mut found = [0, 1].map(|_| vec![f64::NAN; robot.model().nv().pow(2)]);
    let [dfrom, dto] = &mut found;
    robot.difference_derivatives(from, to, dfrom, dto).expect(LENGTHS);
    found
}

/// Returns coordinates and a displacement in general position, whose rotations have this angle.
fn state(model: &Model, angle: f64, random: &mut Random) -> (Vec<f64>, Vec<f64>) {
    let mut q = vec![0.0; model.nq()];
    Interpreter::<f64>::new(model.clone())
        .random_configuration(|| random.between(0.0, 1.0), &mut q)
        .expect(LENGTHS);
    let mut v: Vec<f64> = (0..model.nv()).map(|_| random.between(-1.0, 1.0)).collect();
    for at in [3, 6] {
        let length = v[at..at + 3].iter().map(|x| x * x).sum::<f64>().sqrt();
        v[at..at + 3].iter_mut().for_each(|x| *x *= angle / length);
    }
    (q, v)
}

/// Angles with series, with closed forms, around the limits between them, and close to half a turn.
const ANGLES: [f64; 12] =
    [0.0, 1e-160, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 0.124, 0.126, 0.249, 0.251, 3.1];

#[test]
fn derivatives_are_those_of_other_software() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/displacements.json");
    let text = std::fs::read_to_string(path).expect("the reference data");
    let data: Value = serde_json::from_str(&text).expect("JSON");
    let robot = Interpreter::<f64>::new(robot());
    let states = data["states"].as_array().expect("states");
    assert_eq!(states.len(), 6);
    for state in states {
        let numbers = |value: &Value| -> Vec<f64> {
            value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
        };
        let vector = |name: &str| numbers(&state[name]);
        // The file has rows.
        let matrix = |name: &str| -> Vec<f64> {
            let rows: Vec<Vec<f64>> =
                state[name].as_array().expect("rows").iter().map(numbers).collect();
            (0..rows.len()).flat_map(|j| rows.iter().map(move |row| row[j])).collect()
        };
        let (q, v, to) = (vector("q"), vector("v"), vector("to"));
        let [dq, dv] = of_integrate(&robot, &q, &v);
        assert_close("integrate by q", &dq, &matrix("integrate_dq"), 1e-11);
        assert_close("integrate by v", &dv, &matrix("integrate_dv"), 1e-11);
        let [dfrom, dto] = of_difference(&robot, &q, &to);
        assert_close("difference by from", &dfrom, &matrix("difference_dfrom"), 1e-11);
        assert_close("difference by to", &dto, &matrix("difference_dto"), 1e-11);
    }
}

#[test]
fn derivatives_are_those_of_dual_numbers() {
    let model = robot();
    let (robot, dual) = (Interpreter::new(model.clone()), Interpreter::new(model.clone()));
    let random = &mut Random::new(1);
    let slopes = |v: Vec<Tangent<f64>>| v.into_iter().map(|v| v.dx);
    for angle in ANGLES {
        let (q, v) = state(&model, angle, random);
        let to = moved(&robot, &q, &v);
        let reached = constant(&to);
        let mut expected: [Vec<f64>; 4] = Default::default();
        for k in 0..model.nv() {
            let by_q = moved(&dual, &along_velocity(&model, &q, k), &constant(&v));
            let by_v = moved(&dual, &constant(&q), &along(&v, k));
            expected[0].extend(slopes(between(&dual, &reached, &by_q)));
            expected[1].extend(slopes(between(&dual, &reached, &by_v)));
            let from = along_velocity(&model, &q, k);
            expected[2].extend(slopes(between(&dual, &from, &reached)));
            let to = along_velocity(&model, &to, k);
            expected[3].extend(slopes(between(&dual, &constant(&q), &to)));
        }
        let found = [of_integrate(&robot, &q, &v), of_difference(&robot, &q, &to)].concat();
        for (k, (found, expected)) in zip(found, expected).enumerate() {
            assert_close(&format!("derivative {k} at {angle}"), &found, &expected, 2e-13);
        }
    }
}

/// The derivative of `difference` by its second argument is the inverse of that of `integrate` by the displacement.
#[test]
fn the_derivatives_are_inverse_to_each_other() {
    let model = robot();
    let robot = Interpreter::new(model.clone());
    let (n, random) = (model.nv(), &mut Random::new(2));
    for angle in ANGLES {
        let (q, v) = state(&model, angle, random);
        let [_, dv] = of_integrate(&robot, &q, &v);
        let [_, dto] = of_difference(&robot, &q, &moved(&robot, &q, &v));
        let product =
            |i: usize, j: usize| (0..n).map(|k| dto[k * n + i] * dv[j * n + k]).sum::<f64>();
        let found: Vec<f64> = (0..n * n).map(|at| product(at % n, at / n)).collect();
        let unit: Vec<f64> = (0..n * n).map(|at| f64::from(u8::from(at % n == at / n))).collect();
        assert_close(&format!("the product at {angle}"), &found, &unit, 1e-12);
    }
}
