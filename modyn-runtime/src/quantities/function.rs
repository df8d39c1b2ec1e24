//! The functions.

/// A function of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Function {
    // A new variant is written by hand, with any documentation, at the place of its row. Then
    // `cargo xtask pages` writes the documentation of the row.
    // <!-- data: function-variants -->
    /// Returns the joint accelerations (rad/s^2 or m/s^2) at the coordinates `q` and velocities
    /// `qd` under the joint forces `tau` (N m or N), gravity included. The method is block reverse
    /// Gaussian elimination of the mass matrix by inter- and intra-modular recursion.
    ForwardDynamics,
    /// Returns the joint forces (N m or N) of the accelerations `qdd` at the coordinates `q` and
    /// velocities `qd`, gravity included, by the recursive Newton-Euler algorithm.
    InverseDynamics,
    /// Returns the bias forces (N m or N): inverse dynamics at zero acceleration. They are the
    /// Coriolis, centrifugal and gravity forces and the forces of springs, with damping and
    /// friction if these are enabled.
    BiasForces,
    /// Returns the joint forces (N m or N) that balance gravity and springs at `q` and zero
    /// velocity.
    GravityTorques,
    /// Returns the mass matrix at `q`, nv x nv, an array of columns.
    MassMatrix,
    /// Returns the Coriolis matrix C, nv x nv, an array of columns. C `qd` are the Coriolis and
    /// centrifugal forces, without gravity, damping and friction, and dM/dt - 2 C is skew with the
    /// mass matrix M.
    CoriolisMatrix,
    /// Returns the factorization U D U^T of the mass matrix at `q` by kinematic modules, by block
    /// reverse Gaussian elimination.
    Brge,
    /// Returns the kinetic energy of the moving links and the armatures, J.
    KineticEnergy,
    /// Returns the potential energy of the moving links under gravity and of the springs, J; zero
    /// for mass at the world's origin and springs at rest.
    PotentialEnergy,
    /// Returns the joint accelerations under `tau` and a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in the link's own axes.
    ForwardDynamicsExternalLocal,
    /// Returns the joint accelerations under `tau` and a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in world axes.
    ForwardDynamicsExternal,
    /// Returns the joint forces of `qdd` under a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in the link's own axes.
    InverseDynamicsExternalLocal,
    /// Returns the joint forces of `qdd` under a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in world axes.
    InverseDynamicsExternal,
    /// Returns the generalized forces J^T f of a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in the link's own axes, and their derivative with
    /// respect to `q` (in tangent space), an array of columns. The wrenches rotate with their
    /// links.
    GeneralizedForcesLocal,
    /// Returns the generalized forces J^T f of a wrench on each link (in the order of
    /// `LINK_NAMES`), at the link's origin in world axes, and their derivative with respect to `q`
    /// (in tangent space), an array of columns. The wrenches keep their directions.
    GeneralizedForces,
    /// Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`,
    /// each an array of columns. The derivative with respect to `qdd` is the mass matrix.
    InverseDynamicsDerivatives,
    /// Returns the joint accelerations, and the derivatives of forward dynamics with respect to `q`
    /// (in tangent space), `qd` and `tau`, each an array of columns.
    ForwardDynamicsDerivatives,
    /// Returns the joint forces tau of `qdd`, and the products of `cotangent` with their
    /// derivatives: the gradients of `cotangent`^T tau with respect to `q` (in tangent space), `qd`
    /// and `qdd`.
    InverseDynamicsVjp,
    /// Returns the joint forces tau of `qdd`, and their change under the changes `tangent_q` (in
    /// tangent space), `tangent_qd` and `tangent_qdd`.
    InverseDynamicsJvp,
    /// Returns the accelerations qdd, and the products of `cotangent` with their derivatives: the
    /// gradients of `cotangent`^T qdd with respect to `q` (in tangent space), `qd` and `tau`.
    ForwardDynamicsVjp,
    /// Returns the accelerations qdd, and their change under the changes `tangent_q` (in tangent
    /// space), `tangent_qd` and `tangent_tau`.
    ForwardDynamicsJvp,
    /// Returns the joint forces tau of `qdd`, and the gradients and the Hessian of `cotangent`^T
    /// tau with respect to `q` (in tangent space), `qd` and `qdd`. The blocks of the Hessian are
    /// arrays of columns; the blocks of `qd` and `qdd` and of `qdd` and `qdd` are zero.
    InverseDynamicsHessian,
    /// Returns the accelerations qdd, and the gradients and the Hessian of `cotangent`^T qdd with
    /// respect to `q` (in tangent space), `qd` and `tau`. The blocks of the Hessian are arrays of
    /// columns; the blocks of `qd` and `tau` and of `tau` and `tau` are zero.
    ForwardDynamicsHessian,
    /// Returns the state after the time `dt` (s) under the joint forces `tau`, by the semi-implicit
    /// Euler method: the new velocities are `qd` + `dt` qdd, and move the coordinates.
    StepSemiImplicit,
    /// Returns the state after the time `dt` (s) by the semi-implicit Euler method, and its
    /// derivatives: `a` with respect to the state before and `b` with respect to `tau`, arrays of
    /// columns. A state has the entries of q (in tangent space), then the entries of qd.
    StepSemiImplicitDerivatives,
    /// Returns a knot of optimal control: the velocities after a step of the time `dt` (s) by the
    /// semi-implicit Euler method, and the derivatives of the step in blocks, by rows. The
    /// derivatives of the velocities are with respect to `q` (in tangent space), `qd` and `tau`.
    /// The coordinates after the step are `integrate` of `q` and v, with v = `dt` times these
    /// velocities. Their derivatives with respect to `q` and v are 1, except for a 6 x 6 block at
    /// each quaternion, such as the quaternion of a floating base. A spherical joint has the
    /// angular part of its block.
    Knot,
    /// Returns the state after the time `dt` (s) by the semi-implicit Euler method, and the
    /// gradients and the Hessian of `state_cotangent`^T state: `grad_x` and `grad_tau` with respect
    /// to the state before and `tau`, and `hess_x_x`, `hess_x_tau` and `hess_tau_tau`, arrays of
    /// columns. A state has the entries of q (in tangent space), then the entries of qd.
    /// Displacements of the state after the step are in tangent space, too.
    StepSemiImplicitHessian,
    /// Returns the state after the time `dt` (s) under the constant joint forces `tau`, by a
    /// Runge-Kutta method of fourth order. Rotations follow exponential maps, so quaternions keep
    /// length 1.
    StepRk4,
    /// Returns the state of `step_rk4`, and its derivatives: `a` with respect to the state before
    /// and `b` with respect to `tau`, arrays of columns. A state has the entries of q (in tangent
    /// space), then the entries of qd.
    StepRk4Derivatives,
    /// Returns the state after the time `dt` (s) under the constant joint forces `tau`, by the
    /// implicit midpoint rule: of second order, symmetric, and stable under stiff damping. Three
    /// iterations of simplified Newton solve its equations. Rotations follow exponential maps, so
    /// quaternions keep length 1.
    StepImplicitMidpoint,
    /// Returns the state of `step_implicit_midpoint`, and the derivatives of the implicit midpoint
    /// rule: `a` with respect to the state before and `b` with respect to `tau`, arrays of columns.
    /// A state has the entries of q (in tangent space), then the entries of qd.
    StepImplicitMidpointDerivatives,
    /// Returns the joint accelerations under the joint forces `tau` with the loops closed and the
    /// active contacts held. Also returns the wrench on each constraint's link and the unmet part
    /// of the constraint's acceleration, and the number of independent constraint rows. Loop
    /// constraints come first, in the order of `LOOP_CONSTRAINT_NAMES`, at the second frame's
    /// origin in the first frame's axes. Contacts follow, in the order of `CONTACT_NAMES`, at the
    /// frame's origin in world axes. Redundant rows get the multipliers of smallest norm.
    ConstrainedForwardDynamics,
    /// Returns the displacement and the velocity of each loop constraint's second frame relative to
    /// its first, in the first frame's axes; then of each contact's frame, active or not, relative
    /// to its target, in world axes. Components along free directions are zero. A rotation is its
    /// axis times the sine of its angle.
    ConstraintResidual,
    /// Returns the smallest step (in the metric of the mass matrix) that closes the loops at `q`
    /// and moves the active contacts to their targets to first order, the smallest change of `qd`
    /// that keeps them there, and the number of independent constraint rows. The settings `alpha`
    /// and `beta` have no effect.
    ProjectConstraints,
    /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and their
    /// derivatives with respect to `q` (in tangent space), `qd` and `tau`, each an array of
    /// columns. The derivatives of wrenches are arrays for each constraint, in the axes of the
    /// wrenches. The rank is assumed constant; redundant rows get the derivatives of smallest norm.
    ConstrainedForwardDynamicsDerivatives,
    /// Returns the results of `knot` under the accelerations of `constrained_forward_dynamics`, and
    /// the wrenches of the constraints with their derivatives, which
    /// `constrained_forward_dynamics_derivatives` describes.
    ConstrainedKnot,
    /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and the
    /// gradients and the Hessian of their sum with the weights `cotangent` and `wrench_cotangent`
    /// (of the components of the wrenches) with respect to `q` (in tangent space), `qd` and `tau`.
    /// The blocks of the Hessian are arrays of columns; the blocks of `qd` and `tau` and of `tau`
    /// and `tau` are zero. The rank is assumed constant. Weights of wrenches need independent rows,
    /// or compliance.
    ConstrainedForwardDynamicsHessian,
    /// Returns the velocities after an impact that closes the loops and stops the active contacts
    /// relative to their targets at the same instant, the impulse of each constraint, and the
    /// number of independent constraint rows. Along its normal, a contact leaves with `restitution`
    /// times the speed before the impact. The settings `alpha` and `beta` have no effect.
    ImpactDynamics,
    /// Returns the state after a step of the time `dt` (s) under the joint forces `tau`, with
    /// contacts, joint limits, dry joint friction and closed loops by MuJoCo's law: soft
    /// constraints whose forces minimize a convex function. The solver is Newton's method, to the
    /// tolerance of `step_settings`; `residual` says how far it came, relative to the largest
    /// force. It starts from the accelerations `warm_start`: `qdd` of the last step, or zeros. The
    /// integrator is semi-implicit Euler, implicit in joint damping, or MuJoCo's `implicitfast`, as
    /// the description says.
    Step,
    /// Returns the results of `step`, and the derivatives of the state after it: `a` with respect
    /// to the state before and `b` with respect to `tau`, arrays of columns. A state has the
    /// entries of q (in tangent space), then the entries of qd. The derivatives follow from the
    /// implicit function theorem at the solution; where a contact opens or closes, or a point
    /// begins to slide, they are one-sided.
    StepDerivatives,
    /// Returns the results of `step`, and the gradients of `state_cotangent`^T state after it:
    /// `grad_x` with respect to the state before, and `grad_tau`. A state has the entries of q (in
    /// tangent space), then the entries of qd. At kinks they are as in `step_derivatives`.
    StepVjp,
    /// Returns the results of `step`, and the change `tangent_x` of the state after it under the
    /// changes `tangent_q` (in tangent space), `tangent_qd` and `tangent_tau`. A state has the
    /// entries of q (in tangent space), then the entries of qd. At kinks it is as in
    /// `step_derivatives`.
    StepJvp,
    /// Returns the points of the shapes that can touch the ground, in the order of the `forces` of
    /// `step`: the heights `gaps` above the ground (m; negative in it), the `positions` in the
    /// middle between the shape and the ground (m, world axes), and the `velocities` of the link
    /// there, along the x and y axes of the plane, then along its normal (m/s).
    TouchingPoints,
    /// Returns the joint forces `tau` of the actuators under the controls `ctrl`, in the order of
    /// `CONTROL_NAMES`, and the activations after the time `dt` (s), in the order of
    /// `ACTIVATION_NAMES`. The laws are MuJoCo's: controls, forces, activations and joint forces
    /// are clamped to the ranges of the description.
    Actuate,
    /// Returns the state and the activations after a step of the time `dt` (s) under the controls
    /// `ctrl`: MuJoCo's `mj_step`. The joint forces are the result of `actuate` at the state before
    /// the step, and the forces `applied` beside it (MuJoCo's `qfrc_applied`). All else is as in
    /// `step`.
    StepActuated,
    /// Returns the results of `step_actuated`, and the derivatives of the state after it: `a` with
    /// respect to the state before and `b` with respect to `ctrl`, arrays of columns. A state has
    /// the entries of q (in tangent space), the entries of qd, then `act`. All else is as in
    /// `step_derivatives`.
    StepActuatedDerivatives,
    /// Returns the results of `step_actuated`, and the gradients of `state_cotangent`^T state +
    /// `act_cotangent`^T act after it: `grad_x` with respect to the state before, and `grad_ctrl`.
    /// The state of `grad_x` has the entries of q (in tangent space), the entries of qd, then
    /// `act`. At kinks they are as in `step_derivatives`.
    StepActuatedVjp,
    /// Returns the results of `step_actuated`, and the change `tangent_x` of the state after it
    /// under the changes `tangent_q` (in tangent space), `tangent_qd`, `tangent_ctrl` and
    /// `tangent_act`. The state of `tangent_x` has the entries of q (in tangent space), the entries
    /// of qd, then `act`. At kinks it is as in `step_derivatives`.
    StepActuatedJvp,
    /// Returns the joint forces of the accelerations `qdd`, the wrenches of the active contacts
    /// that carry the floating bases, and the rank of the contacts' columns of the bases. The
    /// wrenches have the smallest sum of (force^2 + (moment / l)^2) / weight with the
    /// characteristic length l of each contact. The joint forces of a base are the wrench on it
    /// that no contact can carry. The wrenches of loop constraints are zero.
    ConstrainedInverseDynamics,
    /// Returns the Jacobian of each constraint, an array of columns. The product with `qd` is, for
    /// a loop constraint, the constrained part of the twist of its second frame relative to its
    /// first, in the first frame's axes; for a contact, active or not, the constrained part of its
    /// frame's twist in world axes.
    ConstraintJacobian,
    /// Returns the bias acceleration of each constraint: the time derivative of
    /// `constraint_jacobian` times `qd`, in the same axes.
    ConstraintJacobianDotQd,
    /// Returns the Delassus matrix J M^-1 J^T of the constraints with the mass matrix M, its
    /// pseudo-inverse, the operational-space inertia, and the number of independent constraint
    /// rows. Both matrices are arrays of columns; each constraint has its constrained
    /// displacements, then its constrained rotations, of a contact in world axes. The entries of
    /// inactive contacts are zero. The Delassus matrix contains the compliance.
    OperationalSpaceInertia,
    /// Returns the regressor Y of inverse dynamics, an array of columns: tau = Y pi, without
    /// armatures and friction. pi has ten entries for each moving link: mass, mass times centre of
    /// mass x, y, z, and Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the link's origin in the link's own
    /// axes (`PARAMETERS`).
    Regressor,
    /// Returns the centre of mass of the moving links in world axes, m.
    CenterOfMass,
    /// Returns the Jacobian of the centre of mass, an array of columns. Its product with `qd` is
    /// the velocity of the centre of mass in world axes.
    CenterOfMassJacobian,
    /// Returns the centroidal momentum matrix, an array of columns. Its product with `qd` is the
    /// momentum about the centre of mass, in world axes. Armatures have energy, but no momentum:
    /// their axes are not described.
    CentroidalMomentumMatrix,
    /// Returns the centroidal composite inertia, an array of columns. Its product with a twist is
    /// the momentum about the centre of mass, in world axes, of all moving links as one rigid body
    /// with this twist at the centre of mass.
    CentroidalCompositeInertia,
    /// Returns the momentum of the moving links about their centre of mass, in world axes.
    /// Armatures have energy, but no momentum: their axes are not described.
    CentroidalMomentum,
    /// Returns the time derivative of the centroidal momentum in world axes: the moment (N m) and
    /// the force (N) about the centre of mass of gravity and of all forces from outside. At `qdd` =
    /// 0 it is the bias A' qd, with the centroidal momentum matrix A.
    CentroidalMomentumRate,
    /// Returns the momentum of the moving links about their centre of mass, its time derivative at
    /// `qdd` (the rate), and the derivatives of both with respect to `q` (in tangent space) and
    /// `qd`, arrays of columns, in world axes. The derivatives of the momentum with respect to
    /// `qd`, and of the rate with respect to `qdd`, are the centroidal momentum matrix.
    CentroidalMomentumDerivatives,
    /// Returns the poses in the world of all links of the description, fixed links included, in the
    /// order of `LINK_NAMES`.
    LinkPoses,
    /// Returns the pose of a link in the world. Computes the link's kinematic path only.
    LinkPose,
    /// Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in world
    /// axes. Computes the link's kinematic path only.
    LinkVelocity,
    /// Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in the
    /// link's own axes. Computes the link's kinematic path only.
    LinkVelocityLocal,
    /// Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
    /// (rad/s^2), in world axes. Gravity is not included. Computes the link's kinematic path only.
    LinkAcceleration,
    /// Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
    /// (rad/s^2), in the link's own axes. Gravity is not included. Computes the link's kinematic
    /// path only.
    LinkAccelerationLocal,
    /// Returns the Jacobian of a link, an array of columns. Its product with `qd` is the velocity
    /// of the link at its origin, in world axes. Computes the link's kinematic path only.
    Jacobian,
    /// Returns the Jacobian of a link, an array of columns. Its product with `qd` is the velocity
    /// of the link at its origin, in the link's own axes. Computes the link's kinematic path only.
    JacobianLocal,
    /// Returns the time derivative of `jacobian`, an array of columns. Its product with `qd` is
    /// `jacobian_dot_qd`. Computes the link's kinematic path only.
    JacobianTimeDerivative,
    /// Returns the time derivative of `jacobian_local`, an array of columns. Its product with `qd`
    /// is `jacobian_dot_qd_local`. Computes the link's kinematic path only.
    JacobianTimeDerivativeLocal,
    /// Returns the bias acceleration of a link in world axes: the time derivative of `jacobian`
    /// times `qd`, which is the link's acceleration at zero joint accelerations. Computes the
    /// link's kinematic path only.
    JacobianDotQd,
    /// Returns the bias acceleration of a link in its own axes: the time derivative of
    /// `jacobian_local` times `qd`. Computes the link's kinematic path only.
    JacobianDotQdLocal,
    /// Returns the coordinates after the displacement `v` (a velocity times a time) from `q`.
    Integrate,
    /// Returns the displacement `v` with which `integrate` leads from `from` to `to`. Rotations are
    /// the shortest ones; joint angles are not wrapped.
    Difference,
    /// Returns the derivatives of `integrate` with respect to `q` and `v`, each an array of columns
    /// in tangent space: displacements of `q` and of the result are in the axes at each of them.
    IntegrateDerivatives,
    /// Returns the derivatives of `difference` with respect to `from` and `to`, each an array of
    /// columns in tangent space: displacements are in the axes at `from` and at `to`.
    DifferenceDerivatives,
    /// Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.
    VelocityToQdot,
    /// Returns the coordinates with quaternions scaled to length 1.
    NormalizeConfiguration,
    /// Returns coordinates within the joint limits, from random numbers uniformly distributed in
    /// [0, 1). Angles without limits are in [-pi, pi), displacements without limits in [-1, 1) m,
    /// rotations uniform over SO(3).
    RandomConfiguration,
    /// `forward_dynamics` of many states at a time.
    ForwardDynamicsBatch,
    /// `inverse_dynamics` of many states at a time.
    InverseDynamicsBatch,
    /// `bias_forces` of many states at a time.
    BiasForcesBatch,
    /// `gravity_torques` of many states at a time.
    GravityTorquesBatch,
    /// `mass_matrix` of many states at a time.
    MassMatrixBatch,
    /// `brge` of many states at a time.
    BrgeBatch,
    /// `kinetic_energy` of many states at a time.
    KineticEnergyBatch,
    /// `potential_energy` of many states at a time.
    PotentialEnergyBatch,
    /// `inverse_dynamics_derivatives` of many states at a time.
    InverseDynamicsDerivativesBatch,
    /// `forward_dynamics_derivatives` of many states at a time.
    ForwardDynamicsDerivativesBatch,
    /// `inverse_dynamics_hessian` of many states at a time.
    InverseDynamicsHessianBatch,
    /// `forward_dynamics_hessian` of many states at a time.
    ForwardDynamicsHessianBatch,
    /// `knot` of many states at a time.
    KnotBatch,
    /// `constrained_forward_dynamics` of many states at a time.
    ConstrainedForwardDynamicsBatch,
    /// `constraint_residual` of many states at a time.
    ConstraintResidualBatch,
    /// `project_constraints` of many states at a time.
    ProjectConstraintsBatch,
    /// `constrained_forward_dynamics_derivatives` of many states at a time.
    ConstrainedForwardDynamicsDerivativesBatch,
    /// `constrained_knot` of many states at a time.
    ConstrainedKnotBatch,
    /// `impact_dynamics` of many states at a time.
    ImpactDynamicsBatch,
    /// `touching_points` of many states at a time.
    TouchingPointsBatch,
    /// `actuate` of many states at a time.
    ActuateBatch,
    /// `constrained_inverse_dynamics` of many states at a time.
    ConstrainedInverseDynamicsBatch,
    /// `constraint_jacobian` of many states at a time.
    ConstraintJacobianBatch,
    /// `constraint_jacobian_dot_qd` of many states at a time.
    ConstraintJacobianDotQdBatch,
    /// `operational_space_inertia` of many states at a time.
    OperationalSpaceInertiaBatch,
    // <!-- end -->
}
