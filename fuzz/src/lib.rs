//! The common part of both targets: an input is the text of a description and, in its last byte, the options.

mod mutate;

pub use mutate::mutate;

/// Returns the text of an input, and the byte that selects the options.
#[must_use]
pub fn text(data: &[u8]) -> (String, u8) {
    let (choice, text) = data.split_last().unwrap_or((&0, &[]));
    (String::from_utf8_lossy(text).into_owned(), *choice)
}
