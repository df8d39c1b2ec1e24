//! Expands a xacro to a URDF, which is then read as any other. Every element and attribute of the
//! URDF keeps the file, the line and the macro calls that it comes from, so that errors name what
//! the user wrote.
//!
//! ```text
//! text ─ tree ─▶ Element ─ expand (text ─ parse ─ evaluate) ─▶ Element ─ write ─▶ URDF and its origins
//! ```
//!
//! The language is the language of `xacro` 2. Expressions are evaluated by [`evaluate`] alone: no
//! code runs but the operators and functions of the language. Work, depth and files are bounded.
//! The environment is not read, so that every build is the same.

mod evaluate;
mod expand;
mod functions;
mod parse;
mod scopes;
mod text;
mod tree;
mod value;
mod write;
mod yaml;

use std::path::PathBuf;

use crate::description::{Description, ReadOptions};
use crate::diagnostics::Report;
use crate::read::{urdf, xml};
use expand::Expander;

/// Returns the description; `None` with errors in the report.
pub fn describe(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Description> {
    let urdf = expand(text, options, report)?;
    urdf::describe(&urdf, options, report)
}

/// Returns the URDF; `None` with an error in the report. From then on, the report's offsets refer
/// to the URDF.
pub fn expand(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<String> {
    let document = xml::document::parse(text, 0, "robot", report)?;
    let mut expander = Expander::new(PathBuf::new(), options, report);
    let root = expander.tree(&document, 0, 0).ok()?;
    let expanded = expander.document(&root).ok()?;
    let (text, mut expansion) = write::write(&expanded, &expander.namespaces);
    expansion.set_calls(std::mem::take(&mut expander.calls));
    report.set_expansion(expansion);
    Some(text)
}
