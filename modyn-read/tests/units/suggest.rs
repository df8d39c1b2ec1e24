//! Suggested names.

use modyn_read::diagnostics::suggest;

#[test]
fn a_letter_or_two() {
    assert_eq!(suggest("orgin", ["axis", "origin"]), Some("origin"));
    assert_eq!(suggest("Axis", ["origin", "axis"]), Some("axis"));
    assert_eq!(suggest("sensor", ["origin", "axis"]), None);
    assert_eq!(suggest("", ["origin", ""]), Some(""));
}
