//! What the compiler tells its user: diagnostics, and the table of their kinds.

use std::fmt;

/// How serious a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Nothing is compiled.
    Error,
    /// The result stands, but probably is not what was meant.
    Warning,
}

/// A place in a text: both count from 1, columns count characters.
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

/// What a diagnostic is about.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Subject {
    /// The joint of this name.
    Joint(String),
    /// The link of this name.
    Link(String),
    /// The robot of this name.
    Robot(String),
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joint(name) => write!(f, "joint `{name}`"),
            Self::Link(name) => write!(f, "link `{name}`"),
            Self::Robot(name) => write!(f, "robot `{name}`"),
        }
    }
}

/// Makes the enum and its names from one table, so that no kind can lack a name.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal,)+) => {
        /// The kinds of diagnostics.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Code {
            $($(#[doc = $doc])+ $variant,)+
        }

        impl Code {
            /// All kinds, in the order of the table.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The identifier that stands in the output; it never changes.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

codes! {
    /// The file is at none of the places where it was looked for.
    MissingFile = "missing-file",
    /// The text is not well-formed XML.
    MalformedXml = "malformed-xml",
    /// The document has a document type declaration, which could redefine what it says.
    Dtd = "dtd",
    /// The document still has to go through xacro.
    Xacro = "xacro",
    /// The document is an SDF.
    Sdf = "sdf",
    /// The document is a `MuJoCo` model.
    Mjcf = "mjcf",
    /// The document is something else than a URDF.
    NotUrdf = "not-urdf",
    /// An attribute that URDF requires is missing or empty.
    MissingAttribute = "missing-attribute",
    /// An element that URDF requires is missing.
    MissingElement = "missing-element",
    /// An element that may stand once stands several times.
    RepeatedElement = "repeated-element",
    /// An attribute or element that would change the figures, but that is not read.
    NotRead = "not-read",
    /// A text that should be a number is none.
    BadNumber = "bad-number",
    /// There are too many or too few numbers.
    NumberCount = "number-count",
    /// A number is NaN, infinite or too large to compute with.
    NotFinite = "not-finite",
    /// There is no such type of joint.
    UnknownJointType = "unknown-joint-type",
    /// Two links have the same name.
    DuplicateLink = "duplicate-link",
    /// Two joints have the same name.
    DuplicateJoint = "duplicate-joint",
    /// The parent of a joint does not exist.
    UnknownParent = "unknown-parent",
    /// The child of a joint does not exist.
    UnknownChild = "unknown-child",
    /// A link is the child of several joints.
    SeveralParents = "several-parents",
    /// Joints form a cycle.
    Cycle = "cycle",
    /// Several links are no joint's child, so the robot falls apart.
    SeveralRoots = "several-roots",
    /// The robot has no link.
    NoLink = "no-link",
    /// The robot has no joint that moves.
    NoMovingJoint = "no-moving-joint",
    /// The axis of a moving joint is zero.
    ZeroAxis = "zero-axis",
    /// The axis of a moving joint is not of unit length; it is normalised.
    AxisLength = "axis-length",
    /// The two axes of a universal joint are parallel.
    ParallelAxes = "parallel-axes",
    /// The lower limit of a joint is above the upper one.
    InvertedLimits = "inverted-limits",
    /// A joint mimics another one, which an option refuses.
    Mimic = "mimic",
    /// A joint mimics a joint that does not exist or does not move.
    MimicTarget = "mimic-target",
    /// A joint of several coordinates mimics one, or is mimicked.
    MimicCoordinates = "mimic-coordinates",
    /// Joints mimic each other in a circle.
    MimicCycle = "mimic-cycle",
    /// A joint mimics another one by a multiplier of 0.
    MimicMultiplier = "mimic-multiplier",
    /// The damping, friction or rotor of a joint is negative.
    NegativeDrive = "negative-drive",
    /// The rotor of a joint is given in two ways.
    RepeatedArmature = "repeated-armature",
    /// The mass of a link is negative.
    NegativeMass = "negative-mass",
    /// A moving body has rotational inertia but no mass.
    InertiaWithoutMass = "inertia-without-mass",
    /// The rotational inertia of a moving body is not positive semidefinite.
    IndefiniteInertia = "indefinite-inertia",
    /// The rotational inertia of a moving body breaks the triangle inequality.
    TriangleInequality = "triangle-inequality",
    /// A joint moves nothing that has inertia, so its acceleration is undefined.
    NoInertiaFelt = "no-inertia-felt",
    /// The gravity in the options is NaN, infinite or too large to compute with.
    Gravity = "gravity",
    /// The list of modules is not a partition of the links into chains.
    Modules = "modules",
    /// A link whose inertia is to be an argument does not exist or does not move.
    Payload = "payload",
    /// The robot takes more operations than code can be written out for.
    TooLarge = "too-large",
    /// The name of the generated type is no Rust identifier, or likely to be taken.
    TypeName = "type-name",
    /// An option is not what it may be.
    Option = "option",
    /// Single precision does not carry the robot's dynamics.
    IllConditioned = "ill-conditioned",
    /// The generated code cannot be written.
    Output = "output",
    /// The model was refused for a reason that reading should have found.
    InvalidModel = "invalid-model",
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One thing that is wrong, where, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Diagnostic {
    /// Whether it stops the compiler.
    pub severity: Severity,
    /// Its kind.
    pub code: Code,
    /// The file, as the caller called it.
    pub file: Option<String>,
    /// Where in the file.
    pub position: Option<Position>,
    /// The joint or link concerned.
    pub subject: Option<Subject>,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A diagnostic without a place.
    pub fn new(severity: Severity, code: Code, message: impl Into<String>) -> Self {
        let (file, position, subject, help) = (None, None, None, None);
        Self { severity, code, file, position, subject, message: message.into(), help }
    }

    /// An error without a place.
    pub fn error(code: Code, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// The file `wanted` is at none of the places that were `tried`: that of the source file and
    /// that of `Cargo.toml`, or the latter alone.
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

    /// The same, in this file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<String>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// The same, at this place in its file.
    #[must_use]
    pub fn at(mut self, position: Position) -> Self {
        self.position = Some(position);
        self
    }

    /// The same, about this joint or link.
    #[must_use]
    pub fn about(mut self, subject: Subject) -> Self {
        self.subject = Some(subject);
        self
    }

    /// The same, with advice.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// `robots/foo.urdf:12:7: error[negative-mass]: link `arm`: the mass is -1 kg`, then the help.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{file}:")?;
        }
        if let Some(position) = self.position {
            write!(f, "{position}:")?;
        }
        if self.file.is_some() || self.position.is_some() {
            f.write_str(" ")?;
        }
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{severity}[{}]: ", self.code)?;
        if let Some(subject) = &self.subject {
            write!(f, "{subject}: ")?;
        }
        f.write_str(&self.message)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Diagnostic {}

/// All that is wrong, errors before warnings, each in the order of their positions.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct Diagnostics(Vec<Diagnostic>);

impl Diagnostics {
    /// These, put in order.
    #[must_use]
    pub fn new(mut diagnostics: Vec<Diagnostic>) -> Self {
        diagnostics.sort_by_key(|d| (d.severity, d.position));
        Self(diagnostics)
    }

    /// The most that are shown to a user.
    pub const SHOWN: usize = 100;

    /// What stands for those that are not shown, of so many.
    #[must_use]
    pub(crate) fn more(count: usize) -> Option<String> {
        let more = count.checked_sub(Self::SHOWN).filter(|&more| more > 0)?;
        Some(format!("... and {more} more"))
    }

    /// Whether there is an error among them.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.0.first().is_some_and(|d| d.severity == Severity::Error)
    }

    /// All of them.
    #[must_use]
    pub fn as_slice(&self) -> &[Diagnostic] {
        &self.0
    }

    /// All of them, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.0.iter()
    }

    /// All of them, by value.
    #[must_use]
    pub fn into_vec(self) -> Vec<Diagnostic> {
        self.0
    }
}

/// As for a user: this is what a build script prints whose `main` returns diagnostics.
impl fmt::Debug for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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

/// The first [`Diagnostics::SHOWN`] of them, and how many more there are.
impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().take(Self::SHOWN).enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{diagnostic}")?;
        }
        if let Some(more) = Self::more(self.0.len()) {
            write!(f, "\n{more}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagnostic_reads_as_compilers_do() {
        let diagnostic = Diagnostic::error(Code::NegativeMass, "the mass is -1 kg")
            .in_file("robots/foo.urdf")
            .at(Position { line: 12, column: 7 })
            .about(Subject::Link("arm".into()))
            .with_help("write a mass of at least 0");
        assert_eq!(
            diagnostic.to_string(),
            "robots/foo.urdf:12:7: error[negative-mass]: link `arm`: the mass is -1 kg\n  help: write a mass of at least 0"
        );
        let missing = Diagnostic::missing_file("a.urdf", &["src/a.urdf", "a.urdf"]).to_string();
        assert!(missing.starts_with(
            "error[missing-file]: `a.urdf` does not exist; tried `src/a.urdf`, `a.urdf`\n"
        ));
        assert!(missing.contains("source file"), "{missing}");
        // A build script has no place but one.
        let missing = Diagnostic::missing_file("a.urdf", &["a.urdf"]).to_string();
        assert!(!missing.contains("source file") && missing.contains("Cargo.toml"), "{missing}");
    }

    #[test]
    fn errors_come_first_then_by_position() {
        let at = |severity, line| {
            Diagnostic::new(severity, Code::Mimic, "").at(Position { line, column: 1 })
        };
        let all = Diagnostics::new(vec![
            at(Severity::Warning, 1),
            at(Severity::Error, 3),
            at(Severity::Error, 2),
        ]);
        let lines: Vec<_> = all.iter().map(|d| d.position.map(|p| p.line)).collect();
        assert_eq!(lines, [Some(2), Some(3), Some(1)]);
        assert!(all.has_errors());
    }

    #[test]
    fn what_is_shown_is_bounded() {
        let shown =
            |count| Diagnostics::new(vec![Diagnostic::error(Code::Mimic, ""); count]).to_string();
        assert_eq!(shown(100).lines().count(), 100);
        assert_eq!(shown(102).lines().count(), 101);
        assert!(shown(102).ends_with("\n... and 2 more"));
    }

    #[test]
    fn no_two_codes_share_a_name() {
        let names: std::collections::BTreeSet<_> = Code::ALL.iter().map(|c| c.name()).collect();
        assert_eq!(names.len(), Code::ALL.len());
    }
}
