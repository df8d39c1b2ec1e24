//! The command's help, version and usage errors.
#![cfg(feature = "command")]

use crate::common;

use common::modyn;

#[test]
fn help_and_version_are_there() {
    let help = modyn(&["--help"]);
    assert_eq!(help.code, 0);
    for command in ["inspect", "generate", "check", "simulate", "view", "compare", "explain"] {
        assert!(help.out.contains(command), "{}", help.out);
        let own = modyn(&[command, "--help"]);
        assert_eq!(own.code, 0);
        assert!(own.out.contains("exit code"), "{}", own.out);
    }
    assert_eq!(modyn(&["--version"]).out, format!("modyn {}\n", env!("CARGO_PKG_VERSION")));
    assert_eq!(modyn(&[]).code, 2);
    assert_eq!(modyn(&["fly"]).code, 2);
}

#[test]
fn codes_are_explained() {
    let one = modyn(&["explain", "singular-joint"]);
    assert_eq!(one.code, 0);
    assert!(one.out.contains("moves no inertia") && one.out.contains("armature"));
    let all = modyn(&["explain"]);
    assert_eq!(all.out.lines().count(), modyn_codegen::diagnostics::Code::ALL.len());
    assert_eq!(modyn(&["explain", "nonsense"]).code, 2);
    let misspelt = modyn(&["explain", "negative_mass"]);
    assert_eq!(misspelt.code, 2);
    assert!(misspelt.err.contains("did you mean `negative-mass`?"), "{}", misspelt.err);
}

#[test]
fn a_misspelt_function_is_suggested() {
    let found = modyn(&["inspect", "robots/gripper.urdf", "--functions", "mass_matrx"]);
    assert_eq!(found.code, 2);
    assert!(found.err.contains("did you mean `mass_matrix`?"), "{}", found.err);
}

#[test]
fn an_option_of_another_command_is_explained() {
    let found = modyn(&["inspect", "robots/gripper.urdf", "--payload", "finger"]);
    assert_eq!(found.code, 2);
    assert!(found.err.contains("'--payload' is an option of 'modyn generate'"), "{}", found.err);
}

#[test]
fn an_earlier_name_of_an_option_leads_to_the_present_one() {
    let found = modyn(&["inspect", "robots/gripper.urdf", "--friction", "none"]);
    assert_eq!(found.code, 2);
    assert!(found.err.contains("'--friction' is named '--joint-friction' now"), "{}", found.err);
}
