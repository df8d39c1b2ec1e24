//! Every back end of text runs every function on robots of every kind, and gives the results of the programs' evaluation.
//! Machine code is in `modyn-jit/tests`, WGSL in `modyn-gpu/tests`.

mod c_text;
mod casadi;
#[allow(dead_code)]
#[path = "../../../tests/src/conformance/mod.rs"]
mod conformance;
mod cpp;
mod cuda;
mod matlab;
#[allow(dead_code)]
#[path = "../../../tests/src/random.rs"]
mod random;
mod rollouts;
mod rust;

use modyn_codegen::FloatType;

use conformance::c::C;
use conformance::{conforms, is_installed, kinds, large, small};

/// Tests of a back end: robots of every kind, a small robot with all functions, and a large robot.
macro_rules! conformance {
    ($($name:ident: $back_end:expr;)*) => {$(
        mod $name {
            use super::*;

            #[test]
            fn robots_of_every_kind() {
                if !is_installed(&$back_end) {
                    return;
                }
                let compared: usize =
                    kinds().iter().map(|case| conforms(&$back_end, case, FloatType::F64)).sum();
                assert!(compared > 200, "{compared}");
            }

            #[test]
            #[ignore = "slow: a compiler sees all functions"]
            fn all_functions() {
                assert!(is_installed(&$back_end));
                conforms(&$back_end, &small(), FloatType::F64);
            }

            #[test]
            #[ignore = "slow: a compiler sees a large robot"]
            fn a_large_robot() {
                conforms(&$back_end, &large(), FloatType::F64);
            }
        }
    )*};
}

conformance! {
    of_gcc: C::gcc();
    of_clang: C::clang();
    of_aarch64: C::aarch64().unoptimised();
    of_rust: rust::Rust;
    of_cuda: cuda::Cuda;
    of_matlab: matlab::Matlab;
}

/// The class in C++ returns what the functions in C return, without memory of the heap.
#[test]
fn cpp_with_eigen() {
    if !cpp::has_eigen() || !is_installed(&cpp::Cpp) {
        println!("not compared: Eigen is not installed");
        return;
    }
    let chosen =
        ["joint_zoo", "five_bar", "parameters", "points", "own_functions", "solver", "actuators"];
    for case in kinds().into_iter().filter(|case| chosen.contains(&case.name)) {
        conforms(&cpp::Cpp, &case, FloatType::F64);
    }
    conforms(&cpp::Cpp, &cpp::keywords(), FloatType::F32);
    cpp::compiles_under_names_of_members();
    cpp::rollouts_are_loops_of_steps();
}

#[test]
fn c_in_single_precision() {
    kinds().iter().for_each(|case| {
        conforms(&C::gcc().unoptimised(), case, FloatType::F32);
    });
}
