//! Kernels on any available processor: their arguments, their names, and numbers of all sizes. `conformance` compares their
//! results; in CI, on Mesa's software processor.

use modyn_codegen::{Builder, Function};
use modyn_gpu::{Gpu, GpuError, GpuRobot};

use crate::common::{columns, numbers};
use crate::conformance::robot;

#[test]
fn arguments_that_do_not_fit_are_refused() {
    let gpu = Gpu::new().expect("a processor");
    let builder = robot("arm6").functions([Function::GravityTorques, Function::LinkPose]);
    let kernels = GpuRobot::new(&gpu, &builder).expect("kernels");
    let q = gpu.upload(&[0.0; 12], 2).expect("room");
    let error = kernels.run("mass_matrix", &[&q]).expect_err("no such kernel").to_string();
    assert!(
        error.contains("no kernel `mass_matrix`; it has gravity_torques, link_pose_"),
        "{error}"
    );
    let error = kernels.run("gravity_torques", &[&q, &q]).expect_err("one argument");
    assert!(matches!(error, GpuError::Arguments { given: 2, .. }));
    let short = gpu.upload(&[0.0; 10], 2).expect("room");
    let error = kernels.run("gravity_torques", &[&short]).expect_err("six numbers").to_string();
    assert_eq!(error, "`arm6_gravity_torques` takes 6 numbers a state as `q`, not 5");
    let other = Gpu::new().expect("a processor").upload(&[0.0; 12], 2).expect("room");
    let error = kernels.run("gravity_torques", &[&other]).expect_err("another processor");
    assert!(matches!(error, GpuError::OtherProcessor { .. }), "{error}");
    assert!(matches!(gpu.upload(&[0.0; 5], 2), Err(GpuError::Length { .. })));
    assert!(matches!(gpu.upload(&[], 0), Err(GpuError::Length { .. })));
}

/// A robot named as the beginning of its functions.
#[test]
fn names_of_kernels_begin_with_that_of_the_robot_once() {
    let gpu = Gpu::new().expect("a processor");
    let builder = robot("arm6").type_name("Gravity").functions([Function::GravityTorques]);
    let kernels = GpuRobot::new(&gpu, &builder).expect("kernels");
    assert_eq!(kernels.source().kernels[0].name, "gravity_gravity_torques");
    let q = gpu.upload(&[0.5; 12], 2).expect("room");
    assert_eq!(kernels.run("gravity_torques", &[&q]).expect("it runs").scalars(), 6);
}

/// A driver may ignore NaN and infinities; they stay within their states. It may flush subnormal numbers to zero.
#[test]
fn states_that_are_not_finite_leave_others_alone() {
    let gpu = Gpu::new().expect("a processor");
    let builder = robot("arm7").functions([Function::ForwardDynamics]);
    let kernels = GpuRobot::new(&gpu, &builder).expect("kernels");
    let states: Vec<Vec<f64>> = numbers(21 * 64).chunks(21).map(<[f64]>::to_vec).collect();
    let run = |states: &[Vec<f64>]| {
        let part = |k: usize| {
            let part: Vec<_> = states.iter().map(|s| s[7 * k..7 * k + 7].to_vec()).collect();
            gpu.upload(&columns(&part), part.len()).expect("room")
        };
        let result = kernels.run("forward_dynamics", &[&part(0), &part(1), &part(2)]);
        result.expect("it runs").read().expect("numbers")
    };
    let before = run(&states);
    let (mut bad, mut tiny) = (states.clone(), states.clone());
    let mut zero = states.clone();
    for (i, number) in [(3, f64::NAN), (20, f64::INFINITY), (41, f64::NEG_INFINITY)] {
        for k in 0..3 {
            bad[i + k][7 * k + i % 7] = number;
            tiny[i + k][7 * k + i % 7] = 1e-40;
            zero[i + k][7 * k + i % 7] = 0.0;
        }
    }
    let changed = |i: usize| [3, 20, 41].iter().any(|first| (*first..first + 3).contains(&i));
    let after = run(&bad);
    for (at, (x, y)) in before.iter().zip(&after).enumerate() {
        assert!(changed(at % 64) || x == y, "state {}: {x} {y}", at % 64);
    }
    for (x, y) in run(&tiny).iter().zip(&run(&zero)) {
        assert!((x - y).abs() <= 1e-4 * y.abs().max(1.0), "{x} {y}");
    }
}

/// A pendulum's torque is the sine of its angle, for every finite angle.
#[test]
fn sines_of_all_angles() {
    let text = r#"<robot name="pendulum"><link name="world"/>
        <joint name="pivot" type="continuous"><parent link="world"/><child link="bob"/><axis xyz="0 1 0"/></joint>
        <link name="bob"><inertial><origin xyz="0 0 -1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
    let gpu = Gpu::new().expect("a processor");
    let builder = Builder::new().urdf_text(text, "pendulum.urdf").gravity([0.0, 0.0, -1.0]);
    let builder = builder.functions([Function::GravityTorques]);
    let kernels = GpuRobot::new(&gpu, &builder).expect("kernels");
    let mut angles = Vec::new();
    for i in 0..20_000_u32 {
        // Angles of all magnitudes, and angles close to multiples of pi.
        let magnitude = f32::from_bits((i * 104_729) % 0x7f80_0000);
        angles.extend([magnitude, -magnitude, (f64::from(i) * std::f64::consts::PI) as f32]);
    }
    let q = gpu.upload(&angles, angles.len()).expect("room");
    let found = kernels.run("gravity_torques", &[&q]).expect("it runs").read().expect("numbers");
    let mut worst = (0.0, 0.0);
    for (angle, sine) in angles.iter().zip(&found) {
        let error = (f64::from(*sine) - f64::from(*angle).sin()).abs();
        if error.is_nan() || error > worst.0 {
            worst = (error, *angle);
        }
    }
    assert!(worst.0 < 4e-7, "{worst:?}");
}
