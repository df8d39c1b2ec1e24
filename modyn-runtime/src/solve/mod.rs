//! Solvers of dense problems, as loops over rows.
//!
//! Equations of the robot's structure become straight-line code. A problem that couples all
//! contacts is dense: it is solved by these loops, for generated robots, for the interpreter and
//! for machine code alike. The memory of a solver consists of rows that the caller has: arrays for
//! generated robots, vectors for a robot that is known at run time.
//!
//! | file | content |
//! |---|---|
//! | `decide` | the trait of numbers on which a loop can decide to end |
//! | `laws` | the velocities that the ground and joint stops allow |
//! | `contact` | one contact with friction: its exact solution, and its residual |
//! | `sweeps` | all contacts and joint stops one after another |
//! | `newton` | damped Newton steps for all of them, where sweeps do not suffice |
//! | `ground` | both, one after the other |
//! | `rank` | the pseudo-inverse of constraint rows, of which some may be dependent |
//! | `derivative` | the derivatives of the impulses that solve the equations |
//!
//! A step on the ground has three parts. `contact_problem`, a row of the table of functions, is
//! straight-line code: the motion without contacts, J M^-1 J^T and M^-1 J^T. The loops of this
//! folder then solve for the impulses, until their residual is small (`Decide`) or a number of
//! iterations is reached. The third part adds the responses to the velocities; the inverse of the
//! mass matrix is computed only if a joint reaches a stop. Expressions have no values to decide by,
//! so `contact_step`, another row of the table, is a fixed number of the same sweeps as
//! straight-line code.

mod contact;
mod decide;
mod derivative;
mod ground;
mod laws;
mod newton;
mod rank;
mod sweeps;

pub use contact::{Contact, ContactMode};
pub use decide::Decide;
pub use ground::{Effort, GroundEquations, Residual, Row, Stop};
pub use laws::velocity_range;
pub(crate) use laws::{add_scaled, relative_velocity, soften};
#[cfg(feature = "alloc")]
pub(crate) use laws::{least_speed, normal_law};
#[cfg(feature = "alloc")]
pub(crate) use rank::{Counts, Exchange, RankFactorization, dot, place, row_start};
pub use rank::{RowEquations, RowSolutions};

#[cfg(test)]
mod tests;
