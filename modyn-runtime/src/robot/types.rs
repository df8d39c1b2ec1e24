//! The types of the arguments and results of a robot's functions, by the kinds and layouts of the table.

/// The type of an argument of this kind.
macro_rules! kind_type {
    (Coordinates) => { &Self::Q<T> };
    (Velocities) => { &Self::V<T> };
    (State) => { &Self::PerState<T> };
    (Time) => { T };
    (Wrenches) => { &Self::PerLink<Wrench<T>> };
    (ConstraintWrenches) => { &Self::PerConstraint<Wrench<T>> };
    (Contacts) => { Self::Contacts };
    (Settings) => { &Settings<Self, T> };
    (RandomNumbers) => { impl FnMut() -> T };
}

/// Declares the macro that returns the type of an argument.
macro_rules! declare_argument_type {
    ($($name:ident $kind:ident,)*) => {
        /// The type of an argument.
        macro_rules! argument_type {
            $(($name) => { kind_type!($kind) };)*
        }
    };
}

table::arguments!(declare_argument_type);

/// The type of a result of this layout.
macro_rules! result_type {
    (scalar) => { T };
    (coordinates) => { Self::Q<T> };
    (velocities) => { Self::V<T> };
    (square) => { Self::M<T> };
    (factors) => { Self::UduFactorization<T> };
    (regressor) => { Self::Regressor<T> };
    (point) => { [T; 3] };
    (vectors3) => { Self::PerVelocity<Vector3<T>> };
    (pose) => { Pose<T> };
    (poses) => { Self::PerLink<Pose<T>> };
    (twist) => { Twist<T> };
    (twists) => { Self::PerVelocity<Twist<T>> };
    (momentum) => { Momentum<T> };
    (momenta) => { Self::PerVelocity<Momentum<T>> };
    (generalized_forces) => { GeneralizedForces<Self::V<T>, Self::M<T>> };
    (inverse_derivatives) => { InverseDynamicsDerivatives<Self::M<T>> };
    (forward_derivatives) => { ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>> };
    (inverse_vjp) => { InverseDynamicsVjp<Self::V<T>> };
    (inverse_jvp) => { InverseDynamicsJvp<Self::V<T>> };
    (forward_vjp) => { ForwardDynamicsVjp<Self::V<T>> };
    (forward_jvp) => { ForwardDynamicsJvp<Self::V<T>> };
    (inverse_hessian) => { InverseDynamicsHessian<Self::V<T>, Self::M<T>> };
    (forward_hessian) => { ForwardDynamicsHessian<Self::V<T>, Self::M<T>> };
    (integrate_derivatives) => { IntegrateDerivatives<Self::M<T>> };
    (difference_derivatives) => { DifferenceDerivatives<Self::M<T>> };
    (centroidal_derivatives) => {
        CentroidalMomentumDerivatives<Momentum<T>, Self::PerVelocity<Momentum<T>>>
    };
    (step) => { Step<Self::Q<T>, Self::V<T>> };
    (step_derivatives) => {
        StepDerivatives<
            Self::Q<T>,
            Self::V<T>,
            Self::PerState<Self::PerState<T>>,
            Self::PerVelocity<Self::PerState<T>>,
        >
    };
    (step_hessian) => {
        StepHessian<
            Self::Q<T>,
            Self::V<T>,
            Self::PerState<T>,
            Self::V<T>,
            Self::PerState<Self::PerState<T>>,
            Self::PerVelocity<Self::PerState<T>>,
            Self::M<T>,
        >
    };
    (constrained) => {
        ConstrainedForwardDynamics<
            Self::V<T>,
            Self::PerConstraint<Wrench<T>>,
            Self::PerConstraint<Twist<T>>,
            T,
        >
    };
    (constrained_derivatives) => {
        ConstrainedForwardDynamicsDerivatives<
            Self::V<T>,
            Self::PerConstraint<Wrench<T>>,
            Self::M<T>,
            Self::PerConstraint<Self::PerVelocity<Wrench<T>>>,
            T,
        >
    };
    (constrained_hessian) => {
        ConstrainedForwardDynamicsHessian<
            Self::V<T>,
            Self::PerConstraint<Wrench<T>>,
            Self::M<T>,
            T,
        >
    };
    (constraint_residual) => { ConstraintResidual<Self::PerConstraint<Twist<T>>> };
    (constraint_projection) => { ConstraintProjection<Self::V<T>, T> };
    (contact_impulse) => { ContactImpulse<Self::V<T>, Self::PerConstraint<Wrench<T>>, T> };
    (constrained_torques) => {
        ConstrainedInverseDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>
    };
    (constraint_jacobian) => { Self::PerConstraint<Self::PerVelocity<Twist<T>>> };
    (constraint_twists) => { Self::PerConstraint<Twist<T>> };
    (operational_inertia) => {
        OperationalInertia<Self::PerConstraintRow<Self::PerConstraintRow<T>>, T>
    };
}

use crate::quantities::table;
pub(super) use {argument_type, kind_type, result_type};
