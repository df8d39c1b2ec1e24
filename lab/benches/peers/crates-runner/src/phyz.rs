//! The crate phyz; its model is made from the output of `../../pinocchio_model.py`.

use std::hint::black_box;

use phyz_math::{DVec, Mat3, SpatialInertia, SpatialTransform, Vec3};
use phyz_model::{Joint, Model, ModelBuilder, State};
use phyz_rigid::{aba, crba, rnea};

use crate::measure::Job;
use crate::{back, back_matrix, order, placed};

/// The model, and the names of its joints.
fn read(path: &str) -> (Model, Vec<String>) {
    let text = std::fs::read_to_string(path).expect("a model");
    let mut builder = ModelBuilder::new().gravity(Vec3::new(0.0, 0.0, -9.81));
    let mut names = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| words[3 + k].parse::<f64>().expect("a number");
        let vector = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2));
        let matrix =
            |k: usize| Mat3::from_cols(vector(k), vector(k + 3), vector(k + 6)).transpose();
        // phyz's placements are rotations of coordinates.
        let mut joint = Joint::revolute(SpatialTransform::new(matrix(3).transpose(), vector(12)));
        joint.axis = match words[2] {
            "RX" => Vec3::new(1.0, 0.0, 0.0),
            "RY" => Vec3::new(0.0, 1.0, 0.0),
            "RZ" => Vec3::new(0.0, 0.0, 1.0),
            "RevoluteUnaligned" => vector(0),
            other => panic!("no joint `{other}`"),
        };
        let parent: i32 = words[1].parse().expect("a parent");
        let inertia = SpatialInertia::new(number(15), vector(16), matrix(19));
        builder = builder.add_body(words[0], parent - 1, joint, inertia);
        names.push(words[0].into());
    }
    (builder.build(), names)
}

/// Measures the crate.
pub fn measure(job: &Job, path: &str) {
    let (model, names) = read(path);
    let order = order(job, names.iter().map(String::as_str));
    let states: Vec<(State, DVec)> = job
        .states()
        .iter()
        .map(|[q, qd, tau, qdd]| {
            let [q, v, ctrl, qdd] = [q, qd, tau, qdd].map(|x| DVec::from_slice(&placed(x, &order)));
            (State { q, v, ctrl, ..model.default_state() }, qdd)
        })
        .collect();
    match job.quantity.as_str() {
        "forward_dynamics" => {
            let result = |(state, _): &(State, DVec)| aba(&model, state);
            job.check(states.iter().map(|x| back(result(x).as_slice().iter().copied(), &order)));
            job.time(&states, |state| drop(black_box(result(state))));
        }
        "inverse_dynamics" => {
            let result = |(state, qdd): &(State, DVec)| rnea(&model, state, qdd);
            job.check(states.iter().map(|x| back(result(x).as_slice().iter().copied(), &order)));
            job.time(&states, |state| drop(black_box(result(state))));
        }
        "mass_matrix" => {
            let result = |(state, _): &(State, DVec)| crba(&model, state);
            job.check(states.iter().map(|x| {
                let matrix = result(x);
                back_matrix(|i, j| matrix[(i, j)], &order)
            }));
            job.time(&states, |state| drop(black_box(result(state))));
        }
        other => panic!("no quantity `{other}`"),
    }
}
