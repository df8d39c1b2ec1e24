//! Options that select functions and modules.

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::{Function, ModuleChoice};
use modyn_runtime::model::{Model, ModuleTree};

use crate::command::outcome::Failure;

/// The value of `--functions`. (For clap a plain `Vec` is an option that can be repeated.)
#[derive(Clone)]
pub struct Functions(pub Vec<Function>);

/// Parses `default,regressor`.
pub fn functions(text: &str) -> Result<Functions, String> {
    let mut functions = Vec::new();
    for name in text.split(',').map(str::trim) {
        match name {
            "all" => functions.extend(Function::ALL),
            "default" => functions.extend(Function::DEFAULT),
            _ => {
                functions.push(Function::from_name(name).ok_or_else(|| Function::unknown(name))?);
            }
        }
    }
    Ok(Functions(functions))
}

/// Parses `chains`, `links` or `[["link", ...], ...]`.
pub fn modules(text: &str) -> Result<ModuleChoice, String> {
    match text {
        "chains" => Ok(ModuleChoice::Chains),
        "links" => Ok(ModuleChoice::Links),
        list => serde_json::from_str(list).map(ModuleChoice::List).map_err(|error| {
            let form = r#"`chains`, `links` or a list such as [["a", "b"], ["c"]]"#;
            format!("expected {form}: {error}")
        }),
    }
}

/// Returns the selected modules of a robot; by default its chains.
pub fn module_tree(model: &Model, choice: Option<&ModuleChoice>) -> Result<ModuleTree, Failure> {
    match choice {
        Some(ModuleChoice::Links) => Ok(ModuleTree::links(model)),
        Some(ModuleChoice::List(list)) => ModuleTree::from_names(model, list).map_err(|errors| {
            let errors: Vec<String> =
                errors.iter().map(|error| sanitize_for_display(&error.to_string())).collect();
            Failure::usage(format!("error: {}", errors.join("\nerror: ")))
        }),
        _ => Ok(ModuleTree::chains(model)),
    }
}
