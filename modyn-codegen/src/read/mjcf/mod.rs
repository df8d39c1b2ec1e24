//! Reads the XML of a `MuJoCo` model (MJCF) to a [`Description`].
//!
//! ```text
//! XML ─ scan ─▶ supported XML ─ used, numbers ─▶ valid XML ─ mjcf-rs ─▶ bodies ─▶ links and joints
//! ```
//!
//! mjcf-rs resolves default classes, angles in degrees and the forms of a rotation. It ignores much of MJCF. Elements and
//! attributes that change the dynamics but are not read are therefore rejected first, with their place (`scan`).

mod bodies;
mod classes;
mod geoms;
mod numbers;
mod pose;
mod scan;
mod used;

use crate::check::gravity_error;
use crate::description::{Base, Description, ReadOptions};
use crate::diagnostics::{Code, Report};
use crate::read::xml;

/// Returns the description; `None` with errors in the report.
pub fn describe(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Description> {
    let document = xml::document::parse(text, 0, "mujoco", report)?;
    let root = document.root_element();
    let at = root.range().start;
    if root.tag_name().name() != "mujoco" {
        let message = format!("the root element is `<{}>`", root.tag_name().name());
        let help = "an MJCF is one element `<mujoco model=\"...\">`";
        report.error(Code::NotMjcf, at, None, message, help);
        return None;
    }
    if options.base == Base::Floating {
        let message = "`base = floating` is for URDF, which cannot say so";
        let help = "write `<freejoint/>` in the body that floats";
        report.error(Code::Option, at, None, message, help);
    }
    scan::scan(root, report);
    if report.errors() > 0 {
        return None;
    }
    let used = used::without_unused_parts(text, root);
    let (text, unread) = numbers::without_invalid_numbers(text, used, root, report);
    let model = parse_model(&text, at, report)?;
    let gravity = model.option.gravity;
    let error = gravity_error(gravity).filter(|_| options.gravity.is_none());
    if let Some(error) = error {
        report.error(error.code, at, None, error.message, error.help.unwrap_or_default());
        return None;
    }
    let description = bodies::describe(&model, root, &unread, report)?;
    Some(Description { gravity: Some(gravity), ..description })
}

/// Returns the model as resolved by mjcf-rs, whose errors have no place.
fn parse_model(text: &str, at: usize, report: &mut Report<'_>) -> Option<mjcf_rs::Model> {
    match mjcf_rs::Model::from_str(text, "") {
        Ok(model) => Some(model),
        Err(error) => {
            let help =
                "write it as MuJoCo's XML reference says; `mj_saveLastXML` writes a plain file";
            report.error(Code::Mjcf, at, None, error.to_string(), help);
            None
        }
    }
}
