//! Random states, and the interpreter's results at them.

use std::fs;
use std::path::Path;

use modyn::equations::State;
use modyn::equations::constraints::ImpulseOutputs;
use modyn::{Interpreter, Wrench, model::Model};
use modyn_codegen::{Base, ReadOptions, read};

use crate::interpreted::{Quantity, settings};
use crate::measure::CHECKED;
use crate::robots::Robot;

/// The number of states of a robot.
const STATES: usize = 1024;

/// Returns the robot's model.
pub fn model(robot: &Robot) -> Model {
    let file = &robot.description;
    let text = fs::read_to_string(file).expect("a description");
    let mut options = ReadOptions::default();
    options.base = robot.base;
    options.contacts.clone_from(&robot.contacts);
    read(&text, &file.to_string_lossy(), &options).expect("a robot").model
}

/// Returns numbers in -1..1, the same on every machine: a linear congruential generator.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Returns random coordinates; a floating base has its position and a unit quaternion (x, y, z, w) first.
fn coordinates(robot: &Robot, nq: usize, number: &mut impl FnMut() -> f64) -> Vec<f64> {
    let mut q: Vec<f64> = (0..nq).map(|_| 3.0 * number()).collect();
    if robot.base == Base::Floating {
        let norm = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[3..7].iter_mut().for_each(|x| *x /= norm);
    }
    q
}

/// Returns the velocities after the contacts have stopped their links.
fn at_rest(robot: &mut Interpreter<f64>, q: &[f64], qd: &[f64]) -> Vec<f64> {
    let contacts = robot.model().contacts().len();
    let (mut after, mut impulses) = (qd.to_vec(), vec![Wrench::zero(); contacts]);
    let (active, settings) = (vec![true; contacts], settings(contacts));
    let results = ImpulseOutputs { qd: &mut after, impulses: &mut impulses };
    robot.impact_dynamics(State { q, qd }, &active, &settings, results).expect("sizes");
    after
}

/// Writes, as little-endian doubles, `ROBOT.states`: q, qd, tau, qdd of one state after the other,
/// and `ROBOT.QUANTITY`: the results at the first states; as text `ROBOT.model`: nq, nv, then the
/// joints in modyn's order. Links that touch the ground are at rest.
pub fn write(robot: &Robot, folder: &Path) {
    let model = model(robot);
    let (nq, nv) = (model.nq(), model.nv());
    let mut number = numbers();
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let states: Vec<[Vec<f64>; 4]> = (0..STATES)
        .map(|_| {
            let q = coordinates(robot, nq, &mut number);
            let [mut qd, tau, qdd] =
                [2.0, 5.0, 5.0].map(|size| (0..nv).map(|_| size * number()).collect::<Vec<f64>>());
            if !robot.contacts.is_empty() {
                qd = at_rest(&mut interpreter, &q, &qd);
            }
            [q, qd, tau, qdd]
        })
        .collect();
    let file = |extension: &str| folder.join(format!("{}.{extension}", robot.name));
    let save = |extension: &str, numbers: &[f64]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        fs::write(file(extension), bytes).expect("a folder to write to");
    };
    save("states", &states.concat().concat());
    let joints = model.moving_links().iter().map(|link| format!("{}\n", link.joint.name));
    let text = format!("{nq} {nv}\n{}", joints.collect::<String>());
    fs::write(file("model"), text).expect("a folder to write to");

    for name in robot.quantities {
        let mut quantity = Quantity::new(model.clone(), name);
        let mut all = Vec::new();
        for state in &states[..CHECKED] {
            all.extend(quantity.compute(state.each_ref().map(Vec::as_slice)));
        }
        save(name, &all);
    }
}
