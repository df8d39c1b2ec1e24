//! Reads the XML of a URDF to a [`Description`].
//!
//! Every number that is used is read strictly, and every diagnostic has a place. Visuals are read for pictures alone. Collisions,
//! transmissions and similar elements are ignored.
//!
//! urdf-rs (0.10) is not used for reading. It skips words in a list that are not numbers, and accepts NaN and infinities.
//! It has no places, cannot tell a missing value from a default, and rejects a file for an error in a `<visual>`. The
//! tests use it as an independent reader of well-formed files.

mod contacts;
mod document;
mod joint;
mod link;
mod loops;
mod reader;
mod robot;
mod visual;

use crate::description::{Description, ReadOptions};
use crate::diagnostics::Report;
use crate::read::xml;

/// Returns the description; `None` with errors in the report.
pub fn describe(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Description> {
    let replaced = xml::document::without_undeclared_prefixes(text);
    let text = replaced.as_deref().unwrap_or(text);
    let document = xml::document::parse(text, 0, "robot", report)?;
    let robot = document::robot(&document, report)?;
    Some(robot::read(robot, options, report))
}
