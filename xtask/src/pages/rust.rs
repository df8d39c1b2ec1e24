//! The items of Rust that rustc needs for each function of the table: the documentation of
//! `Function`'s variants, the traits of `functions`, the functions of `Robot`, and the calls of
//! tests.

use modyn_codegen::Function;
use modyn_codegen::plan::{Argument, ArgumentKind, Record, Row, Shape};

use super::python::{SIZES, wrap};

/// The longest line.
const COLUMNS: usize = 100;

/// Returns the rows of all functions for which a property holds.
fn rows(is_row: impl Fn(&Row) -> bool) -> impl Iterator<Item = Row> {
    Function::ALL.iter().map(|function| function.row()).filter(move |row| is_row(row))
}

/// Returns lines of documentation.
fn docs(text: &str) -> String {
    wrap(text, COLUMNS - 8).iter().map(|line| format!("    /// {line}\n")).collect()
}

/// Returns `head`, the items and `tail` in one line or, if it is too long, in a line for each item.
fn listed(indent: &str, head: &str, items: &[String], tail: &str) -> String {
    let line = format!("{indent}{head}{}{tail}", items.join(", "));
    if line.len() <= COLUMNS {
        return line;
    }
    let lines = items.iter().map(|item| format!("{indent}    {item},\n"));
    format!("{indent}{head}\n{}{indent}{tail}", lines.collect::<String>())
}

/// Returns the variants of `Function`.
pub(super) fn variants() -> String {
    let variant = |row: Row| {
        let text = match row.batch_of {
            None => docs(row.docs),
            Some(one) => docs(&format!("`{}` of many states at a time.", one.name())),
        };
        format!("{text}    {:?},\n", row.function)
    };
    rows(|_| true).map(variant).collect()
}

/// Returns the traits of functions: with their documentation and the message of a call that needs
/// the trait.
fn traits(is_row: impl Fn(&Row) -> bool) -> String {
    let text = |Row { function, name, .. }| {
        let documentation = docs(&format!("Robots that have `{name}`."));
        let message = format!("\"`{{Self}}` has no function `{name}`\";");
        let line = format!("    {function:?} {message}\n");
        let is_short = line.len() <= COLUMNS;
        documentation + &if is_short { line } else { line.replacen(" \"", "\n        \"", 1) }
    };
    rows(is_row).map(text).collect()
}

pub(super) fn traits_of_kinematics() -> String {
    traits(|row| !row.of_constraints && !row.needs_inertia)
}

pub(super) fn traits_of_dynamics() -> String {
    traits(|row| !row.of_constraints && row.needs_inertia)
}

pub(super) fn traits_of_constraints() -> String {
    traits(|row| row.of_constraints)
}

/// Returns the names of the traits of functions in lines.
fn bound(first: &str, is_row: impl Fn(&Row) -> bool) -> String {
    let names = rows(is_row).map(|row| format!(" {:?}", row.function));
    let lines = wrap(&(first.to_owned() + &names.collect::<String>()), COLUMNS - 4);
    lines.iter().map(|line| format!("    {line}\n")).collect()
}

pub(super) fn default_functions() -> String {
    bound("", |row| row.default && row.is_general())
}

pub(super) fn functions_of_one_state() -> String {
    bound("Defaults", |row| !row.default && row.is_general() && row.batch_of.is_none())
}

pub(super) fn default_functions_of_constraints() -> String {
    bound("", |row| row.default && row.of_constraints)
}

pub(super) fn functions_of_many_states() -> String {
    bound("", |row| row.is_general() && row.batch_of.is_some())
}

pub(super) fn functions_of_constraints_for_many_states() -> String {
    bound("", |row| row.of_constraints && row.batch_of.is_some())
}

/// Returns the name of a type of several results and the types of its fields, once for each
/// parameter of the type.
fn several(shape: &Shape) -> Option<(&'static str, Vec<String>)> {
    let Shape::Record(
        record @ (Record::ResultsByField(name) | Record::ResultsByType(name)),
        fields,
    ) = shape
    else {
        return None;
    };
    let mut types: Vec<String> = Vec::new();
    for (_, field) in fields {
        let kind = type_of(field);
        if matches!(record, Record::ResultsByField(_)) || !types.contains(&kind) {
            types.push(kind);
        }
    }
    Some((name, types))
}

/// Returns the type of a layout in the trait of robots.
fn type_of(shape: &Shape) -> String {
    if let Some((name, types)) = several(shape) {
        return format!("{name}<{}>", types.join(", "));
    }
    match shape {
        Shape::Scalar => "T".into(),
        Shape::Array(element, n, _) => array_type(&type_of(element), *n),
        Shape::Record(record, _) => match record {
            Record::Pose => "Pose<T>".into(),
            Record::Factorization => "Self::UduFactorization<T>".into(),
            Record::Spatial(name) | Record::OfScalar(name) => format!("{name}<T>"),
            _ => unreachable!("no function of the trait has a {record:?}"),
        },
    }
}

/// Returns the type of an array of `n` elements.
fn array_type(element: &str, n: usize) -> String {
    let lists = [
        (SIZES.nv, "PerVelocity"),
        (2 * SIZES.nv, "PerState"),
        (SIZES.links, "PerLink"),
        (SIZES.quaternions, "PerQuaternion"),
        (SIZES.constraints, "PerConstraint"),
        (SIZES.constraint_rows, "PerConstraintRow"),
        (SIZES.contacts, "PerContact"),
        (SIZES.touching_points, "PerTouchingPoint"),
        (SIZES.controls, "PerControl"),
        (SIZES.activations, "PerActivation"),
        (2 * SIZES.nv + SIZES.activations, "PerActuatedState"),
    ];
    match (element, n) {
        ("T", n) if n == SIZES.nq => "Self::Q<T>".into(),
        ("T", n) if n == SIZES.nv => "Self::V<T>".into(),
        ("Self::V<T>", n) if n == SIZES.nv => "Self::M<T>".into(),
        ("Self::V<T>", n) if n == 10 * SIZES.moving => "Self::Regressor<T>".into(),
        _ => match lists.iter().find(|(size, _)| *size == n) {
            Some((_, name)) => format!("Self::{name}<{element}>"),
            None => format!("[{element}; {n}]"),
        },
    }
}

/// Returns an argument with its type in the trait of robots.
fn typed(argument: &Argument) -> String {
    let kind = match argument.kind {
        ArgumentKind::Time => "T".into(),
        ArgumentKind::ActiveContacts => "Self::Contacts".into(),
        ArgumentKind::Settings => "&Settings<Self, T>".into(),
        ArgumentKind::StepSettings => {
            "&StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>".into()
        }
        ArgumentKind::RandomNumbers => "impl FnMut() -> T".into(),
        _ => format!("&{}", type_of(&argument.shape(&SIZES))),
    };
    format!("{}: {kind}", argument.name)
}

/// A function of the trait of robots.
struct Method {
    docs: String,
    name: String,
    /// The arguments with their types.
    inputs: Vec<String>,
    /// The lines of the body.
    body: String,
}

impl Method {
    /// Returns the text of a method, which requires the trait of the function.
    fn text(&self, row: &Row) -> String {
        let Self { docs, name, inputs, body } = self;
        let layout = (row.result)(&SIZES);
        let head = format!("fn {name}<T: Scalar>(");
        // rustfmt measures the line of a result without the parenthesis.
        let result = match several(&layout) {
            Some((name, types)) => listed("    ", &format!("-> {name}<"), &types, ">"),
            None => format!("-> {}", type_of(&layout)),
        };
        let signature = listed("    ", &head, inputs, &format!(") {}", result.trim_start()));
        format!(
            "{docs}{signature}\n    where\n        Self: functions::{:?},\n    {{\n{body}\n    }}\n",
            row.function,
        )
    }
}

/// Returns the functions of the trait of robots. A function that depends on run-time parameters has
/// a form with them and a form with the default parameters.
pub(super) fn robot_functions() -> String {
    let mut texts = Vec::new();
    for row in rows(|row| row.batch_of.is_none()) {
        let mut inputs: Vec<String> = row.arguments.iter().map(typed).collect();
        let mut names: Vec<String> =
            row.arguments.iter().map(|argument| argument.name.into()).collect();
        if row.by_link {
            inputs.push("link: Self::Link".into());
            names.push("link".into());
        }
        let aliases = row.known_as.iter().map(|name| format!("    #[doc(alias = \"{name}\")]\n"));
        let aliases: String = aliases.collect();
        let mut method = Method {
            docs: docs(row.docs) + &aliases,
            name: row.name.into(),
            inputs,
            body: "        const { not_generated() }".into(),
        };
        if row.depends_on_parameters {
            let with = format!("{}_with", row.name);
            let params = std::iter::once("params: &Self::Params<T>".into());
            let documented = Method {
                docs: method.docs,
                name: with.clone(),
                inputs: params.chain(method.inputs.iter().cloned()).collect(),
                body: method.body,
            };
            texts.push(documented.text(&row));
            names.insert(0, "&Self::Params::<T>::default()".into());
            method.docs =
                docs(&format!("Calls [`{with}`](Self::{with}) with the default parameters."))
                    + &aliases;
            method.body = listed("        ", &format!("Self::{with}("), &names, ")");
        }
        texts.push(method.text(&row));
    }
    texts.join("\n")
}

/// Returns the rows of the functions that all robots have, for the macro of tests that calls them.
pub(super) fn calls_of_tests() -> String {
    let text = |row: Row| {
        let arguments: Vec<&str> = row.arguments.iter().map(|argument| argument.name).collect();
        format!(
            "            {} {:?} {} [{}] [{}] [{}];\n",
            if row.default { "default" } else { "other" },
            row.function,
            row.name,
            if row.depends_on_parameters { format!("{}_with", row.name) } else { String::new() },
            arguments.join(" "),
            if row.by_link { "link" } else { "" },
        )
    };
    rows(|row| row.is_general() && row.batch_of.is_none()).map(text).collect()
}
