//! Each error that a user can make through the macro has a case in `tests/ui`, which the package `modyn-ui` runs.

use std::fs;
use std::path::Path;

use modyn_codegen::diagnostics::Code;

/// The kinds of diagnostics that no input of the macro causes, and those that are only warnings.
const ELSEWHERE: &[Code] = &[
    Code::IllConditioned,
    Code::Output,
    Code::InvalidModel,
    Code::InvalidProgram,
    Code::TooLarge,
    Code::AxisLength,
    Code::InvertedLimits,
    Code::MimicMultiplier,
    Code::NotMjcf,
    Code::NotSdf,
    Code::Sdf,
    Code::Mjcf,
    Code::Include,
    Code::MissingLimit,
    Code::NegativeLimit,
    Code::EmptyRange,
    Code::ZeroLimit,
    Code::LimitUnit,
    Code::LengthUnit,
    Code::InactiveFriction,
    Code::MissingInertial,
    Code::ImplausibleMass,
    Code::XacroWarning,
    Code::Inexpressible,
];

#[test]
fn every_kind_of_error_has_a_case() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("ui");
    for code in Code::ALL.iter().filter(|code| !ELSEWHERE.contains(code)) {
        let expected = fs::read_to_string(folder.join(format!("{code}.stderr")));
        let expected = expected.unwrap_or_else(|_| panic!("no case for {code}"));
        assert!(expected.contains(&format!(" [{code}]\n")), "{code}");
    }
}
