//! Places of scalars among arguments.

use modyn_codegen::internals::argument_of;

#[test]
fn scalars_are_counted_over_all_arguments() {
    let places: Vec<_> = (0..5).map(|number| argument_of(number, [1, 0, 2])).collect();
    assert_eq!(places, [Ok((0, 0)), Ok((2, 0)), Ok((2, 1)), Err(0), Err(1)]);
}
