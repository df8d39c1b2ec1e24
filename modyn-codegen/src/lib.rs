//! modyn's compiler: from a robot description (URDF, SDF, MJCF) to specialised code.
//!
//! ```text
//! text ─ modyn-read ─▶ Model ─ modules ─▶ equations on Expr (trace) ─▶ Graph
//! Graph ─ passes, plan ─▶ Program ─ emit ─▶ Rust, C99, C++, CUDA, WGSL, CasADi's C, MATLAB
//! ```
//!
//! The macro `modyn::modyn!`, build scripts and the command line use [`Builder`]. The crate
//! [`modyn_read`] reads descriptions; its items that are re-exported here are the same.
//! [`diagnostics`] has the codes of the compiler as well, so a user sees all errors in one list.
//!
//! Stable are [`Builder`] with its options and result, the items of [`modyn_read`], and [`names`].
//! The other modules (`emit`, `graph`, `passes`, `plan`, `program`, `trace`) are public for tests
//! and measurements, and may change in any release.

mod builder;
pub mod emit;
pub mod graph;
mod intern;
pub mod names;
pub mod options;
pub mod output;
pub mod passes;
pub mod plan;
pub mod program;
pub mod trace;

pub use builder::{Builder, Emitted, Generated, ObjectPlanning, Planning};
pub use emit::{
    File, FloatType, GpuLanguage, MachineCode, MachineTarget, RolloutForces, RolloutOptions,
    RolloutSource, Target,
};
pub use modyn_read::diagnostics;
pub use modyn_read::{
    Armature, Base, Contact, ControlLaw, FileStore, Format, Geometry, Ground, JointActuator, Loop,
    LoopEnd, MAX_CONDITION_F32, Mesh, Mimic, Package, ReadOptions, Reading, Rotor, Shape, Shapes,
    Written, XacroArg, condition_number, expand_xacro, joints_without_inertia, read, read_mjcf,
    read_urdf, write,
};
pub use modyn_runtime::equations::{ForwardInput, Motion, State, TimeStepInput};
pub use modyn_runtime::model::{ContactKind, JointFriction, LoopConstraintKind};
pub use modyn_runtime::{
    Interpreter, Scalar, UserArgument, UserArgumentKind, UserDerivatives, UserError, UserFunction,
};
pub use options::{FusedFunction, ModuleChoice};
pub use plan::{CodeForm, Function};

/// Parts that the tests of this crate reach, besides the public interface. They may change in any
/// release.
///
/// The tests are another crate, so that the compiler is built once for all tests.
#[doc(hidden)]
pub mod internals {
    pub use crate::builder::checks::invalid_programs;
    pub use crate::builder::syntax::{is_path, is_visibility};
    pub use crate::emit::rust::embedded::in_any_edition;
    pub use crate::emit::rust::function::operations::literal;
    pub use crate::emit::rust::layout::indented;
    pub use crate::graph::limit::{traced_operations, within};
    pub use crate::graph::table::{Table, hash};
    pub use crate::names::KEYWORDS;
    pub use crate::passes::balance::ready_times;
    pub use crate::passes::factor::factor;
    pub use crate::program::argument_of;
    pub use crate::trace::limbs::groups::{groups, join};
}
