//! Names of results of CasADi's functions.

use modyn_codegen::Function;
use modyn_codegen::internals::{CASADI_FUNCTIONS, casadi_results};
use modyn_codegen::plan::{Sizes, Trace};

/// `CasADi` refuses a function in which an input and a result have the same name.
#[test]
fn every_result_has_a_name_of_its_own() {
    let sizes = Sizes { nq: 7, nv: 6, links: 3, moving: 2, ..Sizes::default() };
    for function in CASADI_FUNCTIONS {
        let row = function.row();
        assert!(!matches!(row.trace, Trace::Poses) && row.batch_of.is_none(), "{function:?}");
        let arguments = row.arguments.iter().map(|argument| argument.name.to_string());
        let results = casadi_results(*function, &sizes).into_iter().map(|(name, _)| name);
        let all: Vec<String> = arguments.chain(results).collect();
        let mut different = all.clone();
        different.sort_unstable();
        different.dedup();
        assert_eq!(different.len(), all.len(), "{function:?}: {all:?}");
    }
    let names = |function| casadi_results(function, &sizes).into_iter().map(|(name, _)| name);
    assert!(names(Function::StepRk4).eq(["q_next", "qd_next"]));
    assert!(names(Function::StepImplicitMidpoint).eq(["q_next", "qd_next"]));
    assert!(names(Function::LinkPose).eq(["rotation", "translation"]));
    assert!(names(Function::ForwardDynamics).eq(["qdd"]));
}
