//! Lines and columns.

use modyn_read::internals::LineIndex;

#[test]
fn columns_count_characters() {
    let lines = LineIndex::of("ab\r\n\u{e9}\u{1f916}x\n");
    let at = |offset| (lines.position(offset).line, lines.position(offset).column);
    assert_eq!(
        [at(0), at(1), at(4), at(6), at(10), at(12)],
        [(1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1)]
    );
}
