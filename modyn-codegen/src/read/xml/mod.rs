//! XML, as all formats here are written in: limits on its size, parsing, elements and numbers.

pub mod document;
pub mod element;
pub mod limits;
mod numbers;
