//! Robots whose functions run on vectors: batches, equal limbs and columns of derivatives, in both precisions.
//!
//! `.ci/run` runs the tests for aarch64 in QEMU; `cargo test` runs them on the host.

modyn::modyn! {
    pub Arm = "../../../../robots/arm7.urdf",
    embed_model = true,
    joint_friction = none,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, forward_dynamics_derivatives, random,
        forward_dynamics_batch, inverse_dynamics_batch, mass_matrix_batch
    ]
}

modyn::modyn! {
    pub SingleArm = "../../../../robots/arm7.urdf",
    embed_model = true,
    joint_friction = none,
    scalar = f32,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, random_configuration,
        forward_dynamics_batch, inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub Quadruped = "../../../../robots/quadruped.urdf",
    embed_model = true,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, forward_dynamics_derivatives, random,
        forward_dynamics_batch, inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub Flying = "../../../../robots/quadruped.urdf",
    embed_model = true,
    base = floating,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, random_configuration, forward_dynamics_batch,
        inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub SingleFlying = "../../../../robots/quadruped.urdf",
    embed_model = true,
    base = floating,
    scalar = f32,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, random_configuration, forward_dynamics_batch,
        inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub Humanoid = "../../../../robots/humanoid.urdf",
    embed_model = true,
    functions = [forward_dynamics, inverse_dynamics, mass_matrix, random_configuration]
}
