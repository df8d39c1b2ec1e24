//! modyn's compiler: from a robot description (URDF, MJCF) to specialised code.
//!
//! ```text
//! text ─ read ─▶ Description ─ assemble, check ─▶ Model ─ modules ─▶ equations on Expr (trace) ─▶ Graph ─ passes, plan ─▶ Program ─ emit ─▶ Rust, C99, CUDA, WGSL, CasADi's C
//! ```
//!
//! The macro `modyn::modyn!`, build scripts and the command line use [`Builder`]. [`read`](read()) returns the model
//! only.
//!
//! Stable are [`Builder`] with its options and result, [`read`](read()) with its options and result, [`diagnostics`] and
//! [`names`]. The other modules (`emit`, `graph`, `passes`, `plan`, `program`, `read::file`, `trace`) are public for tests
//! and measurements, and may change in any release.

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
pub mod passes;
pub mod plan;
pub mod program;
pub mod read;
mod size;
pub mod trace;

pub use builder::{Builder, Generated, ObjectPlanning, Planning};
pub use check::{MAX_CONDITION_F32, condition_number};
pub use description::{Base, Contact, Loop, LoopEnd, Mimic, Package, ReadOptions, Rotor, XacroArg};
pub use emit::{
    CSource, CasadiSource, FloatType, GpuLanguage, GpuSource, MachineCode, MachineTarget,
    RolloutForces, RolloutOptions, RolloutSource,
};
pub use modyn_runtime::model::{ContactKind, Friction, LoopConstraintKind};
pub use modyn_runtime::{
    Interpreter, Scalar, UserArgument, UserArgumentKind, UserDerivatives, UserError, UserFunction,
};
pub use options::{Bundle, ModuleChoice};
pub use plan::{CodeForm, Function};
#[cfg(feature = "mjcf")]
pub use read::read_mjcf;
pub use read::{Format, Reading, expand_xacro, read, read_urdf};
