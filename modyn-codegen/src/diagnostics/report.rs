//! Collects what is wrong while reading goes on.

use super::code::Code;
use super::diagnostic::{Diagnostic, Position, Severity, Subject};
use super::line_index::LineIndex;

/// A byte offset in the text, if there is a text, and the joint or link that is there.
pub type Place = (Option<usize>, Option<Subject>);

/// How many of the other places a warning about many names.
const SHOWN_PLACES: usize = 3;

/// The diagnostics of one file, or of a model that was not read from one.
pub struct Report<'a> {
    file: Option<&'a str>,
    lines: LineIndex,
    diagnostics: Vec<Diagnostic>,
    errors: usize,
}

impl<'a> Report<'a> {
    /// None yet.
    pub fn new(text: &str, file: &'a str) -> Self {
        let lines = LineIndex::of(text);
        Self { file: Some(file), lines, diagnostics: Vec::new(), errors: 0 }
    }

    /// None yet, and no file that they could be in.
    pub fn without_file() -> Self {
        Self { file: None, lines: LineIndex::of(""), diagnostics: Vec::new(), errors: 0 }
    }

    /// Where the byte at this offset stands.
    pub fn position(&self, offset: usize) -> Position {
        self.lines.position(offset)
    }

    /// Takes an error at this byte; without a place, it is about an option or a model.
    pub fn error(
        &mut self,
        code: Code,
        offset: impl Into<Option<usize>>,
        subject: Option<&Subject>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.add(Severity::Error, code, offset, subject, message, help);
    }

    /// Takes a diagnostic at this byte.
    pub fn add(
        &mut self,
        severity: Severity,
        code: Code,
        offset: impl Into<Option<usize>>,
        subject: Option<&Subject>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let mut diagnostic = Diagnostic::new(severity, code, message).with_help(help);
        diagnostic.position = offset.into().map(|offset| self.position(offset));
        diagnostic.subject = subject.cloned();
        self.push(diagnostic);
    }

    /// Takes one warning for all these places, which a real file may have by the dozen: at the first
    /// place, with the number of the others and the lines of some. None for no places.
    pub fn warn_once(&mut self, code: Code, places: &[Place], message: &str, help: &str) {
        let Some(((at, subject), others)) = places.split_first() else { return };
        let shown: Vec<String> = others
            .iter()
            .take(SHOWN_PLACES)
            .map(|(at, subject)| {
                let line = at.map(|at| format!("line {}", self.position(at).line));
                match (subject, line) {
                    (Some(subject), Some(line)) => format!("{subject} ({line})"),
                    (Some(subject), None) => subject.to_string(),
                    (None, line) => line.unwrap_or_default(),
                }
            })
            .collect();
        let more = if others.len() > shown.len() { ", ..." } else { "" };
        let message = match others.len() {
            0 => message.to_string(),
            1 => format!("{message}; the same holds for {}", shown[0]),
            count => {
                format!("{message}; the same holds for {count} others: {}{more}", shown.join(", "))
            }
        };
        self.add(Severity::Warning, code, *at, subject.as_ref(), message, help);
    }

    /// Takes a diagnostic of this file.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        self.diagnostics.push(match self.file {
            Some(file) => diagnostic.in_file(file),
            None => diagnostic,
        });
    }

    /// How many errors there are.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// All diagnostics.
    pub fn finish(self) -> Vec<Diagnostic> {
        self.diagnostics
    }
}
