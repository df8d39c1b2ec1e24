//! Diagnostics: the table of codes, a diagnostic with its place, and the report that a reader
//! collects.
//!
//! The table has the codes of modyn's compiler as well: errors of a description and of the options
//! of the compiler are one list for the user, and a code has one meaning and one remedy, which
//! `modyn explain` shows.
//!
//! Each step of reading continues as far as possible, so a user sees all errors at once. A value
//! that could not be read is replaced by a default and marked, and joints that do not depend on it
//! are checked as usual. Equal warnings are one warning with a count.

mod code;
mod diagnostic;
mod display;
mod expansion;
pub(crate) mod line_index;
pub(crate) mod report;
mod suggest;

pub use code::Code;
pub use diagnostic::{Diagnostic, Diagnostics, Position, Severity, Subject};
pub use display::{is_unprintable, listed, sanitize_for_display};
pub(crate) use expansion::{Expansion, ExpansionCall, Origin};
pub(crate) use report::{Place, Report};
pub(crate) use suggest::Suggestions;
pub use suggest::suggest;
