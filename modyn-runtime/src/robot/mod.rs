//! What every generated robot offers, for code that is written once for all of them.

mod array;
mod factorization;
mod functions;

use crate::Scalar;
use crate::results::{
    ClosingStep, ClosureErrors, ClosureSettings, ConstrainedForwardDynamics,
    ForwardDynamicsDerivatives, InverseDynamicsDerivatives, JointLimits, KinematicModule,
};
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};
use functions::{declare_functions, missing, no_loops, robot_functions};

pub use {
    array::Array,
    factorization::{Factorization, NotGenerated},
};

/// A generated robot, over any scalar.
///
/// The generated type has the same functions by itself on plain numbers; the trait is for code
/// that does not know the robot. Vectors stand in the order of
/// [`COORDINATE_NAMES`](Self::COORDINATE_NAMES) and [`VELOCITY_NAMES`](Self::VELOCITY_NAMES),
/// matrices are arrays of columns; SI units, radians. A call of a function that the robot was
/// compiled without (option `functions`) does not compile.
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
    const CLOSURE_NAMES: &'static [&'static str] = &[];
    /// The limits of the joints, as the description states them.
    const LIMITS: JointLimits<'static>;
    /// The kinematic modules, parents before children.
    const MODULES: &'static [KinematicModule];

    /// What can be changed at run time: gravity and payloads, where the robot was compiled so.
    type Params: Default;
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
    /// Something for each joint that closes a loop, in the order of
    /// [`CLOSURE_NAMES`](Self::CLOSURE_NAMES).
    type PerClosure<X: Copy>: Array<X>;
    /// The regressor's columns.
    type Regressor<T: Scalar>: Array<Self::V<T>>;
    /// The factorization by modules.
    type Brge<T: Scalar>: Factorization<T, V = Self::V<T>, M = Self::M<T>>;

    robot_functions!(declare_functions);

    /// Coordinates with every joint at zero, and quaternions of no rotation.
    #[must_use]
    fn neutral<T: Scalar>() -> Self::Q<T>;
}
