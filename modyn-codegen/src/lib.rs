//! modyn's compiler: from a robot description (URDF, SDF, MJCF) to specialised code.
//!
//! ```text
//! text ─ read ─▶ Description ─ assemble, check ─▶ Model ─ modules ─▶ equations on Expr (trace) ─▶ Graph ─ passes, plan ─▶ Program ─ emit ─▶ Rust, C99, CUDA, WGSL, CasADi's C
//! ```
//!
//! The macro `modyn::modyn!`, build scripts and the command line use [`Builder`]. [`read`](read())
//! returns the model only.
//!
//! Stable are [`Builder`] with its options and result, [`read`](read()) with its options and
//! result, [`diagnostics`] and [`names`]. The other modules (`emit`, `graph`, `passes`, `plan`,
//! `program`, `read::file`, `trace`) are public for tests and measurements, and may change in any
//! release.

mod assemble;
mod builder;
mod check;
mod description;
pub mod diagnostics;
pub mod emit;
pub mod graph;
mod intern;
pub mod names;
pub mod options;
pub mod output;
pub mod passes;
pub mod plan;
pub mod program;
pub mod read;
pub mod trace;
mod work;
mod write;

pub use builder::{Builder, Emitted, Generated, ObjectPlanning, Planning};
pub use check::{MAX_CONDITION_F32, condition_number, joints_without_inertia};
pub use description::{
    Base, Contact, FileStore, Geometry, Loop, LoopEnd, Mesh, Mimic, Package, ReadOptions, Rotor,
    Shape, Shapes, XacroArg,
};
pub use emit::{
    File, FloatType, GpuLanguage, MachineCode, MachineTarget, RolloutForces, RolloutOptions,
    RolloutSource, Target,
};
pub use modyn_runtime::equations::{ForwardInput, Motion, State, TimeStepInput};
pub use modyn_runtime::model::{ContactKind, Friction, LoopConstraintKind};
pub use modyn_runtime::{
    Interpreter, Scalar, UserArgument, UserArgumentKind, UserDerivatives, UserError, UserFunction,
};
pub use options::{Bundle, ModuleChoice};
pub use plan::{CodeForm, Function};
pub use read::read_mjcf;
pub use read::{Format, Reading, expand_xacro, read, read_urdf};
pub use write::{Written, write};

/// Parts that the tests of this crate reach, besides the public interface. They may change in any
/// release.
///
/// The tests are another crate, so that the compiler is built once for all tests.
#[doc(hidden)]
pub mod internals {
    pub use crate::assemble::cycles::cycles;
    pub use crate::builder::checks::invalid_programs;
    pub use crate::builder::syntax::{is_path, is_visibility};
    pub use crate::check::check_model;
    pub use crate::check::singular::{
        CONFIGURATIONS, UNITS, Vec3, articulated, coordinates, motions, rotation, singular_joints,
    };
    pub use crate::diagnostics::line_index::LineIndex;
    pub use crate::diagnostics::report::Report;
    pub use crate::emit::rust::embedded::in_any_edition;
    pub use crate::emit::rust::function::operations::literal;
    pub use crate::emit::rust::layout::indented;
    pub use crate::graph::limit::{traced_operations, within};
    pub use crate::graph::table::{Table, hash};
    pub use crate::names::KEYWORDS;
    pub use crate::passes::balance::ready_times;
    pub use crate::passes::factor::factor;
    pub use crate::program::argument_of;
    pub use crate::read::file::{not_text, read_at_most};
    pub use crate::read::mjcf::table::{Treatment, row};
    pub use crate::read::xml::document::{blank_comments, first_element};
    pub use crate::read::xml::limits::MAX_BYTES;
    pub use crate::read::xml::numbers::numbers;
    pub use crate::trace::limbs::groups::{groups, join};
    pub use crate::work::counted_steps;
}
