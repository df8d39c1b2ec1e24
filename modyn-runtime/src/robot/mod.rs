//! The trait of all generated robots, for code that is written for any robot.

mod array;
#[cfg(feature = "alloc")]
mod embedded_model;
mod factorization;
mod functions;
#[macro_use]
mod types;

use crate::Scalar;
use crate::configuration::{self, ConfigurationError};
use crate::constants::{JointLimits, KinematicModule, ShapeCenter};
use crate::constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};
use crate::quantities::table;
use crate::results::{
    ActuatedStep, ActuatorForces, CentroidalMomentumDerivatives, ConstrainedForwardDynamics,
    ConstrainedForwardDynamicsDerivatives, ConstrainedForwardDynamicsHessian,
    ConstrainedInverseDynamics, ConstraintProjection, ConstraintResidual, ContactImpulse,
    DifferenceDerivatives, ForwardDynamicsDerivatives, ForwardDynamicsHessian, ForwardDynamicsJvp,
    ForwardDynamicsVjp, GeneralizedForces, IntegrateDerivatives, InverseDynamicsDerivatives,
    InverseDynamicsHessian, InverseDynamicsJvp, InverseDynamicsVjp, OperationalInertia, Step,
    StepDerivatives, StepHessian, StepSolution,
};
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};
use crate::step_settings::{ContactSurface, StepSettings};
use functions::{declare_function, declare_functions, missing};

#[cfg(feature = "alloc")]
pub use embedded_model::EmbeddedModel;
pub use {
    array::Array,
    factorization::{Factorization, NotGenerated},
};

/// The settings of the constraints of robot `R`.
pub(crate) type Settings<R, T> = ConstraintSettings<T, <R as Robot>::PerContact<ContactTarget<T>>>;

/// The settings of steps of robot `R`.
pub(crate) type SurfaceSettings<R, T> =
    StepSettings<T, <R as Robot>::PerTouchingShape<ContactSurface<T>>>;

/// A generated robot, over any scalar.
///
/// The generated type has the same functions as inherent methods on `f64` or `f32`. The trait is
/// for code that is written for any robot. Vectors have the order of
/// [`COORDINATE_NAMES`](Self::COORDINATE_NAMES) and [`VELOCITY_NAMES`](Self::VELOCITY_NAMES),
/// matrices are arrays of columns, units are SI units and radians. Quaternions in coordinates must
/// have length 1; only [`check_configuration`](Self::check_configuration) checks them. With a
/// quaternion of length 1.1, accelerations are wrong by a part in a thousand or more.
///
/// A robot has the functions that its option `functions` selects. Code for any robot requires a
/// trait of [`functions`](crate::functions) for each function that it calls.
///
/// ```
/// use modyn_runtime::{Array as _, Robot, functions};
///
/// /// Computed torque: the joint forces of the desired accelerations, with feedback of the velocity errors.
/// fn torques<R: Robot + functions::InverseDynamics>(
///     q: &R::Q<f64>,
///     qd: &R::V<f64>,
///     desired: (&R::V<f64>, &R::V<f64>),
///     gain: f64,
/// ) -> R::V<f64> {
///     let (qd_desired, qdd_desired) = desired;
///     let error = |i: usize| qd_desired.as_ref()[i] - qd.as_ref()[i];
///     let qdd = <R::V<f64>>::from_fn(|i| qdd_desired.as_ref()[i] + gain * error(i));
///     R::inverse_dynamics(q, qd, &qdd)
/// }
/// ```
pub trait Robot {
    /// The robot's name in its description.
    const NAME: &'static str;
    /// nq, the length of the coordinate vector.
    const NQ: usize;
    /// nv, the length of the velocity vector: the number of degrees of freedom.
    const NV: usize;
    /// The names of the moving joints, depth first, including mimic joints.
    const JOINT_NAMES: &'static [&'static str];
    /// The names of all links of the description, in its order: the order of
    /// [`link_poses`](Self::link_poses).
    const LINK_NAMES: &'static [&'static str];
    /// The name of each entry of the coordinate vector.
    const COORDINATE_NAMES: &'static [&'static str];
    /// The name of each entry of the velocity vector.
    const VELOCITY_NAMES: &'static [&'static str];
    /// The names of the joints that close loops, in the description's order.
    const LOOP_CONSTRAINT_NAMES: &'static [&'static str] = &[];
    /// The names of the contacts, in the order of the option.
    const CONTACT_NAMES: &'static [&'static str] = &[];
    /// The names of the shapes that touch the ground in a step: the contacts, or the shapes of the
    /// description.
    const TOUCHING_SHAPE_NAMES: &'static [&'static str] = &[];
    /// The centre of each of these shapes.
    const TOUCHING_SHAPE_CENTERS: &'static [ShapeCenter] = &[];
    /// The names of the controls: of the actuators.
    const CONTROL_NAMES: &'static [&'static str] = &[];
    /// The names of the activations: of the actuators that have a state.
    const ACTIVATION_NAMES: &'static [&'static str] = &[];
    /// The quaternions in the coordinate vector: each joint's name, and the index of the
    /// quaternion's x.
    const QUATERNIONS: &'static [(&'static str, usize)] = &[];
    /// The joint limits of the description.
    const LIMITS: JointLimits<'static>;
    /// The kinematic modules, parents before children.
    const MODULES: &'static [KinematicModule];

    /// The parameters that can change at run time, in the scalar of the computation: gravity, and
    /// the inertias and payloads that the robot was compiled with as parameters. With dual numbers,
    /// results have derivatives with respect to them.
    type Params<T: Scalar>: Clone + Default;
    /// The type that names a link of the description.
    type Link: Copy;
    /// The type of coordinates.
    type Q<T: Scalar>: Array<T>;
    /// The type of velocities, accelerations and joint forces.
    type V<T: Scalar>: Array<T>;
    /// The type of square matrices: an array of columns.
    type M<T: Scalar>: Array<Self::V<T>>;
    /// The type of arrays with an entry for each entry of the velocity vector.
    type PerVelocity<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each entry of a state in tangent space: 2 nv entries,
    /// those of the coordinates first.
    type PerState<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each link of the description, in the order of
    /// [`LINK_NAMES`](Self::LINK_NAMES).
    type PerLink<X: Copy>: Array<X>;
    /// The type of sets of active contacts: a member for each contact, or `()` without contacts.
    type Contacts: ContactSet;
    /// The type of arrays with an entry for each contact, in the order of
    /// [`CONTACT_NAMES`](Self::CONTACT_NAMES).
    type PerContact<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each shape that touches the ground in a step, in the
    /// order of [`TOUCHING_SHAPE_NAMES`](Self::TOUCHING_SHAPE_NAMES).
    type PerTouchingShape<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each point of these shapes that can touch the ground:
    /// two for a capsule, four for a box or a cylinder.
    type PerTouchingPoint<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each control, in the order of
    /// [`CONTROL_NAMES`](Self::CONTROL_NAMES).
    type PerControl<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each activation, in the order of
    /// [`ACTIVATION_NAMES`](Self::ACTIVATION_NAMES).
    type PerActivation<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each constraint: for each joint that closes a loop, in
    /// the order of [`LOOP_CONSTRAINT_NAMES`](Self::LOOP_CONSTRAINT_NAMES), then for each contact.
    type PerConstraint<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each constraint row, all contacts active.
    type PerConstraintRow<X: Copy>: Array<X>;
    /// The type of the regressor: an array of columns.
    type Regressor<T: Scalar>: Array<Self::V<T>>;
    /// The type of the factorization by modules.
    type UduFactorization<T: Scalar>: Factorization<T, V = Self::V<T>, M = Self::M<T>>;

    table::quantities!(declare_functions);

    /// Checks that the quaternions of spherical and floating joints in `q` have length 1.
    ///
    /// The tolerance is half of the scalar's digits: 1.5e-8 in `f64`, 3.5e-4 in `f32`.
    ///
    /// # Errors
    ///
    /// Names the first joint whose quaternion does not have length 1.
    fn check_configuration<T: Scalar + PartialOrd>(
        q: &Self::Q<T>,
    ) -> Result<(), ConfigurationError<T>> {
        configuration::check(Self::QUATERNIONS.iter().copied(), q.as_ref())
    }

    /// Returns the neutral coordinates: zero for every joint, the identity for quaternions.
    #[must_use]
    fn neutral<T: Scalar>() -> Self::Q<T>;
}
