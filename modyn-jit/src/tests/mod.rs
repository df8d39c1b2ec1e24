//! Tests of instructions and of whole functions. The instructions are decoded by disassemblers that share no code
//! with the encoders; the functions are emulated, or run.

#[cfg(target_arch = "aarch64")]
mod calls_aarch64;
#[path = "../../tests/common/mod.rs"]
pub(crate) mod common;
mod emulated;
mod emulator;
mod encoding;
mod encoding_aarch64;
mod page;

use std::mem::size_of;

use modyn_codegen::Function;

use crate::generate::{Generated, generate};
use crate::helper::Linkage;
use crate::instruction_set::InstructionSet;
use crate::lower::lower;
use crate::real::Real;

/// Checks the code of whole functions of a robot: on scalars, with vectors, and for many states.
fn check_functions<S: Real>(
    robot: &str,
    instruction_set: InstructionSet,
    linkage: &Linkage,
    check: impl Fn(&Generated),
) {
    let functions = [Function::ForwardDynamics, Function::Difference, Function::MassMatrix];
    for planned in &common::plan(robot, &functions).plan.functions {
        let Some((scalar, simd)) = planned.kernels.straight() else { continue };
        let arrays = planned.lengths();
        for (program, batch) in [(scalar, false), (simd, false), (scalar, true)] {
            let values = lower::<S>(program, &arrays, instruction_set, batch);
            let bytes = size_of::<S>();
            check(&generate(&values, instruction_set, bytes, arrays.len(), linkage));
        }
    }
}
