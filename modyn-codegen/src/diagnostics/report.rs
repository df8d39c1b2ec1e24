//! The report: diagnostics that are collected while reading continues.

use std::borrow::Cow;
use std::path::PathBuf;

use super::code::Code;
use super::diagnostic::{Diagnostic, Position, Severity, Subject};
use super::line_index::LineIndex;

/// A byte offset in the text, if there is a text, and the joint or link at it.
pub type Place = (Option<usize>, Option<Subject>);

/// The number of other places that a warning about several places names.
const SHOWN_PLACES: usize = 3;

/// A file, whose bytes have the offsets from `start` on.
struct File<'a> {
    name: Option<Cow<'a, str>>,
    start: usize,
    lines: LineIndex,
}

/// The diagnostics of a file and the files that it names, or of a model without a file.
///
/// Offsets continue from file to file: the offset of a byte is its offset in its own file, plus the start of that file.
pub struct Report<'a> {
    files: Vec<File<'a>>,
    /// The offset after the last file.
    end: usize,
    /// The other files that were read.
    dependencies: Vec<PathBuf>,
    diagnostics: Vec<Diagnostic>,
    errors: usize,
}

impl<'a> Report<'a> {
    /// Returns an empty report about a file, whose start is 0.
    pub fn new(text: &str, file: &'a str) -> Self {
        let mut report = Self::without_file();
        report.files.clear();
        report.end = 0;
        report.add_file(file, text);
        report
    }

    /// Returns an empty report about a model without a file.
    pub fn without_file() -> Self {
        let nameless = File { name: None, start: 0, lines: LineIndex::of("") };
        let (dependencies, diagnostics) = (Vec::new(), Vec::new());
        Self { files: vec![nameless], end: 1, dependencies, diagnostics, errors: 0 }
    }

    /// Adds a file, and returns its start: the offset of its first byte.
    pub fn add_file(&mut self, name: impl Into<Cow<'a, str>>, text: &str) -> usize {
        let start = self.end;
        self.files.push(File { name: Some(name.into()), start, lines: LineIndex::of(text) });
        // The end of a text is a place in it.
        self.end += text.len() + 1;
        start
    }

    /// Adds a file that was read besides the description: the robot changes with it.
    pub fn depends_on(&mut self, path: PathBuf) {
        if !self.dependencies.contains(&path) {
            self.dependencies.push(path);
        }
    }

    /// Returns the other files that were read.
    pub fn take_dependencies(&mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.dependencies)
    }

    /// Returns the file of the byte at this offset.
    fn file(&self, offset: usize) -> &File<'a> {
        let after = self.files.partition_point(|file| file.start <= offset);
        &self.files[after.saturating_sub(1)]
    }

    /// Returns the name of the file of the byte at this offset; `None` for a model without a file.
    pub fn file_name(&self, offset: usize) -> Option<&str> {
        self.file(offset).name.as_deref()
    }

    /// Returns the position of the byte at this offset, in its file.
    pub fn position(&self, offset: usize) -> Position {
        let file = self.file(offset);
        file.lines.position(offset - file.start)
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
        let offset = offset.into();
        diagnostic.position = offset.map(|offset| self.position(offset));
        diagnostic.file = offset.and_then(|offset| self.file_name(offset)).map(String::from);
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

    /// Adds a diagnostic. Without a file it is about the description.
    pub fn push(&mut self, mut diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        if diagnostic.file.is_none() {
            diagnostic.file = self.files[0].name.as_deref().map(String::from);
        }
        self.diagnostics.push(diagnostic);
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
