//! The order of arguments.

use modyn_codegen::Function;
use modyn_codegen::internals::ARGUMENTS;

#[test]
fn all_functions_have_their_arguments_in_one_order() {
    for function in Function::ALL {
        let places: Vec<usize> = (function.row().arguments.iter())
            .map(|own| ARGUMENTS.iter().position(|one| one.name == own.name).expect("known"))
            .collect();
        assert!(places.is_sorted_by(|a, b| a < b), "{function:?}: {places:?}");
    }
}
