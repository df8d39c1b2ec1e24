//! The table of functions in `docs/functions.md`, and a sentence or more about each.

use std::fmt::Write as _;

use modyn_codegen::Function;
use modyn_codegen::plan::{CForm, Lowering};

use super::data::markdown;
use super::python;

/// Returns the functions of one state, without the forms in a link's own axes (`.._local`).
fn of_one_state() -> impl Iterator<Item = Function> {
    let all = Function::ALL.iter().copied().filter(|function| function.batched().is_none());
    all.filter(|function| {
        let name = function.name().strip_suffix("_local");
        name.is_none_or(|name| Function::from_name(name).is_none())
    })
}

/// Returns the name of the same function in a link's own axes, if there is one.
fn local(function: Function) -> Option<&'static str> {
    Function::from_name(&format!("{}_local", function.name())).map(|local| local.name())
}

/// Returns the function before an ending for derivatives, if `function` returns derivatives.
fn differentiated(function: Function) -> Option<Function> {
    let endings = ["_derivatives", "_vjp", "_jvp", "_hessian"];
    let stem = endings.iter().find_map(|ending| function.name().strip_suffix(ending))?;
    Function::from_name(stem)
}

/// Returns the results of a function with their shapes. The results of the differentiated function
/// are not repeated.
fn results(function: Function) -> String {
    let without_one = |field: String| match &*field {
        "a number" => field,
        named => named.replace(" a number", ""),
    };
    let all: Vec<String> =
        python::results_of(&function.row()).into_iter().map(without_one).collect();
    let Some(base) = differentiated(function) else { return all.join(", ") };
    let repeated: Vec<String> =
        python::results_of(&base.row()).into_iter().map(without_one).collect();
    if repeated.iter().any(|field| !all.contains(field)) {
        return all.join(", ");
    }
    let others: Vec<String> = all.into_iter().filter(|field| !repeated.contains(field)).collect();
    format!("as `{}`; {}", base.name(), others.join(", "))
}

/// Returns the table.
pub(super) fn table() -> String {
    let rows = of_one_state().map(|function| {
        let row = function.row();
        let name = function.name();
        let mut arguments: Vec<String> =
            row.arguments.iter().map(|a| format!("`{}`", a.name)).collect();
        if row.by_link {
            arguments.push("link".into());
        }
        let place = if differentiated(function).is_some() { "derivatives" } else { name };
        let local = local(function).map_or(String::new(), |local| format!(", `{local}`"));
        [
            format!("[`{name}`](#{place}){local}"),
            row.known_as.iter().map(|name| known(name)).collect::<Vec<String>>().join(", "),
            arguments.join(", "),
            results(function),
            forms(function).join(", "),
        ]
    });
    markdown("function | known as | arguments | result | forms", rows)
}

/// Returns the forms of a function, and the conditions for it.
fn forms(function: Function) -> Vec<&'static str> {
    let row = function.row();
    let default = match (row.default, row.of_constraints) {
        (true, true) => Some("default with constraints"),
        (true, false) => Some("default"),
        _ => None,
    };
    let has_batch = Function::ALL.iter().any(|other| other.batched() == Some(function));
    let c = match Lowering::of(function).c_form {
        CForm::SourceAndExport => None,
        CForm::Source => Some("C only as C99"),
        CForm::None => Some("not in C"),
    };
    let forms = [
        default,
        has_batch.then_some("batch"),
        row.depends_on_parameters.then_some("`_with`"),
        (!row.needs_inertia).then_some("no inertia"),
        c,
    ];
    forms.into_iter().flatten().collect()
}

/// Returns a heading for each function, with its documentation. Derivatives have a section of
/// their own.
pub(super) fn sentences() -> String {
    let mut text = String::new();
    for function in of_one_state().filter(|function| differentiated(*function).is_none()) {
        let own_axes = |local| format!(" `{local}`: in the link's own axes.");
        let local = local(function).map_or(String::new(), own_axes);
        let _ = writeln!(text, "### `{}`\n\n{}{local}\n", function.name(), function.row().docs);
    }
    text
}

/// Returns a name of other libraries or of textbooks: names of code in code.
fn known(name: &str) -> String {
    match name.contains(['.', '_']) {
        true => format!("`{name}`"),
        false => name.into(),
    }
}
