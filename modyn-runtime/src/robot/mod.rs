//! The trait of all generated robots, for code that is written for any robot.

mod array;
#[cfg(feature = "alloc")]
mod embedded_model;
mod factorization;

use crate::Scalar;
use crate::configuration::{self, ConfigurationError};
use crate::constants::{JointLimits, KinematicModule, ShapeCenter};
use crate::constraint_settings::{ConstraintSettings, ContactSet, ContactTarget};
use crate::functions::{self, not_generated};
use crate::results::{
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
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};
use crate::step_settings::{ContactSurface, StepSettings};

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
#[allow(clippy::too_many_arguments, clippy::type_complexity, unused_variables)]
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
    /// the coordinates first.
    type PerState<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each link of the description, in the order of
    /// [`LINK_NAMES`](Self::LINK_NAMES).
    type PerLink<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each quaternion in the coordinates, in the order of
    /// [`QUATERNIONS`](Self::QUATERNIONS).
    type PerQuaternion<X: Copy>: Array<X>;
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

    /// An array with an element for each entry of a state with activations: 2 nv + activations.
    type PerActuatedState<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each constraint: for each joint that closes a loop, in
    /// the order of [`LOOP_CONSTRAINT_NAMES`](Self::LOOP_CONSTRAINT_NAMES), then for each contact.
    type PerConstraint<X: Copy>: Array<X>;
    /// The type of arrays with an entry for each constraint row, all contacts active.
    type PerConstraintRow<X: Copy>: Array<X>;
    /// The type of the regressor: an array of columns.
    type Regressor<T: Scalar>: Array<Self::V<T>>;
    /// The type of the factorization by modules.
    type UduFactorization<T: Scalar>: Factorization<T, V = Self::V<T>, M = Self::M<T>>;

    // <!-- data: robot-functions -->
    /// Returns the joint accelerations (rad/s^2 or m/s^2) at the coordinates `q` and velocities
    /// `qd` under the joint forces `tau` (N m or N), gravity included. The method is block reverse
    /// Gaussian elimination of the mass matrix by inter- and intra-modular recursion.
    #[doc(alias = "ABA")]
    #[doc(alias = "articulated-body algorithm")]
    #[doc(alias = "pin.aba")]
    fn forward_dynamics_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> Self::V<T>
    where
        Self: functions::ForwardDynamics,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_with`](Self::forward_dynamics_with) with the default parameters.
    #[doc(alias = "ABA")]
    #[doc(alias = "articulated-body algorithm")]
    #[doc(alias = "pin.aba")]
    fn forward_dynamics<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, tau: &Self::V<T>) -> Self::V<T>
    where
        Self: functions::ForwardDynamics,
    {
        Self::forward_dynamics_with(&Self::Params::<T>::default(), q, qd, tau)
    }

    /// Returns the joint forces (N m or N) of the accelerations `qdd` at the coordinates `q` and
    /// velocities `qd`, gravity included, by the recursive Newton-Euler algorithm.
    #[doc(alias = "RNEA")]
    #[doc(alias = "recursive Newton-Euler algorithm")]
    #[doc(alias = "pin.rnea")]
    #[doc(alias = "mj_rne")]
    fn inverse_dynamics_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::V<T>
    where
        Self: functions::InverseDynamics,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_with`](Self::inverse_dynamics_with) with the default parameters.
    #[doc(alias = "RNEA")]
    #[doc(alias = "recursive Newton-Euler algorithm")]
    #[doc(alias = "pin.rnea")]
    #[doc(alias = "mj_rne")]
    fn inverse_dynamics<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, qdd: &Self::V<T>) -> Self::V<T>
    where
        Self: functions::InverseDynamics,
    {
        Self::inverse_dynamics_with(&Self::Params::<T>::default(), q, qd, qdd)
    }

    /// Returns the bias forces (N m or N): inverse dynamics at zero acceleration. They are the
    /// Coriolis, centrifugal and gravity forces and the forces of springs, with damping and
    /// friction if these are enabled.
    #[doc(alias = "nonlinear effects")]
    #[doc(alias = "pin.nonLinearEffects")]
    #[doc(alias = "qfrc_bias")]
    fn bias_forces_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Self::V<T>
    where
        Self: functions::BiasForces,
    {
        const { not_generated() }
    }

    /// Calls [`bias_forces_with`](Self::bias_forces_with) with the default parameters.
    #[doc(alias = "nonlinear effects")]
    #[doc(alias = "pin.nonLinearEffects")]
    #[doc(alias = "qfrc_bias")]
    fn bias_forces<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::V<T>
    where
        Self: functions::BiasForces,
    {
        Self::bias_forces_with(&Self::Params::<T>::default(), q, qd)
    }

    /// Returns the joint forces (N m or N) that balance gravity and springs at `q` and zero
    /// velocity.
    #[doc(alias = "gravity compensation")]
    #[doc(alias = "pin.computeGeneralizedGravity")]
    fn gravity_torques_with<T: Scalar>(params: &Self::Params<T>, q: &Self::Q<T>) -> Self::V<T>
    where
        Self: functions::GravityTorques,
    {
        const { not_generated() }
    }

    /// Calls [`gravity_torques_with`](Self::gravity_torques_with) with the default parameters.
    #[doc(alias = "gravity compensation")]
    #[doc(alias = "pin.computeGeneralizedGravity")]
    fn gravity_torques<T: Scalar>(q: &Self::Q<T>) -> Self::V<T>
    where
        Self: functions::GravityTorques,
    {
        Self::gravity_torques_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the mass matrix at `q`, nv x nv, an array of columns.
    #[doc(alias = "CRBA")]
    #[doc(alias = "joint-space inertia matrix")]
    #[doc(alias = "pin.crba")]
    #[doc(alias = "mj_fullM")]
    fn mass_matrix_with<T: Scalar>(params: &Self::Params<T>, q: &Self::Q<T>) -> Self::M<T>
    where
        Self: functions::MassMatrix,
    {
        const { not_generated() }
    }

    /// Calls [`mass_matrix_with`](Self::mass_matrix_with) with the default parameters.
    #[doc(alias = "CRBA")]
    #[doc(alias = "joint-space inertia matrix")]
    #[doc(alias = "pin.crba")]
    #[doc(alias = "mj_fullM")]
    fn mass_matrix<T: Scalar>(q: &Self::Q<T>) -> Self::M<T>
    where
        Self: functions::MassMatrix,
    {
        Self::mass_matrix_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the Coriolis matrix C, nv x nv, an array of columns. C `qd` are the Coriolis and
    /// centrifugal forces, without gravity, damping and friction, and dM/dt - 2 C is skew with the
    /// mass matrix M.
    #[doc(alias = "pin.computeCoriolisMatrix")]
    fn coriolis_matrix_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Self::M<T>
    where
        Self: functions::CoriolisMatrix,
    {
        const { not_generated() }
    }

    /// Calls [`coriolis_matrix_with`](Self::coriolis_matrix_with) with the default parameters.
    #[doc(alias = "pin.computeCoriolisMatrix")]
    fn coriolis_matrix<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::M<T>
    where
        Self: functions::CoriolisMatrix,
    {
        Self::coriolis_matrix_with(&Self::Params::<T>::default(), q, qd)
    }

    /// Returns the factorization U D U^T of the mass matrix at `q` by kinematic modules, by block
    /// reverse Gaussian elimination.
    #[doc(alias = "Cholesky decomposition of the mass matrix")]
    #[doc(alias = "pin.cholesky.decompose")]
    #[doc(alias = "mj_factorM")]
    fn brge_with<T: Scalar>(params: &Self::Params<T>, q: &Self::Q<T>) -> Self::UduFactorization<T>
    where
        Self: functions::Brge,
    {
        const { not_generated() }
    }

    /// Calls [`brge_with`](Self::brge_with) with the default parameters.
    #[doc(alias = "Cholesky decomposition of the mass matrix")]
    #[doc(alias = "pin.cholesky.decompose")]
    #[doc(alias = "mj_factorM")]
    fn brge<T: Scalar>(q: &Self::Q<T>) -> Self::UduFactorization<T>
    where
        Self: functions::Brge,
    {
        Self::brge_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the kinetic energy of the moving links and the armatures, J.
    #[doc(alias = "pin.computeKineticEnergy")]
    fn kinetic_energy_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> T
    where
        Self: functions::KineticEnergy,
    {
        const { not_generated() }
    }

    /// Calls [`kinetic_energy_with`](Self::kinetic_energy_with) with the default parameters.
    #[doc(alias = "pin.computeKineticEnergy")]
    fn kinetic_energy<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> T
    where
        Self: functions::KineticEnergy,
    {
        Self::kinetic_energy_with(&Self::Params::<T>::default(), q, qd)
    }

    /// Returns the potential energy of the moving links under gravity and of the springs, J; zero
    /// for mass at the world's origin and springs at rest.
    #[doc(alias = "pin.computePotentialEnergy")]
    fn potential_energy_with<T: Scalar>(params: &Self::Params<T>, q: &Self::Q<T>) -> T
    where
        Self: functions::PotentialEnergy,
    {
        const { not_generated() }
    }

    /// Calls [`potential_energy_with`](Self::potential_energy_with) with the default parameters.
    #[doc(alias = "pin.computePotentialEnergy")]
    fn potential_energy<T: Scalar>(q: &Self::Q<T>) -> T
    where
        Self: functions::PotentialEnergy,
    {
        Self::potential_energy_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the joint accelerations under `tau` and a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in the link's own axes.
    fn forward_dynamics_external_local_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::ForwardDynamicsExternalLocal,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_external_local_with`](Self::forward_dynamics_external_local_with)
    /// with the default parameters.
    fn forward_dynamics_external_local<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::ForwardDynamicsExternalLocal,
    {
        Self::forward_dynamics_external_local_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            forces,
        )
    }

    /// Returns the joint accelerations under `tau` and a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in world axes.
    fn forward_dynamics_external_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::ForwardDynamicsExternal,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_external_with`](Self::forward_dynamics_external_with) with the
    /// default parameters.
    fn forward_dynamics_external<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::ForwardDynamicsExternal,
    {
        Self::forward_dynamics_external_with(&Self::Params::<T>::default(), q, qd, tau, forces)
    }

    /// Returns the joint forces of `qdd` under a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in the link's own axes.
    fn inverse_dynamics_external_local_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::InverseDynamicsExternalLocal,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_external_local_with`](Self::inverse_dynamics_external_local_with)
    /// with the default parameters.
    fn inverse_dynamics_external_local<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::InverseDynamicsExternalLocal,
    {
        Self::inverse_dynamics_external_local_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            qdd,
            forces,
        )
    }

    /// Returns the joint forces of `qdd` under a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in world axes.
    fn inverse_dynamics_external_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::InverseDynamicsExternal,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_external_with`](Self::inverse_dynamics_external_with) with the
    /// default parameters.
    fn inverse_dynamics_external<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T>
    where
        Self: functions::InverseDynamicsExternal,
    {
        Self::inverse_dynamics_external_with(&Self::Params::<T>::default(), q, qd, qdd, forces)
    }

    /// Returns the generalized forces J^T f of a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in the link's own axes, and their derivative with
    /// respect to `q` (in tangent space), an array of columns. The wrenches rotate with their
    /// links.
    fn generalized_forces_local<T: Scalar>(
        q: &Self::Q<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> GeneralizedForces<Self::V<T>, Self::M<T>>
    where
        Self: functions::GeneralizedForcesLocal,
    {
        const { not_generated() }
    }

    /// Returns the generalized forces J^T f of a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in world axes, and their derivative with respect to `q`
    /// (in tangent space), an array of columns. The wrenches keep their directions.
    fn generalized_forces<T: Scalar>(
        q: &Self::Q<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> GeneralizedForces<Self::V<T>, Self::M<T>>
    where
        Self: functions::GeneralizedForces,
    {
        const { not_generated() }
    }

    /// Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`,
    /// each an array of columns. The derivative with respect to `qdd` is the mass matrix.
    #[doc(alias = "pin.computeRNEADerivatives")]
    fn inverse_dynamics_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> InverseDynamicsDerivatives<Self::M<T>>
    where
        Self: functions::InverseDynamicsDerivatives,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_derivatives_with`](Self::inverse_dynamics_derivatives_with) with
    /// the default parameters.
    #[doc(alias = "pin.computeRNEADerivatives")]
    fn inverse_dynamics_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> InverseDynamicsDerivatives<Self::M<T>>
    where
        Self: functions::InverseDynamicsDerivatives,
    {
        Self::inverse_dynamics_derivatives_with(&Self::Params::<T>::default(), q, qd, qdd)
    }

    /// Returns the joint accelerations, and the derivatives of forward dynamics with respect to `q`
    /// (in tangent space), `qd` and `tau`, each an array of columns.
    #[doc(alias = "pin.computeABADerivatives")]
    fn forward_dynamics_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>>
    where
        Self: functions::ForwardDynamicsDerivatives,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_derivatives_with`](Self::forward_dynamics_derivatives_with) with
    /// the default parameters.
    #[doc(alias = "pin.computeABADerivatives")]
    fn forward_dynamics_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>>
    where
        Self: functions::ForwardDynamicsDerivatives,
    {
        Self::forward_dynamics_derivatives_with(&Self::Params::<T>::default(), q, qd, tau)
    }

    /// Returns the joint forces tau of `qdd`, and the products of `cotangent` with their
    /// derivatives: the gradients of `cotangent`^T tau with respect to `q` (in tangent space), `qd`
    /// and `qdd`.
    fn inverse_dynamics_vjp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> InverseDynamicsVjp<Self::V<T>>
    where
        Self: functions::InverseDynamicsVjp,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_vjp_with`](Self::inverse_dynamics_vjp_with) with the default
    /// parameters.
    fn inverse_dynamics_vjp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> InverseDynamicsVjp<Self::V<T>>
    where
        Self: functions::InverseDynamicsVjp,
    {
        Self::inverse_dynamics_vjp_with(&Self::Params::<T>::default(), q, qd, qdd, cotangent)
    }

    /// Returns the joint forces tau of `qdd`, and their change under the changes `tangent_q` (in
    /// tangent space), `tangent_qd` and `tangent_qdd`.
    fn inverse_dynamics_jvp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        tangent_qdd: &Self::V<T>,
    ) -> InverseDynamicsJvp<Self::V<T>>
    where
        Self: functions::InverseDynamicsJvp,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_jvp_with`](Self::inverse_dynamics_jvp_with) with the default
    /// parameters.
    fn inverse_dynamics_jvp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        tangent_qdd: &Self::V<T>,
    ) -> InverseDynamicsJvp<Self::V<T>>
    where
        Self: functions::InverseDynamicsJvp,
    {
        Self::inverse_dynamics_jvp_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            qdd,
            tangent_q,
            tangent_qd,
            tangent_qdd,
        )
    }

    /// Returns the accelerations qdd, and the products of `cotangent` with their derivatives: the
    /// gradients of `cotangent`^T qdd with respect to `q` (in tangent space), `qd` and `tau`.
    fn forward_dynamics_vjp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> ForwardDynamicsVjp<Self::V<T>>
    where
        Self: functions::ForwardDynamicsVjp,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_vjp_with`](Self::forward_dynamics_vjp_with) with the default
    /// parameters.
    fn forward_dynamics_vjp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> ForwardDynamicsVjp<Self::V<T>>
    where
        Self: functions::ForwardDynamicsVjp,
    {
        Self::forward_dynamics_vjp_with(&Self::Params::<T>::default(), q, qd, tau, cotangent)
    }

    /// Returns the accelerations qdd, and their change under the changes `tangent_q` (in tangent
    /// space), `tangent_qd` and `tangent_tau`.
    fn forward_dynamics_jvp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        tangent_tau: &Self::V<T>,
    ) -> ForwardDynamicsJvp<Self::V<T>>
    where
        Self: functions::ForwardDynamicsJvp,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_jvp_with`](Self::forward_dynamics_jvp_with) with the default
    /// parameters.
    fn forward_dynamics_jvp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        tangent_tau: &Self::V<T>,
    ) -> ForwardDynamicsJvp<Self::V<T>>
    where
        Self: functions::ForwardDynamicsJvp,
    {
        Self::forward_dynamics_jvp_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            tangent_q,
            tangent_qd,
            tangent_tau,
        )
    }

    /// Returns the joint forces tau of `qdd`, and the gradients and the Hessian of `cotangent`^T
    /// tau with respect to `q` (in tangent space), `qd` and `qdd`. The blocks of the Hessian are
    /// arrays of columns; the blocks of `qd` and `qdd` and of `qdd` and `qdd` are zero.
    fn inverse_dynamics_hessian_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> InverseDynamicsHessian<Self::V<T>, Self::M<T>>
    where
        Self: functions::InverseDynamicsHessian,
    {
        const { not_generated() }
    }

    /// Calls [`inverse_dynamics_hessian_with`](Self::inverse_dynamics_hessian_with) with the
    /// default parameters.
    fn inverse_dynamics_hessian<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> InverseDynamicsHessian<Self::V<T>, Self::M<T>>
    where
        Self: functions::InverseDynamicsHessian,
    {
        Self::inverse_dynamics_hessian_with(&Self::Params::<T>::default(), q, qd, qdd, cotangent)
    }

    /// Returns the accelerations qdd, and the gradients and the Hessian of `cotangent`^T qdd with
    /// respect to `q` (in tangent space), `qd` and `tau`. The blocks of the Hessian are arrays of
    /// columns; the blocks of `qd` and `tau` and of `tau` and `tau` are zero.
    fn forward_dynamics_hessian_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> ForwardDynamicsHessian<Self::V<T>, Self::M<T>>
    where
        Self: functions::ForwardDynamicsHessian,
    {
        const { not_generated() }
    }

    /// Calls [`forward_dynamics_hessian_with`](Self::forward_dynamics_hessian_with) with the
    /// default parameters.
    fn forward_dynamics_hessian<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        cotangent: &Self::V<T>,
    ) -> ForwardDynamicsHessian<Self::V<T>, Self::M<T>>
    where
        Self: functions::ForwardDynamicsHessian,
    {
        Self::forward_dynamics_hessian_with(&Self::Params::<T>::default(), q, qd, tau, cotangent)
    }

    /// Returns the state after the time `dt` (s) under the joint forces `tau`, by the semi-implicit
    /// Euler method: the new velocities are `qd` + `dt` qdd, and move the coordinates.
    fn step_semi_implicit_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Step<Self::Q<T>, Self::V<T>>
    where
        Self: functions::StepSemiImplicit,
    {
        const { not_generated() }
    }

    /// Calls [`step_semi_implicit_with`](Self::step_semi_implicit_with) with the default
    /// parameters.
    fn step_semi_implicit<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Step<Self::Q<T>, Self::V<T>>
    where
        Self: functions::StepSemiImplicit,
    {
        Self::step_semi_implicit_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns the state after the time `dt` (s) by the semi-implicit Euler method, and its
    /// derivatives: `a` with respect to the state before and `b` with respect to `tau`, arrays of
    /// columns. A state has the entries of q (in tangent space), then the entries of qd.
    fn step_semi_implicit_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> StepDerivatives<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
    >
    where
        Self: functions::StepSemiImplicitDerivatives,
    {
        const { not_generated() }
    }

    /// Calls [`step_semi_implicit_derivatives_with`](Self::step_semi_implicit_derivatives_with)
    /// with the default parameters.
    fn step_semi_implicit_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> StepDerivatives<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
    >
    where
        Self: functions::StepSemiImplicitDerivatives,
    {
        Self::step_semi_implicit_derivatives_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns a knot of optimal control: the velocities after a step of the time `dt` (s) by the
    /// semi-implicit Euler method, and the derivatives of the step in blocks, by rows. The
    /// derivatives of the velocities are with respect to `q` (in tangent space), `qd` and `tau`.
    /// The coordinates after the step are `integrate` of `q` and v, with v = `dt` times these
    /// velocities. Their derivatives with respect to `q` and v are 1, except for a 6 x 6 block at
    /// each quaternion, such as the quaternion of a floating base. A spherical joint has the
    /// angular part of its block.
    #[doc(alias = "knot point")]
    #[doc(alias = "action model")]
    #[doc(alias = "calcDiff")]
    fn knot_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Knot<Self::V<T>, Self::M<T>, Self::PerQuaternion<[[T; 6]; 6]>>
    where
        Self: functions::Knot,
    {
        const { not_generated() }
    }

    /// Calls [`knot_with`](Self::knot_with) with the default parameters.
    #[doc(alias = "knot point")]
    #[doc(alias = "action model")]
    #[doc(alias = "calcDiff")]
    fn knot<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Knot<Self::V<T>, Self::M<T>, Self::PerQuaternion<[[T; 6]; 6]>>
    where
        Self: functions::Knot,
    {
        Self::knot_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns the state after the time `dt` (s) by the semi-implicit Euler method, and the
    /// gradients and the Hessian of `state_cotangent`^T state: `grad_x` and `grad_tau` with respect
    /// to the state before and `tau`, and `hess_x_x`, `hess_x_tau` and `hess_tau_tau`, arrays of
    /// columns. A state has the entries of q (in tangent space), then the entries of qd.
    /// Displacements of the state after the step are in tangent space, too.
    fn step_semi_implicit_hessian_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        state_cotangent: &Self::PerState<T>,
    ) -> StepHessian<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
        Self::M<T>,
    >
    where
        Self: functions::StepSemiImplicitHessian,
    {
        const { not_generated() }
    }

    /// Calls [`step_semi_implicit_hessian_with`](Self::step_semi_implicit_hessian_with) with the
    /// default parameters.
    fn step_semi_implicit_hessian<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        state_cotangent: &Self::PerState<T>,
    ) -> StepHessian<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
        Self::M<T>,
    >
    where
        Self: functions::StepSemiImplicitHessian,
    {
        Self::step_semi_implicit_hessian_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            dt,
            state_cotangent,
        )
    }

    /// Returns the state after the time `dt` (s) under the constant joint forces `tau`, by a
    /// Runge-Kutta method of fourth order. Rotations follow exponential maps, so quaternions keep
    /// length 1.
    fn step_rk4_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Step<Self::Q<T>, Self::V<T>>
    where
        Self: functions::StepRk4,
    {
        const { not_generated() }
    }

    /// Calls [`step_rk4_with`](Self::step_rk4_with) with the default parameters.
    fn step_rk4<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Step<Self::Q<T>, Self::V<T>>
    where
        Self: functions::StepRk4,
    {
        Self::step_rk4_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns the state of `step_rk4`, and its derivatives: `a` with respect to the state before
    /// and `b` with respect to `tau`, arrays of columns. A state has the entries of q (in tangent
    /// space), then the entries of qd.
    fn step_rk4_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> StepDerivatives<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
    >
    where
        Self: functions::StepRk4Derivatives,
    {
        const { not_generated() }
    }

    /// Calls [`step_rk4_derivatives_with`](Self::step_rk4_derivatives_with) with the default
    /// parameters.
    fn step_rk4_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> StepDerivatives<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
    >
    where
        Self: functions::StepRk4Derivatives,
    {
        Self::step_rk4_derivatives_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns the state after the time `dt` (s) under the constant joint forces `tau`, by the
    /// implicit midpoint rule: of second order, symmetric, and stable under stiff damping. Three
    /// iterations of simplified Newton solve its equations. Rotations follow exponential maps, so
    /// quaternions keep length 1.
    fn step_implicit_midpoint_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Step<Self::Q<T>, Self::V<T>>
    where
        Self: functions::StepImplicitMidpoint,
    {
        const { not_generated() }
    }

    /// Calls [`step_implicit_midpoint_with`](Self::step_implicit_midpoint_with) with the default
    /// parameters.
    fn step_implicit_midpoint<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> Step<Self::Q<T>, Self::V<T>>
    where
        Self: functions::StepImplicitMidpoint,
    {
        Self::step_implicit_midpoint_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns the state of `step_implicit_midpoint`, and the derivatives of the implicit midpoint
    /// rule: `a` with respect to the state before and `b` with respect to `tau`, arrays of columns.
    /// A state has the entries of q (in tangent space), then the entries of qd.
    fn step_implicit_midpoint_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> StepDerivatives<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
    >
    where
        Self: functions::StepImplicitMidpointDerivatives,
    {
        const { not_generated() }
    }

    /// Calls
    /// [`step_implicit_midpoint_derivatives_with`](Self::step_implicit_midpoint_derivatives_with)
    /// with the default parameters.
    fn step_implicit_midpoint_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
    ) -> StepDerivatives<
        Self::Q<T>,
        Self::V<T>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
    >
    where
        Self: functions::StepImplicitMidpointDerivatives,
    {
        Self::step_implicit_midpoint_derivatives_with(&Self::Params::<T>::default(), q, qd, tau, dt)
    }

    /// Returns the joint accelerations under the joint forces `tau` with the loops closed and the
    /// active contacts held. Also returns the wrench on each constraint's link and the unmet part
    /// of the constraint's acceleration, and the number of independent constraint rows. Loop
    /// constraints come first, in the order of `LOOP_CONSTRAINT_NAMES`, at the second frame's
    /// origin in the first frame's axes. Contacts follow, in the order of `CONTACT_NAMES`, at the
    /// frame's origin in world axes. Redundant rows get the multipliers of smallest norm.
    #[doc(alias = "contact dynamics")]
    #[doc(alias = "pin.constraintDynamics")]
    fn constrained_forward_dynamics_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedForwardDynamics<
        Self::V<T>,
        Self::PerConstraint<Wrench<T>>,
        Self::PerConstraint<Twist<T>>,
        T,
    >
    where
        Self: functions::ConstrainedForwardDynamics,
    {
        const { not_generated() }
    }

    /// Calls [`constrained_forward_dynamics_with`](Self::constrained_forward_dynamics_with) with
    /// the default parameters.
    #[doc(alias = "contact dynamics")]
    #[doc(alias = "pin.constraintDynamics")]
    fn constrained_forward_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedForwardDynamics<
        Self::V<T>,
        Self::PerConstraint<Wrench<T>>,
        Self::PerConstraint<Twist<T>>,
        T,
    >
    where
        Self: functions::ConstrainedForwardDynamics,
    {
        Self::constrained_forward_dynamics_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            active,
            settings,
        )
    }

    /// Returns the displacement and the velocity of each loop constraint's second frame relative to
    /// its first, in the first frame's axes; then of each contact's frame, active or not, relative
    /// to its target, in world axes. Components along free directions are zero. A rotation is its
    /// axis times the sine of its angle.
    fn constraint_residual<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        settings: &Settings<Self, T>,
    ) -> ConstraintResidual<Self::PerConstraint<Twist<T>>>
    where
        Self: functions::ConstraintResidual,
    {
        const { not_generated() }
    }

    /// Returns the smallest step (in the metric of the mass matrix) that closes the loops at `q`
    /// and moves the active contacts to their targets to first order, the smallest change of `qd`
    /// that keeps them there, and the number of independent constraint rows. The settings `alpha`
    /// and `beta` have no effect.
    fn project_constraints_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstraintProjection<Self::V<T>, T>
    where
        Self: functions::ProjectConstraints,
    {
        const { not_generated() }
    }

    /// Calls [`project_constraints_with`](Self::project_constraints_with) with the default
    /// parameters.
    fn project_constraints<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstraintProjection<Self::V<T>, T>
    where
        Self: functions::ProjectConstraints,
    {
        Self::project_constraints_with(&Self::Params::<T>::default(), q, qd, active, settings)
    }

    /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and their
    /// derivatives with respect to `q` (in tangent space), `qd` and `tau`, each an array of
    /// columns. The derivatives of wrenches are arrays for each constraint, in the axes of the
    /// wrenches. The rank is assumed constant; redundant rows get the derivatives of smallest norm.
    #[doc(alias = "pin.computeConstraintDynamicsDerivatives")]
    fn constrained_forward_dynamics_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedForwardDynamicsDerivatives<
        Self::V<T>,
        Self::PerConstraint<Wrench<T>>,
        Self::M<T>,
        Self::PerConstraint<Self::PerVelocity<Wrench<T>>>,
        T,
    >
    where
        Self: functions::ConstrainedForwardDynamicsDerivatives,
    {
        const { not_generated() }
    }

    /// Calls
    /// [`constrained_forward_dynamics_derivatives_with`](Self::constrained_forward_dynamics_derivatives_with)
    /// with the default parameters.
    #[doc(alias = "pin.computeConstraintDynamicsDerivatives")]
    fn constrained_forward_dynamics_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedForwardDynamicsDerivatives<
        Self::V<T>,
        Self::PerConstraint<Wrench<T>>,
        Self::M<T>,
        Self::PerConstraint<Self::PerVelocity<Wrench<T>>>,
        T,
    >
    where
        Self: functions::ConstrainedForwardDynamicsDerivatives,
    {
        Self::constrained_forward_dynamics_derivatives_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            active,
            settings,
        )
    }

    /// Returns the results of `knot` under the accelerations of `constrained_forward_dynamics`, and
    /// the wrenches of the constraints with their derivatives, which
    /// `constrained_forward_dynamics_derivatives` describes.
    #[doc(alias = "DifferentialActionModelContactFwdDynamics")]
    fn constrained_knot_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedKnot<
        Self::V<T>,
        Self::PerConstraint<Wrench<T>>,
        Self::M<T>,
        Self::PerQuaternion<[[T; 6]; 6]>,
        Self::PerConstraint<Self::PerVelocity<Wrench<T>>>,
        T,
    >
    where
        Self: functions::ConstrainedKnot,
    {
        const { not_generated() }
    }

    /// Calls [`constrained_knot_with`](Self::constrained_knot_with) with the default parameters.
    #[doc(alias = "DifferentialActionModelContactFwdDynamics")]
    fn constrained_knot<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedKnot<
        Self::V<T>,
        Self::PerConstraint<Wrench<T>>,
        Self::M<T>,
        Self::PerQuaternion<[[T; 6]; 6]>,
        Self::PerConstraint<Self::PerVelocity<Wrench<T>>>,
        T,
    >
    where
        Self: functions::ConstrainedKnot,
    {
        Self::constrained_knot_with(&Self::Params::<T>::default(), q, qd, tau, dt, active, settings)
    }

    /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and the
    /// gradients and the Hessian of their sum with the weights `cotangent` and `wrench_cotangent`
    /// (of the components of the wrenches) with respect to `q` (in tangent space), `qd` and `tau`.
    /// The blocks of the Hessian are arrays of columns; the blocks of `qd` and `tau` and of `tau`
    /// and `tau` are zero. The rank is assumed constant. Weights of wrenches need independent rows,
    /// or compliance.
    fn constrained_forward_dynamics_hessian_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        cotangent: &Self::V<T>,
        wrench_cotangent: &Self::PerConstraint<Wrench<T>>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedForwardDynamicsHessian<Self::V<T>, Self::PerConstraint<Wrench<T>>, Self::M<T>, T>
    where
        Self: functions::ConstrainedForwardDynamicsHessian,
    {
        const { not_generated() }
    }

    /// Calls
    /// [`constrained_forward_dynamics_hessian_with`](Self::constrained_forward_dynamics_hessian_with)
    /// with the default parameters.
    fn constrained_forward_dynamics_hessian<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        cotangent: &Self::V<T>,
        wrench_cotangent: &Self::PerConstraint<Wrench<T>>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedForwardDynamicsHessian<Self::V<T>, Self::PerConstraint<Wrench<T>>, Self::M<T>, T>
    where
        Self: functions::ConstrainedForwardDynamicsHessian,
    {
        Self::constrained_forward_dynamics_hessian_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            cotangent,
            wrench_cotangent,
            active,
            settings,
        )
    }

    /// Returns the velocities after an impact that closes the loops and stops the active contacts
    /// relative to their targets at the same instant, the impulse of each constraint, and the
    /// number of independent constraint rows. Along its normal, a contact leaves with `restitution`
    /// times the speed before the impact. The settings `alpha` and `beta` have no effect.
    #[doc(alias = "impact dynamics")]
    #[doc(alias = "pin.impulseDynamics")]
    fn impact_dynamics_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ImpactDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>
    where
        Self: functions::ImpactDynamics,
    {
        const { not_generated() }
    }

    /// Calls [`impact_dynamics_with`](Self::impact_dynamics_with) with the default parameters.
    #[doc(alias = "impact dynamics")]
    #[doc(alias = "pin.impulseDynamics")]
    fn impact_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ImpactDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>
    where
        Self: functions::ImpactDynamics,
    {
        Self::impact_dynamics_with(&Self::Params::<T>::default(), q, qd, active, settings)
    }

    /// Returns the state after a step of the time `dt` (s) under the joint forces `tau`, with
    /// contacts, joint limits, dry joint friction and closed loops by MuJoCo's law: soft
    /// constraints whose forces minimize a convex function. The solver is Newton's method, to the
    /// tolerance of `step_settings`; `residual` says how far it came, relative to the largest
    /// force. It starts from the accelerations `warm_start`: `qdd` of the last step, or zeros. The
    /// integrator is semi-implicit Euler, implicit in joint damping, or MuJoCo's `implicitfast`, as
    /// the description says.
    #[doc(alias = "mj_step")]
    fn step_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> StepSolution<Self::Q<T>, Self::V<T>, Self::V<T>, Self::PerTouchingPoint<Vector3<T>>, T, T>
    where
        Self: functions::Step,
    {
        const { not_generated() }
    }

    /// Calls [`step_with`](Self::step_with) with the default parameters.
    #[doc(alias = "mj_step")]
    fn step<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> StepSolution<Self::Q<T>, Self::V<T>, Self::V<T>, Self::PerTouchingPoint<Vector3<T>>, T, T>
    where
        Self: functions::Step,
    {
        Self::step_with(&Self::Params::<T>::default(), q, qd, tau, dt, warm_start, step_settings)
    }

    /// Returns the results of `step`, and the derivatives of the state after it: `a` with respect
    /// to the state before and `b` with respect to `tau`, arrays of columns. A state has the
    /// entries of q (in tangent space), then the entries of qd. The derivatives follow from the
    /// implicit function theorem at the solution; where a contact opens or closes, or a point
    /// begins to slide, they are one-sided.
    #[doc(alias = "linearization")]
    #[doc(alias = "mjd_transitionFD")]
    fn step_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> LinearizedStep<
        Self::Q<T>,
        Self::V<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
        T,
        T,
    >
    where
        Self: functions::StepDerivatives,
    {
        const { not_generated() }
    }

    /// Calls [`step_derivatives_with`](Self::step_derivatives_with) with the default parameters.
    #[doc(alias = "linearization")]
    #[doc(alias = "mjd_transitionFD")]
    fn step_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> LinearizedStep<
        Self::Q<T>,
        Self::V<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerState<Self::PerState<T>>,
        Self::PerVelocity<Self::PerState<T>>,
        T,
        T,
    >
    where
        Self: functions::StepDerivatives,
    {
        Self::step_derivatives_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            dt,
            warm_start,
            step_settings,
        )
    }

    /// Returns the results of `step`, and the gradients of `state_cotangent`^T state after it:
    /// `grad_x` with respect to the state before, and `grad_tau`. A state has the entries of q (in
    /// tangent space), then the entries of qd. At kinks they are as in `step_derivatives`.
    #[doc(alias = "reverse-mode differentiation")]
    #[doc(alias = "adjoint")]
    fn step_vjp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        state_cotangent: &Self::PerState<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> StepVjp<
        Self::Q<T>,
        Self::V<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerState<T>,
        Self::V<T>,
        T,
        T,
    >
    where
        Self: functions::StepVjp,
    {
        const { not_generated() }
    }

    /// Calls [`step_vjp_with`](Self::step_vjp_with) with the default parameters.
    #[doc(alias = "reverse-mode differentiation")]
    #[doc(alias = "adjoint")]
    fn step_vjp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        dt: T,
        state_cotangent: &Self::PerState<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> StepVjp<
        Self::Q<T>,
        Self::V<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerState<T>,
        Self::V<T>,
        T,
        T,
    >
    where
        Self: functions::StepVjp,
    {
        Self::step_vjp_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            dt,
            state_cotangent,
            warm_start,
            step_settings,
        )
    }

    /// Returns the results of `step`, and the change `tangent_x` of the state after it under the
    /// changes `tangent_q` (in tangent space), `tangent_qd` and `tangent_tau`. A state has the
    /// entries of q (in tangent space), then the entries of qd. At kinks it is as in
    /// `step_derivatives`.
    #[doc(alias = "forward-mode differentiation")]
    fn step_jvp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        tangent_tau: &Self::V<T>,
        dt: T,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> StepJvp<
        Self::Q<T>,
        Self::V<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerState<T>,
        T,
        T,
    >
    where
        Self: functions::StepJvp,
    {
        const { not_generated() }
    }

    /// Calls [`step_jvp_with`](Self::step_jvp_with) with the default parameters.
    #[doc(alias = "forward-mode differentiation")]
    fn step_jvp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        tangent_tau: &Self::V<T>,
        dt: T,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> StepJvp<
        Self::Q<T>,
        Self::V<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerState<T>,
        T,
        T,
    >
    where
        Self: functions::StepJvp,
    {
        Self::step_jvp_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tau,
            tangent_q,
            tangent_qd,
            tangent_tau,
            dt,
            warm_start,
            step_settings,
        )
    }

    /// Returns the points of the shapes that can touch the ground, in the order of the `forces` of
    /// `step`: the heights `gaps` above the ground (m; negative in it), the `positions` in the
    /// middle between the shape and the ground (m, world axes), and the `velocities` of the link
    /// there, along the x and y axes of the plane, then along its normal (m/s).
    #[doc(alias = "contact distance")]
    #[doc(alias = "foot clearance")]
    #[doc(alias = "mjContact")]
    fn touching_points<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> TouchingPoints<Self::PerTouchingPoint<T>, Self::PerTouchingPoint<Vector3<T>>>
    where
        Self: functions::TouchingPoints,
    {
        const { not_generated() }
    }

    /// Returns the joint forces `tau` of the actuators under the controls `ctrl`, in the order of
    /// `CONTROL_NAMES`, and the activations after the time `dt` (s), in the order of
    /// `ACTIVATION_NAMES`. The laws are MuJoCo's: controls, forces, activations and joint forces
    /// are clamped to the ranges of the description.
    #[doc(alias = "mj_fwdActuation")]
    fn actuate<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
    ) -> ActuatorForces<Self::V<T>, Self::PerActivation<T>>
    where
        Self: functions::Actuate,
    {
        const { not_generated() }
    }

    /// Returns the state and the activations after a step of the time `dt` (s) under the controls
    /// `ctrl`: MuJoCo's `mj_step`. The joint forces are the result of `actuate` at the state before
    /// the step, and the forces `applied` beside it (MuJoCo's `qfrc_applied`). All else is as in
    /// `step`.
    #[doc(alias = "mj_step")]
    fn step_actuated_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> ActuatedStep<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        T,
        T,
    >
    where
        Self: functions::StepActuated,
    {
        const { not_generated() }
    }

    /// Calls [`step_actuated_with`](Self::step_actuated_with) with the default parameters.
    #[doc(alias = "mj_step")]
    fn step_actuated<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> ActuatedStep<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        T,
        T,
    >
    where
        Self: functions::StepActuated,
    {
        Self::step_actuated_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            ctrl,
            dt,
            act,
            applied,
            warm_start,
            step_settings,
        )
    }

    /// Returns the results of `step_actuated`, and the derivatives of the state after it: `a` with
    /// respect to the state before and `b` with respect to `ctrl`, arrays of columns. A state has
    /// the entries of q (in tangent space), the entries of qd, then `act`. All else is as in
    /// `step_derivatives`.
    #[doc(alias = "linearization")]
    #[doc(alias = "mjd_transitionFD")]
    fn step_actuated_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> LinearizedActuatedStep<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerActuatedState<Self::PerActuatedState<T>>,
        Self::PerControl<Self::PerActuatedState<T>>,
        T,
        T,
    >
    where
        Self: functions::StepActuatedDerivatives,
    {
        const { not_generated() }
    }

    /// Calls [`step_actuated_derivatives_with`](Self::step_actuated_derivatives_with) with the
    /// default parameters.
    #[doc(alias = "linearization")]
    #[doc(alias = "mjd_transitionFD")]
    fn step_actuated_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> LinearizedActuatedStep<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerActuatedState<Self::PerActuatedState<T>>,
        Self::PerControl<Self::PerActuatedState<T>>,
        T,
        T,
    >
    where
        Self: functions::StepActuatedDerivatives,
    {
        Self::step_actuated_derivatives_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            ctrl,
            dt,
            act,
            applied,
            warm_start,
            step_settings,
        )
    }

    /// Returns the results of `step_actuated`, and the gradients of `state_cotangent`^T state +
    /// `act_cotangent`^T act after it: `grad_x` with respect to the state before, and `grad_ctrl`.
    /// The state of `grad_x` has the entries of q (in tangent space), the entries of qd, then
    /// `act`. At kinks they are as in `step_derivatives`.
    #[doc(alias = "reverse-mode differentiation")]
    #[doc(alias = "adjoint")]
    fn step_actuated_vjp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        state_cotangent: &Self::PerState<T>,
        act: &Self::PerActivation<T>,
        act_cotangent: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> ActuatedStepVjp<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerActuatedState<T>,
        Self::PerControl<T>,
        T,
        T,
    >
    where
        Self: functions::StepActuatedVjp,
    {
        const { not_generated() }
    }

    /// Calls [`step_actuated_vjp_with`](Self::step_actuated_vjp_with) with the default parameters.
    #[doc(alias = "reverse-mode differentiation")]
    #[doc(alias = "adjoint")]
    fn step_actuated_vjp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        dt: T,
        state_cotangent: &Self::PerState<T>,
        act: &Self::PerActivation<T>,
        act_cotangent: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> ActuatedStepVjp<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerActuatedState<T>,
        Self::PerControl<T>,
        T,
        T,
    >
    where
        Self: functions::StepActuatedVjp,
    {
        Self::step_actuated_vjp_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            ctrl,
            dt,
            state_cotangent,
            act,
            act_cotangent,
            applied,
            warm_start,
            step_settings,
        )
    }

    /// Returns the results of `step_actuated`, and the change `tangent_x` of the state after it
    /// under the changes `tangent_q` (in tangent space), `tangent_qd`, `tangent_ctrl` and
    /// `tangent_act`. The state of `tangent_x` has the entries of q (in tangent space), the entries
    /// of qd, then `act`. At kinks it is as in `step_derivatives`.
    #[doc(alias = "forward-mode differentiation")]
    fn step_actuated_jvp_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        tangent_ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
        tangent_act: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> ActuatedStepJvp<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerActuatedState<T>,
        T,
        T,
    >
    where
        Self: functions::StepActuatedJvp,
    {
        const { not_generated() }
    }

    /// Calls [`step_actuated_jvp_with`](Self::step_actuated_jvp_with) with the default parameters.
    #[doc(alias = "forward-mode differentiation")]
    fn step_actuated_jvp<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tangent_q: &Self::V<T>,
        tangent_qd: &Self::V<T>,
        ctrl: &Self::PerControl<T>,
        tangent_ctrl: &Self::PerControl<T>,
        dt: T,
        act: &Self::PerActivation<T>,
        tangent_act: &Self::PerActivation<T>,
        applied: &Self::V<T>,
        warm_start: &Self::V<T>,
        step_settings: &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>>,
    ) -> ActuatedStepJvp<
        Self::Q<T>,
        Self::V<T>,
        Self::PerActivation<T>,
        Self::V<T>,
        Self::PerTouchingPoint<Vector3<T>>,
        Self::PerActuatedState<T>,
        T,
        T,
    >
    where
        Self: functions::StepActuatedJvp,
    {
        Self::step_actuated_jvp_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            tangent_q,
            tangent_qd,
            ctrl,
            tangent_ctrl,
            dt,
            act,
            tangent_act,
            applied,
            warm_start,
            step_settings,
        )
    }

    /// Returns the joint forces of the accelerations `qdd`, the wrenches of the active contacts
    /// that carry the floating bases, and the rank of the contacts' columns of the bases. The
    /// wrenches have the smallest sum of (force^2 + (moment / l)^2) / weight with the
    /// characteristic length l of each contact. The joint forces of a base are the wrench on it
    /// that no contact can carry. The wrenches of loop constraints are zero.
    fn constrained_inverse_dynamics_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedInverseDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>
    where
        Self: functions::ConstrainedInverseDynamics,
    {
        const { not_generated() }
    }

    /// Calls [`constrained_inverse_dynamics_with`](Self::constrained_inverse_dynamics_with) with
    /// the default parameters.
    fn constrained_inverse_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> ConstrainedInverseDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>
    where
        Self: functions::ConstrainedInverseDynamics,
    {
        Self::constrained_inverse_dynamics_with(
            &Self::Params::<T>::default(),
            q,
            qd,
            qdd,
            active,
            settings,
        )
    }

    /// Returns the Jacobian of each constraint, an array of columns. The product with `qd` is, for
    /// a loop constraint, the constrained part of the twist of its second frame relative to its
    /// first, in the first frame's axes; for a contact, active or not, the constrained part of its
    /// frame's twist in world axes.
    fn constraint_jacobian<T: Scalar>(
        q: &Self::Q<T>,
    ) -> Self::PerConstraint<Self::PerVelocity<Twist<T>>>
    where
        Self: functions::ConstraintJacobian,
    {
        const { not_generated() }
    }

    /// Returns the bias acceleration of each constraint: the time derivative of
    /// `constraint_jacobian` times `qd`, in the same axes.
    fn constraint_jacobian_dot_qd<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Self::PerConstraint<Twist<T>>
    where
        Self: functions::ConstraintJacobianDotQd,
    {
        const { not_generated() }
    }

    /// Returns the Delassus matrix J M^-1 J^T of the constraints with the mass matrix M, its
    /// pseudo-inverse, the operational-space inertia, and the number of independent constraint
    /// rows. Both matrices are arrays of columns; each constraint has its constrained
    /// displacements, then its constrained rotations, of a contact in world axes. The entries of
    /// inactive contacts are zero. The Delassus matrix contains the compliance.
    #[doc(alias = "operational-space inertia")]
    #[doc(alias = "Delassus matrix")]
    fn operational_space_inertia_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> OperationalSpaceInertia<Self::PerConstraintRow<Self::PerConstraintRow<T>>, T>
    where
        Self: functions::OperationalSpaceInertia,
    {
        const { not_generated() }
    }

    /// Calls [`operational_space_inertia_with`](Self::operational_space_inertia_with) with the
    /// default parameters.
    #[doc(alias = "operational-space inertia")]
    #[doc(alias = "Delassus matrix")]
    fn operational_space_inertia<T: Scalar>(
        q: &Self::Q<T>,
        active: Self::Contacts,
        settings: &Settings<Self, T>,
    ) -> OperationalSpaceInertia<Self::PerConstraintRow<Self::PerConstraintRow<T>>, T>
    where
        Self: functions::OperationalSpaceInertia,
    {
        Self::operational_space_inertia_with(&Self::Params::<T>::default(), q, active, settings)
    }

    /// Returns the regressor Y of inverse dynamics, an array of columns: tau = Y pi, without
    /// armatures and friction. pi has ten entries for each moving link: mass, mass times centre of
    /// mass x, y, z, and Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in the link's own
    /// axes (`PARAMETERS`).
    #[doc(alias = "pin.computeJointTorqueRegressor")]
    fn regressor_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::Regressor<T>
    where
        Self: functions::Regressor,
    {
        const { not_generated() }
    }

    /// Calls [`regressor_with`](Self::regressor_with) with the default parameters.
    #[doc(alias = "pin.computeJointTorqueRegressor")]
    fn regressor<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, qdd: &Self::V<T>) -> Self::Regressor<T>
    where
        Self: functions::Regressor,
    {
        Self::regressor_with(&Self::Params::<T>::default(), q, qd, qdd)
    }

    /// Returns the centre of mass of the moving links in world axes, m.
    #[doc(alias = "pin.centerOfMass")]
    #[doc(alias = "subtree_com")]
    fn center_of_mass_with<T: Scalar>(params: &Self::Params<T>, q: &Self::Q<T>) -> [T; 3]
    where
        Self: functions::CenterOfMass,
    {
        const { not_generated() }
    }

    /// Calls [`center_of_mass_with`](Self::center_of_mass_with) with the default parameters.
    #[doc(alias = "pin.centerOfMass")]
    #[doc(alias = "subtree_com")]
    fn center_of_mass<T: Scalar>(q: &Self::Q<T>) -> [T; 3]
    where
        Self: functions::CenterOfMass,
    {
        Self::center_of_mass_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the Jacobian of the centre of mass, an array of columns. Its product with `qd` is
    /// the velocity of the centre of mass in world axes.
    #[doc(alias = "pin.jacobianCenterOfMass")]
    #[doc(alias = "mj_jacSubtreeCom")]
    fn center_of_mass_jacobian_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
    ) -> Self::PerVelocity<Vector3<T>>
    where
        Self: functions::CenterOfMassJacobian,
    {
        const { not_generated() }
    }

    /// Calls [`center_of_mass_jacobian_with`](Self::center_of_mass_jacobian_with) with the default
    /// parameters.
    #[doc(alias = "pin.jacobianCenterOfMass")]
    #[doc(alias = "mj_jacSubtreeCom")]
    fn center_of_mass_jacobian<T: Scalar>(q: &Self::Q<T>) -> Self::PerVelocity<Vector3<T>>
    where
        Self: functions::CenterOfMassJacobian,
    {
        Self::center_of_mass_jacobian_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the centroidal momentum matrix, an array of columns. Its product with `qd` is the
    /// momentum about the centre of mass, in world axes. Armatures have energy, but no momentum:
    /// their axes are not described.
    #[doc(alias = "CMM")]
    #[doc(alias = "pin.ccrba")]
    fn centroidal_momentum_matrix_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
    ) -> Self::PerVelocity<Momentum<T>>
    where
        Self: functions::CentroidalMomentumMatrix,
    {
        const { not_generated() }
    }

    /// Calls [`centroidal_momentum_matrix_with`](Self::centroidal_momentum_matrix_with) with the
    /// default parameters.
    #[doc(alias = "CMM")]
    #[doc(alias = "pin.ccrba")]
    fn centroidal_momentum_matrix<T: Scalar>(q: &Self::Q<T>) -> Self::PerVelocity<Momentum<T>>
    where
        Self: functions::CentroidalMomentumMatrix,
    {
        Self::centroidal_momentum_matrix_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the centroidal composite inertia, an array of columns. Its product with a twist is
    /// the momentum about the centre of mass, in world axes, of all moving links as one rigid body
    /// with this twist at the centre of mass.
    fn centroidal_composite_inertia_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
    ) -> [Momentum<T>; 6]
    where
        Self: functions::CentroidalCompositeInertia,
    {
        const { not_generated() }
    }

    /// Calls [`centroidal_composite_inertia_with`](Self::centroidal_composite_inertia_with) with
    /// the default parameters.
    fn centroidal_composite_inertia<T: Scalar>(q: &Self::Q<T>) -> [Momentum<T>; 6]
    where
        Self: functions::CentroidalCompositeInertia,
    {
        Self::centroidal_composite_inertia_with(&Self::Params::<T>::default(), q)
    }

    /// Returns the momentum of the moving links about their centre of mass, in world axes.
    /// Armatures have energy, but no momentum: their axes are not described.
    #[doc(alias = "pin.computeCentroidalMomentum")]
    fn centroidal_momentum_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Momentum<T>
    where
        Self: functions::CentroidalMomentum,
    {
        const { not_generated() }
    }

    /// Calls [`centroidal_momentum_with`](Self::centroidal_momentum_with) with the default
    /// parameters.
    #[doc(alias = "pin.computeCentroidalMomentum")]
    fn centroidal_momentum<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Momentum<T>
    where
        Self: functions::CentroidalMomentum,
    {
        Self::centroidal_momentum_with(&Self::Params::<T>::default(), q, qd)
    }

    /// Returns the time derivative of the centroidal momentum in world axes: the moment (N m) and
    /// the force (N) about the centre of mass of gravity and of all forces from outside. At `qdd` =
    /// 0 it is the bias A' qd, with the centroidal momentum matrix A.
    #[doc(alias = "pin.computeCentroidalMomentumTimeVariation")]
    fn centroidal_momentum_rate_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Momentum<T>
    where
        Self: functions::CentroidalMomentumRate,
    {
        const { not_generated() }
    }

    /// Calls [`centroidal_momentum_rate_with`](Self::centroidal_momentum_rate_with) with the
    /// default parameters.
    #[doc(alias = "pin.computeCentroidalMomentumTimeVariation")]
    fn centroidal_momentum_rate<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Momentum<T>
    where
        Self: functions::CentroidalMomentumRate,
    {
        Self::centroidal_momentum_rate_with(&Self::Params::<T>::default(), q, qd, qdd)
    }

    /// Returns the momentum of the moving links about their centre of mass, its time derivative at
    /// `qdd` (the rate), and the derivatives of both with respect to `q` (in tangent space) and
    /// `qd`, arrays of columns, in world axes. The derivatives of the momentum with respect to
    /// `qd`, and of the rate with respect to `qdd`, are the centroidal momentum matrix.
    #[doc(alias = "pin.computeCentroidalDynamicsDerivatives")]
    fn centroidal_momentum_derivatives_with<T: Scalar>(
        params: &Self::Params<T>,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> CentroidalMomentumDerivatives<Momentum<T>, Self::PerVelocity<Momentum<T>>>
    where
        Self: functions::CentroidalMomentumDerivatives,
    {
        const { not_generated() }
    }

    /// Calls [`centroidal_momentum_derivatives_with`](Self::centroidal_momentum_derivatives_with)
    /// with the default parameters.
    #[doc(alias = "pin.computeCentroidalDynamicsDerivatives")]
    fn centroidal_momentum_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> CentroidalMomentumDerivatives<Momentum<T>, Self::PerVelocity<Momentum<T>>>
    where
        Self: functions::CentroidalMomentumDerivatives,
    {
        Self::centroidal_momentum_derivatives_with(&Self::Params::<T>::default(), q, qd, qdd)
    }

    /// Returns the poses in the world of all links of the description, fixed links included, in the
    /// order of `LINK_NAMES`.
    #[doc(alias = "forward kinematics")]
    #[doc(alias = "pin.framesForwardKinematics")]
    #[doc(alias = "mj_kinematics")]
    fn link_poses<T: Scalar>(q: &Self::Q<T>) -> Self::PerLink<Pose<T>>
    where
        Self: functions::LinkPoses,
    {
        const { not_generated() }
    }

    /// Returns the pose of a link in the world. Computes the link's kinematic path only.
    #[doc(alias = "forward kinematics")]
    #[doc(alias = "pin.updateFramePlacement")]
    fn link_pose<T: Scalar>(q: &Self::Q<T>, link: Self::Link) -> Pose<T>
    where
        Self: functions::LinkPose,
    {
        const { not_generated() }
    }

    /// Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in world
    /// axes. Computes the link's kinematic path only.
    #[doc(alias = "pin.getFrameVelocity")]
    #[doc(alias = "mj_objectVelocity")]
    fn link_velocity<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, link: Self::Link) -> Twist<T>
    where
        Self: functions::LinkVelocity,
    {
        const { not_generated() }
    }

    /// Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in the
    /// link's own axes. Computes the link's kinematic path only.
    fn link_velocity_local<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, link: Self::Link) -> Twist<T>
    where
        Self: functions::LinkVelocityLocal,
    {
        const { not_generated() }
    }

    /// Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
    /// (rad/s^2), in world axes. Gravity is not included. Computes the link's kinematic path only.
    #[doc(alias = "pin.getFrameClassicalAcceleration")]
    #[doc(alias = "mj_objectAcceleration")]
    fn link_acceleration<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T>
    where
        Self: functions::LinkAcceleration,
    {
        const { not_generated() }
    }

    /// Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
    /// (rad/s^2), in the link's own axes. Gravity is not included. Computes the link's kinematic
    /// path only.
    fn link_acceleration_local<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T>
    where
        Self: functions::LinkAccelerationLocal,
    {
        const { not_generated() }
    }

    /// Returns the Jacobian of a link, an array of columns. Its product with `qd` is the velocity
    /// of the link at its origin, in world axes. Computes the link's kinematic path only.
    #[doc(alias = "geometric Jacobian")]
    #[doc(alias = "pin.getFrameJacobian")]
    #[doc(alias = "mj_jacBody")]
    fn jacobian<T: Scalar>(q: &Self::Q<T>, link: Self::Link) -> Self::PerVelocity<Twist<T>>
    where
        Self: functions::Jacobian,
    {
        const { not_generated() }
    }

    /// Returns the Jacobian of a link, an array of columns. Its product with `qd` is the velocity
    /// of the link at its origin, in the link's own axes. Computes the link's kinematic path only.
    fn jacobian_local<T: Scalar>(q: &Self::Q<T>, link: Self::Link) -> Self::PerVelocity<Twist<T>>
    where
        Self: functions::JacobianLocal,
    {
        const { not_generated() }
    }

    /// Returns the time derivative of `jacobian`, an array of columns. Its product with `qd` is
    /// `jacobian_dot_qd`. Computes the link's kinematic path only.
    #[doc(alias = "pin.getFrameJacobianTimeVariation")]
    #[doc(alias = "mj_jacDot")]
    fn jacobian_time_derivative<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        link: Self::Link,
    ) -> Self::PerVelocity<Twist<T>>
    where
        Self: functions::JacobianTimeDerivative,
    {
        const { not_generated() }
    }

    /// Returns the time derivative of `jacobian_local`, an array of columns. Its product with `qd`
    /// is `jacobian_dot_qd_local`. Computes the link's kinematic path only.
    fn jacobian_time_derivative_local<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        link: Self::Link,
    ) -> Self::PerVelocity<Twist<T>>
    where
        Self: functions::JacobianTimeDerivativeLocal,
    {
        const { not_generated() }
    }

    /// Returns the bias acceleration of a link in world axes: the time derivative of `jacobian`
    /// times `qd`, which is the link's acceleration at zero joint accelerations. Computes the
    /// link's kinematic path only.
    #[doc(alias = "Jdot qd")]
    #[doc(alias = "drift acceleration")]
    fn jacobian_dot_qd<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, link: Self::Link) -> Twist<T>
    where
        Self: functions::JacobianDotQd,
    {
        const { not_generated() }
    }

    /// Returns the bias acceleration of a link in its own axes: the time derivative of
    /// `jacobian_local` times `qd`. Computes the link's kinematic path only.
    fn jacobian_dot_qd_local<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T>
    where
        Self: functions::JacobianDotQdLocal,
    {
        const { not_generated() }
    }

    /// Returns the coordinates after the displacement `v` (a velocity times a time) from `q`.
    #[doc(alias = "pin.integrate")]
    #[doc(alias = "mj_integratePos")]
    fn integrate<T: Scalar>(q: &Self::Q<T>, v: &Self::V<T>) -> Self::Q<T>
    where
        Self: functions::Integrate,
    {
        const { not_generated() }
    }

    /// Returns the displacement `v` with which `integrate` leads from `from` to `to`. Rotations are
    /// the shortest ones; joint angles are not wrapped.
    #[doc(alias = "pin.difference")]
    #[doc(alias = "mj_differentiatePos")]
    fn difference<T: Scalar>(from: &Self::Q<T>, to: &Self::Q<T>) -> Self::V<T>
    where
        Self: functions::Difference,
    {
        const { not_generated() }
    }

    /// Returns the derivatives of `integrate` with respect to `q` and `v`, each an array of columns
    /// in tangent space: displacements of `q` and of the result are in the axes at each of them.
    #[doc(alias = "pin.dIntegrate")]
    fn integrate_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        v: &Self::V<T>,
    ) -> IntegrateDerivatives<Self::M<T>>
    where
        Self: functions::IntegrateDerivatives,
    {
        const { not_generated() }
    }

    /// Returns the derivatives of `difference` with respect to `from` and `to`, each an array of
    /// columns in tangent space: displacements are in the axes at `from` and at `to`.
    #[doc(alias = "pin.dDifference")]
    fn difference_derivatives<T: Scalar>(
        from: &Self::Q<T>,
        to: &Self::Q<T>,
    ) -> DifferenceDerivatives<Self::M<T>>
    where
        Self: functions::DifferenceDerivatives,
    {
        const { not_generated() }
    }

    /// Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.
    fn velocity_to_qdot<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::Q<T>
    where
        Self: functions::VelocityToQdot,
    {
        const { not_generated() }
    }

    /// Returns the coordinates with quaternions scaled to length 1.
    #[doc(alias = "pin.normalize")]
    #[doc(alias = "mj_normalizeQuat")]
    fn normalize_configuration<T: Scalar>(q: &Self::Q<T>) -> Self::Q<T>
    where
        Self: functions::NormalizeConfiguration,
    {
        const { not_generated() }
    }

    /// Returns coordinates within the joint limits, from random numbers uniformly distributed in
    /// [0, 1). Angles without limits are in [-pi, pi), displacements without limits in [-1, 1) m,
    /// rotations uniform over SO(3).
    #[doc(alias = "pin.randomConfiguration")]
    fn random_configuration<T: Scalar>(uniforms: impl FnMut() -> T) -> Self::Q<T>
    where
        Self: functions::RandomConfiguration,
    {
        const { not_generated() }
    }
    // <!-- end -->

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
