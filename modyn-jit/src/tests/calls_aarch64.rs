//! Functions of aarch64 keep the registers of their caller.
//!
//! Unsafe code: a call of a function that `generate` has made, with the arguments that it reads and
//! writes.
#![allow(unsafe_code)]

use std::arch::asm;

use modyn_codegen::Function;

use super::{numbers, plan};
use crate::generate::generate;
use crate::helper::{Helpers, Linkage};
use crate::instruction_set::InstructionSet;
use crate::lower::{Rows, lower};
use crate::machine::Pages;

#[test]
fn registers_of_the_caller_are_kept() {
    let planning = plan("humanoid", &[Function::ForwardDynamics]);
    let (program, _) = planning.plan.functions[0].kernels.straight().expect("one program");
    let arrays: Vec<usize> =
        planning.plan.functions[0].arguments.iter().map(|(_, shape)| shape.len()).collect();
    let values = lower::<f64>(program, &arrays, InstructionSet::Neon, false, Rows::All);
    let linkage = Linkage::Addresses(Helpers::new::<f64>());
    let generated = generate(&values, InstructionSet::Neon, 8, arrays.len(), &linkage, None);
    assert!(generated.size.spills > 0, "all registers are written");
    let pages = Pages::new(&generated.code).expect("executable memory");
    // Small angles, and those that a call reduces.
    for scale in [1.0, 1e6] {
        let arguments: Vec<Vec<f64>> =
            (1..).zip(&arrays).map(|(seed, &length)| numbers(seed, length, scale)).collect();
        let table: Vec<*const f64> = arguments.iter().map(|argument| argument.as_ptr()).collect();
        let mut results = vec![f64::NAN; program.results.len()];
        let numbers: [f64; 8] = std::array::from_fn(|i| 0.25 + i as f64);
        let mut kept = numbers;
        let [a, b, c, d, e, f, g, h] = &mut kept;
        // SAFETY: see the header.
        unsafe {
            asm!(
                "blr {function}",
                function = in(reg) pages.address(0),
                in("x0") table.as_ptr(),
                in("x1") results.as_mut_ptr(),
                inout("v8") *a,
                inout("v9") *b,
                inout("v10") *c,
                inout("v11") *d,
                inout("v12") *e,
                inout("v13") *f,
                inout("v14") *g,
                inout("v15") *h,
                clobber_abi("C"),
            );
        }
        assert_eq!(kept, numbers);
        assert!(results.iter().all(|x| x.is_finite()), "{results:?}");
    }
}
