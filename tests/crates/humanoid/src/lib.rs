//! The largest robot, 29 joints, all functions compiled.
modyn::modyn!("../../../../robots/humanoid.urdf");

/// All that generic code could ask for, in single precision.
pub fn single(q: &[f32; 29], qd: &[f32; 29]) -> ([f32; 29], HumanoidUduFactorization<f32>) {
    use modyn::Robot;
    (<Humanoid as Robot>::forward_dynamics(q, qd, qd), <Humanoid as Robot>::brge(q))
}
