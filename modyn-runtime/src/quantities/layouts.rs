//! The layouts of results, each with its type in the trait of robots.
//!
//! A row is `name (type) |sizes| layout;`. Layouts may call each other by name, and the helpers of
//! `shape.rs`.

/// Passes the layouts to `$layouts`.
macro_rules! layouts {
    ($layouts:ident) => {
        $layouts! {
            scalar (T) |_| Shape::Scalar;
            coordinates (Self::Q<T>) |s| Shape::vector(s.nq);
            velocities (Self::V<T>) |s| Shape::vector(s.nv);
            square (Self::M<T>) |s| Shape::matrix(s.nv, s.nv);
            regressor (Self::Regressor<T>) |s| Shape::matrix(PARAMETERS_PER_LINK * s.moving, s.nv);
            point ([T; 3]) |_| Shape::vector(3);
            vectors3 (Self::PerVelocity<Vector3<T>>) |s| Shape::vector3().columns(s.nv);
            pose (Pose<T>) |_| Shape::pose();
            poses (Self::PerLink<Pose<T>>) |s| Shape::pose().array(s.links);
            twist (Twist<T>) |_| Shape::twist();
            twists (Self::PerVelocity<Twist<T>>) |s| Shape::twist().columns(s.nv);
            momentum (Momentum<T>) |_| Shape::momentum();
            inertia ([Momentum<T>; 6]) |_| Shape::momentum().columns(6);
            momenta (Self::PerVelocity<Momentum<T>>) |s| Shape::momentum().columns(s.nv);
            factors (Self::UduFactorization<T>) |s|
                Shape::Record(Record::Factorization, vec![("factors", Shape::vector(s.factors))]);
            inverse_derivatives (InverseDynamicsDerivatives<Self::M<T>>) |s|
                named_fields("InverseDynamicsDerivatives", vec![("dq", square(s)), ("dqd", square(s))]);
            forward_derivatives (ForwardDynamicsDerivatives<Self::V<T>, Self::M<T>>) |s| {
                let matrices = ["dq", "dqd", "dtau"].map(|name| (name, square(s)));
                named_fields("ForwardDynamicsDerivatives", [vec![("qdd", velocities(s))], matrices.into()].concat())
            };
            generalized_forces (GeneralizedForces<Self::V<T>, Self::M<T>>) |s|
                named_fields("GeneralizedForces", vec![("tau", velocities(s)), ("dq", square(s))]);
            centroidal_derivatives (CentroidalMomentumDerivatives<Momentum<T>, Self::PerVelocity<Momentum<T>>>) |s| {
                let fields = vec![
                    ("momentum", momentum(s)),
                    ("rate", momentum(s)),
                    ("momentum_dq", momenta(s)),
                    ("rate_dq", momenta(s)),
                    ("rate_dqd", momenta(s)),
                ];
                named_fields("CentroidalMomentumDerivatives", fields)
            };
            integrate_derivatives (IntegrateDerivatives<Self::M<T>>) |s|
                named_fields("IntegrateDerivatives", vec![("dq", square(s)), ("dv", square(s))]);
            difference_derivatives (DifferenceDerivatives<Self::M<T>>) |s|
                named_fields("DifferenceDerivatives", vec![("dfrom", square(s)), ("dto", square(s))]);
            inverse_vjp (InverseDynamicsVjp<Self::V<T>>) |s|
                vectors("InverseDynamicsVjp", &["tau", "dq", "dqd", "dqdd"], s);
            inverse_jvp (InverseDynamicsJvp<Self::V<T>>) |s| vectors("InverseDynamicsJvp", &["tau", "dtau"], s);
            forward_vjp (ForwardDynamicsVjp<Self::V<T>>) |s|
                vectors("ForwardDynamicsVjp", &["qdd", "dq", "dqd", "dtau"], s);
            forward_jvp (ForwardDynamicsJvp<Self::V<T>>) |s| vectors("ForwardDynamicsJvp", &["qdd", "dqdd"], s);
            inverse_hessian (InverseDynamicsHessian<Self::V<T>, Self::M<T>>) |s| {
                let matrices = ["dq_dq", "dq_dqd", "dqd_dqd", "dq_dqdd"];
                hessian("InverseDynamicsHessian", &["tau", "dq", "dqd", "dqdd"], &matrices, s)
            };
            forward_hessian (ForwardDynamicsHessian<Self::V<T>, Self::M<T>>) |s| {
                let matrices = ["dq_dq", "dq_dqd", "dqd_dqd", "dq_dtau"];
                hessian("ForwardDynamicsHessian", &["qdd", "dq", "dqd", "dtau"], &matrices, s)
            };
            step (Step<Self::Q<T>, Self::V<T>>) |s|
                Shape::Record(Record::Each("Step"), vec![("q", coordinates(s)), ("qd", velocities(s))]);
            step_derivatives (StepDerivatives<
                Self::Q<T>, Self::V<T>, Self::PerState<Self::PerState<T>>, Self::PerVelocity<Self::PerState<T>>
            >) |s| {
                let matrices = [("a", Shape::matrix(2 * s.nv, 2 * s.nv)), ("b", Shape::matrix(s.nv, 2 * s.nv))];
                let state = [("q", coordinates(s)), ("qd", velocities(s))];
                Shape::Record(Record::Each("StepDerivatives"), [state, matrices].concat())
            };
            step_hessian (StepHessian<
                Self::Q<T>, Self::V<T>, Self::PerState<T>, Self::V<T>, Self::PerState<Self::PerState<T>>,
                Self::PerVelocity<Self::PerState<T>>, Self::M<T>
            >) |s| {
                let fields = vec![
                    ("q", coordinates(s)),
                    ("qd", velocities(s)),
                    ("dx", state(s)),
                    ("dtau", velocities(s)),
                    ("dx_dx", Shape::matrix(2 * s.nv, 2 * s.nv)),
                    ("dx_dtau", Shape::matrix(s.nv, 2 * s.nv)),
                    ("dtau_dtau", square(s)),
                ];
                Shape::Record(Record::Each("StepHessian"), fields)
            };
            constrained (ConstrainedForwardDynamics<
                Self::V<T>, Self::PerConstraint<Wrench<T>>, Self::PerConstraint<Twist<T>>, T
            >) |s| {
                let wrenches = Shape::wrench().array(s.constraints);
                let residuals = Shape::twist().array(s.constraints);
                let fields = vec![
                    ("qdd", velocities(s)),
                    ("wrenches", wrenches),
                    ("residuals", residuals),
                    ("rank", Shape::Scalar),
                ];
                named_fields("ConstrainedForwardDynamics", fields)
            };
            constraint_residual (ConstraintResidual<Self::PerConstraint<Twist<T>>>) |s| {
                let twists = || Shape::twist().array(s.constraints);
                named_fields("ConstraintResidual", vec![("displacements", twists()), ("velocities", twists())])
            };
            constrained_derivatives (ConstrainedForwardDynamicsDerivatives<
                Self::V<T>, Self::PerConstraint<Wrench<T>>, Self::M<T>,
                Self::PerConstraint<Self::PerVelocity<Wrench<T>>>, T
            >) |s| {
                let matrices = ["dq", "dqd", "dtau"].map(|name| (name, square(s)));
                let changes = || Shape::wrench().columns(s.nv).array(s.constraints);
                let changes = ["wrenches_dq", "wrenches_dqd", "wrenches_dtau"].map(|name| (name, changes()));
                let first = [("qdd", velocities(s)), ("wrenches", Shape::wrench().array(s.constraints))];
                let fields = [&first[..], &matrices, &changes, &[("rank", Shape::Scalar)]].concat();
                named_fields("ConstrainedForwardDynamicsDerivatives", fields)
            };
            constrained_hessian (ConstrainedForwardDynamicsHessian<
                Self::V<T>, Self::PerConstraint<Wrench<T>>, Self::M<T>, T
            >) |s| {
                let first = [("qdd", velocities(s)), ("wrenches", constraint_wrenches(s))];
                let vectors = ["dq", "dqd", "dtau"].map(|name| (name, velocities(s)));
                let matrices = ["dq_dq", "dq_dqd", "dqd_dqd", "dq_dtau"].map(|name| (name, square(s)));
                let fields = [&first[..], &vectors, &matrices, &[("rank", Shape::Scalar)]].concat();
                named_fields("ConstrainedForwardDynamicsHessian", fields)
            };
            contact_impulse (ContactImpulse<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>) |s| {
                let impulses = Shape::wrench().array(s.constraints);
                let fields = vec![("qd", velocities(s)), ("impulses", impulses), ("rank", Shape::Scalar)];
                named_fields("ContactImpulse", fields)
            };
            step_solution (StepSolution<
                Self::Q<T>, Self::V<T>, Self::V<T>, Self::PerTouchingPoint<Vector3<T>>, T, T
            >) |s| {
                let motion = [("q", coordinates(s)), ("qd", velocities(s)), ("qdd", velocities(s))];
                let solver = [("residual", Shape::Scalar), ("iterations", Shape::Scalar)];
                let forces = [("forces", point_forces(s))];
                Shape::Record(Record::Each("StepSolution"), [&motion[..], &forces, &solver].concat())
            };
            actuated_step (ActuatedStep<
                Self::Q<T>, Self::V<T>, Self::PerActivation<T>, Self::V<T>, Self::PerTouchingPoint<Vector3<T>>, T, T
            >) |s| {
                let motion = [("q", coordinates(s)), ("qd", velocities(s)), ("act", activations(s))];
                let solution = [("qdd", velocities(s)), ("forces", point_forces(s))];
                let solver = [("residual", Shape::Scalar), ("iterations", Shape::Scalar)];
                Shape::Record(Record::Each("ActuatedStep"), [&motion[..], &solution, &solver].concat())
            };
            actuator_forces (ActuatorForces<Self::V<T>, Self::PerActivation<T>>) |s| {
                let fields = vec![("tau", velocities(s)), ("act", activations(s))];
                Shape::Record(Record::Each("ActuatorForces"), fields)
            };
            constrained_torques (ConstrainedInverseDynamics<Self::V<T>, Self::PerConstraint<Wrench<T>>, T>) |s| {
                let wrenches = Shape::wrench().array(s.constraints);
                let fields = vec![("tau", velocities(s)), ("wrenches", wrenches), ("rank", Shape::Scalar)];
                named_fields("ConstrainedInverseDynamics", fields)
            };
            constraint_jacobian (Self::PerConstraint<Self::PerVelocity<Twist<T>>>) |s| twists(s).array(s.constraints);
            constraint_twists (Self::PerConstraint<Twist<T>>) |s| Shape::twist().array(s.constraints);
            operational_inertia (OperationalInertia<Self::PerConstraintRow<Self::PerConstraintRow<T>>, T>) |s| {
                let matrix = || Shape::matrix(s.constraint_rows, s.constraint_rows);
                let fields = vec![("inverse", matrix()), ("inertia", matrix()), ("rank", Shape::Scalar)];
                named_fields("OperationalInertia", fields)
            };
            constraint_projection (ConstraintProjection<Self::V<T>, T>) |s| {
                let fields = vec![("dq", velocities(s)), ("dqd", velocities(s)), ("rank", Shape::Scalar)];
                named_fields("ConstraintProjection", fields)
            };
        }
    };
}

pub(crate) use layouts;
