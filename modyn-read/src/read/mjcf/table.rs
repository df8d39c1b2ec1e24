//! The elements and attributes of MJCF: which are read, which have no effect on the equations of
//! motion, and which are refused because they have one and are not read.
//!
//! An element or attribute that is not in the table is an error, as in `MuJoCo`.

use Values::{Any, Exactly, Only, Text, UpTo, Word, Zero};

/// The values of an attribute.
#[derive(Clone, Copy)]
pub enum Values {
    /// This many numbers.
    Exactly(usize),
    /// One number or more, at most this many.
    UpTo(usize),
    /// Any number of numbers.
    Any,
    /// One of these words.
    Word(&'static [&'static str]),
    /// Any text.
    Text,
    /// Numbers that must be zero, since others are not supported; the help otherwise.
    Zero(&'static str),
    /// One of these words, since others are not supported; the help otherwise.
    Only(&'static [&'static str], &'static str),
}

/// The treatment of an element.
#[derive(Clone, Copy)]
pub enum Treatment {
    /// It is read. The attributes that are read, with their values, and those that have no effect.
    Read(&'static [(&'static str, Values)], &'static str),
    /// It has no effect on the equations of motion, nor has anything in it.
    Harmless,
    /// It is refused with this help.
    Refused(&'static str),
}

/// An element in certain places.
pub struct Row {
    /// The names of the elements that may contain it.
    pub parents: &'static [&'static str],
    /// Its names.
    pub names: &'static [&'static str],
    pub treatment: Treatment,
}

/// Returns the row of an element; `None` if MJCF has no such element in this place.
pub fn row(parent: &str, name: &str) -> Option<&'static Row> {
    TABLE.iter().find(|row| row.parents.contains(&parent) && row.names.contains(&name))
}

/// Returns the names of the elements that `parent` may contain.
pub fn children(parent: &str) -> impl Iterator<Item = &'static str> {
    TABLE
        .iter()
        .filter(move |row| row.parents.contains(&parent))
        .flat_map(|row| row.names.iter().copied())
}

const BOOL: Values = Word(&["true", "false"]);
const SWITCH: Values = Word(&["enable", "disable"]);
const AUTO: Values = Word(&["true", "false", "auto"]);
const MODEL: &[&str] = &["mujoco"];
const BODY: &[&str] = &["worldbody", "body", "frame", "replicate"];

macro_rules! pose {
    ($($row:tt)*) => {
        &[("pos", Exactly(3)), ("quat", Exactly(4)), ("axisangle", Exactly(4)), ("euler", Exactly(3)),
          ("xyaxes", Exactly(6)), ("zaxis", Exactly(3)), $($row)*]
    };
}

const POLYNOMIAL: Values = UpTo(3);

/// The elements. `worldbody`, `body`, `frame` and `replicate` may contain the same.
const TABLE: &[Row] = &[
    Row {
        parents: MODEL,
        names: &["compiler"],
        treatment: Treatment::Read(
            &[
                ("angle", Word(&["degree", "radian"])),
                ("eulerseq", Text),
                ("autolimits", BOOL),
                ("inertiafromgeom", AUTO),
                ("inertiagrouprange", Exactly(2)),
                ("settotalmass", Exactly(1)),
                ("boundmass", Exactly(1)),
                ("boundinertia", Exactly(1)),
                ("balanceinertia", BOOL),
                ("fitaabb", BOOL),
                ("alignfree", BOOL),
                ("meshdir", Text),
                ("assetdir", Text),
                ("strippath", Text),
                (
                    "coordinate",
                    Only(
                        &["local"],
                        "MuJoCo reads local coordinates only: load and save the model by MuJoCo 2.3.3",
                    ),
                ),
            ],
            "texturedir discardvisual convexhull usethread fusestatic saveinertial savecompiled \
             savecanonical passthrough conflict \
             exactmeshinertia",
        ),
    },
    Row { parents: &["compiler"], names: &["lengthrange"], treatment: Treatment::Harmless },
    Row {
        parents: MODEL,
        names: &["option"],
        treatment: Treatment::Read(
            &[
                ("gravity", Exactly(3)),
                ("density", Exactly(1)),
                ("viscosity", Exactly(1)),
                ("timestep", Exactly(1)),
                ("cone", Word(&["pyramidal", "elliptic"])),
                ("impratio", Exactly(1)),
                ("integrator", Word(&["Euler", "RK4", "implicit", "implicitfast"])),
                ("o_margin", Exactly(1)),
                ("o_solref", UpTo(2)),
                ("o_solimp", UpTo(5)),
                ("o_friction", UpTo(5)),
                ("actuatorgroupdisable", Any),
            ],
            "apirate tolerance ls_tolerance noslip_tolerance mpr_tolerance \
             ccd_tolerance sleep_tolerance wind \
             magnetic collision jacobian solver iterations \
             ls_iterations noslip_iterations mpr_iterations ccd_iterations sdf_iterations \
             sdf_initpoints",
        ),
    },
    Row {
        parents: &["option"],
        names: &["flag"],
        treatment: Treatment::Read(
            &[
                ("gravity", SWITCH),
                ("spring", SWITCH),
                ("damper", SWITCH),
                ("passive", SWITCH),
                ("frictionloss", SWITCH),
                ("constraint", SWITCH),
                ("equality", SWITCH),
                ("actuation", SWITCH),
                ("clampctrl", SWITCH),
                ("limit", SWITCH),
                ("contact", SWITCH),
                ("override", SWITCH),
            ],
            "warmstart filterparent refsafe sensor midphase eulerdamp autoreset \
             nativeccd island multiccd \
             energy fwdinv invdiscrete sensornoise sleep diagexact ipc speculative",
        ),
    },
    Row {
        parents: MODEL,
        names: &["size", "statistic", "visual", "custom", "sensor"],
        treatment: Treatment::Harmless,
    },
    // Plugins have an effect where an element uses one.
    Row { parents: MODEL, names: &["extension"], treatment: Treatment::Harmless },
    Row { parents: MODEL, names: &["default"], treatment: Treatment::Read(&[("class", Text)], "") },
    Row {
        parents: &["default"],
        names: &["default"],
        treatment: Treatment::Read(&[("class", Text)], ""),
    },
    Row {
        parents: &["default"],
        names: &["texture", "material", "camera", "light"],
        treatment: Treatment::Harmless,
    },
    Row { parents: MODEL, names: &["contact"], treatment: Treatment::Read(&[], "") },
    Row {
        parents: &["contact", "default"],
        names: &["pair"],
        treatment: Treatment::Read(
            &[
                ("class", Text),
                ("geom1", Text),
                ("geom2", Text),
                ("condim", Exactly(1)),
                ("friction", UpTo(5)),
                ("solref", UpTo(2)),
                ("solreffriction", UpTo(2)),
                ("solimp", UpTo(5)),
                ("margin", Exactly(1)),
                ("adhesion", Exactly(1)),
            ],
            "name gap",
        ),
    },
    Row {
        parents: &["contact"],
        names: &["exclude"],
        treatment: Treatment::Read(&[("body1", Text), ("body2", Text)], "name"),
    },
    Row { parents: MODEL, names: &["asset"], treatment: Treatment::Read(&[], "") },
    Row {
        parents: &["asset"],
        names: &["texture", "material", "skin"],
        treatment: Treatment::Harmless,
    },
    Row {
        parents: &["asset", "default"],
        names: &["mesh"],
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("file", Text),
                ("vertex", Any),
                ("face", Any),
                ("refpos", Exactly(3)),
                ("refquat", Exactly(4)),
                ("scale", Exactly(3)),
                ("inertia", Word(&["convex", "legacy", "exact", "shell"])),
                ("builtin", Text),
                ("content_type", Text),
            ],
            "normal texcoord smoothnormal maxhullvert params material octree_maxdepth",
        ),
    },
    Row {
        parents: &["asset"],
        names: &["hfield"],
        treatment: Treatment::Read(
            &[("name", Text), ("file", Text), ("size", Exactly(4))],
            "content_type nrow ncol elevation",
        ),
    },
    Row {
        parents: &["asset"],
        names: &["model"],
        treatment: Treatment::Read(&[("name", Text), ("file", Text)], "content_type"),
    },
    // The plugin of a mesh makes its surface.
    Row { parents: &["mesh", "geom"], names: &["plugin"], treatment: Treatment::Harmless },
    Row {
        parents: MODEL,
        names: &["worldbody"],
        treatment: Treatment::Read(&[("childclass", Text)], "name pos quat"),
    },
    Row {
        parents: BODY,
        names: &["body"],
        treatment: Treatment::Read(
            pose![
                ("name", Text),
                ("childclass", Text),
                ("class", Text),
                ("mocap", BOOL),
                ("gravcomp", Exactly(1)),
            ],
            "sleep simple fuse user",
        ),
    },
    Row {
        parents: BODY,
        names: &["frame"],
        treatment: Treatment::Read(
            pose![("childclass", Text), ("class", Text), ("name", Text),],
            "",
        ),
    },
    Row {
        parents: BODY,
        names: &["replicate"],
        treatment: Treatment::Read(
            &[
                ("count", Exactly(1)),
                ("offset", Exactly(3)),
                ("euler", Exactly(3)),
                ("sep", Text),
                ("childclass", Text),
            ],
            "",
        ),
    },
    Row {
        parents: BODY,
        names: &["attach"],
        treatment: Treatment::Read(
            &[("model", Text), ("body", Text), ("frame", Text), ("prefix", Text)],
            "",
        ),
    },
    Row {
        parents: &["body"],
        names: &["inertial"],
        treatment: Treatment::Read(
            pose![("mass", Exactly(1)), ("diaginertia", Exactly(3)), ("fullinertia", Exactly(6)),],
            "",
        ),
    },
    Row {
        parents: &["body", "frame", "replicate", "default"],
        names: &["joint"],
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("type", Word(&["free", "ball", "slide", "hinge"])),
                ("pos", Exactly(3)),
                ("axis", Exactly(3)),
                ("springdamper", Exactly(2)),
                ("limited", AUTO),
                ("actuatorfrclimited", AUTO),
                ("stiffness", POLYNOMIAL),
                ("springyield", Zero("write 0: springs that yield are not supported")),
                ("range", Exactly(2)),
                ("actuatorfrcrange", Exactly(2)),
                ("ref", Exactly(1)),
                ("springref", Exactly(1)),
                ("armature", Exactly(1)),
                ("damping", POLYNOMIAL),
                ("frictionloss", Exactly(1)),
                ("solreflimit", UpTo(2)),
                ("solimplimit", UpTo(5)),
                ("solreffriction", UpTo(2)),
                ("solimpfriction", UpTo(5)),
                ("margin", Exactly(1)),
            ],
            "group actuatorgravcomp user",
        ),
    },
    Row {
        parents: &["body", "frame", "replicate"],
        names: &["freejoint"],
        treatment: Treatment::Read(&[("name", Text), ("align", AUTO)], "group"),
    },
    Row {
        parents: &["worldbody", "body", "frame", "replicate", "default"],
        names: &["geom"],
        treatment: Treatment::Read(
            pose![
                ("class", Text),
                (
                    "type",
                    Word(&[
                        "plane",
                        "hfield",
                        "sphere",
                        "capsule",
                        "ellipsoid",
                        "cylinder",
                        "box",
                        "mesh",
                        "sdf"
                    ])
                ),
                ("group", Exactly(1)),
                ("size", UpTo(3)),
                ("mass", Exactly(1)),
                ("density", Exactly(1)),
                ("shellinertia", BOOL),
                ("fromto", Exactly(6)),
                ("hfield", Text),
                ("mesh", Text),
                ("fitscale", Exactly(1)),
                ("contype", Exactly(1)),
                ("conaffinity", Exactly(1)),
                ("condim", Exactly(1)),
                ("priority", Exactly(1)),
                ("friction", UpTo(3)),
                ("solmix", Exactly(1)),
                ("solref", UpTo(2)),
                ("solimp", UpTo(5)),
                ("margin", Exactly(1)),
                ("surfacevel", UpTo(6)),
                ("adhesion", Exactly(1)),
            ],
            "name material gap rgba fluidshape fluidcoef castshadow user",
        ),
    },
    Row {
        parents: &["worldbody", "body", "frame", "replicate", "default"],
        names: &["site"],
        treatment: Treatment::Read(
            pose![("name", Text), ("class", Text), ("fromto", Exactly(6)),],
            "type group material mesh size rgba user",
        ),
    },
    Row { parents: BODY, names: &["camera", "light"], treatment: Treatment::Harmless },
    Row {
        parents: BODY,
        names: &["composite", "flexcomp"],
        treatment: Treatment::Refused(
            "it makes many bodies: let MuJoCo write them out (`mj_saveLastXML`), or remove it; \
             soft bodies are not supported",
        ),
    },
    Row {
        parents: BODY,
        names: &["plugin"],
        treatment: Treatment::Refused(
            "a plugin may exert forces: remove it, and give its forces with the others",
        ),
    },
    Row { parents: MODEL, names: &["deformable"], treatment: Treatment::Read(&[], "") },
    Row { parents: &["deformable"], names: &["skin"], treatment: Treatment::Harmless },
    Row {
        parents: &["deformable"],
        names: &["flex"],
        treatment: Treatment::Refused("soft bodies are not supported: remove it"),
    },
    Row { parents: MODEL, names: &["tendon"], treatment: Treatment::Read(&[], "") },
    Row {
        parents: &["tendon", "default"],
        names: &["spatial", "fixed", "tendon"],
        treatment: Treatment::Read(
            &[
                ("class", Text),
                ("stiffness", POLYNOMIAL),
                ("damping", POLYNOMIAL),
                ("frictionloss", Exactly(1)),
                ("armature", Exactly(1)),
                ("name", Text),
                ("range", Exactly(2)),
                ("actuatorfrclimited", AUTO),
                ("actuatorfrcrange", Exactly(2)),
                ("limited", AUTO),
                ("margin", Exactly(1)),
                ("solreflimit", UpTo(2)),
                ("solimplimit", UpTo(5)),
                ("solreffriction", UpTo(2)),
                ("solimpfriction", UpTo(5)),
                ("springlength", UpTo(2)),
                ("springyield", Any),
            ],
            "group width material rgba user",
        ),
    },
    Row {
        parents: &["spatial"],
        names: &["site", "geom", "pulley"],
        treatment: Treatment::Harmless,
    },
    Row {
        parents: &["fixed"],
        names: &["joint"],
        treatment: Treatment::Read(&[("joint", Text), ("coef", Exactly(1))], ""),
    },
    Row { parents: MODEL, names: &["equality"], treatment: Treatment::Read(&[], "") },
    Row {
        parents: &["default"],
        names: &["equality"],
        treatment: Treatment::Read(
            &[("active", BOOL), ("solref", UpTo(2)), ("solimp", UpTo(5))],
            "",
        ),
    },
    Row {
        parents: &["equality"],
        names: &["connect"],
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("active", BOOL),
                ("body1", Text),
                ("body2", Text),
                ("anchor", Exactly(3)),
                ("site1", Text),
                ("site2", Text),
                ("solref", UpTo(2)),
                ("solimp", UpTo(5)),
            ],
            "",
        ),
    },
    Row {
        parents: &["equality"],
        names: &["weld"],
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("active", BOOL),
                ("body1", Text),
                ("body2", Text),
                ("anchor", Exactly(3)),
                ("relpose", Exactly(7)),
                ("torquescale", Exactly(1)),
                ("site1", Text),
                ("site2", Text),
                ("solref", UpTo(2)),
                ("solimp", UpTo(5)),
            ],
            "",
        ),
    },
    Row {
        parents: &["equality"],
        names: &["joint"],
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("active", BOOL),
                ("joint1", Text),
                ("joint2", Text),
                ("polycoef", UpTo(5)),
                ("solref", UpTo(2)),
                ("solimp", UpTo(5)),
            ],
            "",
        ),
    },
    Row {
        parents: &["equality"],
        names: &["tendon"],
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("active", BOOL),
                ("tendon1", Text),
                ("tendon2", Text),
                ("polycoef", UpTo(5)),
                ("solref", UpTo(2)),
                ("solimp", UpTo(5)),
            ],
            "",
        ),
    },
    Row {
        parents: &["equality"],
        names: &["flex", "flexvert", "flexstrain", "distance"],
        treatment: Treatment::Read(
            &[("class", Text), ("active", BOOL)],
            "name flex cell geom1 geom2 distance solref solimp",
        ),
    },
    Row { parents: MODEL, names: &["actuator"], treatment: Treatment::Read(&[], "") },
    Row {
        parents: &["actuator", "default"],
        names: ACTUATORS,
        treatment: Treatment::Read(
            &[
                ("name", Text),
                ("class", Text),
                ("joint", Text),
                ("jointinparent", Text),
                ("tendon", Text),
                ("site", Text),
                ("cranksite", Text),
                ("body", Text),
                ("group", Exactly(1)),
                ("dyntype", Text),
                ("gaintype", Text),
                ("biastype", Text),
                ("dynprm", Any),
                ("gainprm", Any),
                ("biasprm", Any),
                ("gear", UpTo(6)),
                ("ctrllimited", AUTO),
                ("ctrlrange", Exactly(2)),
                ("forcelimited", AUTO),
                ("forcerange", Exactly(2)),
                ("actlimited", AUTO),
                ("actrange", Exactly(2)),
                ("actearly", BOOL),
                ("delay", Exactly(1)),
                ("kp", Exactly(1)),
                ("kv", Exactly(1)),
                ("dampratio", Exactly(1)),
                ("timeconst", UpTo(2)),
                ("inheritrange", Exactly(1)),
                ("area", Exactly(1)),
                ("diameter", Exactly(1)),
                ("bias", Exactly(3)),
                ("damping", Zero("move it to the `<joint>`")),
                ("armature", Zero("move it to the `<joint>`")),
            ],
            ACTUATOR_ATTRIBUTES,
        ),
    },
    Row { parents: &["plugin"], names: &["config"], treatment: Treatment::Harmless },
    Row { parents: MODEL, names: &["keyframe"], treatment: Treatment::Read(&[], "") },
    Row {
        parents: &["keyframe"],
        names: &["key"],
        treatment: Treatment::Read(
            &[("name", Text), ("qpos", Any), ("qvel", Any), ("act", Any), ("ctrl", Any)],
            "time mpos mquat plastic",
        ),
    },
];

/// The elements of actuators, which share the values of classes.
pub const ACTUATORS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];

/// The other attributes of actuators, of laws that do not act.
const ACTUATOR_ATTRIBUTES: &str = "*";
