//! One case for each error a user can make through the macro. `TRYBUILD=overwrite` renews what is
//! expected.

use std::path::Path;

use modyn_codegen::diagnostics::Code;

/// Kinds that no input of the macro leads to, and those that are only warnings.
const ELSEWHERE: &[Code] = &[
    Code::IllConditioned,
    Code::Output,
    Code::InvalidModel,
    Code::TooLarge,
    Code::AxisLength,
    Code::InvertedLimits,
    Code::MimicMultiplier,
    Code::NotMjcf,
    Code::Include,
    Code::MissingLimit,
    Code::NegativeLimit,
    Code::InactiveFriction,
    Code::MissingInertial,
    Code::ImplausibleMass,
];

#[test]
fn what_users_see() {
    let cases = trybuild::TestCases::new();
    cases.pass("ui/pass/*.rs");
    cases.compile_fail("ui/*.rs");
}

#[test]
fn every_kind_of_error_has_a_case() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("ui");
    for code in Code::ALL.iter().filter(|code| !ELSEWHERE.contains(code)) {
        let expected = std::fs::read_to_string(folder.join(format!("{code}.stderr")));
        let expected = expected.unwrap_or_else(|_| panic!("no case for {code}"));
        assert!(expected.contains(&format!(" [{code}]\n")), "{code}");
    }
}
