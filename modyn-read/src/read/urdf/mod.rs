//! Reads the XML of a URDF to a [`Description`].
//!
//! Every number that is used is read strictly, and every diagnostic has a place. Visuals are read
//! for pictures alone, collisions where there is a ground for them to touch. Sensors are ignored.
//! Extensions of other programs are read where they have a meaning here, else named by a warning.
//!
//! urdf-rs (0.10) is not used for reading. It skips words in a list that are not numbers, and
//! accepts NaN and infinities. It has no places, cannot tell a missing value from a default, and
//! rejects a file for an error in a `<visual>`. The tests use it as an independent reader of
//! well-formed files.

mod collision;
mod contacts;
mod document;
mod extensions;
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
    let text = xml::document::with_prefixes_in_names(text);
    let document = xml::document::parse(&text, 0, "robot", report)?;
    let robot = document::robot(&document, report)?;
    Some(robot::read(robot, options, report))
}
