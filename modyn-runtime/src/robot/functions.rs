//! The table of the functions of a robot.
//!
//! A row is the function's documentation, its name (and that of the form that takes run-time
//! parameters), its arguments, its result, and the message of the compile error where a robot was
//! compiled without it.

/// Passes the table on to `$row`, a macro that takes all rows.
macro_rules! robot_functions {
    ($rows:ident) => {
        $rows! {
            /// Joint accelerations under the joint torques `tau`.
            forward_dynamics / forward_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>
            ) -> Self::V<T>, else missing;

            /// Joint torques of the accelerations `qdd`.
            inverse_dynamics / inverse_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>
            ) -> Self::V<T>, else missing;

            /// Coriolis, centrifugal and gravity torques (damping and friction too, where they act).
            bias_forces / bias_forces_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> Self::V<T>, else missing;

            /// Joint torques that hold the robot still.
            gravity_torques / gravity_torques_with(q: &Self::Q<T>) -> Self::V<T>, else missing;

            /// The mass matrix.
            mass_matrix / mass_matrix_with(q: &Self::Q<T>) -> Self::M<T>, else missing;

            /// The mass matrix as U D U^T by modules.
            brge / brge_with(q: &Self::Q<T>) -> Self::Brge<T>, else missing;

            /// Kinetic energy, J.
            kinetic_energy / kinetic_energy_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> T, else missing;

            /// Potential energy under gravity, J; zero at the world's origin.
            potential_energy / potential_energy_with(q: &Self::Q<T>) -> T, else missing;

            /// Joint accelerations under the joint torques `tau` and a wrench on each link, at the link's
            /// origin in its own axes.
            forward_dynamics_external / forward_dynamics_external_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, else missing;

            /// Joint accelerations under the joint torques `tau` and a wrench on each link, at the link's
            /// origin in the world's axes.
            forward_dynamics_external_world / forward_dynamics_external_world_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, else missing;

            /// Joint torques of the accelerations `qdd` under a wrench on each link, at the link's origin in
            /// its own axes.
            inverse_dynamics_external / inverse_dynamics_external_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, else missing;

            /// Joint torques of the accelerations `qdd` under a wrench on each link, at the link's origin in
            /// the world's axes.
            inverse_dynamics_external_world / inverse_dynamics_external_world_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                forces: &Self::PerLink<Wrench<T>>
            ) -> Self::V<T>, else missing;

            /// The poses of all links in the world.
            link_poses(q: &Self::Q<T>) -> Self::PerLink<Pose<T>>, else missing;

            /// The derivatives of the inverse dynamics; with respect to `q` in tangent space.
            inverse_dynamics_derivatives / inverse_dynamics_derivatives_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>
            ) -> InverseDynamicsDerivatives<Self::M<T>>, else missing;

            /// The derivatives of the forward dynamics; with respect to `q` in tangent space.
            forward_dynamics_derivatives / forward_dynamics_derivatives_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>
            ) -> ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>>, else missing;

            /// Joint accelerations under the joint torques `tau` with the loops closed, and what closes each
            /// of them: the wrench on its second link at the second frame's origin, in the first frame's axes.
            /// Of redundant constraints the first have all forces.
            constrained_forward_dynamics / constrained_forward_dynamics_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                tau: &Self::V<T>,
                settings: &ClosureSettings<T>
            ) -> ConstrainedForwardDynamics<Self::V<T>, Self::PerClosure<Wrench<T>>>, else no_loops;

            /// How far the frames of each closure are apart, and how fast they part: the second frame against
            /// the first, in the first one's axes, without what is free. Rotations are given by their axes
            /// times the sines of their angles.
            closure_errors(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> ClosureErrors<Self::PerClosure<Twist<T>>>, else no_loops;

            /// The smallest step (in the metric of the inertia matrix) that, to first order, closes the loops
            /// at `q`, and the smallest change of `qd` that keeps them closed. Of `settings` the tolerance
            /// alone matters.
            closing_step / closing_step_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                settings: &ClosureSettings<T>
            ) -> ClosingStep<Self::V<T>>, else no_loops;

            /// The regressor Y of the inverse dynamics, an array of columns: tau = Y pi (rotors and friction
            /// apart), where pi holds ten numbers a moving link: mass, mass times centre of mass x, y, z, and
            /// Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in its own axes.
            regressor / regressor_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>
            ) -> Self::Regressor<T>, else missing;

            /// The centre of mass of the moving links in the world, m.
            center_of_mass / center_of_mass_with(q: &Self::Q<T>) -> Vector3<T>, else missing;

            /// The derivative of the centre of mass: its velocity is this times `qd`. An array of columns.
            center_of_mass_jacobian / center_of_mass_jacobian_with(
                q: &Self::Q<T>
            ) -> Self::PerVelocity<Vector3<T>>, else missing;

            /// The centroidal momentum matrix, an array of columns: this times `qd` is the momentum about the
            /// centre of mass, in world axes.
            centroidal_momentum_matrix / centroidal_momentum_matrix_with(
                q: &Self::Q<T>
            ) -> Self::PerVelocity<Momentum<T>>, else missing;

            /// The momentum about the centre of mass, in world axes.
            centroidal_momentum / centroidal_momentum_with(
                q: &Self::Q<T>,
                qd: &Self::V<T>
            ) -> Momentum<T>, else missing;

            /// The pose of a link in the world.
            link_pose(q: &Self::Q<T>, link: Self::Link) -> Pose<T>, else missing;

            /// The velocity of a link's origin and its angular velocity, in world axes.
            link_velocity(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, else missing;

            /// The same in the link's own axes.
            local_link_velocity(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, else missing;

            /// The (classical) acceleration of a link's origin, gravity left out, and its angular
            /// acceleration, in world axes.
            link_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, else missing;

            /// The same in the link's own axes.
            local_link_acceleration(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                qdd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, else missing;

            /// A link's Jacobian, an array of columns: this times `qd` is
            /// [`link_velocity`](Self::link_velocity).
            jacobian(q: &Self::Q<T>, link: Self::Link) -> Self::PerVelocity<Twist<T>>, else missing;

            /// The same in the link's own axes.
            local_jacobian(
                q: &Self::Q<T>,
                link: Self::Link
            ) -> Self::PerVelocity<Twist<T>>, else missing;

            /// The time derivative of [`jacobian`](Self::jacobian), times `qd`: the link's (classical)
            /// acceleration without joint accelerations.
            jacobian_rate(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, else missing;

            /// The time derivative of [`local_jacobian`](Self::local_jacobian), times `qd`: the rates of the
            /// velocity's components in the link's own axes.
            local_jacobian_rate(
                q: &Self::Q<T>,
                qd: &Self::V<T>,
                link: Self::Link
            ) -> Twist<T>, else missing;

            /// The coordinates behind a displacement `v` (a velocity times a time) from `q`.
            integrate(q: &Self::Q<T>, v: &Self::V<T>) -> Self::Q<T>, else missing;

            /// The displacement that [leads](Self::integrate) from one to the other.
            difference(from: &Self::Q<T>, to: &Self::Q<T>) -> Self::V<T>, else missing;

            /// The rates of the coordinates: dq/dt.
            coordinate_rates(q: &Self::Q<T>, qd: &Self::V<T>) -> Self::Q<T>, else missing;

            /// The same coordinates, quaternions of unit length.
            normalize(q: &Self::Q<T>) -> Self::Q<T>, else missing;

            /// Coordinates within the joints' limits from numbers in [0, 1), evenly spread: angles without
            /// limits in [-pi, pi), displacements without limits in [-1, 1), rotations of any direction.
            random(uniform: impl FnMut() -> T) -> Self::Q<T>, else missing;
        }
    };
}

/// The functions of the trait: each stops compilation where a robot does not have it. A row with two
/// names is two functions, one with run-time parameters and one with the default ones.
macro_rules! declare_functions {
    () => {};
    (
        $(#[$documentation:meta])*
        $name:ident / $with:ident($($argument:ident: $of:ty),*) -> $result:ty, else $missing:ident;
        $($rows:tt)*
    ) => {
        $(#[$documentation])*
        fn $with<T: Scalar>(params: &Self::Params, $($argument: $of),*) -> $result {
            $missing!($name: params, $($argument),*)
        }

        #[doc = concat!("[`", stringify!($with), "`](Self::", stringify!($with), ") with the default parameters.")]
        fn $name<T: Scalar>($($argument: $of),*) -> $result {
            Self::$with(&Self::Params::default(), $($argument),*)
        }

        declare_functions! { $($rows)* }
    };
    (
        $(#[$documentation:meta])*
        $name:ident($($argument:ident: $of:ty),*) -> $result:ty, else $missing:ident;
        $($rows:tt)*
    ) => {
        $(#[$documentation])*
        fn $name<T: Scalar>($($argument: $of),*) -> $result {
            $missing!($name: $($argument),*)
        }

        declare_functions! { $($rows)* }
    };
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

pub(super) use {declare_functions, missing, no_loops, robot_functions};
