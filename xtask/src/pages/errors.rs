//! The table of errors and warnings in `docs/troubleshooting.md`.

use modyn_codegen::diagnostics::Code;

use super::data::markdown;

/// Returns a row for each code.
pub(super) fn list() -> String {
    let row = |code: &Code| [format!("`{}`", code.name()), code.cause().replace('|', "\\|")];
    markdown("code | cause", Code::ALL.iter().map(row))
}
