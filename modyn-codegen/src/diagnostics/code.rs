//! The table of the codes of diagnostics: name, cause and remedy.

use std::fmt;

use super::suggest::suggest;

/// Defines the enum, its names and remedies from one table, so that no code can lack one.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal: $remedy:literal,)+) => {
        /// The codes of diagnostics.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Code {
            $($(#[doc = $doc])+ $variant,)+
        }

        impl Code {
            /// All codes, in the order of the table.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Returns the name in the output; it never changes.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }

            /// Returns the cause: one sentence about what is wrong.
            #[must_use]
            pub fn cause(self) -> &'static str {
                match self {
                    $(Self::$variant => concat!($($doc),+).trim_ascii_start(),)+
                }
            }

            /// Returns the remedy: what to do about it.
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
        "With the feature `mjcf`, the macro, `Builder::file` and `Builder::mjcf` read it, as the command \
        `modyn` does, if it is written as MuJoCo's XML reference says. Elsewhere convert the model to URDF, \
        or take the URDF that the MJCF was made from.",
    /// The document is something else than a URDF.
    NotUrdf = "not-urdf":
        "Give a file in UTF-8 whose root element is `<robot>`.",
    /// The document that is to be read as a `MuJoCo` model is something else.
    NotMjcf = "not-mjcf":
        "Give a file whose root element is `<mujoco>`, or read it as the format that it has.",
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
    /// Returns the code of this name; `None` if there is none.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// Returns the code whose name differs from `name` by one or two letters; `None` if there is none.
    #[must_use]
    pub fn suggest(name: &str) -> Option<Self> {
        suggest(name, Self::ALL.iter().map(|code| code.name())).and_then(Self::from_name)
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::Code;

    #[test]
    fn a_code_is_suggested() {
        assert_eq!(Code::suggest("no-inertia-flet"), Some(Code::NoInertiaFelt));
        assert_eq!(Code::suggest("inertia"), None);
    }

    #[test]
    fn no_two_codes_share_a_name() {
        let names: std::collections::BTreeSet<_> = Code::ALL.iter().map(|c| c.name()).collect();
        assert_eq!(names.len(), Code::ALL.len());
    }
}
