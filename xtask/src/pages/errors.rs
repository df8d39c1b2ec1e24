//! The sections of errors and warnings in `docs/troubleshooting.md`.

use modyn_codegen::diagnostics::Code;

/// Returns a section for each code.
pub(super) fn list() -> String {
    let section = |code: &Code| {
        let (name, cause, remedy) = (code.name(), code.cause(), code.remedy());
        format!("\n### {name}\n\n{cause}\n\n**Remedy.** {remedy}\n")
    };
    Code::ALL.iter().map(section).collect()
}
