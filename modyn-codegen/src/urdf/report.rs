//! Collects what is wrong while reading goes on.

use super::locate::Lines;
use crate::error::{Code, Diagnostic, Position, Severity, Subject};

/// The diagnostics of one file.
pub struct Report<'a> {
    file: &'a str,
    lines: Lines,
    diagnostics: Vec<Diagnostic>,
    errors: usize,
}

impl<'a> Report<'a> {
    /// None yet.
    pub fn new(text: &str, file: &'a str) -> Self {
        Self { file, lines: Lines::of(text), diagnostics: Vec::new(), errors: 0 }
    }

    /// Where the byte at this offset stands.
    pub fn position(&self, offset: usize) -> Position {
        self.lines.position(offset)
    }

    /// Takes an error at this byte.
    pub fn error(
        &mut self,
        code: Code,
        offset: usize,
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
        offset: usize,
        subject: Option<&Subject>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let position = self.position(offset);
        let mut diagnostic = Diagnostic::new(severity, code, message).at(position).with_help(help);
        diagnostic.subject = subject.cloned();
        self.push(diagnostic);
    }

    /// Takes a diagnostic of this file.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        self.diagnostics.push(diagnostic.in_file(self.file));
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
