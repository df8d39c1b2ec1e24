//! From the XML of a URDF to a [`Description`].
//!
//! Every number that is used is read strictly, every diagnostic says where. Meshes, visuals, collisions,
//! transmissions and the like are never looked into.
//!
//! The numbers are not read with urdf-rs (measured with 0.10): it skips what is no number in a list, takes NaN and
//! infinities, cannot say whether or where something was written, and refuses a whole file for a fault in a
//! `<visual>`. It serves the tests as an independent witness of what well-formed files say.

mod document;
mod joint;
mod link;
mod loops;
mod reader;
mod robot;

use crate::description::{Description, ReadOptions};
use crate::diagnostics::Report;
use crate::read::xml;

/// The description; `None` with errors in the report.
pub fn describe(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Description> {
    let document = xml::document::parse(text, report)?;
    let robot = document::robot(&document, report)?;
    Some(robot::read(robot, options, report))
}
