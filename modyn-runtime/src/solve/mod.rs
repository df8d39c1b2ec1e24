//! The pseudo-inverse of constraint rows, of which some may be dependent, as loops over rows.
//!
//! Equations of the robot's structure become straight-line code. The equations of all constraint
//! rows are dense: these loops solve them, for generated robots, for the interpreter and for machine
//! code alike.

mod rank;

#[cfg(feature = "alloc")]
pub(crate) use rank::{Counts, Exchange, RankFactorization, dot, place, row_start};
pub use rank::{RowEquations, RowSolutions};
