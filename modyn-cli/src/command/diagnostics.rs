//! Prints diagnostics: for people, with the line of the fault, and for programs.

use modyn_codegen::diagnostics::{Diagnostic, Severity, Subject};
use serde_json::{Value, json};

use crate::command::description::Description;
use crate::report;

/// Returns diagnostics as compilers show them, one below the other.
pub fn render(diagnostics: &[Diagnostic], description: Option<&Description>) -> String {
    let main_file = description.map(|description| (&*description.name, &*description.text));
    report::render(diagnostics, main_file, |file| std::fs::read_to_string(file).unwrap_or_default())
}

/// Returns diagnostics for programs, with the field names of [`Diagnostic`].
pub fn to_json(diagnostics: &[Diagnostic]) -> Value {
    diagnostics.iter().map(one_to_json).collect()
}

fn one_to_json(diagnostic: &Diagnostic) -> Value {
    let subject = diagnostic.subject.as_ref().map(|subject| {
        let (kind, name) = match subject {
            Subject::Joint(name) => ("joint", name),
            Subject::Link(name) => ("link", name),
            Subject::Contact(name) => ("contact", name),
            Subject::Robot(name) => ("robot", name),
            other => ("other", &other.to_string()),
        };
        json!({ "kind": kind, "name": name })
    });
    json!({
        "file": diagnostic.file,
        "severity": match diagnostic.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        },
        "code": diagnostic.code.name(),
        "line": diagnostic.position.map(|at| at.line),
        "column": diagnostic.position.map(|at| at.column),
        "subject": subject,
        "message": diagnostic.message,
        "notes": diagnostic.notes,
        "help": diagnostic.help,
    })
}
