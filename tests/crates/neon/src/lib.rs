//! Robots whose functions run on vectors: batches, equal limbs and columns of derivatives, in both precisions.
//!
//! `.ci/run` runs the tests for aarch64 in QEMU; `cargo test` runs them on the host.

modyn::modyn! {
    pub Arm = "../../../../robots/arm7.urdf",
    friction = none,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, forward_dynamics_derivatives, random,
        forward_dynamics_batch, inverse_dynamics_batch, mass_matrix_batch
    ]
}

modyn::modyn! {
    pub SingleArm = "../../../../robots/arm7.urdf",
    friction = none,
    scalar = f32,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, random,
        forward_dynamics_batch, inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub Quadruped = "../../../../robots/quadruped.urdf",
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, forward_dynamics_derivatives, random,
        forward_dynamics_batch, inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub Flying = "../../../../robots/quadruped.urdf",
    base = floating,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, random, forward_dynamics_batch, inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub SingleFlying = "../../../../robots/quadruped.urdf",
    base = floating,
    scalar = f32,
    functions = [
        forward_dynamics, inverse_dynamics, mass_matrix, random, forward_dynamics_batch, inverse_dynamics_batch
    ]
}

modyn::modyn! {
    pub Humanoid = "../../../../robots/humanoid.urdf",
    functions = [forward_dynamics, inverse_dynamics, mass_matrix, random]
}
