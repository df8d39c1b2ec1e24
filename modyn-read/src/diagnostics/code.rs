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

            /// Returns the remedy.
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
    /// The file does not exist at any of the places that were tried.
    MissingFile = "missing-file":
        "Give a path that exists. In the macro it is relative to the source file or to the \
        folder of `Cargo.toml`, in a build script to the folder of `Cargo.toml`, on the command line to \
        the current folder. On the command line, `-` is standard input.",
    /// The text is not well-formed XML.
    MalformedXml = "malformed-xml":
        "Repair the XML at the position: a tag that is not closed, an attribute without \
        quotes, a stray `&` or `<`. Comments may contain anything, even `--`.",
    /// The document has a document type declaration, which could redefine its contents.
    Dtd = "dtd":
        "Remove the `<!DOCTYPE ...>`: URDF has none, and its entities could change the numbers.",
    /// The document exceeds a limit on its size, its attributes or its namespaces.
    Excessive = "excessive":
        "Check where the file comes from: it is damaged, or made to do harm. The limits are 256 attributes of an \
        element, 256 namespaces of a document and 1 GiB for a file. The number of joints and links is not limited.",
    /// A xacro cannot be expanded.
    Xacro = "xacro":
        "Repair the element, expression or substitution at the position; the notes name the macro \
         calls that led there. \
        A xacro whose name does not end in `.xacro` and that has no `<xacro:...>` is read as a URDF: rename it.",
    /// A xacro itself issues a warning, or reads a variable of the environment, which has its
    /// default here.
    XacroWarning = "xacro-warning":
        "Do what the message says. A variable of the environment becomes an argument, `$(arg name)`, whose value \
        the option `xacro_args` gives.",
    /// The document is an SDF.
    Sdf = "sdf":
        "Read the file as the format that it has: `modyn_read::read`, `modyn!`, `Builder::file` and the \
        command `modyn` detect it.",
    /// The document is a `MuJoCo` model.
    Mjcf = "mjcf":
        "Read the file as the format that it has: `modyn_read::read`, `modyn!`, `Builder::file` and the \
        command `modyn` detect it.",
    /// The document is not a URDF.
    NotUrdf = "not-urdf":
        "Give a file in UTF-8 whose root element is `<robot>`.",
    /// The document is not a `MuJoCo` model.
    NotMjcf = "not-mjcf":
        "Give a file whose root element is `<mujoco>`, or read the file as the format that it has.",
    /// The document is not an SDF.
    NotSdf = "not-sdf":
        "Give a file whose root element is `<sdf version=\"...\">`, or read the file as the format that it has.",
    /// The version of an SDF is missing, or is not read.
    SdfVersion = "sdf-version":
        "Write `<sdf version=\"1.12\">`, or the version that the file has. Versions from 1.2 are read; elements of \
        newer versions than 1.12 may be missing.",
    /// An SDF has no model, or several worlds.
    SdfModel = "sdf-model":
        "Give a file with one `<world>`, or with a `<model>` alone.",
    /// A name of an SDF does not mean a frame, is reserved, or means two things.
    FrameName = "frame-name":
        "Name a link, joint, `<frame>` or model of the same model, or a part of a nested model as in `model::link`. \
        Elements beside each other need different names.",
    /// Poses of an SDF depend on each other, or a frame is attached to itself.
    FrameCycle = "frame-cycle":
        "Write one of the poses relative to `__model__`, or attach one of the frames to a link.",
    /// The file is not text.
    NotText = "not-text":
        "Save the file as UTF-8. URDF, SDF and MJCF are text.",
    /// An attribute that URDF requires is missing or empty.
    MissingAttribute = "missing-attribute":
        "Write the attribute that the message names. URDF has no default for it.",
    /// An element that URDF requires is missing.
    MissingElement = "missing-element":
        "Write the element that the message names, in the link or joint that it names.",
    /// An element that may occur only once is repeated.
    RepeatedElement = "repeated-element":
        "Keep one of the elements and remove the others.",
    /// An attribute or element that would change the robot is not read.
    NotRead = "not-read":
        "Write the value as the help says, or remove the attribute or element. If it is a warning, the attribute or \
        element has no effect: check the spelling, or do what the help says.",
    /// The description includes another file, which is not read: parts of the robot are missing.
    Include = "include":
        "MJCF: write a path relative to the folder of the model, and include each file once. URDF \
         has no includes: copy \
        the contents of that file into this one; files that a tool has expanded (`xacro`) have none.",
    /// A text is not a number.
    BadNumber = "bad-number":
        "Write a decimal number, such as `0.25` or `2.5e-1`: with a point, without a unit, \
        and without an expression.",
    /// There are too many or too few numbers.
    NumberCount = "number-count":
        "Write the expected number of values, separated by spaces: three for `xyz` and `rpy`.",
    /// A number is NaN, infinite or too large to compute with.
    NotFinite = "not-finite":
        "Write a finite number in SI units, of a magnitude below 1e60. If the number is a product \
        (of a long chain's lengths, or of multipliers), make its factors smaller.",
    /// The joint type does not exist.
    UnknownJointType = "unknown-joint-type":
        "Use `revolute`, `continuous`, `prismatic`, `universal`, `planar`, `spherical`, \
        `floating` or `fixed`.",
    /// Two links have the same name.
    DuplicateLink = "duplicate-link":
        "Give one of the links another name, also in the joints that refer to it.",
    /// Two joints have the same name.
    DuplicateJoint = "duplicate-joint":
        "Give one of the joints another name.",
    /// The parent of a joint does not exist.
    UnknownParent = "unknown-parent":
        "Write the name of a link of this file in `<parent link=\"...\"/>`; the help suggests the closest name.",
    /// The child of a joint does not exist.
    UnknownChild = "unknown-child":
        "Write the name of a link of this file in `<child link=\"...\"/>`; the help suggests the closest name.",
    /// A link is the child of several joints.
    SeveralParents = "several-parents":
        "Keep one of the joints: a link has one parent. To describe a closed loop, cut it: make one joint of the \
        loop a `<loop_joint>`.",
    /// Joints form a cycle.
    Cycle = "cycle":
        "Make the robot a tree: one link must not be the child of any joint. To describe a closed loop, cut it: make \
        one of its joints a `<loop_joint>`.",
    /// Several links are not the child of any joint, so the robot is not connected.
    SeveralRoots = "several-roots":
        "Connect them: write a joint, such as a `fixed` joint, to every root but one.",
    /// The robot has no link.
    NoLink = "no-link":
        "Write a `<link>`.",
    /// The robot has no moving joint.
    NoMovingJoint = "no-moving-joint":
        "Make a joint `revolute`, `continuous` or `prismatic`, or let the base float (`base = \
        floating`).",
    /// The axis of a moving joint is zero.
    ZeroAxis = "zero-axis":
        "Write the direction of the axis, such as `<axis xyz=\"0 0 1\"/>`.",
    /// The axis of a moving joint is not of unit length; it is normalised.
    AxisLength = "axis-length":
        "Write the unit vector that the help shows. The robot is compiled with that vector in any case.",
    /// The two axes of a universal joint are parallel.
    ParallelAxes = "parallel-axes":
        "Change one of the axes: `<axis>` and `<axis2>` of a universal joint must span a plane.",
    /// The lower limit of a joint is above its upper limit.
    InvertedLimits = "inverted-limits":
        "Exchange `lower` and `upper`. The default of both is 0.",
    /// A revolute or prismatic joint has no `<limit>`; it is read as a joint without limits.
    MissingLimit = "missing-limit":
        "Write `<limit lower=\"...\" upper=\"...\" effort=\"...\" velocity=\"...\"/>`, which URDF \
        requires. A joint that rotates without limits is `continuous`.",
    /// The upper position limit of a joint is its lower one, so that the joint cannot move within
    /// its limits.
    EmptyRange = "empty-range":
        "Write the range: `lower` and `upper` of a URDF's `<limit>` are 0 if they are missing. A \
         joint that rotates without \
        limits is `continuous`.",
    /// The effort or velocity limit of a joint is 0, so that nothing can move the joint within its
    /// limits.
    ZeroLimit = "zero-limit":
        "Write the largest joint force (N m or N) or velocity (rad/s or m/s) of the joint, or \
         omit the attribute if there is no \
        limit. Programs that export URDF often write 0 for an unknown limit.",
    /// The range of a joint is several revolutions, as if it were in degrees.
    LimitUnit = "limit-unit":
        "Write the range in rad: 180 degrees are 3.14159. If the joint really makes several \
         revolutions, the warning has no effect; \
        a joint that rotates without limits is `continuous`.",
    /// An origin or a range is far longer than the other lengths of the robot, as if it were in
    /// millimetres.
    LengthUnit = "length-unit":
        "Write lengths in m: 350 mm are 0.35. If the length is right, the warning has no effect.",
    /// The effort or velocity limit of a joint is negative; it is ignored.
    NegativeLimit = "negative-limit":
        "Write the magnitude of the limit, which is at least 0. Omit the attribute if there is no limit.",
    /// A joint mimics another joint, which the option `mimic = refuse` makes an error.
    Mimic = "mimic":
        "Remove `<mimic>`, or choose the option `mimic = follow` or `mimic = independent`.",
    /// A joint mimics a joint that does not exist or does not move.
    MimicTarget = "mimic-target":
        "Name a joint of this file that moves, or remove `<mimic>`.",
    /// A joint with several coordinates mimics another joint, or is mimicked.
    MimicCoordinates = "mimic-coordinates":
        "Use `<mimic>` between joints with one coordinate only: `revolute`, `continuous`, `prismatic`.",
    /// Mimic joints form a cycle.
    MimicCycle = "mimic-cycle":
        "Make one of the joints independent: remove its `<mimic>`.",
    /// A joint mimics another joint with a multiplier of 0.
    MimicMultiplier = "mimic-multiplier":
        "Write the ratio of the velocities, or make the joint `fixed` if it does not move.",
    /// A loop joint refers to a link that does not exist.
    LoopLink = "loop-link":
        "Write the names of two links of this file in `<link1 link=\"...\"/>` and `<link2 \
        link=\"...\"/>` (or in the option `loops`); the help suggests the closest name.",
    /// A loop joint connects two links that cannot move relative to each other.
    LoopEnds = "loop-ends":
        "Name two links with a moving joint between them, or remove the loop joint.",
    /// A contact frame cannot be held: its type, its name, its link or its place is wrong.
    ContactFrame = "contact-frame":
        "Write `<contact_frame name=\"...\" type=\"point\" link=\"...\" xyz=\"0 0 0\" rpy=\"0 0 \
         0\"/>` with the type `point` or \
        `surface`, a name of its own, and a link of this file that moves.",
    /// The damping, friction or armature of a joint is negative.
    NegativeJointDynamics = "negative-joint-dynamics":
        "Write a number of at least 0: damping and friction oppose the motion, and an armature is an inertia.",
    /// The description has damping or friction, but the option `joint_friction` is not set; they
    /// have no effect.
    InactiveFriction = "inactive-friction":
        "Set the option `joint_friction`: with `viscous`, `coulomb` or `smooth`, damping (and friction) act on \
        the joints; with `none` they have no effect, and there is no warning.",
    /// The armature of a joint is given twice.
    RepeatedArmature = "repeated-armature":
        "Keep either `armature`, or `rotor_inertia` with `gear_ratio`: armature = \
        gear_ratio^2 rotor_inertia.",
    /// The mass of a link is negative.
    NegativeMass = "negative-mass":
        "Write a mass of at least 0, in kg. No option accepts a negative mass.",
    /// Neither a moving link nor a link that is fixed to it has an `<inertial>`; the link counts as
    /// massless.
    MissingInertial = "missing-inertial":
        "Write the link's `<inertial>`. If it is massless on purpose, between two joints about different \
        axes, write an `<inertial>` with zeros.",
    /// By its mass and its rotational inertia, a link is denser than any material.
    ImplausibleMass = "implausible-mass":
        "Check the units: the mass is in kg, not in g, and the inertia in kg m^2, about the centre of \
        mass. A point mass has an inertia of zeros.",
    /// A moving body has rotational inertia but no mass.
    InertiaWithoutMass = "inertia-without-mass":
        "Give the link its mass, or remove its inertia. `unphysical_inertia = warn` accepts it.",
    /// The rotational inertia of a moving body is not positive semidefinite.
    IndefiniteInertia = "indefinite-inertia":
        "Check the signs of `ixy`, `ixz`, `iyz` and the units (kg m^2), and that the inertia \
        is about the centre of mass. `unphysical_inertia = warn` accepts it.",
    /// The rotational inertia of a moving body breaks the triangle inequality.
    TriangleInequality = "triangle-inequality":
        "Check `ixx`, `iyy` and `izz`, and whether the inertia is about the centre of mass. \
        `unphysical_inertia = warn` accepts it.",
    /// A joint moves no inertia, although its link has mass, so its acceleration is undefined.
    SingularJoint = "singular-joint":
        "Give the link that the joint moves (or a link that is fixed to it) a mass and an inertia, give the \
        joint an armature (`armature`, or `<dynamics armature>`), or make the joint `fixed`.",
    /// Joints move no inertia, since their links have none, so the robot has kinematic functions
    /// alone.
    KinematicsOnly = "kinematics-only":
        "Nothing, if poses, Jacobians and velocities are all that is needed: they do not depend on \
         inertia. For dynamics, \
        give the links that the message names a mass and an inertia, or give their joints armatures (`armature`, or \
        `<dynamics armature>`); any armature makes the mass matrix regular. Without inertia, a function of \
        dynamics that is selected by name is an error.",
    /// The gravity in the options is NaN, infinite or too large to compute with.
    Gravity = "gravity":
        "Give three finite numbers in m/s^2, such as `[0.0, 0.0, -9.81]`.",
    /// The list of modules is not a partition of the links into chains.
    Modules = "modules":
        "List every moving link once. Each module is a chain of links, from the parent to the tip, that ends \
        where the tree branches. `chains` and `links` are always valid.",
    /// A link in `runtime_inertia` does not exist or does not move.
    RuntimeInertia = "runtime-inertia":
        "Name links of the description that move, each once.",
    /// A link in `payload` does not exist or does not move.
    Payload = "payload":
        "Name links of the description that move, each once.",
    /// The code for the robot's functions would be too large.
    TooLarge = "too-large":
        "Choose `modules = links` or fewer `functions` if the help proposes that, make unimportant joints `fixed`, \
        or use `modyn::Interpreter`, which accepts robots of any size.",
    /// The name of the generated type is not a Rust identifier, or collides with the trait `Robot`.
    TypeName = "type-name":
        "Choose a name in upper camel case: `modyn!(pub MyArm = \"...\")`, `Builder::type_name`, `--type-name`.",
    /// An option has an invalid value.
    Option = "option":
        "Set the option to one of the values in the message.",
    /// Single precision may not suffice for the robot's dynamics.
    IllConditioned = "ill-conditioned":
        "Use `f64`, or compare the results with `f64` at relevant states. A frequent cause is a link that is very \
        light compared with the links that it carries.",
    /// The packed program of a function is invalid, so the function is computed on scalars.
    InvalidProgram = "invalid-program":
        "Report this fault of modyn, with the description. The function's results are right, but take longer.",
    /// A format has no words for a part of a robot that is to be written in it.
    Inexpressible = "inexpressible":
        "Write the robot in the other format, URDF or MJCF, or change the part that the message names.",
    /// The generated code cannot be written.
    Output = "output":
        "Give a path in a writable folder. Two robots of one build script need different names.",
    /// The model is invalid for a reason that the reader should have found.
    InvalidModel = "invalid-model":
        "Report this fault of modyn, with the description.",
}

impl Code {
    /// Returns the code of this name; `None` if there is none.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// Returns the code whose name differs from `name` by one or two letters; `None` if there is
    /// none.
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
