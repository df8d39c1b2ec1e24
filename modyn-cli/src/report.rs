//! Shows diagnostics to people, with the line of the fault: the text of `modyn check`.

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use modyn_read::diagnostics::sanitize_for_display;
use modyn_read::diagnostics::{Diagnostic, Diagnostics, Position, Severity};

/// The longest line that is shown; a file may be one line of a million characters.
const MAX_LINE_LENGTH: usize = 10_000;

/// Returns diagnostics as compilers show them, one below the other, with colours as terminals have
/// them.
///
/// `own` is the name and the text of the description; `other` returns the text of another file that
/// diagnostics name.
#[must_use]
pub fn render(
    diagnostics: &[Diagnostic],
    main_file: Option<(&str, &str)>,
    other: impl Fn(&str) -> String,
) -> String {
    let (name, lines): (_, Vec<&str>) = match main_file {
        Some((name, text)) => (Some(name), text.lines().collect()),
        None => (None, Vec::new()),
    };
    let is_other = |file: &&str| name.is_some_and(|name| name != *file);
    let renderer = Renderer::styled();
    let mut out = String::new();
    for diagnostic in diagnostics.iter().take(Diagnostics::SHOWN) {
        // A file that the description names.
        let text = diagnostic.file.as_deref().filter(is_other).map(&other);
        let others = text.as_deref().map(|text| text.lines().collect::<Vec<_>>());
        out += &renderer.render(&[group(diagnostic, others.as_ref().unwrap_or(&lines))]);
        out += "\n\n";
    }
    if diagnostics.len() > Diagnostics::SHOWN {
        out += &format!("... and {} more\n\n", diagnostics.len() - Diagnostics::SHOWN);
    }
    out
}

/// Returns the line that says whether a description of this name can be used, and how many errors
/// and warnings it has.
#[must_use]
pub fn verdict(name: &str, is_usable: bool, diagnostics: &[Diagnostic]) -> String {
    let count = |severity, what: &str| {
        let count = diagnostics.iter().filter(|one| one.severity == severity).count();
        match count {
            0 => String::new(),
            1 => format!(", 1 {what}"),
            _ => format!(", {count} {what}s"),
        }
    };
    let errors = count(Severity::Error, "error");
    let warnings = count(Severity::Warning, "warning");
    let verdict = if is_usable { "usable" } else { "refused" };
    format!("{}: {verdict}{errors}{warnings}\n", sanitize_for_display(name))
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

/// Returns a line safe to display. Characters are replaced one by one, so that columns do not
/// change; tabs stay.
fn sanitize_line(line: &str) -> String {
    line.split('\t').map(sanitize_for_display).collect::<Vec<_>>().join("\t")
}

/// Returns the bytes of a line to mark: the tag, the attribute or the value that starts at the
/// position.
fn marked_range(line: &str, at: Position) -> std::ops::Range<usize> {
    let start = line.char_indices().nth(at.column - 1).map_or(line.len(), |(i, _)| i);
    let rest = &line[start..];
    let name_end = rest.find(|c: char| !c.is_alphanumeric() && !"_:-.".contains(c));
    let name = name_end.unwrap_or(rest.len());
    let before = line[..start].chars().next_back();
    let found_length = if let Some(quote) = before.filter(|c| matches!(c, '"' | '\'')) {
        rest.find(quote)
    } else if rest.starts_with('<') {
        rest.find('>').map(|end| end + 1)
    } else if let Some(quote) = rest[name..].strip_prefix('=').and_then(|v| v.chars().next()) {
        let value = name + 1 + quote.len_utf8();
        rest.get(value..).and_then(|rest| rest.find(quote)).map(|end| value + end + 1)
    } else {
        Some(name)
    };
    let length = found_length.unwrap_or(rest.trim_end().len());
    let one = rest.chars().next().map_or(0, char::len_utf8);
    start..start + length.max(one)
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
