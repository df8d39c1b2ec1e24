//! Patterns of sparse matrices.

use modyn_codegen::plan::CasadiMatrix;

#[test]
fn patterns_are_compressed_columns() {
    let of = |rows, nonzeros: &[&[usize]]| CasadiMatrix {
        name: "a".into(),
        rows,
        columns: nonzeros.len(),
        nonzeros: nonzeros.iter().map(|rows| rows.to_vec()).collect(),
    };
    // A matrix with an empty column, a dense one, and one without nonzeros.
    let some = of(3, &[&[0, 2], &[], &[1]]).compressed_columns();
    assert_eq!(some, [3, 3, 0, 2, 2, 3, 0, 2, 1]);
    assert_eq!(of(2, &[&[0, 1]]).compressed_columns(), [2, 1, 1]);
    assert_eq!(of(2, &[&[], &[]]).compressed_columns(), [2, 2, 0, 0, 0]);
}
