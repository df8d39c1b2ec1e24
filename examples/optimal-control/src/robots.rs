//! The robots of the examples: a fixed arm of seven joints, the arm with a load and with the description's damping, and
//! floating quadrupeds with contacts at four feet, and at the two feet of each stance of a trot.

modyn::modyn! {
    pub(crate) Arm = "../../robots/arm7.urdf",
    joint_friction = none, // the description's damping does not act
    functions = [
        forward_dynamics, gravity_torques, knot, step_semi_implicit, step_semi_implicit_derivatives,
        link_pose, jacobian, integrate, difference, velocity_to_qdot, normalize_configuration,
        random_configuration,
    ]
}

modyn::modyn! {
    pub(crate) LoadedArm = "../../robots/arm7.urdf",
    joint_friction = viscous,
    payload = ["hand"],
    functions = [step_semi_implicit]
}

modyn::modyn! {
    pub(crate) Quadruped = "../../robots/quadruped.urdf",
    base = floating,
    functions = [
        mass_matrix, bias_forces, integrate, difference, difference_derivatives,
        constraint_jacobian, constraint_jacobian_dot_qd, constraint_residual,
        constrained_inverse_dynamics, constrained_forward_dynamics, constrained_knot, step,
    ],
    contacts = [
        "front left": point("front_left_foot"),
        "front right": point("front_right_foot"),
        "hind left": point("hind_left_foot"),
        "hind right": point("hind_right_foot"),
    ]
}

// The quadruped while two feet swing: a contact that is not active would cost as much as one that is.
modyn::modyn! {
    pub(crate) FrontLeftStance = "../../robots/quadruped.urdf",
    base = floating,
    functions = [constrained_forward_dynamics, constrained_knot],
    contacts = ["front left": point("front_left_foot"), "hind right": point("hind_right_foot")]
}

modyn::modyn! {
    pub(crate) FrontRightStance = "../../robots/quadruped.urdf",
    base = floating,
    functions = [constrained_forward_dynamics, constrained_knot],
    contacts = ["front right": point("front_right_foot"), "hind left": point("hind_left_foot")]
}

/// The settings of `FEET` contacts.
pub(crate) type Settings<const FEET: usize> =
    modyn::ConstraintSettings<f64, [modyn::ContactTarget<f64>; FEET]>;

/// The greatest torque of a joint of Solo12, N m (Grimminger et al. 2020, "An open torque-controlled modular robot
/// architecture for legged locomotion research"). The limits of the description are placeholders.
pub(crate) const TORQUE_LIMIT: f64 = 2.7;

/// Returns the coordinates of the quadruped with bent knees and its feet on the plane z = 0.
pub(crate) fn standing() -> [f64; 19] {
    let mut q = Quadruped::NEUTRAL;
    for leg in 0..4 {
        // Knees bend towards the trunk's middle.
        let bend = if leg < 2 { 0.6 } else { -0.6 };
        q[7 + 3 * leg + 1] = bend;
        q[7 + 3 * leg + 2] = -2.0 * bend;
    }
    let feet =
        Quadruped::constraint_residual(&q, &[0.0; 18], &Settings::<4>::DEFAULT).displacements;
    q[2] = -feet[0].linear[2];
    q
}
