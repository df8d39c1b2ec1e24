//! Names that users give to functions of generated code: to fused functions, and to functions that
//! they wrote.

use modyn_read::diagnostics::{Code, Diagnostic};

use crate::names;
use crate::plan::Function;

/// Names of functions and other items that generated code has beside the functions of the table.
const RESERVED: &[&str] = &[
    "active_contacts",
    "check_configuration",
    "default_parameters",
    "joint",
    "link",
    "neutral",
    "params",
    "placements",
    "udu_factorization",
];

/// The first words after the name of a function that make a name of the function's own functions.
const FORMS: &[&str] =
    &["batch", "each", "lanes", "of", "on", "placed", "scalar", "vectorized", "with"];

/// The names of a fused function or of a user's function.
pub(crate) struct OwnNames {
    /// The fused function or function in words.
    pub owner: String,
    /// The names, its own first.
    pub names: Vec<String>,
}

impl OwnNames {
    fn error(&self, message: &str, help: &str) -> Diagnostic {
        let message = format!("{}: {message}", self.owner);
        Diagnostic::error(Code::Option, message).with_help(help)
    }
}

/// Returns the error of a name and its remedy, if generated code cannot have the name. `what` has
/// the name.
pub(super) fn name_defect(name: &str, what: &str) -> Option<(String, String)> {
    let snake = names::snake(name);
    if names::KEYWORDS.contains(&name) {
        return Some(("its name is a keyword".into(), format!("`{snake}` is not one")));
    }
    if snake != *name {
        return Some(("its name is not in snake case".into(), format!("`{snake}` is")));
    }
    let help = || format!("give the {what} another name");
    if RESERVED.contains(&name) {
        return Some((format!("generated code has another `{name}`"), help()));
    }
    let begins_as_in_c = ["default_", "rollout"].iter().any(|start| name.starts_with(start));
    let ends_as_in_c = ["_names", "_numbers", "_t", "_with"].iter().any(|end| name.ends_with(end));
    if begins_as_in_c || ends_as_in_c {
        return Some(("generated C has such names".into(), help()));
    }
    let begins = |function: &&Function| {
        let rest = name.strip_prefix(function.name());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    };
    let function = Function::ALL.iter().find(begins)?;
    Some((format!("its name begins with that of the function `{}`", function.name()), help()))
}

/// Returns the errors of names that belong to several of these.
pub(crate) fn shared_names(all: &[OwnNames]) -> Vec<Diagnostic> {
    let mut errors = Vec::new();
    for (i, owner) in all.iter().enumerate() {
        for (k, other) in all.iter().enumerate().filter(|(k, _)| *k != i) {
            let taken = owner.names.iter().find(|name| {
                other.names.iter().any(|taken| {
                    let same_type = || names::type_name(name) == names::type_name(taken);
                    k < i && same_type() || is_form(name, taken)
                })
            });
            if let Some(name) = taken {
                let name = match owner.names.first() == Some(name) {
                    true => "its name".into(),
                    false => format!("`{name}`"),
                };
                let message = format!("{name} belongs to {}", other.owner);
                errors.push(owner.error(&message, "give one of them another name"));
            }
        }
    }
    errors
}

/// Returns whether `name` is the name of a form of the function `other`.
fn is_form(name: &str, other: &str) -> bool {
    let Some(rest) = name.strip_prefix(other).and_then(|rest| rest.strip_prefix('_')) else {
        return false;
    };
    let first = rest.split('_').next().unwrap_or_default();
    let numbered = first.trim_end_matches(|c: char| c.is_ascii_digit());
    FORMS.contains(&first) || ["", "chunk", "routine"].contains(&numbered)
}
