//! `docs/errors.md` is the table of diagnostics.

use std::fmt::Write as _;

use modyn_codegen::diagnostics::Code;

/// Returns the text of the page.
pub(super) fn page() -> String {
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
