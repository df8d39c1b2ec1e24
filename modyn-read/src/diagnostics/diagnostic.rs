//! A diagnostic, and the diagnostics of a run: severity, place, subject, message and help, and
//! their display.

use std::borrow::Cow;
use std::fmt;

use super::code::Code;
use super::display::sanitize_for_display;

/// The severity of a diagnostic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// An error: nothing is compiled.
    #[default]
    Error,
    /// A warning: the result is usable, but probably not what was intended.
    Warning,
}

/// A place in a text. Lines and columns count from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Position {
    /// The line.
    pub line: usize,
    /// The column.
    pub column: usize,
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// The part of the robot that a diagnostic is about.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Subject {
    /// The joint of this name.
    Joint(String),
    /// The link of this name.
    Link(String),
    /// The contact of this name.
    Contact(String),
    /// The robot of this name.
    Robot(String),
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joint(name) => write!(f, "joint `{name}`"),
            Self::Link(name) => write!(f, "link `{name}`"),
            Self::Contact(name) => write!(f, "contact `{name}`"),
            Self::Robot(name) => write!(f, "robot `{name}`"),
        }
    }
}

/// A fault: the error, its place in the file, and the remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Diagnostic {
    /// The severity.
    pub severity: Severity,
    /// The code.
    pub code: Code,
    /// The file's name, as the caller gave it.
    pub file: Option<String>,
    /// The place in the file.
    pub position: Option<Position>,
    /// The joint, link or robot.
    pub subject: Option<Subject>,
    /// What is wrong.
    pub message: String,
    /// How the place came to be: the calls of macros that led there, the innermost first.
    pub notes: Vec<String>,
    /// What would be right.
    pub help: Option<String>,
}

impl Diagnostic {
    /// Returns a diagnostic without a place.
    pub fn new(severity: Severity, code: Code, message: impl Into<String>) -> Self {
        let file = None;
        let position = None;
        let subject = None;
        let help = None;
        let message = message.into();
        let notes = Vec::new();
        Self { severity, code, file, position, subject, message, notes, help }
    }

    /// Returns an error without a place.
    pub fn error(code: Code, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// Returns the error that the file `wanted` does not exist at any of the places `tried`. These
    /// are the folder of the source file and the folder of `Cargo.toml`, or the folder of
    /// `Cargo.toml` alone.
    pub fn missing_file<T: fmt::Display>(wanted: impl fmt::Display, tried: &[T]) -> Self {
        use fmt::Write;
        let mut message = format!("`{wanted}` does not exist");
        for (i, place) in tried.iter().enumerate() {
            let lead = if i == 0 { "; tried" } else { "," };
            // Writing to a string cannot fail.
            let _ = write!(message, "{lead} `{place}`");
        }
        Self::error(Code::MissingFile, message).with_help(if tried.len() > 1 {
            "give the path relative to the source file that names it, or to the folder of Cargo.toml"
        } else {
            "give the path relative to the folder of Cargo.toml"
        })
    }

    /// Returns the diagnostic with the name of its file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<String>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// Returns the diagnostic with its place in the file.
    #[must_use]
    pub fn at(mut self, position: Position) -> Self {
        self.position = Some(position);
        self
    }

    /// Returns the diagnostic with its joint, link or robot.
    #[must_use]
    pub fn with_subject(mut self, subject: Subject) -> Self {
        self.subject = Some(subject);
        self
    }

    /// Returns the diagnostic with advice.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Writes `robots/foo.urdf:12:7: error[negative-mass]: link `arm`: the mass is -1 kg`, then the
/// help on a line of its own. Line breaks and control characters in names are replaced: they could
/// command a terminal or end a comment.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_place(f)?;
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{severity}[{}]: ", self.code)?;
        self.write_message(f)?;
        self.write_notes(f)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {}", sanitize_for_display(help)),
            None => Ok(()),
        }
    }
}

impl Diagnostic {
    /// Returns the text for a tool that writes `error: ` itself, such as rustc:
    /// `robots/foo.urdf:12:7: link `arm`: the mass is -1 kg [negative-mass]`, then the help.
    #[must_use]
    pub fn without_severity(&self) -> impl fmt::Display + '_ {
        WithoutSeverity(self)
    }

    fn write_place(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", sanitize_for_display(file))?;
        }
        if let Some(position) = self.position {
            write!(f, "{position}:")?;
        }
        if self.file.is_some() || self.position.is_some() { f.write_str(" ") } else { Ok(()) }
    }

    fn write_notes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut notes = self.notes.iter();
        notes.try_for_each(|note| write!(f, "\n  note: {}", sanitize_for_display(note)))
    }

    fn write_message(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(subject) = &self.subject {
            write!(f, "{}: ", sanitize_for_display(&subject.to_string()))?;
        }
        f.write_str(&sanitize_for_display(&shortened(&self.message)))
    }
}

/// The largest number of characters of a message that are shown: names of a description may have
/// any length.
const MAX_SHOWN: usize = 4000;

/// Returns a message without its middle part if it is very long.
fn shortened(message: &str) -> Cow<'_, str> {
    if message.len() <= MAX_SHOWN {
        return message.into();
    }
    let first: String = message.chars().take(MAX_SHOWN / 2).collect();
    let mut last: Vec<char> = message.chars().rev().take(MAX_SHOWN / 2).collect();
    last.reverse();
    format!("{first} ... {}", String::from_iter(last)).into()
}

struct WithoutSeverity<'d>(&'d Diagnostic);

impl fmt::Display for WithoutSeverity<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(diagnostic) = self;
        diagnostic.write_place(f)?;
        diagnostic.write_message(f)?;
        write!(f, " [{}]", diagnostic.code)?;
        diagnostic.write_notes(f)?;
        match &diagnostic.help {
            Some(help) => write!(f, "\nhelp: {}", sanitize_for_display(help)),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Diagnostic {}

/// The diagnostics of a run: errors before warnings, each in the order of their places.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct Diagnostics(Vec<Diagnostic>);

impl Diagnostics {
    /// Returns these diagnostics in order.
    #[must_use]
    pub fn new(mut diagnostics: Vec<Diagnostic>) -> Self {
        diagnostics.sort_by_key(|d| (d.severity, d.position));
        Self(diagnostics)
    }

    /// The largest number that is shown to a user.
    pub const SHOWN: usize = 100;

    /// Returns the line that replaces the diagnostics that are not shown, of `count` in total.
    #[must_use]
    pub fn count_hidden(count: usize) -> Option<String> {
        let more = count.checked_sub(Self::SHOWN).filter(|&more| more > 0)?;
        Some(format!("... and {more} more"))
    }

    /// Returns whether there is an error.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.0.first().is_some_and(|d| d.severity == Severity::Error)
    }

    /// Returns all diagnostics, in order.
    #[must_use]
    pub fn as_slice(&self) -> &[Diagnostic] {
        &self.0
    }

    /// Returns an iterator over all diagnostics, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.0.iter()
    }

    /// Returns all diagnostics by value.
    #[must_use]
    pub fn into_vec(self) -> Vec<Diagnostic> {
        self.0
    }
}

/// Writes the diagnostics for a user: a build script whose `main` returns them prints this text
/// after `Error: `. Their number therefore comes first, on a line of its own.
impl fmt::Debug for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |severity, one: &str| {
            let count = self.0.iter().filter(|diagnostic| diagnostic.severity == severity).count();
            let plural = if count == 1 { "" } else { "s" };
            (count > 0).then(|| format!("{count} {one}{plural}"))
        };
        let both = [count(Severity::Error, "error"), count(Severity::Warning, "warning")];
        let counts: Vec<String> = both.into_iter().flatten().collect();
        writeln!(f, "{}", if counts.is_empty() { "none".into() } else { counts.join(", ") })?;
        fmt::Display::fmt(self, f)
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

/// Writes the first [`Diagnostics::SHOWN`] diagnostics, and the number of the others.
impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().take(Self::SHOWN).enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{diagnostic}")?;
        }
        if let Some(more) = Self::count_hidden(self.0.len()) {
            write!(f, "\n{more}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}
