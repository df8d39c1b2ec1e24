//! Other crates that compute dynamics, measured as modyn is: `crates-runner CRATE FOLDER ROBOT QUANTITY REPETITIONS
//! MODEL`.

mod dynamics_rs;
mod dynibo;
#[path = "../../modyn-runner/src/measure.rs"]
mod measure;
mod phyz;

use std::path::Path;

use measure::Job;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [name, folder, robot, quantity, repetitions, model] = arguments[..] else {
        panic!("CRATE FOLDER ROBOT QUANTITY REPETITIONS MODEL");
    };
    let job = Job::read(Path::new(folder), robot, quantity, repetitions);
    match name {
        "phyz" => phyz::measure(&job, model),
        "dynamics-rs" => dynamics_rs::measure(&job, model),
        "dynibo" => dynibo::measure(&job, model),
        _ => panic!("no crate `{name}`"),
    }
}

/// Returns numbers of modyn in another order: entry i is modyn's entry `order[i]`.
fn placed(numbers: &[f64], order: &[usize]) -> Vec<f64> {
    order.iter().map(|&k| numbers[k]).collect()
}

/// Returns the numbers in modyn's order.
fn back(numbers: impl Iterator<Item = f64>, order: &[usize]) -> Vec<f64> {
    let mut out = vec![0.0; order.len()];
    numbers.zip(order).for_each(|(number, &k)| out[k] = number);
    out
}

/// Returns a square matrix in modyn's order, by columns.
fn back_matrix(entry: impl Fn(usize, usize) -> f64, order: &[usize]) -> Vec<f64> {
    let n = order.len();
    let mut out = vec![0.0; n * n];
    for (i, row) in order.iter().enumerate() {
        for (j, column) in order.iter().enumerate() {
            out[column * n + row] = entry(i, j);
        }
    }
    out
}

/// Returns modyn's index of each joint of the other software.
fn order<'a>(job: &Job, names: impl Iterator<Item = &'a str>) -> Vec<usize> {
    let find = |name: &str| job.joints.iter().position(|joint| joint == name);
    let order: Vec<usize> = names.filter_map(find).collect();
    assert_eq!(order.len(), job.nv, "the same joints");
    order
}
