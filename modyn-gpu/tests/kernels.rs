//! The kernels give the interpreter's results, on any available processor: in CI, on Mesa's software processor.

use crate::common;

use modyn_codegen::{Base, Builder, Function};
use modyn_gpu::{Gpu, GpuError, GpuRobot};
use modyn_runtime::{ForwardDerivatives, Interpreter};

use modyn_runtime::spatial::Pose;

use common::{columns, numbers, robot};

const STATES: usize = 300;

/// A function that computes the interpreter's result for the state with this number.
type Equation<'a> = dyn FnMut(&mut Interpreter<f64>, usize, &mut [f64]) + 'a;

/// The arguments of all functions, for each state.
#[derive(Clone)]
struct States {
    q: Vec<Vec<f64>>,
    qd: Vec<Vec<f64>>,
    tau: Vec<Vec<f64>>,
    qdd: Vec<Vec<f64>>,
}

impl States {
    /// Returns these states with each number changed by at most the rounding error of single precision.
    fn shaken(&self, seed: usize) -> Self {
        let mut shaken = self.clone();
        let States { q, qd, tau, qdd } = &mut shaken;
        let all = || [&self.q, &self.qd, &self.tau, &self.qdd];
        let count = all().iter().map(|states| states.len() * states[0].len()).sum::<usize>();
        let mut noise = numbers(count * (seed + 1)).into_iter().skip(count * seed);
        for x in [q, qd, tau, qdd].into_iter().flatten().flatten() {
            *x *= 1.0 + f64::from(f32::EPSILON) / 2.0 * noise.next().expect("enough");
        }
        shaken
    }
}

/// The interpreter's results: for each kernel its name and, for each state, the numbers.
fn expected(
    interpreter: &mut Interpreter<f64>,
    states: &States,
) -> Vec<(&'static str, Vec<Vec<f64>>)> {
    let model = interpreter.model();
    let (nv, links) = (model.nv(), model.frames().len());
    let mut each = |size: usize, equation: &mut Equation<'_>| {
        let one = |i: usize| {
            let mut out = vec![0.0; size];
            equation(interpreter, i, &mut out);
            out
        };
        (0..STATES).map(one).collect::<Vec<Vec<f64>>>()
    };
    let States { q, qd, tau, qdd } = states;
    let mut poses = vec![Pose::identity(); links];
    vec![
        (
            "forward_dynamics",
            each(nv, &mut |i, s, out| {
                i.forward_dynamics(&q[s], &qd[s], &tau[s], out).expect("lengths");
            }),
        ),
        (
            "inverse_dynamics",
            each(nv, &mut |i, s, out| {
                i.inverse_dynamics(&q[s], &qd[s], &qdd[s], out).expect("lengths");
            }),
        ),
        (
            "mass_matrix",
            each(nv * nv, &mut |i, s, out| i.mass_matrix(&q[s], out).expect("lengths")),
        ),
        (
            "gravity_torques",
            each(nv, &mut |i, s, out| i.gravity_torques(&q[s], out).expect("lengths")),
        ),
        (
            "link_poses",
            each(12 * links, &mut |i, s, out| {
                i.link_poses(&q[s], &mut poses).expect("lengths");
                for (out, pose) in out.chunks_exact_mut(12).zip(&poses) {
                    out[..9].copy_from_slice(pose.rotation.as_flattened());
                    out[9..].copy_from_slice(&pose.translation);
                }
            }),
        ),
        (
            "forward_dynamics_derivatives",
            each(nv + 3 * nv * nv, &mut |i, s, out| {
                let (qdd, out) = out.split_at_mut(nv);
                let (dqdd_dq, out) = out.split_at_mut(nv * nv);
                let (dqdd_dqd, dqdd_dtau) = out.split_at_mut(nv * nv);
                let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
                i.forward_dynamics_derivatives(&q[s], &qd[s], &tau[s], outputs).expect("lengths");
            }),
        ),
    ]
}

/// Compares kernels with the interpreter. The bound of a state follows how sensitive it is: `FLOOR` of its largest number, and
/// `FACTOR` times the change of the result when each argument changes by its rounding error in single precision.
fn check(name: &str, base: Base, scale: f64, functions: &[Function]) {
    const FLOOR: f64 = 4e-6;
    const FACTOR: f64 = 64.0;
    let gpu = Gpu::new().expect("a processor: Mesa has one in software");
    let builder = robot(name).base(base).functions(functions.iter().copied());
    let kernels = GpuRobot::new(&gpu, &builder).expect("kernels");
    let model = builder.generate().expect("good").model;
    let (nq, nv) = (model.nq(), model.nv());
    let mut interpreter = Interpreter::<f64>::new(model);
    let mut all = numbers(STATES * (nq + 3 * nv)).into_iter();
    let mut vector = |n: usize| all.by_ref().take(n).collect::<Vec<f64>>();
    let mut states = States { q: vec![], qd: vec![], tau: vec![], qdd: vec![] };
    for _ in 0..STATES {
        let drawn = vector(nq).iter().map(|x| f64::from((x * scale) as f32)).collect::<Vec<_>>();
        let mut unit = drawn.clone();
        interpreter.normalize(&mut unit).expect("lengths");
        states.q.push(unit.iter().map(|x| f64::from(*x as f32)).collect());
        states.qd.push(vector(nv));
        states.tau.push(vector(nv));
        states.qdd.push(vector(nv));
    }
    let shaken: Vec<_> =
        (0..4).map(|seed| expected(&mut interpreter, &states.shaken(seed))).collect();
    let upload = |states: &[Vec<f64>]| gpu.upload(&columns(states), STATES).expect("room");
    let [q, qd, tau, qdd] = [&states.q, &states.qd, &states.tau, &states.qdd].map(|x| upload(x));
    for (k, (kernel, expected)) in expected(&mut interpreter, &states).iter().enumerate() {
        if !functions.iter().any(|function| function.name() == *kernel) {
            continue;
        }
        let arguments = match *kernel {
            "forward_dynamics" | "forward_dynamics_derivatives" => vec![&q, &qd, &tau],
            "inverse_dynamics" => vec![&q, &qd, &qdd],
            _ => vec![&q],
        };
        let result = kernels.run(kernel, &arguments).expect("it runs");
        assert_eq!(result.states(), STATES);
        let found = result.read().expect("numbers");
        for (i, expected) in expected.iter().enumerate() {
            let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            let moved = |shaken: &Vec<(&str, Vec<Vec<f64>>)>| {
                let pairs = shaken[k].1[i].iter().zip(expected);
                pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
            };
            let spread = shaken.iter().map(moved).fold(0.0, f64::max);
            let bound = FLOOR * largest + FACTOR * spread;
            for (j, x) in expected.iter().enumerate() {
                let error = (f64::from(found[j * STATES + i]) - x).abs();
                let place = format!("{name}, {kernel}, number {j} of state {i}");
                assert!(error <= bound, "{place}: {error:e}, more than {bound:e}");
            }
        }
        let moving = expected.iter().flatten().any(|x| x.abs() > 1e-3);
        assert!(moving, "{name}, {kernel}: nothing moves");
    }
}

const FUNCTIONS: [Function; 6] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::GravityTorques,
    Function::ForwardDynamicsDerivatives,
    Function::LinkPoses,
];

#[test]
fn an_arm() {
    check("arm7", Base::Fixed, 3.0, &FUNCTIONS);
}

/// Angles beyond the fast reduction of sine and cosine. (The offset of a joint would round much larger angles.)
#[test]
fn an_arm_after_many_revolutions() {
    check("arm7", Base::Fixed, 100.0, &FUNCTIONS);
}

#[test]
fn all_joint_types() {
    check("joint_zoo", Base::Fixed, 1.0, &FUNCTIONS);
}

#[test]
fn a_floating_quadruped() {
    check("quadruped", Base::Floating, 1.0, &FUNCTIONS);
}

#[test]
#[ignore = "slow: a humanoid"]
fn a_humanoid() {
    check("humanoid", Base::Floating, 1.0, &[Function::ForwardDynamics, Function::LinkPoses]);
    check("humanoid", Base::Fixed, 1.0, &[Function::ForwardDynamicsDerivatives]);
}

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
