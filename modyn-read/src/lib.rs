#![doc = include_str!("../README.md")]
//!
//! # From a text to a model
//!
//! ```text
//! text ─ read ─▶ Description ─ assemble, check ─▶ Model ─ write ─▶ text
//! ```
//!
//! [`read`](read()) finds the format of a text, and [`Format::read`] reads a text of a known
//! format. Both return a [`Reading`] or the [`Diagnostics`](diagnostics::Diagnostics). A model that
//! was built in code passes the same checks by [`Reading::of_model`].
//!
//! Each folder imports only folders to its left: `diagnostics` ← `description` ← `check` ←
//! `assemble` ← `read`. A format knows no model, and a model no format. A check reports at the
//! places that it is given, or without places for a model that was not read.

mod assemble;
mod check;
mod description;
pub mod diagnostics;
pub mod read;
mod work;
mod write;

pub use check::{
    MAX_CONDITION_F32, condition_number, conditioning_warning, gravity_error,
    joints_without_inertia,
};
pub use description::{
    Armature, Base, Contact, ControlLaw, FileStore, Geometry, Ground, JointActuator, Loop, LoopEnd,
    Mesh, Mimic, Package, ReadOptions, Rotor, Shape, Shapes, XacroArg,
};
pub use modyn_runtime::model::{ContactKind, JointFriction, LoopConstraintKind};
pub use read::{
    Format, PACKAGE_PATHS, Reading, expand_xacro, read, read_file, read_mjcf, read_urdf,
};
pub use write::{Written, write};

/// Parts that the tests of this crate reach, besides the public interface. They may change in any
/// release.
///
/// The tests are another crate, so that the reader is built once for all tests.
#[doc(hidden)]
pub mod internals {
    pub use crate::assemble::cycles::cycles;
    pub use crate::check::check_model;
    pub use crate::check::singular::{
        CONFIGURATIONS, UNITS, Vec3, articulated, coordinates, motions, rotation, singular_joints,
    };
    pub use crate::diagnostics::line_index::LineIndex;
    pub use crate::diagnostics::report::Report;
    pub use crate::read::file::{not_text, read_at_most};
    pub use crate::read::mjcf::table::{Treatment, row};
    pub use crate::read::xml::document::{blank_comments, first_element};
    pub use crate::read::xml::limits::MAX_BYTES;
    pub use crate::read::xml::numbers::numbers;
    pub use crate::work::counted_steps;
}
