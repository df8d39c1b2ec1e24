//! XML, the syntax of all formats: size limits, parsing, elements and numbers.

pub mod document;
pub mod element;
pub mod limits;
pub mod numbers;
pub mod unread;
