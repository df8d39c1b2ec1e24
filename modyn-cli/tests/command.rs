//! What the command says of itself.
#![cfg(feature = "command")]

mod common;

use common::modyn;

#[test]
fn help_and_version_are_there() {
    let help = modyn(&["--help"]);
    assert_eq!(help.code, 0);
    for command in ["inspect", "generate", "check", "simulate", "compare"] {
        assert!(help.out.contains(command), "{}", help.out);
        let own = modyn(&[command, "--help"]);
        assert_eq!(own.code, 0);
        assert!(own.out.contains("Exit code"), "{}", own.out);
    }
    assert_eq!(modyn(&["--version"]).out, format!("modyn {}\n", env!("CARGO_PKG_VERSION")));
    assert_eq!(modyn(&[]).code, 2);
    assert_eq!(modyn(&["fly"]).code, 2);
}
