//! The runtime of modyn's generated code, and the equations of motion.
//!
//! Without features, this crate has the types and functions that generated code uses, on `core`
//! alone (and `libm` for square roots): [`Scalar`], [`Pose`], the [`Robot`] trait with its
//! [`functions`], and [`conventions`]. Features add:
//!
//! - `alloc`: the [`model`], the [`equations`], and the [`Interpreter`] for models that are known
//!   at run time only
//! - `nalgebra`: the most used functions over nalgebra's types
//! - `num-dual`: the numbers of num-dual as scalars, for exact derivatives
//! - `rayon`: batches on all cores
//! - `serde`: serialization and deserialization of the model
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod batch;
#[doc(hidden)]
pub mod configuration;
mod constants;
mod constraint_settings;
pub mod conventions;
#[cfg(feature = "alloc")]
pub mod equations;
mod float;
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
#[cfg(feature = "alloc")]
pub mod quantities;
mod results;
mod robot;
mod scalar;
mod setting_range;
pub mod simulate;
pub mod solve;
#[cfg(feature = "alloc")]
pub mod sources;
pub mod spatial;
mod step_settings;
#[cfg(feature = "std")]
#[doc(hidden)]
pub mod trig_steps;
#[cfg(feature = "alloc")]
mod user_function;

/// nalgebra, in the version of the types of [`Nalgebra`].
#[cfg(feature = "nalgebra")]
pub use ::nalgebra as na;
/// num-dual, in the version whose numbers implement [`Scalar`].
#[cfg(feature = "num-dual")]
pub use ::num_dual;
#[cfg(feature = "alloc")]
pub use equations::Forces;
#[cfg(feature = "alloc")]
pub use interpreter::{
    ActuatorOutputs, ConstrainedDerivatives, ConstrainedHessianOutputs, ConstrainedKnotOutputs,
    DecompositionError, ForwardDerivatives, HessianOutputs, InertialError, Interpreter,
    KnotOutputs, LinkError, ModuleMismatch, ShapeError, StateChange, StateDerivatives,
    StateGradients, StepHessianOutputs, StepOutputs, StepSolutionOutputs, UduFactorization,
    UpdateError,
};

#[cfg(feature = "nalgebra")]
pub use crate::nalgebra::Nalgebra;
pub use batch::BatchError;
pub use configuration::ConfigurationError;
pub use constants::{JointLimits, KinematicModule, OperationCount, ShapeCenter};
pub use constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};
#[doc(hidden)]
pub use float::{ELEMENTARY_F32, ELEMENTARY_F64, ElementaryNumbers};
pub use inertial::{Inertial, InertialDefect};
pub use parameters::ParameterError;
pub use results::{
    ActuatedStep, ActuatedStepJvp, ActuatedStepVjp, ActuatorForces, CentroidalMomentumDerivatives,
    ConstrainedForwardDynamics, ConstrainedForwardDynamicsDerivatives,
    ConstrainedForwardDynamicsHessian, ConstrainedInverseDynamics, ConstrainedKnot,
    ConstraintProjection, ConstraintResidual, DifferenceDerivatives, ForwardDynamicsDerivatives,
    ForwardDynamicsHessian, ForwardDynamicsJvp, ForwardDynamicsVjp, GeneralizedForces,
    ImpactDynamics, IntegrateDerivatives, InverseDynamicsDerivatives, InverseDynamicsHessian,
    InverseDynamicsJvp, InverseDynamicsVjp, Knot, LinearizedActuatedStep, LinearizedStep,
    OperationalSpaceInertia, Step, StepDerivatives, StepHessian, StepJvp, StepSolution, StepVjp,
    TouchingPoints,
};
#[cfg(feature = "alloc")]
pub use robot::EmbeddedModel;
pub use robot::{Array, Factorization, NotGenerated, Robot};
#[cfg(feature = "alloc")]
pub use scalar::LaneScalar;
#[doc(hidden)]
pub use scalar::{FRAC_1_PI_BITS, PI_BITS};
pub use scalar::{Portable, SIN_COS_F32, SIN_COS_F64, Scalar, SinCosNumbers};
pub use setting_range::{
    SettingError, SettingPlace, SettingRange, check_settings, check_step_settings,
};
pub use spatial::{Momentum, Pose, Twist, Vector3, Wrench};
pub use step_settings::{ContactSurface, StepSettings};
#[cfg(feature = "alloc")]
pub use user_function::{UserArgument, UserArgumentKind, UserDerivatives, UserError, UserFunction};
