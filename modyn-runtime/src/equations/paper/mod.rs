//! The dense matrices of the method's paper, for study.

mod decomposition;
mod denoc;
mod dense;

pub use {
    decomposition::Decomposition,
    denoc::{DeNoc, denoc},
    dense::Dense,
};
