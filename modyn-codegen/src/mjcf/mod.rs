//! From the text of a `MuJoCo` model (MJCF) to a [`Model`](modyn_runtime::model::Model).
//!
//! ```text
//! text ─ document ─▶ XML ─ scan ─▶ nothing that would go unread ─ mjcf-rs ─▶ bodies ─ pieces ─▶ links and joints
//! ```
//!
//! Default classes, angles in degrees and the ways to write a rotation are resolved by mjcf-rs. It passes over
//! much of MJCF, so whatever changes the dynamics and is not read is refused before, with its place (`scan`). From
//! links and joints on, the way is that of a URDF, with the same checks.
//!
//! - Bodies are links, in a world that is the root link `world`; several joints of one body have links without mass
//!   between them. A body's frame is its link's. Coordinates are those of `docs/conventions.md`, not `MuJoCo`'s:
//!   `modyn::conventions::mujoco` has the conversions.
//! - Where no inertia is written (`<inertial>`), it is that of the geoms, unless these are meshes.
//! - Gravity is that of `<option>`, unless the options give another one than the default.
//! - Contacts, actuators, sensors and what is only to be seen do not matter. Damping and friction act if the
//!   options say so, as for a URDF.

mod geoms;
mod pieces;
mod scan;

use crate::error::{Code, Diagnostics};
use crate::urdf::report::Report;
use crate::urdf::{self, Base, ReadOptions, Reading, document};
use pieces::Pieces;

/// Whether this is the text of a `MuJoCo` model: well-formed XML whose root element is `<mujoco>`.
#[must_use]
pub fn is_mjcf(text: &str) -> bool {
    document::bounded(text, &mut Report::new(text, "")).is_some_and(|text| {
        roxmltree::Document::parse(&text)
            .is_ok_and(|document| document.root_element().tag_name().name() == "mujoco")
    })
}

/// Reads an MJCF; `file` is what diagnostics call it. No other file is read.
///
/// # Errors
///
/// What is wrong with the text, or not supported, with the warnings.
pub fn read(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    urdf::reading(text, file, options, |options, report| {
        let text = document::bounded(text, report)?;
        let document = document::parse(&text, report)?;
        let root = document.root_element();
        let at = root.range().start;
        if root.tag_name().name() != "mujoco" {
            let message = format!("the root element is `<{}>`", root.tag_name().name());
            let help = "an MJCF is one element `<mujoco model=\"...\">`";
            report.error(Code::NotUrdf, at, None, message, help);
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
        let model = resolved(&text, at, report)?;
        let gravity = options.gravity.unwrap_or(model.option.gravity);
        if let Some(error) = urdf::gravity_error(gravity) {
            report.error(error.code, at, None, error.message, error.help.unwrap_or_default());
            return None;
        }
        let pieces = Pieces::of(&model, root, report)?;
        let options = ReadOptions { gravity: Some(gravity), ..options.clone() };
        urdf::assemble(pieces.parts(), &options, report)
    })
}

/// What mjcf-rs makes of it; it does not say where something is wrong.
fn resolved(text: &str, at: usize, report: &mut Report<'_>) -> Option<mjcf_rs::Model> {
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
