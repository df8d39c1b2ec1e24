//! Suggested names of functions.

use modyn_codegen::plan::unknown_function;

#[test]
fn a_function_is_suggested() {
    let said = unknown_function("mas_matrix");
    assert_eq!(said, "there is no function `mas_matrix`; did you mean `mass_matrix`?");
    assert!(unknown_function("foo").contains("there are: default, all, forward_dynamics, "));
}
