//! The table of functions in `docs/functions.md`.

use modyn_codegen::Function;
use modyn_codegen::plan::{CForm, Lowering};

use super::data::markdown;

/// Returns the table.
pub(super) fn table() -> String {
    let titles = "function | known as | arguments | result | default | needs inertia | `_with` parameters | batch | C";
    let of_one_state = Function::ALL.iter().filter(|function| function.batched().is_none());
    let rows = of_one_state.map(|function| {
        let row = function.row();
        let arguments: Vec<String> =
            row.arguments.iter().map(|a| format!("`{}`", a.name)).collect();
        let of = |yes: bool| if yes { "yes" } else { "" };
        let default = match (row.default, row.of_constraints) {
            (true, true) => "with constraints",
            (default, _) => of(default),
        };
        let batch = Function::ALL.iter().any(|other| other.batched() == Some(*function));
        let c = match Lowering::of(*function).c_form {
            CForm::SourceAndExport => "yes",
            CForm::Source => "C99 alone",
            CForm::None => "",
        };
        [
            format!("`{}`", function.name()),
            row.known_as.iter().map(|name| known(name)).collect::<Vec<String>>().join(", "),
            arguments.join(", "),
            row.docs.into(),
            default.into(),
            of(row.needs_inertia).into(),
            of(row.depends_on_parameters).into(),
            of(batch).into(),
            c.into(),
        ]
    });
    markdown(titles, rows)
}

/// Returns a name of other libraries or of textbooks: names of code in code.
fn known(name: &str) -> String {
    match name.contains(['.', '_']) {
        true => format!("`{name}`"),
        false => name.into(),
    }
}
