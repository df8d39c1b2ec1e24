//! Texts in lines, for documentation.

use modyn_runtime::quantities::Function;

use crate::intern::intern;

/// Returns the documentation of a function of the table, in lines.
pub(super) fn docs_of(function: Function) -> &'static str {
    intern(&wrapped(function.row().docs))
}

/// Returns a text in lines of at most 110 characters.
pub(super) fn wrapped(text: &str) -> String {
    let mut result = String::new();
    let mut length = 0;
    for word in text.split(' ') {
        if length > 0 && length + 1 + word.len() > 110 {
            result.push('\n');
            length = 0;
        } else if length > 0 {
            result.push(' ');
            length += 1;
        }
        result += word;
        length += word.len();
    }
    result
}
