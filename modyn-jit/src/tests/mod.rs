//! Tests of instructions and of whole functions. The instructions are decoded by disassemblers that
//! share no code with the encoders; the functions are emulated, or run.

#[cfg(target_arch = "aarch64")]
mod calls_aarch64;
mod emulated;
mod emulator;
mod encoding;
mod encoding_aarch64;
mod page;

use std::mem::size_of;

use modyn_codegen::program::Program;
use modyn_codegen::{Function, Planning};
use modyn_tests::conformance::numbers::{Arithmetic, Number};
use modyn_tests::conformance::robot;
use modyn_tests::random::Random;

use crate::generate::{Generated, generate};
use crate::helper::Linkage;
use crate::instruction_set::InstructionSet;
use crate::lower::{Rows, lower};
use crate::real::Real;

/// A number of machine code.
pub(crate) trait Fuse: Real + Number {}

impl<F: Real + Number> Fuse for F {}

/// Returns the programs of some functions of a robot.
pub(crate) fn plan(name: &str, functions: &[Function]) -> Planning {
    robot(name).functions(functions.iter().copied()).plan().expect("good")
}

/// Returns random numbers.
pub(crate) fn numbers<F: Fuse>(seed: u64, count: usize, scale: f64) -> Vec<F> {
    let mut random = Random::new(seed);
    (0..count).map(|_| F::from_f64(random.between(-scale, scale))).collect()
}

/// Returns numbers as several arrays.
fn split<'a, F>(mut numbers: &'a [F], lengths: &[usize]) -> Vec<&'a [F]> {
    let next = |&length: &usize| {
        let (first, rest) = numbers.split_at(length);
        numbers = rest;
        first
    };
    lengths.iter().map(next).collect()
}

/// Returns the instruction sets of x86-64, which this processor may lack.
pub(crate) fn sets_of_x86_64() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|set| set.architecture() == "x86_64")
}

/// Returns a program's results with the instruction set's rounding.
fn evaluate<F: Fuse>(
    program: &Program,
    instruction_set: InstructionSet,
    arguments: &[F],
) -> Vec<F> {
    let fuses = instruction_set.fuses();
    let arithmetic = if fuses { Arithmetic::FusedSines } else { Arithmetic::Separate };
    modyn_tests::conformance::numbers::evaluate(program, arithmetic, arguments)
}

/// Checks the code of whole functions of a robot: on scalars, with vectors, and for many states.
fn check_functions<S: Real>(
    robot: &str,
    instruction_set: InstructionSet,
    linkage: &Linkage,
    check: impl Fn(&Generated),
) {
    let functions = [Function::ForwardDynamics, Function::Difference, Function::MassMatrix];
    for planned in &plan(robot, &functions).plan.functions {
        let Some((scalar, simd)) = planned.kernels.straight() else { continue };
        let arrays = planned.lengths();
        for (program, batch) in [(scalar, false), (simd, false), (scalar, true)] {
            let values = lower::<S>(program, &arrays, instruction_set, batch, Rows::All);
            let bytes = size_of::<S>();
            check(&generate(&values, instruction_set, bytes, arrays.len(), linkage, None));
        }
    }
}
