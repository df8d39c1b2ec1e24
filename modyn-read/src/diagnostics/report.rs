//! The report: diagnostics that are collected while reading continues.

use std::borrow::Cow;
use std::path::PathBuf;

use super::code::Code;
use super::diagnostic::{Diagnostic, Position, Severity, Subject};
use super::expansion::{Expansion, ExpansionCall, Origin};
use super::line_index::LineIndex;

/// A byte offset in the text, if there is a text, and the joint or link at it.
pub type Place = (Option<usize>, Option<Subject>);

/// The number of other places that a warning about several places names.
const SHOWN_PLACES: usize = 3;

/// The number of calls that led to a place that a diagnostic names.
const SHOWN_CALLS: usize = 5;

/// A file, whose bytes have the offsets from `start` on.
struct File<'a> {
    name: Option<Cow<'a, str>>,
    start: usize,
    lines: LineIndex,
}

/// The diagnostics of a file and the files that it names, or of a model without a file.
///
/// Offsets continue from file to file: the offset of a byte is its offset in its own file, plus the
/// start of that file.
pub struct Report<'a> {
    files: Vec<File<'a>>,
    /// The offset after the last file.
    end: usize,
    /// The other files that were read.
    dependencies: Vec<PathBuf>,
    /// The origins of the text that offsets refer to, if macros made it.
    expansion: Option<Expansion>,
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
        let dependencies = Vec::new();
        let diagnostics = Vec::new();
        let files = vec![nameless];
        Self { files, end: 1, dependencies, expansion: None, diagnostics, errors: 0 }
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

    /// Sets the origins of a text that macros made. From now on offsets refer to the text.
    pub fn set_expansion(&mut self, expansion: Expansion) {
        self.expansion = Some(expansion);
    }

    /// Returns the offset in the files of the byte at this offset of the text, and its call.
    fn origin(&self, offset: usize) -> (usize, usize) {
        self.expansion.as_ref().map_or((offset, 0), |expansion| expansion.origin(offset))
    }

    /// Returns the file of the byte at this offset of the files.
    fn file(&self, offset: usize) -> &File<'a> {
        let after = self.files.partition_point(|file| file.start <= offset);
        &self.files[after.saturating_sub(1)]
    }

    /// Returns the name of the file of the byte at this offset; `None` for a model without a file.
    pub fn file_name(&self, offset: usize) -> Option<&str> {
        self.file(self.origin(offset).0).name.as_deref()
    }

    /// Returns the position of the byte at this offset, in its file.
    pub fn position(&self, offset: usize) -> Position {
        self.position_in_files(self.origin(offset).0)
    }

    fn position_in_files(&self, at: usize) -> Position {
        let file = self.file(at);
        file.lines.position(at - file.start)
    }

    /// Returns the calls that led to a place, the innermost first, in words.
    fn notes(&self, calls: &[ExpansionCall], call: usize) -> Vec<String> {
        let parents = std::iter::successors(Some(call), |call| Some(calls.get(*call)?.parent));
        let calls = parents.take_while(|call| *call > 0).filter_map(|call| calls.get(call));
        let note = |call: &ExpansionCall| {
            let file = self.file(call.at).name.as_deref().unwrap_or_default();
            format!("in the {}, called at {file}:{}", call.name, self.position_in_files(call.at))
        };
        calls.take(SHOWN_CALLS).map(note).collect()
    }

    /// Adds a diagnostic at an offset of the files that a call of a macro reached, before the
    /// expansion is complete.
    pub fn add_in_call(&mut self, diagnostic: Diagnostic, origin: &Origin<'_>) {
        self.push(self.placed(diagnostic, origin));
    }

    /// Returns the diagnostic with its position, its file and the calls that led there.
    fn placed(&self, diagnostic: Diagnostic, origin: &Origin<'_>) -> Diagnostic {
        Diagnostic {
            position: Some(self.position_in_files(origin.at)),
            file: self.file(origin.at).name.as_deref().map(String::from),
            notes: self.notes(origin.calls, origin.call),
            ..diagnostic
        }
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
        diagnostic.subject = subject.cloned();
        if let Some(offset) = offset {
            let (at, call) = self.origin(offset);
            let calls = self.expansion.as_ref().map_or(&[][..], |expansion| expansion.calls());
            diagnostic = self.placed(diagnostic, &Origin { at, calls, call });
        }
        self.push(diagnostic);
    }

    /// Adds one warning for all these places, of which a real file may have dozens: at the first
    /// place, with the number of the others and the lines of some. Adds nothing if there are no
    /// places.
    pub fn warn_once(&mut self, code: Code, places: &[Place], message: &str, help: &str) {
        self.add_once(Severity::Warning, code, places, message, help);
    }

    /// Adds one error or warning for all these places, as [`warn_once`](Self::warn_once) does.
    pub fn add_once(
        &mut self,
        severity: Severity,
        code: Code,
        places: &[Place],
        message: &str,
        help: &str,
    ) {
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
        self.add(severity, code, *at, subject.as_ref(), message, help);
    }

    /// Adds a diagnostic. Without a file it is about the description.
    pub fn push(&mut self, mut diagnostic: Diagnostic) {
        self.errors += usize::from(diagnostic.severity == Severity::Error);
        if diagnostic.file.is_none() {
            diagnostic.file = self.files[0].name.as_deref().map(String::from);
        }
        self.diagnostics.push(diagnostic);
    }

    /// Returns the number of diagnostics.
    pub fn count(&self) -> usize {
        self.diagnostics.len()
    }

    /// Takes the diagnostics after the first `count`, which may be added again by
    /// [`push`](Self::push).
    pub fn take_after(&mut self, count: usize) -> Vec<Diagnostic> {
        let taken = self.diagnostics.split_off(count);
        self.errors -= taken.iter().filter(|one| one.severity == Severity::Error).count();
        taken
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
