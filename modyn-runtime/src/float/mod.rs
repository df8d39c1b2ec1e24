//! `f64` and `f32` as scalars: operations of one number, and packed work on the vectors of the
//! processor.

mod elementary;
mod native;
#[cfg(test)]
mod root;
mod scalars;

pub use elementary::{ELEMENTARY_F32, ELEMENTARY_F64, ElementaryNumbers};
