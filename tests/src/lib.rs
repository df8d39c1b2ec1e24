//! The common parts of the tests: reference data, random robots, and an independent implementation of the equations.
//!
//! The equations of motion exist once, so the interpreter cannot reveal a wrong one. Four other sources check them:
//! [`golden`] (numbers of other software), the paper's printed numbers, physical identities on [`random`] robots, and
//! [`naive`], which shares no code with the equations.

pub mod arguments;
pub mod cases;
pub mod changed;
pub mod close;
pub mod compiled;
pub mod conformance;
pub mod counting;
pub mod dense;
pub mod dual;
pub mod fleet;
pub mod floating;
pub mod golden;
pub mod lanes;
pub mod naive;
pub mod plain;
pub mod quantities;
pub mod random;
pub mod tangent;
pub mod values;
