//! Steps with soft contacts, limits and dry friction of joints and tendons, couplings and closed loops:
//! MuJoCo's law, solved by Newton's method on the tree.
//!
//! A constraint row with the Jacobian J has a force f(J a - a*) by its law ([`ContactLaw`],
//! [`SoftRow`]). The accelerations a minimize the convex function
//!
//! ```text
//! 1/2 (a - a0)^T M (a - a0) + sum s(J a - a*),   f = -ds/d(J a),   M a0 = tau - h
//! ```
//!
//! Newton's matrix is M + J^T D J with the stiffness D of the laws: the mass matrix of a robot
//! whose touching links carry added 6 x 6 inertias and whose stopped joints carry added armature.
//! So an iteration is the recursion of forward dynamics (`against_fall`). Step lengths and the
//! residual need no further recursion: after a step a = a0 + M^-1 J^T G holds for forces G of the
//! rows, so the function's slope is a sum over the rows.
//!
//! The dampers of joints act with the velocities after the step, and by `implicitfast` so do the dampers
//! of tendons, the velocity gains of actuators (`damping`) and the rotation of free bodies
//! (`free_bodies`).
//!
//! Loops, tendons, couplings and mimic joints couple limbs: with them Newton's matrix is factorized as a whole
//! (`dense`).

mod actuated;
mod damping;
mod dense;
mod derivatives;
mod drive;
mod free_bodies;
mod input;
mod law;
mod lengths;
mod loops;
mod newton;
mod problem;
mod responses;
mod rows;
mod shapes;
mod single_rows;
mod stops;
mod touching_points;

pub use actuated::{ActuatedForces, ActuatedInput};
pub use damping::DampingMatrix;
pub(crate) use damping::couples;
pub use derivatives::{has_closed_form, state_derivatives, state_derivatives_by_newton};
pub use drive::StepDrive;
pub use input::{StepConstraints, StepInput};
pub use law::{ContactLaw, Response, RowState, SoftRow};
pub use lengths::{CouplingParameters, Length, LengthTerm, SpringParameters, TendonParameters};
pub use newton::{Advance, MAX_ITERATIONS, MAX_SEARCH, Progress, Search, SoftStep, soft_step};
pub use problem::{Iterate, SoftMotion, StepProblem, next_state};
pub use rows::{ContactParameters, JointParameters, LoopParameters, SoftModel};
pub use stops::StopParameters;
pub use touching_points::{TouchingPoint, touching_points};
