//! Diagnostics: the table of codes, a diagnostic with its place, and the report that a reader
//! collects.

mod code;
mod diagnostic;
mod display;
mod expansion;
pub(crate) mod line_index;
pub(crate) mod report;
mod suggest;

pub use code::Code;
pub use diagnostic::{Diagnostic, Diagnostics, Position, Severity, Subject};
pub use display::{is_unprintable, sanitize_for_display};
pub(crate) use expansion::{Expansion, ExpansionCall};
pub(crate) use report::{Place, Report};
pub(crate) use suggest::Suggestions;
pub use suggest::suggest;
