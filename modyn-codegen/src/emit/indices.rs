//! The indices of numbers in arrays, by name, as enumerations in headers for C.

use std::fmt::Write as _;

use modyn_read::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;
use modyn_runtime::{ConstraintSettings, ContactSurface, ContactTarget, StepSettings};

use crate::names;
use crate::plan::{ArgumentKind, Function};

/// The numbers of the settings of a step, before the surfaces.
const STEP_SETTINGS: [(&str, usize); 3] =
    [("TOLERANCE", 0), ("IMPRATIO", 1), ("SURFACES", StepSettings::<f64>::COUNT)];

/// The numbers of a surface.
const SURFACE: [(&str, usize); 10] = [
    ("ROTATION", 0),
    ("TRANSLATION", 9),
    ("RADIUS", 12),
    ("FRICTION", 13),
    ("TORSIONAL_FRICTION", 14),
    ("ROLLING_FRICTION", 15),
    ("MARGIN", 16),
    ("SOLREF", 17),
    ("SOLIMP", 19),
    ("COUNT", ContactSurface::<f64>::COUNT),
];

/// The numbers of the settings of constraints, before the targets.
const SETTINGS: [(&str, usize); 5] = [
    ("ALPHA", 0),
    ("BETA", 1),
    ("TOLERANCE", 2),
    ("ROUNDING", 3),
    ("TARGETS", ConstraintSettings::<f64>::COUNT),
];

/// The numbers of a contact's target.
const TARGET: [(&str, usize); 10] = [
    ("ROTATION", 0),
    ("TRANSLATION", 9),
    ("VELOCITY", 12),
    ("TANGENTIAL", 18),
    ("ALPHA", 19),
    ("BETA", 20),
    ("COMPLIANCE", 21),
    ("RESTITUTION", 22),
    ("WEIGHT", 23),
    ("COUNT", ContactTarget::<f64>::COUNT),
];

/// Prints the enumerations of a robot.
struct Indices<'a> {
    text: String,
    prefix: &'a str,
    upper: String,
}

/// Returns the enumerations of a robot with these functions: of links, coordinates and velocities, and
/// of contacts, shapes, controls and activations where there are some; and of the numbers of settings
/// that functions take.
pub(super) fn indices(model: &Model, functions: &[Function], prefix: &str) -> String {
    let takes = |kind: ArgumentKind| {
        functions.iter().any(|f| f.row().arguments.iter().any(|argument| argument.kind == kind))
    };
    let upper = prefix.to_uppercase();
    let mut indices = Indices { text: String::new(), prefix, upper };
    let coordinates = model.coordinate_names();
    let velocities = model.velocity_names();
    let links = model.frames().iter().map(|frame| &*frame.name);
    indices.named("link", "The links of the description, in its order", links);
    indices.named("q", "The entries of `q`", coordinates.iter().map(String::as_str));
    let docs = "The entries of `qd`, and of accelerations and joint forces";
    indices.named("v", docs, velocities.iter().map(String::as_str));
    let loops = model.loop_constraints().iter().map(|constraint| &*constraint.name);
    indices.named("loop", "The joints that close loops", loops);
    let contacts = model.contacts().iter().map(|contact| &*contact.name);
    indices.named("contact", "The contacts", contacts);
    indices.named("control", "The entries of `ctrl`", model.control_names());
    indices.named("activation", "The entries of `act`", model.activation_names());
    if takes(ArgumentKind::Settings) {
        indices.numbers("setting", "The places among `settings`, before the targets", &SETTINGS);
        let docs =
            "The places in the target of a contact: the rotation by rows, the translation, ..";
        indices.numbers("target", docs, &TARGET);
    }
    if takes(ArgumentKind::StepSettings) {
        let shapes = model.touching_shapes();
        let names = shapes.iter().map(|shape| &*shape.name);
        indices.named("shape", "The shapes that touch the ground", names);
        let docs = "The places among `step_settings`, before the surfaces of the shapes";
        indices.numbers("step_setting", docs, &STEP_SETTINGS);
        let docs =
            "The places in a surface: the rotation of its plane by rows, a point of the plane, ..";
        indices.numbers("surface", docs, &SURFACE);
    }
    indices.text
}

/// Returns the documentation of a function in a header, with the enumerations in place of Rust's names.
pub(super) fn in_header(docs: &str, prefix: &str) -> String {
    let kinds = [
        ("LINK_NAMES", "link"),
        ("LOOP_CONSTRAINT_NAMES", "loop"),
        ("CONTACT_NAMES", "contact"),
        ("CONTROL_NAMES", "control"),
        ("ACTIVATION_NAMES", "activation"),
    ];
    let names = docs.replace(" (`PARAMETERS`)", "");
    kinds.iter().fold(names, |docs, (name, kind)| {
        docs.replace(&format!("`{name}`"), &format!("`enum {prefix}_{kind}`"))
    })
}

impl Indices<'_> {
    /// Prints an enumeration of names; none of no names.
    fn named<'n>(&mut self, kind: &str, docs: &str, names: impl IntoIterator<Item = &'n str>) {
        let names: Vec<&str> = names.into_iter().collect();
        let fields = names::fields(&names, &[]);
        let constants = fields.iter().zip(&names).enumerate();
        let rows: Vec<String> = constants
            .map(|(i, (constant, name))| {
                self.row(kind, &constant.to_uppercase(), i, &format!(" /* {} */", comment(name)))
            })
            .collect();
        self.enumeration(kind, docs, &rows);
    }

    /// Prints an enumeration of places.
    fn numbers(&mut self, kind: &str, docs: &str, places: &[(&str, usize)]) {
        let rows: Vec<String> =
            places.iter().map(|&(name, place)| self.row(kind, name, place, "")).collect();
        self.enumeration(kind, docs, &rows);
    }

    fn row(&self, kind: &str, name: &str, place: usize, comment: &str) -> String {
        format!("    {}_{}_{name} = {place},{comment}\n", self.upper, kind.to_uppercase())
    }

    fn enumeration(&mut self, kind: &str, docs: &str, rows: &[String]) {
        let Some((last, others)) = rows.split_last() else { return };
        let last = last.replacen(',', "", 1);
        let prefix = self.prefix;
        let others = others.concat();
        let _ = writeln!(self.text, "/* {docs}. */\nenum {prefix}_{kind} {{\n{others}{last}}};\n");
    }
}

/// Returns a name, with any characters, in a form that is safe in a comment.
pub(super) fn comment(name: &str) -> String {
    // No end of a comment, no start of another one (compilers warn of it), and no trigraph.
    format!(
        "`{}`",
        sanitize_for_display(name).replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")
    )
}
