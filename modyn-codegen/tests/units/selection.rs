//! Suggested names of functions.

use modyn_codegen::Function;

#[test]
fn a_function_is_suggested() {
    let said = Function::unknown("mas_matrix");
    assert_eq!(said, "there is no function `mas_matrix`; did you mean `mass_matrix`?");
    assert!(Function::unknown("foo").contains("there are: default, all, forward_dynamics, "));
}
