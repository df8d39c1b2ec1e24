//! The table of the functions of a robot.
//!
//! A row has the function's documentation, its name and that of the form with run-time parameters, its
//! arguments, its result, and the trait of `modyn::functions` that robots with this function implement.

/// Passes the table to `$rows`, a macro that takes all rows.
macro_rules! robot_functions {
    ($rows:ident) => {
        $rows! {
            /// Returns the joint accelerations (rad/s^2 or m/s^2) under the joint forces `tau` (N m or N).
            forward_dynamics / forward_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>
            ) -> Self::V<T>, if ForwardDynamics;

            /// Returns the joint forces (N m or N) of the accelerations `qdd`.
            inverse_dynamics / inverse_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>
            ) -> Self::V<T>, if InverseDynamics;

            /// Returns the bias forces (N m or N): Coriolis, centrifugal and gravity forces, with damping and friction
            /// if these are enabled.
            bias_forces / bias_forces_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> Self::V<T>, if BiasForces;

            /// Returns the joint forces (N m or N) that balance gravity at zero velocity.
            gravity_torques / gravity_torques_with(q: &Self::Q<T>) -> Self::V<T>, if GravityTorques;

            /// Returns the mass matrix, nv x nv, an array of columns.
            mass_matrix / mass_matrix_with(q: &Self::Q<T>) -> Self::M<T>, if MassMatrix;

            /// Returns the Coriolis matrix C, nv x nv, an array of columns: C qd are the Coriolis and centrifugal forces,
            /// and dM/dt - 2 C is skew with the mass matrix M.
            coriolis_matrix / coriolis_matrix_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> Self::M<T>, if CoriolisMatrix;

            /// Returns the factorization U D U^T of the mass matrix by modules.
            brge / brge_with(q: &Self::Q<T>) -> Self::UduFactorization<T>, if Brge;

            /// Returns the kinetic energy, J.
            kinetic_energy / kinetic_energy_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> T, if KineticEnergy;

            /// Returns the potential energy under gravity, J; zero for mass at the world's origin.
            potential_energy / potential_energy_with(q: &Self::Q<T>) -> T, if PotentialEnergy;

            /// Returns the joint accelerations under the joint forces `tau` and a wrench on each link, at the link's
            /// origin in the link's own axes.
            forward_dynamics_external / forward_dynamics_external_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, if ForwardDynamicsExternal;

            /// Returns the joint accelerations under the joint forces `tau` and a wrench on each link, at the link's
            /// origin in world axes.
            forward_dynamics_external_world / forward_dynamics_external_world_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, if ForwardDynamicsExternalWorld;

            /// Returns the joint forces of the accelerations `qdd` under a wrench on each link, at the link's origin in
            /// the link's own axes.
            inverse_dynamics_external / inverse_dynamics_external_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, if InverseDynamicsExternal;

            /// Returns the joint forces of the accelerations `qdd` under a wrench on each link, at the link's origin in
            /// world axes.
            inverse_dynamics_external_world / inverse_dynamics_external_world_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, if InverseDynamicsExternalWorld;

            /// Returns the generalized forces J^T f of a wrench on each link, at the link's origin in the link's own
            /// axes, and their derivative with respect to `q` (in tangent space). The wrenches rotate with their links.
            generalized_forces(
                q: &Self::Q<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> GeneralizedForces<Self::V<T>, Self::M<T>>, if GeneralizedForces;

            /// Returns the generalized forces J^T f of a wrench on each link, at the link's origin in world axes, and
            /// their derivative with respect to `q` (in tangent space). The wrenches keep their directions.
            generalized_forces_world(
                q: &Self::Q<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> GeneralizedForces<Self::V<T>, Self::M<T>>, if GeneralizedForcesWorld;

            /// Returns the poses of all links in the world.
            link_poses(q: &Self::Q<T>) -> Self::PerLink<Pose<T>>, if LinkPoses;

            /// Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`.
            inverse_dynamics_derivatives / inverse_dynamics_derivatives_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>
            ) -> InverseDynamicsDerivatives<Self::M<T>>, if InverseDynamicsDerivatives;

            /// Returns the joint forces tau of the accelerations `qdd`, and the products of `cotangent` with their
            /// derivatives: the gradients of `cotangent`^T tau with respect to `q` (in tangent space), `qd` and `qdd`.
            inverse_dynamics_vjp / inverse_dynamics_vjp_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                cotangent: &Self::V<T>
            ) -> InverseDynamicsVjp<Self::V<T>>, if InverseDynamicsVjp;

            /// Returns the joint forces tau of the accelerations `qdd`, and their change under the changes `dq` (in
            /// tangent space), `dqd` and `dqdd`.
            inverse_dynamics_jvp / inverse_dynamics_jvp_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                dq: &Self::V<T>,
                dqd: &Self::V<T>,
                dqdd: &Self::V<T>
            ) -> InverseDynamicsJvp<Self::V<T>>, if InverseDynamicsJvp;

            /// Returns the accelerations qdd, and the products of `cotangent` with their derivatives: the gradients of
            /// `cotangent`^T qdd with respect to `q` (in tangent space), `qd` and `tau`.
            forward_dynamics_vjp / forward_dynamics_vjp_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                cotangent: &Self::V<T>
            ) -> ForwardDynamicsVjp<Self::V<T>>, if ForwardDynamicsVjp;

            /// Returns the accelerations qdd, and their change under the changes `dq` (in tangent space), `dqd` and
            /// `dtau`.
            forward_dynamics_jvp / forward_dynamics_jvp_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                dq: &Self::V<T>,
                dqd: &Self::V<T>,
                dtau: &Self::V<T>
            ) -> ForwardDynamicsJvp<Self::V<T>>, if ForwardDynamicsJvp;

            /// Returns the state after the time `dt` (s) under the joint forces `tau`, by the semi-implicit Euler method.
            step_semi_implicit / step_semi_implicit_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                dt: T
            ) -> Step<Self::Q<T>, Self::V<T>>, if StepSemiImplicit;

            /// Returns the state of [`step_semi_implicit`](Self::step_semi_implicit), and its derivatives A with respect
            /// to the state before the step (in tangent space) and B with respect to `tau`.
            step_semi_implicit_derivatives / step_semi_implicit_derivatives_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                dt: T
            ) -> LinearStep<Self, T>, if StepSemiImplicitDerivatives;

            /// Returns the state after the time `dt` (s) under the joint forces `tau`, by a Runge-Kutta method of fourth
            /// order.
            step_rk4 / step_rk4_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                dt: T
            ) -> Step<Self::Q<T>, Self::V<T>>, if StepRk4;

            /// Returns the accelerations, and the derivatives of forward dynamics with respect to `q` (in tangent
            /// space), `qd` and `tau`.
            forward_dynamics_derivatives / forward_dynamics_derivatives_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>
            ) -> ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>>, if ForwardDynamicsDerivatives;

            /// Returns the joint accelerations under the joint forces `tau` with the loops closed and the
            /// active contacts held; the wrench on each constraint's link; the unmet part of each constraint's
            /// acceleration; and the number of independent constraint rows. Wrenches and residuals of loop
            /// constraints are at the second frame's origin in the first frame's axes, of contacts at the
            /// frame's origin in world axes. Redundant rows get the multipliers of smallest norm.
            constrained_forward_dynamics / constrained_forward_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                contacts: Self::Contacts,
                settings: &Settings<Self, T>
            ) -> Constrained<Self, Self::V<T>, T>, if ConstrainedForwardDynamics;

            /// Returns the displacement and the velocity of each loop constraint's second frame relative to its
            /// first, in the first frame's axes; then of each contact's frame, active or not, relative to its
            /// target, in world axes. Components along free directions are zero. A rotation is its axis times
            /// the sine of its angle.
            constraint_residual(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                settings: &Settings<Self, T>
            ) -> ConstraintResidual<Self::PerConstraint<Twist<T>>>, if ConstraintResidual;

            /// Returns the smallest step (in the metric of the mass matrix) that closes the loops at `q` and
            /// moves the active contacts to their targets to first order, the smallest change of `qd` that
            /// keeps them there, and the number of independent constraint rows. The settings `alpha` and `beta`
            /// have no effect.
            project_constraints / project_constraints_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                contacts: Self::Contacts,
                settings: &Settings<Self, T>
            ) -> ConstraintProjection<Self::V<T>, T>, if ProjectConstraints;

            /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and their
            /// derivatives with respect to `q` (in tangent space), `qd` and `tau`. The rank is assumed
            /// constant; redundant rows get the derivatives of smallest norm.
            constrained_forward_dynamics_derivatives / constrained_forward_dynamics_derivatives_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                contacts: Self::Contacts,
                settings: &Settings<Self, T>
            ) -> ConstrainedDerivatives<Self, T>, if ConstrainedForwardDynamicsDerivatives;

            /// Returns the velocities after an impact that closes the loops and stops the active contacts
            /// relative to their targets at the same instant, the impulse of each constraint, and the number of
            /// independent constraint rows. Along its normal, a contact leaves with `restitution` times the
            /// speed before the impact.
            contact_impulse / contact_impulse_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                contacts: Self::Contacts,
                settings: &Settings<Self, T>
            ) -> ContactImpulse<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>, if ContactImpulse;

            /// Returns the joint forces of the accelerations `qdd`, and the wrenches of the active contacts
            /// that carry the floating bases: those with the smallest weighted norm. The joint forces of a base
            /// are the wrench on it that no contact can carry.
            constrained_inverse_dynamics / constrained_inverse_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                contacts: Self::Contacts,
                settings: &Settings<Self, T>
            ) -> ConstrainedInverseDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>, if ConstrainedInverseDynamics;

            /// Returns the Jacobian of each constraint, an array of columns. The product with `qd` is, for a
            /// loop constraint, the constrained part of the twist of its second frame relative to its first, in
            /// the first frame's axes; for a contact, active or not, the constrained part of its frame's twist
            /// in world axes.
            constraint_jacobian(
                q: &Self::Q<T>
            ) -> Self::PerConstraint<Self::PerVelocity<Twist<T>>>, if ConstraintJacobian;

            /// Returns the bias acceleration of each constraint: the time derivative of `constraint_jacobian`
            /// times `qd`, in the same axes.
            constraint_bias_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> Self::PerConstraint<Twist<T>>, if ConstraintBiasAcceleration;

            /// Returns the operational-space inertia of the constraints and its inverse J I^-1 J^T, arrays of
            /// columns. Each constraint has its constrained rotations, then its constrained displacements, of a
            /// contact in world axes. The entries of inactive contacts are zero.
            operational_inertia / operational_inertia_with(
                q: &Self::Q<T>,
                contacts: Self::Contacts,
                settings: &Settings<Self, T>
            ) -> OperationalInertia<Self::PerConstraintRow<Self::PerConstraintRow<T>>, T>, if OperationalInertia;

            /// Returns the regressor Y of inverse dynamics, an array of columns: tau = Y pi, without rotors and
            /// friction. pi has ten entries for each moving link: mass, mass times centre of mass x, y, z, and
            /// Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in the link's own axes.
            regressor / regressor_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>
            ) -> Self::Regressor<T>, if Regressor;

            /// Returns the centre of mass of the moving links in world axes, m.
            center_of_mass / center_of_mass_with(q: &Self::Q<T>) -> [T; 3], if CenterOfMass;

            /// Returns the Jacobian of the centre of mass, an array of columns: its product with `qd` is the velocity of
            /// the centre of mass in world axes.
            center_of_mass_jacobian / center_of_mass_jacobian_with(
                q: &Self::Q<T>
            ) -> Self::PerVelocity<Vector3<T>>, if CenterOfMassJacobian;

            /// Returns the centroidal momentum matrix, an array of columns: its product with `qd` is the momentum about
            /// the centre of mass, in world axes.
            centroidal_momentum_matrix / centroidal_momentum_matrix_with(
                q: &Self::Q<T>
            ) -> Self::PerVelocity<Momentum<T>>, if CentroidalMomentumMatrix;

            /// Returns the momentum about the centre of mass, in world axes.
            centroidal_momentum / centroidal_momentum_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> Momentum<T>, if CentroidalMomentum;

            /// Returns the pose of a link in the world.
            link_pose(q: &Self::Q<T>, link: Self::Link) -> Pose<T>, if LinkPose;

            /// Returns the velocity of a link at its origin, in world axes.
            link_velocity(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, if LinkVelocity;

            /// Returns the velocity of a link at its origin, in the link's own axes.
            local_link_velocity(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, if LocalLinkVelocity;

            /// Returns the angular acceleration of a link and the classical acceleration of its origin, in world axes.
            /// Gravity is not included.
            link_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, if LinkAcceleration;

            /// Returns the angular acceleration of a link and the classical acceleration of its origin, in the link's
            /// own axes. Gravity is not included.
            local_link_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, if LocalLinkAcceleration;

            /// Returns the Jacobian of a link at its origin in world axes, an array of columns: its product with `qd` is
            /// [`link_velocity`](Self::link_velocity).
            jacobian(q: &Self::Q<T>, link: Self::Link) -> Self::PerVelocity<Twist<T>>, if Jacobian;

            /// Returns the Jacobian of a link at its origin in the link's own axes, an array of columns: its product
            /// with `qd` is [`local_link_velocity`](Self::local_link_velocity).
            local_jacobian(
                q: &Self::Q<T>,
                link: Self::Link
            ) -> Self::PerVelocity<Twist<T>>, if LocalJacobian;

            /// Returns the time derivative of [`jacobian`](Self::jacobian), an array of columns: its product with `qd` is
            /// [`bias_acceleration`](Self::bias_acceleration).
            jacobian_time_derivative(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Self::PerVelocity<Twist<T>>, if JacobianTimeDerivative;

            /// Returns the time derivative of [`local_jacobian`](Self::local_jacobian), an array of columns: its product
            /// with `qd` is [`local_bias_acceleration`](Self::local_bias_acceleration).
            local_jacobian_time_derivative(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Self::PerVelocity<Twist<T>>, if LocalJacobianTimeDerivative;

            /// Returns the bias acceleration of a link in world axes, the time derivative of
            /// [`jacobian`](Self::jacobian) times `qd`: its acceleration at zero joint accelerations.
            bias_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, if BiasAcceleration;

            /// Returns the bias acceleration of a link in its own axes, the time derivative of
            /// [`local_jacobian`](Self::local_jacobian) times `qd`.
            local_bias_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, if LocalBiasAcceleration;

            /// Returns the coordinates after the displacement `v` (a velocity times a time) from `q`.
            integrate(q: &Self::Q<T>, v: &Self::V<T>) -> Self::Q<T>, if Integrate;

            /// Returns the displacement `v` with which [`integrate`](Self::integrate) leads from `from` to `to`.
            difference(from: &Self::Q<T>, to: &Self::Q<T>) -> Self::V<T>, if Difference;

            /// Returns the derivatives of [`integrate`](Self::integrate) with respect to `q` and `v`, in tangent space:
            /// displacements of `q` and of the result are in the axes at each of them.
            integrate_derivatives(
                q: &Self::Q<T>,
                v: &Self::V<T>
            ) -> IntegrateDerivatives<Self::M<T>>, if IntegrateDerivatives;

            /// Returns the derivatives of [`difference`](Self::difference) with respect to `from` and `to`, in tangent
            /// space: displacements are in the axes at `from` and at `to`.
            difference_derivatives(
                from: &Self::Q<T>,
                to: &Self::Q<T>
            ) -> DifferenceDerivatives<Self::M<T>>, if DifferenceDerivatives;

            /// Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.
            velocity_to_qdot(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::Q<T>, if VelocityToQdot;

            /// Returns the coordinates with quaternions scaled to length 1.
            normalize(q: &Self::Q<T>) -> Self::Q<T>, if Normalize;

            /// Returns coordinates within the joint limits, from random numbers uniformly distributed in [0, 1). Angles
            /// without limits are in [-pi, pi), displacements without limits in [-1, 1) m, rotations uniform over SO(3).
            random(uniform: impl FnMut() -> T) -> Self::Q<T>, if Random;
        }
    };
}

/// Declares the functions of the trait; each requires the trait of robots that have it. A row with two names is
/// two functions, one with run-time parameters and one with the default parameters.
macro_rules! declare_functions {
    () => {};
    (
        $(#[$documentation:meta])*
        $name:ident / $with:ident($($argument:ident: $of:ty),*) -> $result:ty, if $function:ident;
        $($rows:tt)*
    ) => {
        $(#[$documentation])*
        fn $with<T: Scalar>(params: &Self::Params<T>, $($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            missing!(params, $($argument),*)
        }

        #[doc = concat!("Calls [`", stringify!($with), "`](Self::", stringify!($with), ") with the default parameters.")]
        fn $name<T: Scalar>($($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            Self::$with(&Self::Params::<T>::default(), $($argument),*)
        }

        declare_functions! { $($rows)* }
    };
    (
        $(#[$documentation:meta])*
        $name:ident($($argument:ident: $of:ty),*) -> $result:ty, if $function:ident;
        $($rows:tt)*
    ) => {
        $(#[$documentation])*
        fn $name<T: Scalar>($($argument: $of),*) -> $result
        where
            Self: crate::functions::$function,
        {
            missing!($($argument),*)
        }

        declare_functions! { $($rows)* }
    };
}

/// The body of a function that a robot does not have. Its bound prevents calls.
macro_rules! missing {
    ($($argument:ident),*) => {{
        $(let _ = $argument;)*
        const { panic!("a trait of `modyn::functions` is implemented for a robot without that function") }
    }};
}

pub(super) use {declare_functions, missing, robot_functions};
