//! What every generated robot offers, for code that is written once for all of them.

mod array;
mod factorization;
mod functions;

use crate::Scalar;
use crate::configuration::{self, ConfigurationError};
use crate::constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};
use crate::results::{
    ConstrainedForwardDynamics, ConstrainedForwardDynamicsDerivatives, ConstrainedInverseDynamics,
    ConstraintProjection, ConstraintResidual, ContactImpulse, ForwardDynamicsDerivatives,
    InverseDynamicsDerivatives, JointLimits, KinematicModule, OperationalInertia,
};
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};
use functions::{declare_functions, missing, robot_functions};

pub use {
    array::Array,
    factorization::{Factorization, NotGenerated},
};

/// The result of constrained forward dynamics for robot `R`, with accelerations as `V`.
pub(crate) type Constrained<R, V, T> = ConstrainedForwardDynamics<
    V,
    <R as Robot>::PerConstraint<Wrench<T>>,
    <R as Robot>::PerConstraint<Twist<T>>,
    T,
>;

/// The derivatives of constrained forward dynamics for robot `R`.
pub(crate) type ConstrainedDerivatives<R, T> = ConstrainedForwardDynamicsDerivatives<
    <R as Robot>::V<T>,
    <R as Robot>::PerConstraint<Wrench<T>>,
    <R as Robot>::M<T>,
    <R as Robot>::PerConstraint<<R as Robot>::PerVelocity<Wrench<T>>>,
    T,
>;

/// The settings of the constraints of robot `R`.
pub(crate) type Settings<R, T> = ConstraintSettings<T, <R as Robot>::PerContact<ContactTarget<T>>>;

/// A generated robot, over any scalar.
///
/// The generated type has the same functions by itself on plain numbers; the trait is for code
/// that does not know the robot. Vectors stand in the order of
/// [`COORDINATE_NAMES`](Self::COORDINATE_NAMES) and [`VELOCITY_NAMES`](Self::VELOCITY_NAMES),
/// matrices are arrays of columns; SI units, radians. Quaternions in coordinates must have length 1, which is not checked
/// but by [`check_configuration`](Self::check_configuration): with one of length 1.1, accelerations are wrong by a part in a
/// thousand or more.
///
/// A robot has the functions that its option `functions` selects. Code for any robot requires the functions
/// that it calls: [`functions`](crate::functions) has a trait for each.
pub trait Robot {
    /// The robot's name in its description.
    const NAME: &'static str;
    /// Length of the coordinate vector.
    const NQ: usize;
    /// Length of the velocity vector: degrees of freedom.
    const NV: usize;
    /// The moving joints, depth first; those that mimic another too.
    const JOINT_NAMES: &'static [&'static str];
    /// All links of the description, in its order: the order of [`link_poses`](Self::link_poses).
    const LINK_NAMES: &'static [&'static str];
    /// What each entry of the coordinate vector is called.
    const COORDINATE_NAMES: &'static [&'static str];
    /// What each entry of the velocity vector is called.
    const VELOCITY_NAMES: &'static [&'static str];
    /// The joints that close loops, in the description's order.
    const LOOP_CONSTRAINT_NAMES: &'static [&'static str] = &[];
    /// The frames of links that may touch the world.
    const CONTACT_NAMES: &'static [&'static str] = &[];
    /// The quaternions in the coordinate vector: the name of the joint of each, and the entry that it begins at.
    const QUATERNIONS: &'static [(&'static str, usize)] = &[];
    /// The limits of the joints, as the description states them.
    const LIMITS: JointLimits<'static>;
    /// The kinematic modules, parents before children.
    const MODULES: &'static [KinematicModule];

    /// The numbers that can be changed at run time, in the scalar of the computation: gravity, inertias and payloads,
    /// where the robot was compiled so. On dual numbers, results come with their derivatives by them.
    type Params<T: Scalar>: Clone + Default;
    /// A link of the description.
    type Link: Copy;
    /// Coordinates.
    type Q<T: Scalar>: Array<T>;
    /// Velocities, accelerations, torques.
    type V<T: Scalar>: Array<T>;
    /// Square matrices, an array of columns.
    type M<T: Scalar>: Array<Self::V<T>>;
    /// Something for each entry of the velocity vector.
    type PerVelocity<X: Copy>: Array<X>;
    /// Something for each link of the description, in the order of [`LINK_NAMES`](Self::LINK_NAMES).
    type PerLink<X: Copy>: Array<X>;
    /// Which contacts are active: a type with a member for each contact, `()` if there are none.
    type Contacts: ContactSet;
    /// Something for each contact, in the order of [`CONTACT_NAMES`](Self::CONTACT_NAMES).
    type PerContact<X: Copy>: Array<X>;
    /// Something for each constraint: for each joint that closes a loop, in the order of
    /// [`LOOP_CONSTRAINT_NAMES`](Self::LOOP_CONSTRAINT_NAMES), then for each contact.
    type PerConstraint<X: Copy>: Array<X>;
    /// Something for each constraint row, all contacts active.
    type PerConstraintRow<X: Copy>: Array<X>;
    /// The regressor's columns.
    type Regressor<T: Scalar>: Array<Self::V<T>>;
    /// The factorization by modules.
    type Brge<T: Scalar>: Factorization<T, V = Self::V<T>, M = Self::M<T>>;

    robot_functions!(declare_functions);

    /// Checks that the quaternions of spherical and floating joints in `q` have length 1, to half of the scalar's digits: to
    /// 1.5e-8 in `f64`, to 3.5e-4 in `f32`.
    ///
    /// # Errors
    ///
    /// The first joint whose quaternion has another length.
    fn check_configuration<T: Scalar + PartialOrd>(
        q: &Self::Q<T>,
    ) -> Result<(), ConfigurationError<T>> {
        configuration::check(Self::QUATERNIONS.iter().copied(), q.as_ref())
    }

    /// Coordinates with every joint at zero, and quaternions of no rotation.
    #[must_use]
    fn neutral<T: Scalar>() -> Self::Q<T>;
}
