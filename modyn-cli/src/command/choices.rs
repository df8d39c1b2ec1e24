//! The modules of a robot.

use modyn_codegen::ModuleChoice;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::{Model, ModuleTree};

use crate::command::outcome::Failure;

/// The modules of a robot that are chosen, by default its chains.
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
