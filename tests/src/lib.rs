//! What the tests share: reference data, random robots, and a second opinion on the equations.
//!
//! The equations of motion exist once, so the interpreter cannot catch a wrong one. They are held
//! by [`golden`] (figures from other software), by the paper's printed numbers, by physical
//! identities on [`random`] robots, and by [`naive`], which shares nothing with them.

pub mod cases;
pub mod changed;
pub mod close;
pub mod compiled;
pub mod counting;
pub mod dense;
pub mod dual;
pub mod fleet;
pub mod floating;
pub mod golden;
pub mod naive;
pub mod plain;
pub mod quantities;
pub mod random;
pub mod tangent;
pub mod values;
