//! What every generated robot offers, for code that is written once for all of them.

use core::convert::Infallible;
use core::marker::PhantomData;

use crate::Scalar;
use crate::figures::{
    ClosingStep, ClosureErrors, ClosureSettings, ConstrainedForwardDynamics,
    ForwardDynamicsDerivatives, InverseDynamicsDerivatives, JointLimits, KinematicModule,
};
use crate::spatial::{Momentum, Pose, Twist, Vector3, Wrench};

/// A fixed number of scalars: `[T; N]`, where N cannot be named.
pub trait Array<T>: Copy + AsRef<[T]> + AsMut<[T]> {
    /// How many.
    const LEN: usize;

    /// Entry i is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> T) -> Self;
}

impl<T: Copy, const N: usize> Array<T> for [T; N] {
    const LEN: usize = N;

    fn from_fn(f: impl FnMut(usize) -> T) -> Self {
        core::array::from_fn(f)
    }
}

/// Stops compilation where a function is called that a robot was not given.
macro_rules! missing {
    ($function:ident: $($argument:ident),*) => {{
        $(let _ = $argument;)*
        const {
            panic!(concat!(
                "this robot was compiled without `",
                stringify!($function),
                "`: add it to its option `functions`"
            ))
        }
    }};
}

/// The same where only robots with loops have the function.
macro_rules! no_loops {
    ($function:ident: $($argument:ident),*) => {{
        $(let _ = $argument;)*
        const {
            panic!(concat!(
                "this robot was compiled without `",
                stringify!($function),
                "`: it has no loops (`<loop_joint>` or option `loops`), or its option `functions` leaves it out"
            ))
        }
    }};
}

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

    /// Joint accelerations under the joint torques `tau`.
    fn forward_dynamics_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> Self::V<T> {
        missing!(forward_dynamics: params, q, qd, tau)
    }

    /// [`forward_dynamics_with`](Self::forward_dynamics_with) the default parameters.
    fn forward_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> Self::V<T> {
        Self::forward_dynamics_with(&Self::Params::default(), q, qd, tau)
    }

    /// Joint torques of the accelerations `qdd`.
    fn inverse_dynamics_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::V<T> {
        missing!(inverse_dynamics: params, q, qd, qdd)
    }

    /// [`inverse_dynamics_with`](Self::inverse_dynamics_with) the default parameters.
    fn inverse_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::V<T> {
        Self::inverse_dynamics_with(&Self::Params::default(), q, qd, qdd)
    }

    /// Coriolis, centrifugal and gravity torques (damping and friction too, where they act).
    fn bias_forces_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Self::V<T> {
        missing!(bias_forces: params, q, qd)
    }

    /// [`bias_forces_with`](Self::bias_forces_with) the default parameters.
    fn bias_forces<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::V<T> {
        Self::bias_forces_with(&Self::Params::default(), q, qd)
    }

    /// Joint torques that hold the robot still.
    fn gravity_torques_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Self::V<T> {
        missing!(gravity_torques: params, q)
    }

    /// [`gravity_torques_with`](Self::gravity_torques_with) the default parameters.
    fn gravity_torques<T: Scalar>(q: &Self::Q<T>) -> Self::V<T> {
        Self::gravity_torques_with(&Self::Params::default(), q)
    }

    /// The generalized inertia matrix.
    fn mass_matrix_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Self::M<T> {
        missing!(mass_matrix: params, q)
    }

    /// [`mass_matrix_with`](Self::mass_matrix_with) the default parameters.
    fn mass_matrix<T: Scalar>(q: &Self::Q<T>) -> Self::M<T> {
        Self::mass_matrix_with(&Self::Params::default(), q)
    }

    /// The generalized inertia matrix as U D U^T by modules.
    fn brge_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Self::Brge<T> {
        missing!(brge: params, q)
    }

    /// [`brge_with`](Self::brge_with) the default parameters.
    fn brge<T: Scalar>(q: &Self::Q<T>) -> Self::Brge<T> {
        Self::brge_with(&Self::Params::default(), q)
    }

    /// Kinetic energy, J.
    fn kinetic_energy_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>, qd: &Self::V<T>) -> T {
        missing!(kinetic_energy: params, q, qd)
    }

    /// [`kinetic_energy_with`](Self::kinetic_energy_with) the default parameters.
    fn kinetic_energy<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> T {
        Self::kinetic_energy_with(&Self::Params::default(), q, qd)
    }

    /// Potential energy under gravity, J; zero at the world's origin.
    fn potential_energy_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> T {
        missing!(potential_energy: params, q)
    }

    /// [`potential_energy_with`](Self::potential_energy_with) the default parameters.
    fn potential_energy<T: Scalar>(q: &Self::Q<T>) -> T {
        Self::potential_energy_with(&Self::Params::default(), q)
    }

    /// Joint accelerations under the joint torques `tau` and a wrench on each link, at the link's
    /// origin in its own axes.
    fn forward_dynamics_external_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        missing!(forward_dynamics_external: params, q, qd, tau, forces)
    }

    /// [`forward_dynamics_external_with`](Self::forward_dynamics_external_with) the default parameters.
    fn forward_dynamics_external<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        Self::forward_dynamics_external_with(&Self::Params::default(), q, qd, tau, forces)
    }

    /// Joint accelerations under the joint torques `tau` and a wrench on each link, at the link's
    /// origin in the world's axes.
    fn forward_dynamics_external_world_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        missing!(forward_dynamics_external_world: params, q, qd, tau, forces)
    }

    /// [`forward_dynamics_external_world_with`](Self::forward_dynamics_external_world_with) the default parameters.
    fn forward_dynamics_external_world<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        Self::forward_dynamics_external_world_with(&Self::Params::default(), q, qd, tau, forces)
    }

    /// Joint torques of the accelerations `qdd` under a wrench on each link, at the link's origin in
    /// its own axes.
    fn inverse_dynamics_external_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        missing!(inverse_dynamics_external: params, q, qd, qdd, forces)
    }

    /// [`inverse_dynamics_external_with`](Self::inverse_dynamics_external_with) the default parameters.
    fn inverse_dynamics_external<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        Self::inverse_dynamics_external_with(&Self::Params::default(), q, qd, qdd, forces)
    }

    /// Joint torques of the accelerations `qdd` under a wrench on each link, at the link's origin in
    /// the world's axes.
    fn inverse_dynamics_external_world_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        missing!(inverse_dynamics_external_world: params, q, qd, qdd, forces)
    }

    /// [`inverse_dynamics_external_world_with`](Self::inverse_dynamics_external_world_with) the default parameters.
    fn inverse_dynamics_external_world<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        forces: &Self::PerLink<Wrench<T>>,
    ) -> Self::V<T> {
        Self::inverse_dynamics_external_world_with(&Self::Params::default(), q, qd, qdd, forces)
    }

    /// The poses of all links in the world.
    fn link_poses<T: Scalar>(q: &Self::Q<T>) -> Self::PerLink<Pose<T>> {
        missing!(link_poses: q)
    }

    /// The derivatives of the inverse dynamics; with respect to `q` in tangent space.
    fn inverse_dynamics_derivatives_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> InverseDynamicsDerivatives<Self::M<T>> {
        missing!(inverse_dynamics_derivatives: params, q, qd, qdd)
    }

    /// [`inverse_dynamics_derivatives_with`](Self::inverse_dynamics_derivatives_with) the default parameters.
    fn inverse_dynamics_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> InverseDynamicsDerivatives<Self::M<T>> {
        Self::inverse_dynamics_derivatives_with(&Self::Params::default(), q, qd, qdd)
    }

    /// The derivatives of the forward dynamics; with respect to `q` in tangent space.
    fn forward_dynamics_derivatives_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>> {
        missing!(forward_dynamics_derivatives: params, q, qd, tau)
    }

    /// [`forward_dynamics_derivatives_with`](Self::forward_dynamics_derivatives_with) the default parameters.
    fn forward_dynamics_derivatives<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
    ) -> ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>> {
        Self::forward_dynamics_derivatives_with(&Self::Params::default(), q, qd, tau)
    }

    /// Joint accelerations under the joint torques `tau` with the loops closed, and what closes each
    /// of them: the wrench on its second link at the second frame's origin, in the first frame's axes.
    /// Of redundant constraints the first have all forces.
    fn constrained_forward_dynamics_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        settings: &ClosureSettings<T>,
    ) -> ConstrainedForwardDynamics<Self::V<T>, Self::PerClosure<Wrench<T>>> {
        no_loops!(constrained_forward_dynamics: params, q, qd, tau, settings)
    }

    /// [`constrained_forward_dynamics_with`](Self::constrained_forward_dynamics_with) the default parameters.
    fn constrained_forward_dynamics<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        tau: &Self::V<T>,
        settings: &ClosureSettings<T>,
    ) -> ConstrainedForwardDynamics<Self::V<T>, Self::PerClosure<Wrench<T>>> {
        Self::constrained_forward_dynamics_with(&Self::Params::default(), q, qd, tau, settings)
    }

    /// How far the frames of each closure are apart, and how fast they part: the second frame against
    /// the first, in the first one's axes, without what is free. Rotations are given by their axes
    /// times the sines of their angles.
    fn closure_errors<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> ClosureErrors<Self::PerClosure<Twist<T>>> {
        no_loops!(closure_errors: q, qd)
    }

    /// The smallest step (in the metric of the inertia matrix) that, to first order, closes the loops
    /// at `q`, and the smallest change of `qd` that keeps them closed. Of `settings` the tolerance
    /// alone matters.
    fn closing_step_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        settings: &ClosureSettings<T>,
    ) -> ClosingStep<Self::V<T>> {
        no_loops!(closing_step: params, q, qd, settings)
    }

    /// [`closing_step_with`](Self::closing_step_with) the default parameters.
    fn closing_step<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        settings: &ClosureSettings<T>,
    ) -> ClosingStep<Self::V<T>> {
        Self::closing_step_with(&Self::Params::default(), q, qd, settings)
    }

    /// The regressor Y of the inverse dynamics, an array of columns: tau = Y pi (rotors and friction
    /// apart), where pi holds ten numbers a moving link: mass, mass times centre of mass x, y, z, and
    /// Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in its own axes.
    fn regressor_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::Regressor<T> {
        missing!(regressor: params, q, qd, qdd)
    }

    /// [`regressor_with`](Self::regressor_with) the default parameters.
    fn regressor<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
    ) -> Self::Regressor<T> {
        Self::regressor_with(&Self::Params::default(), q, qd, qdd)
    }

    /// The centre of mass of the moving links in the world, m.
    fn center_of_mass_with<T: Scalar>(params: &Self::Params, q: &Self::Q<T>) -> Vector3<T> {
        missing!(center_of_mass: params, q)
    }

    /// [`center_of_mass_with`](Self::center_of_mass_with) the default parameters.
    fn center_of_mass<T: Scalar>(q: &Self::Q<T>) -> Vector3<T> {
        Self::center_of_mass_with(&Self::Params::default(), q)
    }

    /// The derivative of the centre of mass: its velocity is this times `qd`. An array of columns.
    fn center_of_mass_jacobian_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
    ) -> Self::PerVelocity<Vector3<T>> {
        missing!(center_of_mass_jacobian: params, q)
    }

    /// [`center_of_mass_jacobian_with`](Self::center_of_mass_jacobian_with) the default parameters.
    fn center_of_mass_jacobian<T: Scalar>(q: &Self::Q<T>) -> Self::PerVelocity<Vector3<T>> {
        Self::center_of_mass_jacobian_with(&Self::Params::default(), q)
    }

    /// The centroidal momentum matrix, an array of columns: this times `qd` is the momentum about the
    /// centre of mass, in world axes.
    fn centroidal_momentum_matrix_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
    ) -> Self::PerVelocity<Momentum<T>> {
        missing!(centroidal_momentum_matrix: params, q)
    }

    /// [`centroidal_momentum_matrix_with`](Self::centroidal_momentum_matrix_with) the default parameters.
    fn centroidal_momentum_matrix<T: Scalar>(q: &Self::Q<T>) -> Self::PerVelocity<Momentum<T>> {
        Self::centroidal_momentum_matrix_with(&Self::Params::default(), q)
    }

    /// The momentum about the centre of mass, in world axes.
    fn centroidal_momentum_with<T: Scalar>(
        params: &Self::Params,
        q: &Self::Q<T>,
        qd: &Self::V<T>,
    ) -> Momentum<T> {
        missing!(centroidal_momentum: params, q, qd)
    }

    /// [`centroidal_momentum_with`](Self::centroidal_momentum_with) the default parameters.
    fn centroidal_momentum<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Momentum<T> {
        Self::centroidal_momentum_with(&Self::Params::default(), q, qd)
    }

    /// The pose of a link in the world.
    fn link_pose<T: Scalar>(q: &Self::Q<T>, link: Self::Link) -> Pose<T> {
        missing!(link_pose: q, link)
    }

    /// The velocity of a link's origin and its angular velocity, in world axes.
    fn link_velocity<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, link: Self::Link) -> Twist<T> {
        missing!(link_velocity: q, qd, link)
    }

    /// The same in the link's own axes.
    fn local_link_velocity<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T> {
        missing!(local_link_velocity: q, qd, link)
    }

    /// The (classical) acceleration of a link's origin, gravity left out, and its angular
    /// acceleration, in world axes.
    fn link_acceleration<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T> {
        missing!(link_acceleration: q, qd, qdd, link)
    }

    /// The same in the link's own axes.
    fn local_link_acceleration<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        qdd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T> {
        missing!(local_link_acceleration: q, qd, qdd, link)
    }

    /// A link's Jacobian, an array of columns: this times `qd` is
    /// [`link_velocity`](Self::link_velocity).
    fn jacobian<T: Scalar>(q: &Self::Q<T>, link: Self::Link) -> Self::PerVelocity<Twist<T>> {
        missing!(jacobian: q, link)
    }

    /// The same in the link's own axes.
    fn local_jacobian<T: Scalar>(q: &Self::Q<T>, link: Self::Link) -> Self::PerVelocity<Twist<T>> {
        missing!(local_jacobian: q, link)
    }

    /// The time derivative of [`jacobian`](Self::jacobian), times `qd`: the link's (classical)
    /// acceleration without joint accelerations.
    fn jacobian_rate<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>, link: Self::Link) -> Twist<T> {
        missing!(jacobian_rate: q, qd, link)
    }

    /// The time derivative of [`local_jacobian`](Self::local_jacobian), times `qd`: the rates of the
    /// velocity's components in the link's own axes.
    fn local_jacobian_rate<T: Scalar>(
        q: &Self::Q<T>,
        qd: &Self::V<T>,
        link: Self::Link,
    ) -> Twist<T> {
        missing!(local_jacobian_rate: q, qd, link)
    }

    /// The coordinates behind a displacement `v` (a velocity times a time) from `q`.
    fn integrate<T: Scalar>(q: &Self::Q<T>, v: &Self::V<T>) -> Self::Q<T> {
        missing!(integrate: q, v)
    }

    /// The displacement that [leads](Self::integrate) from one to the other.
    fn difference<T: Scalar>(from: &Self::Q<T>, to: &Self::Q<T>) -> Self::V<T> {
        missing!(difference: from, to)
    }

    /// The rates of the coordinates: dq/dt.
    fn coordinate_rates<T: Scalar>(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::Q<T> {
        missing!(coordinate_rates: q, qd)
    }

    /// The same coordinates, quaternions of unit length.
    fn normalize<T: Scalar>(q: &Self::Q<T>) -> Self::Q<T> {
        missing!(normalize: q)
    }

    /// Coordinates with every joint at zero, and quaternions of no rotation.
    #[must_use]
    fn neutral<T: Scalar>() -> Self::Q<T>;

    /// Coordinates within the joints' limits from numbers in [0, 1), evenly spread: angles without
    /// limits in [-pi, pi), displacements without limits in [-1, 1), rotations of any direction.
    fn random<T: Scalar>(uniform: impl FnMut() -> T) -> Self::Q<T> {
        missing!(random: uniform)
    }
}

/// The factorization I = U D U^T of a generalized inertia matrix by kinematic modules, (35)-(57).
pub trait Factorization<T: Scalar> {
    /// Joint vectors.
    type V;
    /// Matrices, an array of columns.
    type M;

    /// The block upper triangular U, (43).
    fn u(&self) -> Self::M;
    /// The block diagonal D, (45).
    fn d(&self) -> Self::M;
    /// U^-1, (54).
    fn u_inverse(&self) -> Self::M;
    /// D^-1, (54).
    fn d_inverse(&self) -> Self::M;
    /// The x with I x = `rhs`, by the three steps of (60).
    fn solve(&self, rhs: &Self::V) -> Self::V;
    /// The inverse, (50).
    fn inverse(&self) -> Self::M;
    /// The natural logarithm of the determinant.
    fn log_determinant(&self) -> T;
    /// The condition number (2-norm) of module `module`'s pivot block; `None` if there is none.
    fn condition_number(&self, module: usize) -> Option<T>;
}

/// In place of a factorization that a robot was not given; there is no value of it.
#[derive(Clone, Copy, Debug)]
pub struct NotGenerated<V, M>(Infallible, PhantomData<(V, M)>);

impl<T: Scalar, V, M> Factorization<T> for NotGenerated<V, M> {
    type V = V;
    type M = M;
    fn u(&self) -> M {
        match self.0 {}
    }
    fn d(&self) -> M {
        match self.0 {}
    }
    fn u_inverse(&self) -> M {
        match self.0 {}
    }
    fn d_inverse(&self) -> M {
        match self.0 {}
    }
    fn solve(&self, _: &V) -> V {
        match self.0 {}
    }
    fn inverse(&self) -> M {
        match self.0 {}
    }
    fn log_determinant(&self) -> T {
        match self.0 {}
    }
    fn condition_number(&self, _: usize) -> Option<T> {
        match self.0 {}
    }
}
