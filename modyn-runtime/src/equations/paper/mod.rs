//! The dense matrices of the method's paper, for study.
//!
//! They are in this crate because the tests of identities and the examples of `docs/paper.md` call
//! them.

mod decomposition;
mod denoc;
mod dense;

pub use {
    decomposition::Decomposition,
    denoc::{DeNoc, denoc},
    dense::Dense,
};
