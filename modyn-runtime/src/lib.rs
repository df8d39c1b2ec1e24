//! What modyn's generated code needs at run time, and the equations of motion behind it.
//!
//! Without features this crate is what generated code needs, on `core` alone (and `libm` for square roots):
//! [`Scalar`], [`Pose`], the [`Robot`] trait with its [`functions`], [`conventions`]. Feature `alloc` adds the
//! [`model`], the [`equations`] and the [`Interpreter`] that runs them for any model at run time;
//! `nalgebra` the same calls over nalgebra's types; `rayon` batches on all cores;
//! `num-dual` its numbers as scalars, for exact derivatives; `serde` (de)serialization of the model.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod batch;
#[doc(hidden)]
pub mod configuration;
mod constraint_settings;
pub mod conventions;
#[cfg(feature = "alloc")]
pub mod equations;
pub mod functions;
mod inertial;
#[cfg(feature = "alloc")]
mod interpreter;
pub mod jacobi;
pub mod joint;
mod lanes;
#[cfg(feature = "alloc")]
pub mod mechanism;
#[cfg(feature = "alloc")]
pub mod model;
#[cfg(feature = "nalgebra")]
mod nalgebra;
#[doc(hidden)]
pub mod parameters;
mod results;
mod robot;
mod scalar;
pub mod simulate;
#[cfg(feature = "alloc")]
pub mod sources;
pub mod spatial;

/// nalgebra, in the version whose types [`Nalgebra`] has.
#[cfg(feature = "nalgebra")]
pub use ::nalgebra as na;
/// num-dual, in the version whose numbers are scalars.
#[cfg(feature = "num-dual")]
pub use ::num_dual;
#[cfg(feature = "alloc")]
pub use equations::Forces;
#[cfg(feature = "alloc")]
pub use interpreter::{
    Brge, ConstrainedDerivatives, DecompositionError, ForwardDerivatives, FrameError,
    InertialError, Interpreter, ModuleMismatch, ShapeError, UpdateError,
};

#[cfg(feature = "nalgebra")]
pub use crate::nalgebra::Nalgebra;
pub use batch::BatchError;
pub use configuration::ConfigurationError;
pub use constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};
pub use inertial::{Inertial, InertialDefect};
pub use parameters::ParameterError;
pub use results::{
    ConstrainedForwardDynamics, ConstrainedForwardDynamicsDerivatives, ConstrainedInverseDynamics,
    ConstraintProjection, ConstraintResidual, ContactImpulse, ForwardDynamicsDerivatives,
    InverseDynamicsDerivatives, JointLimits, KinematicModule, OperationCount, OperationalInertia,
};
pub use robot::{Array, Factorization, NotGenerated, Robot};
#[cfg(feature = "alloc")]
pub use scalar::LaneScalar;
pub use scalar::{Portable, SIN_COS_F32, SIN_COS_F64, Scalar, SinCosNumbers};
pub use spatial::{Momentum, Pose, Twist, Vector3, Wrench};
