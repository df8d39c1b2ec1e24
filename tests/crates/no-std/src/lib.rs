//! A crate without `std`, for firmware: nothing here, and nothing in what it depends on, may use
//! the standard library or a heap. It is built for a target that has neither.
#![no_std]
#![forbid(unsafe_code)]
#![deny(warnings, missing_docs)]

modyn::modyn!(pub Arm = "../../../../robots/arm7.urdf", scalar = f32);
modyn::modyn!("../../../../robots/gripper.urdf");
modyn::modyn!(pub Zoo = "../../../../robots/joint_zoo.urdf", scalar = f32);
modyn::modyn!(pub Pendulum = "../../../../robots/double_pendulum.urdf", functions = all, scalar = f32);

/// Returns the torques that hold the arm and accelerate it.
#[must_use]
pub fn control(q: &[f32; Arm::NQ], qd: &[f32; Arm::NV], qdd: &[f32; Arm::NV]) -> [f32; Arm::NV] {
    Arm::inverse_dynamics(q, qd, qdd)
}

/// Returns the accelerations of the gripper's joints.
#[must_use]
pub fn accelerations(tau: &[f64; 4]) -> [f64; 4] {
    Gripper::brge(&[0.1; 4]).solve(tau)
}
