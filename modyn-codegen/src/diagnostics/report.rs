//! The report: diagnostics that are collected while reading continues.

use super::code::Code;
use super::diagnostic::{Diagnostic, Position, Severity, Subject};
use super::line_index::LineIndex;

/// A byte offset in the text, if there is a text, and the joint or link at it.
pub type Place = (Option<usize>, Option<Subject>);

/// The number of other places that a warning about several places names.
const SHOWN_PLACES: usize = 3;

/// The diagnostics of one file, or of a model without a file.
pub struct Report<'a> {
    file: Option<&'a str>,
    lines: LineIndex,
    diagnostics: Vec<Diagnostic>,
    errors: usize,
}

impl<'a> Report<'a> {
    /// Returns an empty report about a file.
    pub fn new(text: &str, file: &'a str) -> Self {
        let lines = LineIndex::of(text);
        Self { file: Some(file), lines, diagnostics: Vec::new(), errors: 0 }
    }

    /// Returns an empty report about a model without a file.
    pub fn without_file() -> Self {
        Self { file: None, lines: LineIndex::of(""), diagnostics: Vec::new(), errors: 0 }
    }

    /// Returns the position of the byte at this offset.
    pub fn position(&self, offset: usize) -> Position {
        self.lines.position(offset)
    }

    /// Adds an error at this byte; without a place, it is about an option or a model.
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

    /// Adds a diagnostic at this byte.
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

    /// Adds one warning for all these places, of which a real file may have dozens: at the first place, with the number of
    /// the others and the lines of some. Adds nothing if there are no places.
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

    /// Adds a diagnostic of this file.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        self.diagnostics.push(match self.file {
            Some(file) => diagnostic.in_file(file),
            None => diagnostic,
        });
    }

    /// Returns the number of errors.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Returns all diagnostics.
    pub fn finish(self) -> Vec<Diagnostic> {
        self.diagnostics
    }
}
