//! Names of kinds of diagnostics.

use modyn_read::diagnostics::Code;

#[test]
fn a_code_is_suggested() {
    assert_eq!(Code::suggest("singular-jiont"), Some(Code::SingularJoint));
    assert_eq!(Code::suggest("inertia"), None);
}

#[test]
fn no_two_codes_share_a_name() {
    let names: std::collections::BTreeSet<_> = Code::ALL.iter().map(|c| c.name()).collect();
    assert_eq!(names.len(), Code::ALL.len());
}
