//! Prints diagnostics: for people, with the line of the fault, and for programs.

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::diagnostics::{Diagnostic, Diagnostics, Position, Severity, Subject};
use serde_json::{Value, json};

use crate::command::description::Description;

/// The longest line that is shown; a file may be one line of a million characters.
const MAX_LINE_LENGTH: usize = 10_000;

/// Returns diagnostics as compilers show them, one below the other.
pub fn render(found: &[Diagnostic], description: Option<&Description>) -> String {
    let own: Vec<&str> = description.map(|own| own.text.lines().collect()).unwrap_or_default();
    let is_other = |file: &&str| description.is_some_and(|own| own.name != *file);
    let renderer = Renderer::styled();
    let mut out = String::new();
    for diagnostic in found.iter().take(Diagnostics::SHOWN) {
        // A file that the description names.
        let other = diagnostic.file.as_deref().filter(is_other);
        let text = other.map(|file| std::fs::read_to_string(file).unwrap_or_default());
        let lines = text.as_deref().map(|text| text.lines().collect::<Vec<_>>());
        out += &renderer.render(&[group(diagnostic, lines.as_ref().unwrap_or(&own))]);
        out += "\n\n";
    }
    if found.len() > Diagnostics::SHOWN {
        out += &format!("... and {} more\n\n", found.len() - Diagnostics::SHOWN);
    }
    out
}

fn group<'a>(diagnostic: &Diagnostic, lines: &[&str]) -> Group<'a> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = match &diagnostic.subject {
        Some(subject) => format!("{subject}: {}", diagnostic.message),
        None => diagnostic.message.clone(),
    };
    let mut group = Group::with_title(
        level.primary_title(sanitize_for_display(&title)).id(diagnostic.code.name()),
    );
    let file = sanitize_for_display(diagnostic.file.as_deref().unwrap_or_default());
    let line = diagnostic.position.and_then(|at| Some((at, *lines.get(at.line.checked_sub(1)?)?)));
    match (line.filter(|(_, line)| line.len() <= MAX_LINE_LENGTH), diagnostic.position) {
        (Some((at, line)), _) => {
            let line = sanitize_line(line);
            let span = AnnotationKind::Primary.span(marked_range(&line, at));
            let snippet = Snippet::source(line).line_start(at.line).path(file);
            group = group.element(snippet.annotation(span));
        }
        (None, Some(at)) => {
            group = group.element(Origin::path(file).line(at.line).char_column(at.column));
        }
        (None, None) if !file.is_empty() => group = group.element(Origin::path(file)),
        (None, None) => {}
    }
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(sanitize_for_display(note)));
    }
    match &diagnostic.help {
        Some(text) => group.element(Level::HELP.message(sanitize_for_display(text))),
        None => group,
    }
}

/// Returns a line safe to display. Characters are replaced one by one, so that columns do not change; tabs stay.
fn sanitize_line(line: &str) -> String {
    line.split('\t').map(sanitize_for_display).collect::<Vec<_>>().join("\t")
}

/// Returns the bytes of a line to mark: the tag, the attribute or the value that starts at the position.
fn marked_range(line: &str, at: Position) -> std::ops::Range<usize> {
    let start = line.char_indices().nth(at.column - 1).map_or(line.len(), |(i, _)| i);
    let rest = &line[start..];
    let name = rest.find(|c: char| !c.is_alphanumeric() && !"_:-.".contains(c));
    let name = name.unwrap_or(rest.len());
    let before = line[..start].chars().next_back();
    let length = if let Some(quote) = before.filter(|c| matches!(c, '"' | '\'')) {
        rest.find(quote)
    } else if rest.starts_with('<') {
        rest.find('>').map(|end| end + 1)
    } else if let Some(quote) = rest[name..].strip_prefix('=').and_then(|v| v.chars().next()) {
        let value = name + 1 + quote.len_utf8();
        rest.get(value..).and_then(|rest| rest.find(quote)).map(|end| value + end + 1)
    } else {
        Some(name)
    };
    let length = length.unwrap_or(rest.trim_end().len());
    let one = rest.chars().next().map_or(0, char::len_utf8);
    start..start + length.max(one)
}

/// Returns diagnostics for programs, with the field names of [`Diagnostic`].
pub fn to_json(found: &[Diagnostic]) -> Value {
    found.iter().map(one_to_json).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_covers_the_name_that_begins_there() {
        let line = "  <mass value=\"-1\"/><é a='x'/>";
        let mark = |column| &line[marked_range(line, Position { line: 1, column })];
        assert_eq!(mark(3), "<mass value=\"-1\"/>");
        assert_eq!(mark(9), "value=\"-1\"");
        assert_eq!(mark(16), "-1");
        assert_eq!(mark(21), "<é a='x'/>");
        assert_eq!(mark(24), "a='x'");
        assert_eq!(mark(2), " ");
        assert_eq!(mark(1000), "");
        let open = "<mass value=\"-1  ";
        assert_eq!(&open[marked_range(open, Position { line: 1, column: 7 })], "value=\"-1");
    }
}
