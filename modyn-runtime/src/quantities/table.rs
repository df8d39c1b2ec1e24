//! The table of quantities: a row for each function of one state.
//!
//! A row names the fields in which it differs from its base: [`Row::GEOMETRIC`], [`Row::INERTIAL`] or
//! [`Row::CONSTRAINED`].
//!
//! The rows have the order of the variants of [`Function`]. `cargo xtask pages` writes the items
//! that follow from the table and that rustc needs one by one: the documentation of the variants,
//! the traits of [`functions`](crate::functions), the functions of [`Robot`](crate::Robot), the
//! methods of the Python package, and the list of functions for tests.

use super::arguments::{
    ACT, ACT_COTANGENT, ACTIVE, APPLIED, COTANGENT, CTRL, DT, FORCES, FROM, Q, QD, QDD, SETTINGS,
    STATE_COTANGENT, STEP_SETTINGS, TANGENT_ACT, TANGENT_CTRL, TANGENT_Q, TANGENT_QD, TANGENT_QDD,
    TANGENT_TAU, TAU, TO, UNIFORMS, V, WARM_START, WRENCH_COTANGENT,
};
use super::function::Function;
use super::row::Row;
use super::shapes;

/// The rows of the functions of one state.
pub const ROWS: &[Row] = &[
    Row {
        function: Function::ForwardDynamics,
        name: "forward_dynamics",
        known_as: &["ABA", "articulated-body algorithm", "pin.aba"],
        arguments: &[Q, QD, TAU],
        result: shapes::velocities,
        result_name: Some("qdd"),
        docs: "Returns the joint accelerations (rad/s^2 or m/s^2) at the coordinates `q` and \
            velocities `qd` under the joint forces `tau` (N m or N), gravity included. The method \
            is block reverse Gaussian elimination of the mass matrix by inter- and intra-modular \
            recursion.",
        default: true,
        hot: true,
        casadi: true,
        batch: Some(Function::ForwardDynamicsBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::InverseDynamics,
        name: "inverse_dynamics",
        known_as: &["RNEA", "recursive Newton-Euler algorithm", "pin.rnea", "mj_rne"],
        arguments: &[Q, QD, QDD],
        result: shapes::velocities,
        result_name: Some("tau"),
        docs: "Returns the joint forces (N m or N) of the accelerations `qdd` at the coordinates \
            `q` and velocities `qd`, gravity included, by the recursive Newton-Euler algorithm.",
        default: true,
        hot: true,
        casadi: true,
        batch: Some(Function::InverseDynamicsBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::BiasForces,
        name: "bias_forces",
        known_as: &["nonlinear effects", "pin.nonLinearEffects", "qfrc_bias"],
        arguments: &[Q, QD],
        result: shapes::velocities,
        docs: "Returns the bias forces (N m or N): inverse dynamics at zero acceleration. They are \
            the Coriolis, centrifugal and gravity forces and the forces of springs, with damping \
            and friction if these are enabled.",
        default: true,
        hot: true,
        casadi: true,
        batch: Some(Function::BiasForcesBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::GravityTorques,
        name: "gravity_torques",
        known_as: &["gravity compensation", "pin.computeGeneralizedGravity"],
        arguments: &[Q],
        result: shapes::velocities,
        docs: "Returns the joint forces (N m or N) that balance gravity and springs at `q` and \
            zero velocity.",
        default: true,
        casadi: true,
        batch: Some(Function::GravityTorquesBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::MassMatrix,
        name: "mass_matrix",
        known_as: &["CRBA", "joint-space inertia matrix", "pin.crba", "mj_fullM"],
        arguments: &[Q],
        result: shapes::square,
        docs: "Returns the mass matrix at `q`, nv x nv, an array of columns.",
        default: true,
        hot: true,
        casadi: true,
        batch: Some(Function::MassMatrixBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::CoriolisMatrix,
        name: "coriolis_matrix",
        known_as: &["pin.computeCoriolisMatrix"],
        arguments: &[Q, QD],
        result: shapes::square,
        docs: "Returns the Coriolis matrix C, nv x nv, an array of columns. C `qd` are the \
            Coriolis and centrifugal forces, without gravity, damping and friction, and dM/dt - 2 \
            C is skew with the mass matrix M.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::Brge,
        name: "brge",
        known_as: &[
            "Cholesky decomposition of the mass matrix",
            "pin.cholesky.decompose",
            "mj_factorM",
        ],
        arguments: &[Q],
        result: shapes::factors,
        docs: "Returns the factorization U D U^T of the mass matrix at `q` by kinematic modules, \
            by block reverse Gaussian elimination.",
        default: true,
        batch: Some(Function::BrgeBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::KineticEnergy,
        name: "kinetic_energy",
        known_as: &["pin.computeKineticEnergy"],
        arguments: &[Q, QD],
        result: shapes::scalar,
        docs: "Returns the kinetic energy of the moving links and the armatures, J.",
        default: true,
        casadi: true,
        batch: Some(Function::KineticEnergyBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::PotentialEnergy,
        name: "potential_energy",
        known_as: &["pin.computePotentialEnergy"],
        arguments: &[Q],
        result: shapes::scalar,
        docs: "Returns the potential energy of the moving links under gravity and of the springs, \
            J; zero for mass at the world's origin and springs at rest.",
        default: true,
        casadi: true,
        batch: Some(Function::PotentialEnergyBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::ForwardDynamicsExternalLocal,
        name: "forward_dynamics_external_local",
        arguments: &[Q, QD, TAU, FORCES],
        result: shapes::velocities,
        result_name: Some("qdd"),
        docs: "Returns the joint accelerations under `tau` and a wrench on each link (in the order \
            of `LINK_NAMES`), at the link's origin in the link's own axes.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::ForwardDynamicsExternal,
        name: "forward_dynamics_external",
        arguments: &[Q, QD, TAU, FORCES],
        result: shapes::velocities,
        result_name: Some("qdd"),
        docs: "Returns the joint accelerations under `tau` and a wrench on each link (in the order \
            of `LINK_NAMES`), at the link's origin in world axes.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::InverseDynamicsExternalLocal,
        name: "inverse_dynamics_external_local",
        arguments: &[Q, QD, QDD, FORCES],
        result: shapes::velocities,
        result_name: Some("tau"),
        docs: "Returns the joint forces of `qdd` under a wrench on each link (in the order of \
            `LINK_NAMES`), at the link's origin in the link's own axes.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::InverseDynamicsExternal,
        name: "inverse_dynamics_external",
        arguments: &[Q, QD, QDD, FORCES],
        result: shapes::velocities,
        result_name: Some("tau"),
        docs: "Returns the joint forces of `qdd` under a wrench on each link (in the order of \
            `LINK_NAMES`), at the link's origin in world axes.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::GeneralizedForcesLocal,
        name: "generalized_forces_local",
        arguments: &[Q, FORCES],
        result: shapes::generalized_forces,
        docs: "Returns the generalized forces J^T f of a wrench on each link (in the order of \
            `LINK_NAMES`), at the link's origin in the link's own axes, and their derivative with \
            respect to `q` (in tangent space), an array of columns. The wrenches rotate with their \
            links.",
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::GeneralizedForces,
        name: "generalized_forces",
        arguments: &[Q, FORCES],
        result: shapes::generalized_forces,
        docs: "Returns the generalized forces J^T f of a wrench on each link (in the order of \
            `LINK_NAMES`), at the link's origin in world axes, and their derivative with respect \
            to `q` (in tangent space), an array of columns. The wrenches keep their directions.",
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::InverseDynamicsDerivatives,
        name: "inverse_dynamics_derivatives",
        known_as: &["pin.computeRNEADerivatives"],
        arguments: &[Q, QD, QDD],
        result: shapes::inverse_derivatives,
        result_name: Some("derivatives"),
        docs: "Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) \
            and `qd`, each an array of columns. The derivative with respect to `qdd` is the mass \
            matrix.",
        hot: true,
        batch: Some(Function::InverseDynamicsDerivativesBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::ForwardDynamicsDerivatives,
        name: "forward_dynamics_derivatives",
        known_as: &["pin.computeABADerivatives"],
        arguments: &[Q, QD, TAU],
        result: shapes::forward_derivatives,
        result_name: Some("derivatives"),
        docs: "Returns the joint accelerations, and the derivatives of forward dynamics with \
            respect to `q` (in tangent space), `qd` and `tau`, each an array of columns.",
        hot: true,
        batch: Some(Function::ForwardDynamicsDerivativesBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::InverseDynamicsVjp,
        name: "inverse_dynamics_vjp",
        arguments: &[Q, QD, QDD, COTANGENT],
        result: shapes::inverse_vjp,
        docs: "Returns the joint forces tau of `qdd`, and the products of `cotangent` with their \
            derivatives: the gradients of `cotangent`^T tau with respect to `q` (in tangent \
            space), `qd` and `qdd`.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::InverseDynamicsJvp,
        name: "inverse_dynamics_jvp",
        arguments: &[Q, QD, QDD, TANGENT_Q, TANGENT_QD, TANGENT_QDD],
        result: shapes::inverse_jvp,
        docs: "Returns the joint forces tau of `qdd`, and their change under the changes \
            `tangent_q` (in tangent space), `tangent_qd` and `tangent_qdd`.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::ForwardDynamicsVjp,
        name: "forward_dynamics_vjp",
        arguments: &[Q, QD, TAU, COTANGENT],
        result: shapes::forward_vjp,
        docs: "Returns the accelerations qdd, and the products of `cotangent` with their \
            derivatives: the gradients of `cotangent`^T qdd with respect to `q` (in tangent \
            space), `qd` and `tau`.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::ForwardDynamicsJvp,
        name: "forward_dynamics_jvp",
        arguments: &[Q, QD, TAU, TANGENT_Q, TANGENT_QD, TANGENT_TAU],
        result: shapes::forward_jvp,
        docs: "Returns the accelerations qdd, and their change under the changes `tangent_q` (in \
            tangent space), `tangent_qd` and `tangent_tau`.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::InverseDynamicsHessian,
        name: "inverse_dynamics_hessian",
        arguments: &[Q, QD, QDD, COTANGENT],
        result: shapes::inverse_hessian,
        docs: "Returns the joint forces tau of `qdd`, and the gradients and the Hessian of \
            `cotangent`^T tau with respect to `q` (in tangent space), `qd` and `qdd`. The blocks \
            of the Hessian are arrays of columns; the blocks of `qd` and `qdd` and of `qdd` and \
            `qdd` are zero.",
        batch: Some(Function::InverseDynamicsHessianBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::ForwardDynamicsHessian,
        name: "forward_dynamics_hessian",
        arguments: &[Q, QD, TAU, COTANGENT],
        result: shapes::forward_hessian,
        docs: "Returns the accelerations qdd, and the gradients and the Hessian of `cotangent`^T \
            qdd with respect to `q` (in tangent space), `qd` and `tau`. The blocks of the Hessian \
            are arrays of columns; the blocks of `qd` and `tau` and of `tau` and `tau` are zero.",
        batch: Some(Function::ForwardDynamicsHessianBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepSemiImplicit,
        name: "step_semi_implicit",
        arguments: &[Q, QD, TAU, DT],
        result: shapes::step,
        docs: "Returns the state after the time `dt` (s) under the joint forces `tau`, by the \
            semi-implicit Euler method: the new velocities are `qd` + `dt` qdd, and move the \
            coordinates.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepSemiImplicitDerivatives,
        name: "step_semi_implicit_derivatives",
        arguments: &[Q, QD, TAU, DT],
        result: shapes::step_derivatives,
        docs: "Returns the state after the time `dt` (s) by the semi-implicit Euler method, and \
            its derivatives: `a` with respect to the state before and `b` with respect to `tau`, \
            arrays of columns. A state has the entries of q (in tangent space), then the entries \
            of qd.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::Knot,
        name: "knot",
        known_as: &["knot point", "action model", "calcDiff"],
        arguments: &[Q, QD, TAU, DT],
        result: shapes::knot,
        docs: "Returns a knot of optimal control: the velocities after a step of the time `dt` (s) \
            by the semi-implicit Euler method, and the derivatives of the step in blocks, by rows. \
            The derivatives of the velocities are with respect to `q` (in tangent space), `qd` and \
            `tau`. The coordinates after the step are `integrate` of `q` and v, with v = `dt` times \
            these velocities. Their derivatives with respect to `q` and v are 1, except for a 6 x \
            6 block at each quaternion, such as the quaternion of a floating base. A spherical \
            joint has the angular part of its block.",
        hot: true,
        batch: Some(Function::KnotBatch),
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepSemiImplicitHessian,
        name: "step_semi_implicit_hessian",
        arguments: &[Q, QD, TAU, DT, STATE_COTANGENT],
        result: shapes::step_hessian,
        docs: "Returns the state after the time `dt` (s) by the semi-implicit Euler method, and \
            the gradients and the Hessian of `state_cotangent`^T state: `grad_x` and `grad_tau` \
            with respect to the state before and `tau`, and `hess_x_x`, `hess_x_tau` and \
            `hess_tau_tau`, arrays of columns. A state has the entries of q (in tangent space), \
            then the entries of qd. Displacements of the state after the step are in tangent space, \
            too.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepRk4,
        name: "step_rk4",
        arguments: &[Q, QD, TAU, DT],
        result: shapes::step,
        docs: "Returns the state after the time `dt` (s) under the constant joint forces `tau`, by \
            a Runge-Kutta method of fourth order. Rotations follow exponential maps, so \
            quaternions keep length 1.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepRk4Derivatives,
        name: "step_rk4_derivatives",
        arguments: &[Q, QD, TAU, DT],
        result: shapes::step_derivatives,
        docs: "Returns the state of `step_rk4`, and its derivatives: `a` with respect to the state \
            before and `b` with respect to `tau`, arrays of columns. A state has the entries of q \
            (in tangent space), then the entries of qd.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepImplicitMidpoint,
        name: "step_implicit_midpoint",
        arguments: &[Q, QD, TAU, DT],
        result: shapes::step,
        docs: "Returns the state after the time `dt` (s) under the constant joint forces `tau`, by \
            the implicit midpoint rule: of second order, symmetric, and stable under stiff \
            damping. Three iterations of simplified Newton solve its equations. Rotations follow \
            exponential maps, so quaternions keep length 1.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepImplicitMidpointDerivatives,
        name: "step_implicit_midpoint_derivatives",
        arguments: &[Q, QD, TAU, DT],
        result: shapes::step_derivatives,
        docs: "Returns the state of `step_implicit_midpoint`, and the derivatives of the implicit \
            midpoint rule: `a` with respect to the state before and `b` with respect to `tau`, \
            arrays of columns. A state has the entries of q (in tangent space), then the entries \
            of qd.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::ConstrainedForwardDynamics,
        name: "constrained_forward_dynamics",
        known_as: &["contact dynamics", "pin.constraintDynamics"],
        arguments: &[Q, QD, TAU, ACTIVE, SETTINGS],
        result: shapes::constrained,
        docs: "Returns the joint accelerations under the joint forces `tau` with the loops closed \
            and the active contacts held. Also returns the wrench on each constraint's link and \
            the unmet part of the constraint's acceleration, and the number of independent \
            constraint rows. Loop constraints come first, in the order of `LOOP_CONSTRAINT_NAMES`, \
            at the second frame's origin in the first frame's axes. Contacts follow, in the order \
            of `CONTACT_NAMES`, at the frame's origin in world axes. Redundant rows get the \
            multipliers of smallest norm.",
        default: true,
        batch: Some(Function::ConstrainedForwardDynamicsBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::ConstraintResidual,
        name: "constraint_residual",
        arguments: &[Q, QD, SETTINGS],
        result: shapes::constraint_residual,
        docs: "Returns the displacement and the velocity of each loop constraint's second frame \
            relative to its first, in the first frame's axes; then of each contact's frame, active \
            or not, relative to its target, in world axes. Components along free directions are \
            zero. A rotation is its axis times the sine of its angle.",
        default: true,
        of_constraints: true,
        batch: Some(Function::ConstraintResidualBatch),
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::ProjectConstraints,
        name: "project_constraints",
        arguments: &[Q, QD, ACTIVE, SETTINGS],
        result: shapes::constraint_projection,
        docs: "Returns the smallest step (in the metric of the mass matrix) that closes the loops \
            at `q` and moves the active contacts to their targets to first order, the smallest \
            change of `qd` that keeps them there, and the number of independent constraint rows. \
            The settings `alpha` and `beta` have no effect.",
        default: true,
        batch: Some(Function::ProjectConstraintsBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::ConstrainedForwardDynamicsDerivatives,
        name: "constrained_forward_dynamics_derivatives",
        known_as: &["pin.computeConstraintDynamicsDerivatives"],
        arguments: &[Q, QD, TAU, ACTIVE, SETTINGS],
        result: shapes::constrained_derivatives,
        docs: "Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and \
            their derivatives with respect to `q` (in tangent space), `qd` and `tau`, each an \
            array of columns. The derivatives of wrenches are arrays for each constraint, in the \
            axes of the wrenches. The rank is assumed constant; redundant rows get the derivatives \
            of smallest norm.",
        batch: Some(Function::ConstrainedForwardDynamicsDerivativesBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::ConstrainedKnot,
        name: "constrained_knot",
        known_as: &["DifferentialActionModelContactFwdDynamics"],
        arguments: &[Q, QD, TAU, DT, ACTIVE, SETTINGS],
        result: shapes::constrained_knot,
        docs: "Returns the results of `knot` under the accelerations of \
            `constrained_forward_dynamics`, and the wrenches of the constraints with their \
            derivatives, which `constrained_forward_dynamics_derivatives` describes.",
        batch: Some(Function::ConstrainedKnotBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::ConstrainedForwardDynamicsHessian,
        name: "constrained_forward_dynamics_hessian",
        arguments: &[Q, QD, TAU, COTANGENT, WRENCH_COTANGENT, ACTIVE, SETTINGS],
        result: shapes::constrained_hessian,
        docs: "Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and \
            the gradients and the Hessian of their sum with the weights `cotangent` and \
            `wrench_cotangent` (of the components of the wrenches) with respect to `q` (in tangent \
            space), `qd` and `tau`. The blocks of the Hessian are arrays of columns; the blocks of \
            `qd` and `tau` and of `tau` and `tau` are zero. The rank is assumed constant. Weights \
            of wrenches need independent rows, or compliance.",
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::ImpactDynamics,
        name: "impact_dynamics",
        known_as: &["impact dynamics", "pin.impulseDynamics"],
        arguments: &[Q, QD, ACTIVE, SETTINGS],
        result: shapes::impact_dynamics,
        docs: "Returns the velocities after an impact that closes the loops and stops the active \
            contacts relative to their targets at the same instant, the impulse of each \
            constraint, and the number of independent constraint rows. Along its normal, a contact \
            leaves with `restitution` times the speed before the impact. The settings `alpha` and \
            `beta` have no effect.",
        batch: Some(Function::ImpactDynamicsBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::Step,
        name: "step",
        known_as: &["mj_step"],
        arguments: &[Q, QD, TAU, DT, WARM_START, STEP_SETTINGS],
        result: shapes::step_solution,
        docs: "Returns the state after a step of the time `dt` (s) under the joint forces `tau`, \
            with contacts, joint limits, dry joint friction and closed loops by MuJoCo's law: soft \
            constraints whose forces minimize a convex function. The solver is Newton's method, to \
            the tolerance of `step_settings`; `residual` says how far it came, relative to the \
            largest force. It starts from the accelerations `warm_start`: `qdd` of the last step, \
            or zeros. The integrator is semi-implicit Euler, implicit in joint damping, or \
            MuJoCo's `implicitfast`, as the description says.",
        has_solver: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepDerivatives,
        name: "step_derivatives",
        known_as: &["linearization", "mjd_transitionFD"],
        arguments: &[Q, QD, TAU, DT, WARM_START, STEP_SETTINGS],
        result: shapes::linearized_step,
        docs: "Returns the results of `step`, and the derivatives of the state after it: `a` with \
            respect to the state before and `b` with respect to `tau`, arrays of columns. A state \
            has the entries of q (in tangent space), then the entries of qd. The derivatives \
            follow from the implicit function theorem at the solution; where a contact opens or \
            closes, or a point begins to slide, they are one-sided.",
        has_solver: true,
        derivatives_of: Some(Function::Step),
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepVjp,
        name: "step_vjp",
        known_as: &["reverse-mode differentiation", "adjoint"],
        arguments: &[Q, QD, TAU, DT, STATE_COTANGENT, WARM_START, STEP_SETTINGS],
        result: shapes::step_vjp,
        docs: "Returns the results of `step`, and the gradients of `state_cotangent`^T state after \
            it: `grad_x` with respect to the state before, and `grad_tau`. A state has the entries \
            of q (in tangent space), then the entries of qd. At kinks they are as in \
            `step_derivatives`.",
        has_solver: true,
        derivatives_of: Some(Function::Step),
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepJvp,
        name: "step_jvp",
        known_as: &["forward-mode differentiation"],
        arguments: &[Q, QD, TAU, TANGENT_Q, TANGENT_QD, TANGENT_TAU, DT, WARM_START, STEP_SETTINGS],
        result: shapes::step_jvp,
        docs: "Returns the results of `step`, and the change `tangent_x` of the state after it \
            under the changes `tangent_q` (in tangent space), `tangent_qd` and `tangent_tau`. A \
            state has the entries of q (in tangent space), then the entries of qd. At kinks it is \
            as in `step_derivatives`.",
        has_solver: true,
        derivatives_of: Some(Function::Step),
        ..Row::INERTIAL
    },
    Row {
        function: Function::TouchingPoints,
        name: "touching_points",
        known_as: &["contact distance", "foot clearance", "mjContact"],
        arguments: &[Q, QD, STEP_SETTINGS],
        result: shapes::touching_points,
        result_name: Some("points"),
        docs: "Returns the points of the shapes that can touch the ground, in the order of the \
            `forces` of `step`: the heights `gaps` above the ground (m; negative in it), the \
            `positions` in the middle between the shape and the ground (m, world axes), and the \
            `velocities` of the link there, along the x and y axes of the plane, then along its \
            normal (m/s).",
        of_touching_shapes: true,
        batch: Some(Function::TouchingPointsBatch),
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::Actuate,
        name: "actuate",
        known_as: &["mj_fwdActuation"],
        arguments: &[Q, QD, CTRL, DT, ACT],
        result: shapes::actuator_forces,
        result_name: Some("forces"),
        docs: "Returns the joint forces `tau` of the actuators under the controls `ctrl`, in the \
            order of `CONTROL_NAMES`, and the activations after the time `dt` (s), in the order of \
            `ACTIVATION_NAMES`. The laws are MuJoCo's: controls, forces, activations and joint \
            forces are clamped to the ranges of the description.",
        of_actuators: true,
        casadi: true,
        batch: Some(Function::ActuateBatch),
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::StepActuated,
        name: "step_actuated",
        known_as: &["mj_step"],
        arguments: &[Q, QD, CTRL, DT, ACT, APPLIED, WARM_START, STEP_SETTINGS],
        result: shapes::actuated_step,
        docs: "Returns the state and the activations after a step of the time `dt` (s) under the \
            controls `ctrl`: MuJoCo's `mj_step`. The joint forces are the result of `actuate` at \
            the state before the step, and the forces `applied` beside it (MuJoCo's \
            `qfrc_applied`). All else is as in `step`.",
        of_actuators: true,
        has_solver: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepActuatedDerivatives,
        name: "step_actuated_derivatives",
        known_as: &["linearization", "mjd_transitionFD"],
        arguments: &[Q, QD, CTRL, DT, ACT, APPLIED, WARM_START, STEP_SETTINGS],
        result: shapes::linearized_actuated_step,
        docs: "Returns the results of `step_actuated`, and the derivatives of the state after it: \
            `a` with respect to the state before and `b` with respect to `ctrl`, arrays of \
            columns. A state has the entries of q (in tangent space), the entries of qd, then \
            `act`. All else is as in `step_derivatives`.",
        of_actuators: true,
        has_solver: true,
        derivatives_of: Some(Function::StepActuated),
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepActuatedVjp,
        name: "step_actuated_vjp",
        known_as: &["reverse-mode differentiation", "adjoint"],
        arguments: &[
            Q,
            QD,
            CTRL,
            DT,
            STATE_COTANGENT,
            ACT,
            ACT_COTANGENT,
            APPLIED,
            WARM_START,
            STEP_SETTINGS,
        ],
        result: shapes::actuated_step_vjp,
        docs: "Returns the results of `step_actuated`, and the gradients of `state_cotangent`^T \
            state + `act_cotangent`^T act after it: `grad_x` with respect to the state before, and \
            `grad_ctrl`. The state of `grad_x` has the entries of q (in tangent space), the \
            entries of qd, then `act`. At kinks they are as in `step_derivatives`.",
        of_actuators: true,
        has_solver: true,
        derivatives_of: Some(Function::StepActuated),
        ..Row::INERTIAL
    },
    Row {
        function: Function::StepActuatedJvp,
        name: "step_actuated_jvp",
        known_as: &["forward-mode differentiation"],
        arguments: &[
            Q,
            QD,
            TANGENT_Q,
            TANGENT_QD,
            CTRL,
            TANGENT_CTRL,
            DT,
            ACT,
            TANGENT_ACT,
            APPLIED,
            WARM_START,
            STEP_SETTINGS,
        ],
        result: shapes::actuated_step_jvp,
        docs: "Returns the results of `step_actuated`, and the change `tangent_x` of the state after \
            it under the changes `tangent_q` (in tangent space), `tangent_qd`, `tangent_ctrl` and \
            `tangent_act`. The state of `tangent_x` has the entries of q (in tangent space), the \
            entries of qd, then `act`. At kinks it is as in `step_derivatives`.",
        of_actuators: true,
        has_solver: true,
        derivatives_of: Some(Function::StepActuated),
        ..Row::INERTIAL
    },
    Row {
        function: Function::ConstrainedInverseDynamics,
        name: "constrained_inverse_dynamics",
        arguments: &[Q, QD, QDD, ACTIVE, SETTINGS],
        result: shapes::constrained_torques,
        docs: "Returns the joint forces of the accelerations `qdd`, the wrenches of the active \
            contacts that carry the floating bases, and the rank of the contacts' columns of the \
            bases. The wrenches have the smallest sum of (force^2 + (moment / l)^2) / weight with \
            the characteristic length l of each contact. The joint forces of a base are the wrench \
            on it that no contact can carry. The wrenches of loop constraints are zero.",
        batch: Some(Function::ConstrainedInverseDynamicsBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::ConstraintJacobian,
        name: "constraint_jacobian",
        arguments: &[Q],
        result: shapes::constraint_jacobian,
        docs: "Returns the Jacobian of each constraint, an array of columns. The product with `qd` \
            is, for a loop constraint, the constrained part of the twist of its second frame \
            relative to its first, in the first frame's axes; for a contact, active or not, the \
            constrained part of its frame's twist in world axes.",
        of_constraints: true,
        batch: Some(Function::ConstraintJacobianBatch),
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::ConstraintJacobianDotQd,
        name: "constraint_jacobian_dot_qd",
        arguments: &[Q, QD],
        result: shapes::constraint_twists,
        docs: "Returns the bias acceleration of each constraint: the time derivative of \
            `constraint_jacobian` times `qd`, in the same axes.",
        of_constraints: true,
        batch: Some(Function::ConstraintJacobianDotQdBatch),
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::OperationalSpaceInertia,
        name: "operational_space_inertia",
        known_as: &["operational-space inertia", "Delassus matrix"],
        arguments: &[Q, ACTIVE, SETTINGS],
        result: shapes::operational_space_inertia,
        docs: "Returns the Delassus matrix J M^-1 J^T of the constraints with the mass matrix M, \
            its pseudo-inverse, the operational-space inertia, and the number of independent \
            constraint rows. Both matrices are arrays of columns; each constraint has its \
            constrained displacements, then its constrained rotations, of a contact in world \
            axes. The entries of inactive contacts are zero. The Delassus matrix contains the \
            compliance.",
        batch: Some(Function::OperationalSpaceInertiaBatch),
        ..Row::CONSTRAINED
    },
    Row {
        function: Function::Regressor,
        name: "regressor",
        known_as: &["pin.computeJointTorqueRegressor"],
        arguments: &[Q, QD, QDD],
        result: shapes::regressor,
        docs: "Returns the regressor Y of inverse dynamics, an array of columns: tau = Y pi, \
            without armatures and friction. pi has ten entries for each moving link: mass, mass \
            times centre of mass x, y, z, and Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin \
            in the link's own axes (`PARAMETERS`).",
        depends_on_parameters: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::CenterOfMass,
        name: "center_of_mass",
        known_as: &["pin.centerOfMass", "subtree_com"],
        arguments: &[Q],
        result: shapes::point,
        result_name: Some("position"),
        docs: "Returns the centre of mass of the moving links in world axes, m.",
        default: true,
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::CenterOfMassJacobian,
        name: "center_of_mass_jacobian",
        known_as: &["pin.jacobianCenterOfMass", "mj_jacSubtreeCom"],
        arguments: &[Q],
        result: shapes::vectors3,
        result_name: Some("jacobian"),
        docs: "Returns the Jacobian of the centre of mass, an array of columns. Its product with \
            `qd` is the velocity of the centre of mass in world axes.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::CentroidalMomentumMatrix,
        name: "centroidal_momentum_matrix",
        known_as: &["CMM", "pin.ccrba"],
        arguments: &[Q],
        result: shapes::momenta,
        result_name: Some("momentum_matrix"),
        docs: "Returns the centroidal momentum matrix, an array of columns. Its product with `qd` \
            is the momentum about the centre of mass, in world axes. Armatures have energy, but no \
            momentum: their axes are not described.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::CentroidalCompositeInertia,
        name: "centroidal_composite_inertia",
        arguments: &[Q],
        result: shapes::inertia,
        result_name: Some("inertia"),
        docs: "Returns the centroidal composite inertia, an array of columns. Its product with a \
            twist is the momentum about the centre of mass, in world axes, of all moving links as \
            one rigid body with this twist at the centre of mass.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::CentroidalMomentum,
        name: "centroidal_momentum",
        known_as: &["pin.computeCentroidalMomentum"],
        arguments: &[Q, QD],
        result: shapes::momentum,
        result_name: Some("momentum"),
        docs: "Returns the momentum of the moving links about their centre of mass, in world axes. \
            Armatures have energy, but no momentum: their axes are not described.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::CentroidalMomentumRate,
        name: "centroidal_momentum_rate",
        known_as: &["pin.computeCentroidalMomentumTimeVariation"],
        arguments: &[Q, QD, QDD],
        result: shapes::momentum,
        result_name: Some("momentum_rate"),
        docs: "Returns the time derivative of the centroidal momentum in world axes: the moment (N \
            m) and the force (N) about the centre of mass of gravity and of all forces from \
            outside. At `qdd` = 0 it is the bias A' qd, with the centroidal momentum matrix A.",
        casadi: true,
        ..Row::INERTIAL
    },
    Row {
        function: Function::CentroidalMomentumDerivatives,
        name: "centroidal_momentum_derivatives",
        known_as: &["pin.computeCentroidalDynamicsDerivatives"],
        arguments: &[Q, QD, QDD],
        result: shapes::centroidal_derivatives,
        result_name: Some("derivatives"),
        docs: "Returns the momentum of the moving links about their centre of mass, its time \
            derivative at `qdd` (the rate), and the derivatives of both with respect to `q` (in \
            tangent space) and `qd`, arrays of columns, in world axes. The derivatives of the \
            momentum with respect to `qd`, and of the rate with respect to `qdd`, are the \
            centroidal momentum matrix.",
        ..Row::INERTIAL
    },
    Row {
        function: Function::LinkPoses,
        name: "link_poses",
        known_as: &["forward kinematics", "pin.framesForwardKinematics", "mj_kinematics"],
        arguments: &[Q],
        result: shapes::poses,
        docs: "Returns the poses in the world of all links of the description, fixed links \
            included, in the order of `LINK_NAMES`.",
        default: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::LinkPose,
        name: "link_pose",
        known_as: &["forward kinematics", "pin.updateFramePlacement"],
        arguments: &[Q],
        by_link: true,
        result: shapes::pose,
        result_name: Some("pose"),
        docs: "Returns the pose of a link in the world. Computes the link's kinematic path only.",
        default: true,
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::LinkVelocity,
        name: "link_velocity",
        known_as: &["pin.getFrameVelocity", "mj_objectVelocity"],
        arguments: &[Q, QD],
        by_link: true,
        result: shapes::twist,
        result_name: Some("velocity"),
        docs: "Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in \
            world axes. Computes the link's kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::LinkVelocityLocal,
        name: "link_velocity_local",
        arguments: &[Q, QD],
        by_link: true,
        result: shapes::twist,
        result_name: Some("velocity"),
        docs: "Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in \
            the link's own axes. Computes the link's kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::LinkAcceleration,
        name: "link_acceleration",
        known_as: &["pin.getFrameClassicalAcceleration", "mj_objectAcceleration"],
        arguments: &[Q, QD, QDD],
        by_link: true,
        result: shapes::twist,
        result_name: Some("acceleration"),
        docs: "Returns the classical acceleration of a link's origin (m/s^2) and its angular \
            acceleration (rad/s^2), in world axes. Gravity is not included. Computes the link's \
            kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::LinkAccelerationLocal,
        name: "link_acceleration_local",
        arguments: &[Q, QD, QDD],
        by_link: true,
        result: shapes::twist,
        result_name: Some("acceleration"),
        docs: "Returns the classical acceleration of a link's origin (m/s^2) and its angular \
            acceleration (rad/s^2), in the link's own axes. Gravity is not included. Computes the \
            link's kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::Jacobian,
        name: "jacobian",
        known_as: &["geometric Jacobian", "pin.getFrameJacobian", "mj_jacBody"],
        arguments: &[Q],
        by_link: true,
        result: shapes::twists,
        docs: "Returns the Jacobian of a link, an array of columns. Its product with `qd` is the \
            velocity of the link at its origin, in world axes. Computes the link's kinematic path \
            only.",
        default: true,
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::JacobianLocal,
        name: "jacobian_local",
        arguments: &[Q],
        by_link: true,
        result: shapes::twists,
        result_name: Some("jacobian"),
        docs: "Returns the Jacobian of a link, an array of columns. Its product with `qd` is the \
            velocity of the link at its origin, in the link's own axes. Computes the link's \
            kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::JacobianTimeDerivative,
        name: "jacobian_time_derivative",
        known_as: &["pin.getFrameJacobianTimeVariation", "mj_jacDot"],
        arguments: &[Q, QD],
        by_link: true,
        result: shapes::twists,
        docs: "Returns the time derivative of `jacobian`, an array of columns. Its product with \
            `qd` is `jacobian_dot_qd`. Computes the link's kinematic path only.",
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::JacobianTimeDerivativeLocal,
        name: "jacobian_time_derivative_local",
        arguments: &[Q, QD],
        by_link: true,
        result: shapes::twists,
        docs: "Returns the time derivative of `jacobian_local`, an array of columns. Its product \
            with `qd` is `jacobian_dot_qd_local`. Computes the link's kinematic path only.",
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::JacobianDotQd,
        name: "jacobian_dot_qd",
        known_as: &["Jdot qd", "drift acceleration"],
        arguments: &[Q, QD],
        by_link: true,
        result: shapes::twist,
        result_name: Some("acceleration"),
        docs: "Returns the bias acceleration of a link in world axes: the time derivative of \
            `jacobian` times `qd`, which is the link's acceleration at zero joint accelerations. \
            Computes the link's kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::JacobianDotQdLocal,
        name: "jacobian_dot_qd_local",
        arguments: &[Q, QD],
        by_link: true,
        result: shapes::twist,
        result_name: Some("acceleration"),
        docs: "Returns the bias acceleration of a link in its own axes: the time derivative of \
            `jacobian_local` times `qd`. Computes the link's kinematic path only.",
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::Integrate,
        name: "integrate",
        known_as: &["pin.integrate", "mj_integratePos"],
        arguments: &[Q, V],
        result: shapes::coordinates,
        result_name: Some("q_next"),
        docs: "Returns the coordinates after the displacement `v` (a velocity times a time) from \
            `q`.",
        default: true,
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::Difference,
        name: "difference",
        known_as: &["pin.difference", "mj_differentiatePos"],
        arguments: &[FROM, TO],
        result: shapes::velocities,
        result_name: Some("displacement"),
        docs: "Returns the displacement `v` with which `integrate` leads from `from` to `to`. \
            Rotations are the shortest ones; joint angles are not wrapped.",
        default: true,
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::IntegrateDerivatives,
        name: "integrate_derivatives",
        known_as: &["pin.dIntegrate"],
        arguments: &[Q, V],
        result: shapes::integrate_derivatives,
        docs: "Returns the derivatives of `integrate` with respect to `q` and `v`, each an array \
            of columns in tangent space: displacements of `q` and of the result are in the axes at \
            each of them.",
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::DifferenceDerivatives,
        name: "difference_derivatives",
        known_as: &["pin.dDifference"],
        arguments: &[FROM, TO],
        result: shapes::difference_derivatives,
        docs: "Returns the derivatives of `difference` with respect to `from` and `to`, each an \
            array of columns in tangent space: displacements are in the axes at `from` and at \
            `to`.",
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::VelocityToQdot,
        name: "velocity_to_qdot",
        arguments: &[Q, QD],
        result: shapes::coordinates,
        result_name: Some("qdot"),
        docs: "Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.",
        default: true,
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::NormalizeConfiguration,
        name: "normalize_configuration",
        known_as: &["pin.normalize", "mj_normalizeQuat"],
        arguments: &[Q],
        result: shapes::coordinates,
        result_name: Some("unit_q"),
        docs: "Returns the coordinates with quaternions scaled to length 1.",
        default: true,
        casadi: true,
        ..Row::GEOMETRIC
    },
    Row {
        function: Function::RandomConfiguration,
        name: "random_configuration",
        known_as: &["pin.randomConfiguration"],
        arguments: &[UNIFORMS],
        result: shapes::coordinates,
        docs: "Returns coordinates within the joint limits, from random numbers uniformly \
            distributed in [0, 1). Angles without limits are in [-pi, pi), displacements without \
            limits in [-1, 1) m, rotations uniform over SO(3).",
        default: true,
        ..Row::GEOMETRIC
    },
];
