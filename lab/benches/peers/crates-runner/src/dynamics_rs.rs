//! The crate dynamics-rs, which reads the description itself.

use std::hint::black_box;

use dynamics_rs::model::data::Data;
use dynamics_rs::prelude::{
    ABAConvention, Configuration, build_models_from_urdf, forward_dynamics, inverse_dynamics,
};

use crate::measure::Job;
use crate::{back, order, placed};

/// Measures the crate.
pub fn measure(job: &Job, path: &str) {
    let (model, ..) = build_models_from_urdf(path, None).expect("a robot");
    let order = order(job, model.joint_names.iter().map(String::as_str));
    let states: Vec<[Configuration; 4]> = job
        .states()
        .iter()
        .map(|state| state.each_ref().map(|x| Configuration::from_row_slice(&placed(x, &order))))
        .collect();
    let mut data = model.create_data();
    match job.quantity.as_str() {
        "forward_dynamics" => run(job, &states, &order, |[q, qd, tau, _]| {
            let none = None;
            forward_dynamics(&model, &mut data, q, qd, tau, none, ABAConvention::Local)
                .expect("sizes")
                .clone()
        }),
        "inverse_dynamics" => run(job, &states, &order, |[q, qd, _, qdd]| {
            inverse_dynamics(&model, &mut data, q, qd, qdd, None).expect("sizes").clone()
        }),
        other => panic!("no quantity `{other}`"),
    }
    let _: Data = data;
}

fn run(
    job: &Job,
    states: &[[Configuration; 4]],
    order: &[usize],
    mut result: impl FnMut(&[Configuration; 4]) -> Configuration,
) {
    job.check(states.iter().map(|state| {
        let result = result(state);
        back((0..result.len()).map(|k| result[k]), order)
    }));
    job.time(states, |state| drop(black_box(result(state))));
}
