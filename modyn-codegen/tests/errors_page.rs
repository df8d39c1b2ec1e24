//! `docs/errors.md` is the table of diagnostics.

use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::diagnostics::Code;

/// Returns the text of the page.
fn page() -> String {
    let mut page = String::from(
        "# Errors and warnings\n\n\
         Every diagnostic has a code, which never changes: `robots/arm.urdf:12:13: error[negative-mass]: ...`. \
         `modyn explain CODE` prints the section of one code, and `modyn check ROBOT.urdf` all errors and warnings \
         of a description with their lines. This page is made from the table in `modyn-codegen/src/diagnostics/code.rs`.\n",
    );
    for code in Code::ALL {
        let (name, cause, remedy) = (code.name(), code.cause(), code.remedy());
        // Writing to a string cannot fail.
        let _ = write!(page, "\n## {name}\n\n{cause}\n\n**Remedy.** {remedy}\n");
    }
    page
}

#[test]
fn every_code_has_a_cause_and_a_remedy() {
    for code in Code::ALL {
        for text in [code.cause(), code.remedy()] {
            assert!(
                text.len() > 10 && text.ends_with('.') && text == text.trim(),
                "{code}: {text:?}"
            );
        }
        assert_eq!(Code::from_name(code.name()), Some(*code));
    }
    assert_eq!(Code::from_name("no-such-code"), None);
}

/// With the variable `UPDATE_SNAPSHOTS`, the test writes the page.
#[test]
fn the_page_equals_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/errors.md");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, page()).expect("the page is written");
    }
    let found = std::fs::read_to_string(&path).expect("the page").replace("\r\n", "\n");
    assert_eq!(found, page(), "UPDATE_SNAPSHOTS=1 writes it");
}
