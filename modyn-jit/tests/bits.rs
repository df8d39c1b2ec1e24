//! Machine code computes the bits of its program's evaluation, for all robots and all instruction sets of the
//! processor: for small and large angles, infinities and NaN, one state and many.

use crate::common;

use common::{
    Fuse, ROBOTS, evaluate, has_vectors, instruction_sets, is_same, numbers, plan, program, random,
    split,
};
use modyn_codegen::diagnostics::Code;
use modyn_codegen::{Builder, Function, Planning};
use modyn_jit::{Compiled, InstructionSet, Options};
use modyn_runtime::model::Model;

const FUNCTIONS: [Function; 9] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::KineticEnergy,
    Function::ForwardDynamicsDerivatives,
    Function::ConstrainedForwardDynamics,
    Function::Difference,
    Function::Integrate,
    Function::Random,
];

fn compile<F: Fuse>(planning: &Planning, instruction_set: InstructionSet) -> Compiled<F> {
    let mut options = Options::default();
    (options.instruction_set, options.batches) = (Some(instruction_set), true);
    Compiled::from_plan(planning, options).expect("code")
}

/// States: small angles, angles about the limit of the fast reduction, larger ones, and one with infinities and NaN.
fn states<F: Fuse>(count: usize) -> Vec<Vec<F>> {
    let scales = [1.5, 30.0, 6e3, 3e5, 1e20].iter().zip(1..);
    let mut states: Vec<Vec<F>> =
        scales.map(|(&scale, seed)| numbers(seed, count, scale)).collect();
    for (seed, special) in [(6, f64::INFINITY), (7, f64::NAN), (8, 0.0), (9, -0.0), (10, 1e-310)] {
        let mut state: Vec<F> = numbers(seed, count, 2.0);
        state[seed as usize % count] = F::from_f64(special);
        states.push(state);
    }
    states
}

fn compare<F: Fuse>(name: &str, planning: &Planning, instruction_set: InstructionSet) -> usize {
    let compiled = compile::<F>(planning, instruction_set);
    assert_eq!(compiled.instruction_set(), instruction_set);
    let mut compared = 0;
    for function in compiled.functions() {
        let vectors = has_vectors::<F>(instruction_set);
        let Some(of_one) = program(planning, function, vectors) else { continue };
        let call = compiled.function(function).expect("compiled");
        let lengths: Vec<usize> = call.arguments().iter().map(|(_, shape)| shape.len()).collect();
        let states = states::<F>(lengths.iter().sum());
        let mut many: Vec<Vec<F>> = vec![Vec::new(); lengths.len()];
        for (k, state) in states.iter().enumerate() {
            let arguments = split(state, &lengths);
            let mut found = vec![F::from_f64(f64::NAN); call.result().len()];
            call.one(&arguments, &mut found).expect("fits");
            let expected = evaluate(of_one, instruction_set, state);
            for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
                let function = function.name();
                assert!(
                    is_same(*a, *b),
                    "{name} {function} {instruction_set:?} {k} {i}: {a:?} {b:?}"
                );
                compared += 1;
            }
            for (all, argument) in many.iter_mut().zip(arguments) {
                all.extend_from_slice(argument);
            }
        }
        let arguments: Vec<&[F]> = many.iter().map(Vec::as_slice).collect();
        let one = call.result().len();
        let mut found = vec![F::from_f64(f64::NAN); one * states.len()];
        call.many(&arguments, &mut found).expect("fits");
        let program = program(planning, function, false).expect("not of a link");
        for (k, state) in states.iter().enumerate() {
            let expected = evaluate(program, instruction_set, state);
            for (i, (a, b)) in found[k * one..].iter().zip(&expected).enumerate() {
                let function = function.name();
                assert!(
                    is_same(*a, *b),
                    "{name} many {function} {instruction_set:?} {k} {i}: {a:?} {b:?}"
                );
                compared += 1;
            }
        }
    }
    compared
}

fn robots(robots: &[&str]) {
    for name in robots {
        let planning = plan(name, &FUNCTIONS);
        for instruction_set in instruction_sets() {
            let compared =
                [compare::<f64>, compare::<f32>].map(|of| of(name, &planning, instruction_set));
            assert!(compared.iter().all(|&count| count > 500), "{name} {compared:?}");
        }
    }
}

#[test]
fn small_robots() {
    robots(&ROBOTS[..7]);
}

#[test]
fn arms_and_loops() {
    robots(&ROBOTS[7..10]);
}

#[test]
fn a_humanoid() {
    robots(&ROBOTS[10..]);
}

/// Compares machine code of some functions of one state of a random robot.
fn compare_some(seed: u64, model: Model) {
    let mut random = random::Random::new(seed);
    let mut functions = Function::ALL.to_vec();
    functions.retain(|function| {
        let fits = !function.row().of_constraints && function.batched().is_none();
        fits && *function != Function::Brge && random.chance(0.2)
    });
    let name = format!("seed {seed}, {}", model.name());
    let planning = match Builder::new().model(model).functions(functions).plan() {
        Ok(planning) => planning,
        // A few of many seeds: a Runge-Kutta derivative of such a robot would be too long.
        Err(errors) if errors.iter().all(|error| error.code == Code::TooLarge) => return,
        Err(errors) => panic!("{errors}"),
    };
    for instruction_set in instruction_sets() {
        compare::<f64>(&name, &planning, instruction_set);
        compare::<f32>(&name, &planning, instruction_set);
    }
}

/// With joints of all types.
#[test]
fn random_robots() {
    for seed in random::seeds(2) {
        compare_some(seed, random::mixed_zoo(seed, 2 + (seed % 6) as usize));
    }
}

/// With equal and similar limbs.
#[test]
fn random_limbs() {
    for seed in random::seeds(2) {
        compare_some(seed, random::limbs(seed, 3 + (seed % 4) as usize));
    }
}
