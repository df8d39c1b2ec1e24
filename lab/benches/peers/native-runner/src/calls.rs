//! Calls of machine code.

use std::hint::black_box;
use std::ops::Range;

use modyn::{ConstraintSettings, ContactTarget};
use modyn_codegen::plan::Shape;
use modyn_codegen::{Builder, Function};
use modyn_jit::{Compiled, InstructionSet, Options};

use crate::measure::Job;
use crate::robots::Robot;

/// The results that are compared, in this order; a result without names is compared as a whole.
const COMPARED: [&str; 4] = ["qdd", "dqdd_dq", "dqdd_dqd", "dqdd_dtau"];

/// Returns the robot's builder, with this function.
pub fn builder(robot: &Robot, quantity: &str) -> Builder {
    let function = Function::from_name(quantity).expect("a function");
    Builder::new()
        .urdf(&robot.description)
        .base(robot.base)
        .contacts(robot.contacts.clone())
        .functions([function])
}

/// Returns the numbers of an argument that is the same at all states: all contacts are active, and nothing stabilizes them.
pub fn constant(name: &str, contacts: usize) -> Vec<f64> {
    match name {
        "active" => vec![1.0; contacts],
        "settings" => {
            let settings = ConstraintSettings::<f64, [ContactTarget<f64>; 0]>::EXACT.numbers();
            let target = ContactTarget::<f64>::EXACT.numbers();
            [&settings[..], &target.repeat(contacts)].concat()
        }
        other => panic!("no argument `{other}`"),
    }
}

/// Returns the places of the compared numbers in a result.
fn compared(result: &Shape) -> Vec<Range<usize>> {
    let Shape::Record(_, fields) = result else { return vec![0..result.len()] };
    let mut begin = 0;
    let mut places = Vec::new();
    for (name, shape) in fields {
        let place = begin..begin + shape.len();
        begin = place.end;
        places.push((*name, place));
    }
    let place = |wanted| places.iter().find(|(name, _)| *name == wanted);
    COMPARED.iter().filter_map(|name| place(*name)).map(|(_, place)| place.clone()).collect()
}

/// Checks and measures a function with these vector instructions, for one state a call or for all.
pub fn measure(job: &Job, robot: &Robot, set: InstructionSet, batch: bool) {
    let mut options = Options::default();
    (options.instruction_set, options.batches) = (Some(set), batch);
    let planning = builder(robot, &job.quantity).plan().expect("a robot");
    let compiled = Compiled::<f64>::from_plan(&planning, options).expect("machine code");
    let function = Function::from_name(&job.quantity).expect("a function");
    let call = compiled.function(function).expect("compiled");
    let names: Vec<&str> = call.arguments().iter().map(|(name, _)| *name).collect();
    let arguments = |[q, qd, tau, qdd]: &[Vec<f64>; 4]| -> Vec<Vec<f64>> {
        let argument = |name: &&str| match *name {
            "q" => q.clone(),
            "qd" => qd.clone(),
            "tau" => tau.clone(),
            "qdd" => qdd.clone(),
            other => constant(other, robot.contacts.len()),
        };
        names.iter().map(argument).collect()
    };
    let places = compared(call.result());
    let numbers = |result: &[f64]| {
        places.iter().flat_map(|place| &result[place.clone()]).copied().collect::<Vec<f64>>()
    };
    let states: Vec<Vec<Vec<f64>>> = job.states().iter().map(arguments).collect();
    let mut result = vec![0.0; call.result().len()];
    if batch {
        let count = states.len();
        let column = |k: usize| states.iter().flat_map(|state| &state[k]).copied().collect();
        let all: Vec<Vec<f64>> = (0..names.len()).map(column).collect();
        let given: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
        let mut results = result.repeat(count);
        let pass = |results: &mut [f64]| {
            call.many(black_box(&given), results).expect("sizes");
            black_box(results);
        };
        pass(&mut results);
        job.check(results.chunks(result.len()).map(numbers));
        job.time_all(count, || pass(&mut results));
        return;
    }
    // The slices are made outside of what is timed, as other programs' pointers are.
    let given: Vec<Vec<&[f64]>> =
        states.iter().map(|state| state.iter().map(Vec::as_slice).collect()).collect();
    job.check(given.iter().map(|state| {
        call.one(state, &mut result).expect("sizes");
        numbers(&result)
    }));
    job.time(&given, |state| {
        call.one(state, &mut result).expect("sizes");
        black_box(&result);
    });
}
