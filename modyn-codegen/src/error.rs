//! What the compiler tells its user: diagnostics, and the table of their kinds.

use std::fmt;

use crate::tame::tame;
use crate::urdf::nearest::nearest;

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

/// Makes the enum, its names and remedies from one table, so that no kind can lack one.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal: $remedy:literal,)+) => {
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

            /// What is the matter.
            #[must_use]
            pub fn cause(self) -> &'static str {
                match self {
                    $(Self::$variant => concat!($($doc),+).trim_ascii_start(),)+
                }
            }

            /// What to do about it.
            #[must_use]
            pub fn remedy(self) -> &'static str {
                match self {
                    $(Self::$variant => $remedy,)+
                }
            }
        }
    };
}

codes! {
    /// The file is at none of the places where it was looked for.
    MissingFile = "missing-file":
        "Give a path that exists. In the macro it is relative to the source file or to the \
        folder of `Cargo.toml`, in a build script to the latter, on the command line to \
        where you stand; `-` is standard input there.",
    /// The text is not well-formed XML.
    MalformedXml = "malformed-xml":
        "Mend the XML where the position says: a tag that is not closed, an attribute without \
        quotes, a stray `&` or `<`. Comments may hold anything, even `--`.",
    /// The document has a document type declaration, which could redefine what it says.
    Dtd = "dtd":
        "Remove the `<!DOCTYPE ...>`: URDF has none, and entities could change what the \
        figures are.",
    /// The document has more of something than any description needs, and than can be read in linear time.
    Excessive = "excessive":
        "Take the file for damaged or made to do harm. There may be 256 attributes in an element, 256 \
        namespaces in a document and 1 GiB in a file; joints and links may be any number.",
    /// The document still has to go through xacro.
    Xacro = "xacro":
        "Expand the file first, `xacro robot.urdf.xacro > robot.urdf`, and give the result. \
        Through a pipe: `xacro robot.urdf.xacro | modyn check -`.",
    /// The document is an SDF.
    Sdf = "sdf":
        "Convert the model to URDF, or export it as URDF from where it was made.",
    /// The document is a `MuJoCo` model.
    Mjcf = "mjcf":
        "The command `modyn` and `Builder::mjcf` (feature `mjcf`) read it, if it is written as MuJoCo's \
        XML reference says. Elsewhere convert the model to URDF, or take the URDF that the MJCF was \
        made from.",
    /// The document is something else than a URDF.
    NotUrdf = "not-urdf":
        "Give a file in UTF-8 whose root element is `<robot>`.",
    /// An attribute that URDF requires is missing or empty.
    MissingAttribute = "missing-attribute":
        "Write the attribute that is named. URDF has no default for it, and a guess would be \
        a wrong robot.",
    /// An element that URDF requires is missing.
    MissingElement = "missing-element":
        "Write the element that is named, in the link or joint that is named.",
    /// An element that may stand once stands several times.
    RepeatedElement = "repeated-element":
        "Leave one of them: which one is meant cannot be known.",
    /// An attribute or element that would change the figures, but that is not read.
    NotRead = "not-read":
        "Write the figure in the way that the help says, or remove what is not URDF. Where it \
        is a warning, check the spelling: what is not read changes nothing.",
    /// The description includes another file, which is not read: parts of the robot are missing.
    Include = "include":
        "Write the parts of that file into this one. The file that a tool has expanded (`xacro`, or the \
        exporter of a CAD program) has no includes.",
    /// A text that should be a number is none.
    BadNumber = "bad-number":
        "Write a decimal number, such as `0.25` or `2.5e-1`: with a point, without a unit, \
        and without an expression.",
    /// There are too many or too few numbers.
    NumberCount = "number-count":
        "Write as many numbers as are expected, with spaces between them: three for `xyz` and \
        `rpy`.",
    /// A number is NaN, infinite or too large to compute with.
    NotFinite = "not-finite":
        "Write a finite figure in SI units, below 1e60 in size. Where the figure is a product \
        (of a long chain's lengths, of multipliers), make its factors smaller.",
    /// There is no such type of joint.
    UnknownJointType = "unknown-joint-type":
        "Use `revolute`, `continuous`, `prismatic`, `universal`, `planar`, `spherical`, \
        `floating` or `fixed`.",
    /// Two links have the same name.
    DuplicateLink = "duplicate-link":
        "Give one of them another name, and the joints that mean it as well.",
    /// Two joints have the same name.
    DuplicateJoint = "duplicate-joint":
        "Give one of them another name.",
    /// The parent of a joint does not exist.
    UnknownParent = "unknown-parent":
        "Write the name of a link of this file in `<parent link=\"...\"/>`; the help names \
        the nearest.",
    /// The child of a joint does not exist.
    UnknownChild = "unknown-child":
        "Write the name of a link of this file in `<child link=\"...\"/>`; the help names the \
        nearest.",
    /// A link is the child of several joints.
    SeveralParents = "several-parents":
        "A link hangs on one joint. Leave one; a closed loop of joints is no tree, and has to \
        be cut: make one joint of the loop a `<loop_joint>`.",
    /// Joints form a cycle.
    Cycle = "cycle":
        "Let one of the joints begin at the link that carries the others. A closed loop has \
        to be cut: make one of its joints a `<loop_joint>`.",
    /// Several links are no joint's child, so the robot falls apart.
    SeveralRoots = "several-roots":
        "Join them: write a joint (a `fixed` one, perhaps) to every root but one.",
    /// The robot has no link.
    NoLink = "no-link":
        "Describe a link.",
    /// The robot has no joint that moves.
    NoMovingJoint = "no-moving-joint":
        "Make a joint `revolute`, `continuous` or `prismatic`, or let the base float (`base = \
        floating`).",
    /// The axis of a moving joint is zero.
    ZeroAxis = "zero-axis":
        "Write the direction of the axis, such as `<axis xyz=\"0 0 1\"/>`.",
    /// The axis of a moving joint is not of unit length; it is normalised.
    AxisLength = "axis-length":
        "Write the unit vector that the help shows. It is what is used in any case.",
    /// The two axes of a universal joint are parallel.
    ParallelAxes = "parallel-axes":
        "Turn one of them: `<axis>` and `<axis2>` of a universal joint must span a plane.",
    /// The lower limit of a joint is above the upper one.
    InvertedLimits = "inverted-limits":
        "Exchange `lower` and `upper`; one that is not written is 0.",
    /// A revolute or prismatic joint has no `<limit>`; it is read as a joint without limits.
    MissingLimit = "missing-limit":
        "Write `<limit lower=\"...\" upper=\"...\" effort=\"...\" velocity=\"...\"/>`, which URDF \
        requires. A joint that turns without end is `continuous`.",
    /// The effort or velocity limit of a joint is negative; it is read as if it were not written.
    NegativeLimit = "negative-limit":
        "Write the largest size of the effort or velocity, which is at least 0. Leave the attribute \
        out if there is no limit.",
    /// A joint mimics another one, which an option refuses.
    Mimic = "mimic":
        "Remove `<mimic>`, or choose the option `mimic = follow` or `mimic = independent`.",
    /// A joint mimics a joint that does not exist or does not move.
    MimicTarget = "mimic-target":
        "Name a joint of this file that moves, or remove `<mimic>`.",
    /// A joint of several coordinates mimics one, or is mimicked.
    MimicCoordinates = "mimic-coordinates":
        "Let joints of one coordinate (`revolute`, `continuous`, `prismatic`) mimic each \
        other, and only those.",
    /// Joints mimic each other in a circle.
    MimicCycle = "mimic-cycle":
        "Let one of them move by itself: remove its `<mimic>`.",
    /// A joint mimics another one by a multiplier of 0.
    MimicMultiplier = "mimic-multiplier":
        "Write the ratio of the velocities, or make the joint `fixed` if it is not to move.",
    /// A loop joint holds a link that does not exist.
    LoopLink = "loop-link":
        "Write the names of two links of this file in `<link1 link=\"...\"/>` and `<link2 \
        link=\"...\"/>` (or in the option `loops`); the help names the nearest.",
    /// A loop joint holds two links that cannot move against each other.
    LoopEnds = "loop-ends":
        "Name two links with a joint that moves between them, or remove the loop joint: what \
        is fixed together needs none.",
    /// The damping, friction or rotor of a joint is negative.
    NegativeDrive = "negative-drive":
        "Write a figure of at least 0: damping and friction work against the motion, and a \
        rotor has inertia.",
    /// The description has damping or friction, but no option says whether it acts; it does not.
    InactiveFriction = "inactive-friction":
        "Set the option `friction`: `viscous`, `coulomb` or `smooth` makes damping (and friction) act on \
        the joints; `none` says that neither is wanted, and ends the warning.",
    /// The rotor of a joint is given in two ways.
    RepeatedArmature = "repeated-armature":
        "Leave one of `armature` and `rotor_inertia` with `gear_ratio`: armature = \
        gear_ratio^2 rotor_inertia.",
    /// The mass of a link is negative.
    NegativeMass = "negative-mass":
        "Write a mass of at least 0, in kg. There is no option that takes a negative one.",
    /// A link that moves has no `<inertial>`, nor has a link that is fixed to it; it counts as massless.
    MissingInertial = "missing-inertial":
        "Write the link's `<inertial>`. If it is massless on purpose, between two joints about different \
        axes, write an `<inertial>` with zeros.",
    /// A link would be denser than any material, by its mass and its rotational inertia.
    ImplausibleMass = "implausible-mass":
        "Check the units: the mass is in kg, not in g, and the inertia in kg m^2, about the centre of \
        mass. A point mass has an inertia of zeros.",
    /// A moving body has rotational inertia but no mass.
    InertiaWithoutMass = "inertia-without-mass":
        "Give the link its mass, or remove its inertia.",
    /// The rotational inertia of a moving body is not positive semidefinite.
    IndefiniteInertia = "indefinite-inertia":
        "Check the signs of `ixy`, `ixz`, `iyz` and the units (kg m^2), and that the inertia \
        is about the centre of mass. `unphysical_inertia = warn` takes it as it is.",
    /// The rotational inertia of a moving body breaks the triangle inequality.
    TriangleInequality = "triangle-inequality":
        "Check `ixx`, `iyy` and `izz`, and whether the inertia is about the centre of mass. \
        `unphysical_inertia = warn` takes it as it is.",
    /// A joint moves nothing that has inertia, so its acceleration is undefined.
    NoInertiaFelt = "no-inertia-felt":
        "Give what the joint moves (or what is fixed to it) a mass and an inertia, give the \
        joint a rotor (`rotors`, or `<dynamics armature>`), or make it `fixed`.",
    /// The gravity in the options is NaN, infinite or too large to compute with.
    Gravity = "gravity":
        "Give three finite numbers in m/s^2, such as `[0.0, 0.0, -9.81]`.",
    /// The list of modules is not a partition of the links into chains.
    Modules = "modules":
        "List every moving link once, in chains from their parents outwards, each ending \
        where the tree branches. `chains` and `links` are always right.",
    /// A link whose inertia is to be an argument does not exist or does not move.
    RuntimeInertia = "runtime-inertia":
        "Name links of the description that move, each once.",
    /// A link that is to carry a payload does not exist or does not move.
    Payload = "payload":
        "Name links of the description that move, each once.",
    /// The robot's functions take more text than code can be written out for.
    TooLarge = "too-large":
        "Choose `modules = links` or fewer `functions` where that is proposed, make joints `fixed` that do \
        not matter, or use `modyn::Interpreter`, which takes robots of any size.",
    /// The name of the generated type is no Rust identifier, or likely to be taken.
    TypeName = "type-name":
        "Give the type a name of your own in upper camel case: `modyn!(pub MyArm = \"...\")`, \
        `Builder::type_name`, `--type-name`.",
    /// An option is not what it may be.
    Option = "option":
        "Give the option what the message says it may be.",
    /// Single precision does not carry the robot's dynamics.
    IllConditioned = "ill-conditioned":
        "Use `f64`, or compare with it at the states that matter. Often a link is very light \
        beside what hangs on it.",
    /// The generated code cannot be written.
    Output = "output":
        "Give a path in a folder that exists and can be written to; two robots of one build \
        script need different names.",
    /// The model was refused for a reason that reading should have found.
    InvalidModel = "invalid-model":
        "This is a fault of modyn: please report it with the description.",
}

impl Code {
    /// The kind of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// The kind whose name differs from this text by a letter or two.
    #[must_use]
    pub fn suggest(name: &str) -> Option<Self> {
        nearest(name, Self::ALL.iter().map(|code| code.name())).and_then(Self::from_name)
    }
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
/// In one line, and one for the help: names in it may hold line breaks, which would command a terminal or
/// end a comment.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_place(f)?;
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{severity}[{}]: ", self.code)?;
        self.write_message(f)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {}", tame(help)),
            None => Ok(()),
        }
    }
}

impl Diagnostic {
    /// Its text for a tool that writes `error: ` itself, such as rustc: `robots/foo.urdf:12:7: link `arm`: the mass is
    /// -1 kg [negative-mass]`, then the help.
    #[must_use]
    pub fn without_severity(&self) -> impl fmt::Display + '_ {
        WithoutSeverity(self)
    }

    fn write_place(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", tame(file))?;
        }
        if let Some(position) = self.position {
            write!(f, "{position}:")?;
        }
        if self.file.is_some() || self.position.is_some() { f.write_str(" ") } else { Ok(()) }
    }

    fn write_message(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(subject) = &self.subject {
            write!(f, "{}: ", tame(&subject.to_string()))?;
        }
        f.write_str(&tame(&self.message))
    }
}

struct WithoutSeverity<'d>(&'d Diagnostic);

impl fmt::Display for WithoutSeverity<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(diagnostic) = self;
        diagnostic.write_place(f)?;
        diagnostic.write_message(f)?;
        write!(f, " [{}]", diagnostic.code)?;
        match &diagnostic.help {
            Some(help) => write!(f, "\nhelp: {}", tame(help)),
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

/// As for a user: a build script whose `main` returns diagnostics prints this after `Error: `. So their number comes
/// first, in a line of its own.
impl fmt::Debug for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |severity, one: &str| {
            let count = self.0.iter().filter(|found| found.severity == severity).count();
            let plural = if count == 1 { "" } else { "s" };
            (count > 0).then(|| format!("{count} {one}{plural}"))
        };
        let counts = [count(Severity::Error, "error"), count(Severity::Warning, "warning")];
        let counts: Vec<String> = counts.into_iter().flatten().collect();
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

    /// Rustc and `main` write `error: ` before a text.
    #[test]
    fn error_is_said_once() {
        let diagnostic = Diagnostic::error(Code::NegativeMass, "the mass is -1 kg")
            .in_file("robots/foo.urdf")
            .at(Position { line: 12, column: 7 })
            .about(Subject::Link("arm".into()))
            .with_help("write a mass of at least 0");
        assert_eq!(
            diagnostic.without_severity().to_string(),
            "robots/foo.urdf:12:7: link `arm`: the mass is -1 kg [negative-mass]\nhelp: write a mass of at least 0"
        );
        let gravity = Diagnostic::error(Code::Gravity, "it is not finite");
        assert_eq!(gravity.without_severity().to_string(), "it is not finite [gravity]");
        let warning = Diagnostic::new(Severity::Warning, Code::Mimic, "odd");
        let all = Diagnostics::new(vec![warning, gravity.clone(), gravity]);
        let shown = format!("Error: {all:?}");
        assert!(shown.starts_with("Error: 2 errors, 1 warning\nerror[gravity]: it is"), "{shown}");
    }

    #[test]
    fn a_code_is_suggested() {
        assert_eq!(Code::suggest("no-inertia-flet"), Some(Code::NoInertiaFelt));
        assert_eq!(Code::suggest("inertia"), None);
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
