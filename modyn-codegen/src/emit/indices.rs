//! The names of the entries of arrays, in headers for C: as enumerations, and as texts.

use std::fmt::Write as _;

use modyn_read::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;

use crate::names;

/// The names of the entries of arrays.
pub(super) struct Named {
    /// What the entries are, in one word.
    pub(super) kind: &'static str,
    pub(super) docs: &'static str,
    pub(super) names: Vec<String>,
}

/// Returns the names of links, coordinates and velocities, and of loops, contacts, shapes, controls
/// and activations where there are some.
pub(super) fn all_names(model: &Model) -> Vec<Named> {
    let named = |kind, docs, names: Vec<String>| Named { kind, docs, names };
    let links = model.links().iter().map(|link| link.name.to_string());
    let loops = model.loop_constraints().iter().map(|constraint| constraint.name.to_string());
    let contacts = model.contacts().iter().map(|contact| contact.name.to_string());
    let touching = model.touching_shapes();
    let shapes = touching.iter().map(|shape| shape.name.to_string());
    let controls = model.control_names().into_iter().map(str::to_owned);
    let velocities = "The entries of `qd`, and of accelerations and joint forces";
    let all = vec![
        named("link", "The links of the description, in its order", links.collect()),
        named("q", "The entries of `q`", model.coordinate_names()),
        named("v", velocities, model.velocity_names()),
        named("loop", "The joints that close loops", loops.collect()),
        named("contact", "The contacts", contacts.collect()),
        named("shape", "The shapes that touch the ground in steps", shapes.collect()),
        named("control", "The entries of `ctrl`", controls.collect()),
        named("activation", "The entries of `act`", model.activation_names()),
    ];
    all.into_iter().filter(|named| !named.names.is_empty()).collect()
}

/// Returns the enumerations of a robot.
pub(super) fn indices(model: &Model, prefix: &str) -> String {
    all_names(model).iter().map(|named| named.enumeration(prefix)).collect()
}

/// The texts of names.
pub(super) struct NameTables {
    pub(super) declarations: String,
    pub(super) definitions: String,
}

/// Returns the names of a robot as texts, in the order of the enumerations.
pub(super) fn name_tables(model: &Model, prefix: &str) -> NameTables {
    let mut tables = NameTables {
        declarations: "/* The names in the description. */\n".into(),
        definitions: String::new(),
    };
    for Named { kind, names, .. } in all_names(model) {
        let table = format!("const char *const {prefix}_{kind}_names[{}]", names.len());
        let texts: Vec<String> = names.iter().map(|name| format!("    {}", text(name))).collect();
        let _ = writeln!(tables.declarations, "extern {table};");
        let _ = writeln!(tables.definitions, "{table} = {{\n{}\n}};\n", texts.join(",\n"));
    }
    tables.declarations.push('\n');
    tables
}

/// Returns a text in quotation marks.
fn text(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b" _-./:".contains(&byte);
    let byte = |byte: u8| match plain(byte) {
        true => char::from(byte).to_string(),
        false => format!("\\{byte:03o}"),
    };
    format!("\"{}\"", name.bytes().map(byte).collect::<String>())
}

/// Returns the documentation of a function in a header for C, with the enumerations in place of
/// Rust's names.
pub(super) fn in_header(docs: &str, prefix: &str) -> String {
    with_enumerations(docs, |kind| format!("enum {prefix}_{kind}"))
}

/// Returns the documentation of a function with the names of enumerations, by the kind of their
/// entries, in place of Rust's names.
pub(super) fn with_enumerations(docs: &str, name: impl Fn(&str) -> String) -> String {
    let kinds = [
        ("LINK_NAMES", "link"),
        ("LOOP_CONSTRAINT_NAMES", "loop"),
        ("CONTACT_NAMES", "contact"),
        ("CONTROL_NAMES", "control"),
        ("ACTIVATION_NAMES", "activation"),
    ];
    let docs = docs.replace(" (`PARAMETERS`)", "");
    kinds.iter().fold(docs, |docs, (in_rust, kind)| {
        docs.replace(&format!("`{in_rust}`"), &format!("`{}`", name(kind)))
    })
}

impl Named {
    /// Returns the names as identifiers in snake case.
    pub(super) fn identifiers(&self, reserved: &[&str]) -> Vec<String> {
        names::fields(&self.names.iter().map(String::as_str).collect::<Vec<_>>(), reserved)
    }

    fn enumeration(&self, prefix: &str) -> String {
        let Self { kind, docs, names } = self;
        let upper = format!("{prefix}_{kind}").to_uppercase();
        let constants = self.identifiers(&[]);
        let named = constants.iter().zip(names).enumerate();
        let rows: String = named
            .map(|(i, (constant, name))| {
                let comma = if i + 1 < names.len() { "," } else { "" };
                format!(
                    "    {upper}_{} = {i}{comma} /* {} */\n",
                    constant.to_uppercase(),
                    comment(name)
                )
            })
            .collect();
        format!("/* {docs}. */\nenum {prefix}_{kind} {{\n{rows}}};\n\n")
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
