//! The largest robot, 29 joints, with all functions.
modyn::modyn!("../../../../robots/humanoid.urdf");

/// Calls every function of the trait, in single precision.
pub fn single(q: &[f32; 29], qd: &[f32; 29]) -> ([f32; 29], HumanoidUduFactorization<f32>) {
    use modyn::Robot;
    (<Humanoid as Robot>::forward_dynamics(q, qd, qd), <Humanoid as Robot>::brge(q))
}
