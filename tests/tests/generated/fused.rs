//! Fused functions of compiled robots give the numbers of their functions: through the macro, with run-time parameters,
//! in single precision, with a floating base, and for many states.

use modyn::spatial::{Pose, Twist, Vector3};
use modyn_tests::random::Random;

modyn::modyn! {
    Arm = "../../../robots/arm7.urdf",
    joint_friction = none,
    runtime_gravity = true,
    payload = ["link7"],
    functions = [
        mass_matrix, bias_forces, jacobian, jacobian_dot_qd, link_pose, step_semi_implicit,
        forward_dynamics_derivatives
    ],
    fused = [
        control: batch(
            mass_matrix, bias_forces, jacobian("hand"), jacobian_dot_qd("hand"), link_pose("hand")
        ),
        linear: batch(step_semi_implicit, forward_dynamics_derivatives),
    ]
}

modyn::modyn! {
    Flying = "../../../robots/quadruped.urdf",
    base = floating,
    scalar = f32,
    functions = [mass_matrix, bias_forces, jacobian, link_velocity, kinetic_energy, normalize_configuration],
    fused = [
        feet: (
            kinetic_energy, jacobian("front_left_foot"), jacobian("hind_right_foot"), bias_forces,
            mass_matrix, link_velocity("hind_right_foot")
        )
    ]
}

fn numbers<const N: usize>(random: &mut Random) -> [f64; N] {
    std::array::from_fn(|_| random.between(-2.0, 2.0))
}

/// Gravity that is not vertical, and a load.
fn params() -> ArmParams {
    let mut params = ArmParams::DEFAULT;
    params.set_gravity([1.0, -2.0, -8.0]);
    let mass = modyn::Inertial {
        mass: 1.5,
        center_of_mass: [0.1, -0.05, 0.2],
        inertia: [0.04, 0.001, 0.002, 0.05, -0.003, 0.03],
    };
    params.set_payload_of_link7(mass).expect("a rigid body");
    params
}

fn close<const N: usize>(name: &str, found: [f64; N], expected: [f64; N], relative: f64) {
    let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() <= relative * size, "{name}: {found} {expected}");
    }
}

fn columns<const N: usize>(jacobian: [Twist<f64>; N]) -> [[f64; 6]; N] {
    jacobian.map(|twist| twist.components())
}

/// Compares all entries of two lists of columns.
fn close_columns<const R: usize, const C: usize>(
    name: &str,
    found: [[f64; R]; C],
    expected: [[f64; R]; C],
    relative: f64,
) {
    let size = expected.as_flattened().iter().fold(1.0, |size: f64, x| size.max(x.abs()));
    for (found, expected) in found.into_iter().zip(expected) {
        close(name, found.map(|x| x / size), expected.map(|x| x / size), relative);
    }
}

fn close_poses(found: Pose<f64>, expected: Pose<f64>) {
    close_columns("rotation", found.rotation, expected.rotation, 1e-12);
    close("translation", found.translation, expected.translation, 1e-12);
}

#[test]
fn an_arm() {
    let mut random = Random::new(1);
    let params = params();
    for _ in 0..20 {
        let (q, qd, tau) = (numbers(&mut random), numbers(&mut random), numbers(&mut random));
        let ArmControl {
            mass_matrix,
            bias_forces,
            jacobian_hand,
            jacobian_dot_qd_hand,
            link_pose_hand,
        } = Arm::control_with(&params, &q, &qd);
        let hand = ArmLink::Hand;
        close_columns("mass", mass_matrix, Arm::mass_matrix_with(&params, &q), 1e-12);
        close("bias", bias_forces, Arm::bias_forces_with(&params, &q, &qd), 1e-12);
        close_columns("J", columns(jacobian_hand), columns(Arm::jacobian(&q, hand)), 1e-12);
        let rate = Arm::jacobian_dot_qd(&q, &qd, hand).components();
        close("J'", jacobian_dot_qd_hand.components(), rate, 1e-12);
        close_poses(link_pose_hand, Arm::link_pose(&q, hand));
        // The defaults are those of the description.
        close("bias", Arm::control(&q, &qd).bias_forces, Arm::bias_forces(&q, &qd), 1e-12);

        let linear = Arm::linear_with(&params, &q, &qd, &tau, 0.01);
        let step = Arm::step_semi_implicit_with(&params, &q, &qd, &tau, 0.01);
        close("q", linear.step_semi_implicit.q, step.q, 1e-11);
        close("qd", linear.step_semi_implicit.qd, step.qd, 1e-11);
        let expected = Arm::forward_dynamics_derivatives_with(&params, &q, &qd, &tau);
        let found = linear.forward_dynamics_derivatives;
        close("qdd", found.qdd, expected.qdd, 1e-10);
        close_columns("dqdd_dq", found.dqdd_dq, expected.dqdd_dq, 1e-10);
        close_columns("dqdd_dqd", found.dqdd_dqd, expected.dqdd_dqd, 1e-10);
        close_columns("dqdd_dtau", found.dqdd_dtau, expected.dqdd_dtau, 1e-10);
    }
}

#[test]
fn a_floating_base_in_single_precision() {
    let mut random = Random::new(2);
    let mut single = || random.between(-1.0, 1.0) as f32;
    for _ in 0..10 {
        let q = Flying::normalize_configuration(&std::array::from_fn(|_| single()));
        let qd = std::array::from_fn(|_| single());
        let found = Flying::feet(&q, &qd);
        let double = |x: [f32; 18]| x.map(f64::from);
        let of_twists = |all: [Twist<f32>; 18]| all.map(|twist| twist.components().map(f64::from));
        let energy = Flying::kinetic_energy(&q, &qd);
        close("energy", [found.kinetic_energy.into()], [energy.into()], 1e-5);
        for (found, link) in [
            (found.jacobian_front_left_foot, FlyingLink::FrontLeftFoot),
            (found.jacobian_hind_right_foot, FlyingLink::HindRightFoot),
        ] {
            let expected = of_twists(Flying::jacobian(&q, link));
            close_columns("J", of_twists(found), expected, 1e-5);
        }
        let bias = double(Flying::bias_forces(&q, &qd));
        close("bias", double(found.bias_forces), bias, 1e-4);
        let mass = Flying::mass_matrix(&q).map(double);
        close_columns("mass", found.mass_matrix.map(double), mass, 1e-5);
        let velocity = Flying::link_velocity(&q, &qd, FlyingLink::HindRightFoot);
        let velocity = velocity.components().map(f64::from);
        let found = found.link_velocity_hind_right_foot.components().map(f64::from);
        close("velocity", found, velocity, 1e-5);
    }
}

/// The number of states: several vectors, and a rest.
const STATES: usize = 37;

#[test]
fn many_states() {
    let mut random = Random::new(3);
    let params = params();
    let q: Vec<[f64; 7]> = (0..STATES).map(|_| numbers(&mut random)).collect();
    let qd: Vec<[f64; 7]> = (0..STATES).map(|_| numbers(&mut random)).collect();
    let expected: Vec<ArmControl> =
        q.iter().zip(&qd).map(|(q, qd)| Arm::control_with(&params, q, qd)).collect();
    let compare = |k: usize, found: &ArmControl| {
        let expected = &expected[k];
        close_columns("mass", found.mass_matrix, expected.mass_matrix, 1e-11);
        close("bias", found.bias_forces, expected.bias_forces, 1e-11);
        let jacobians = [found, expected].map(|all| columns(all.jacobian_hand));
        close_columns("J", jacobians[0], jacobians[1], 1e-11);
        let rates = [found, expected].map(|all| all.jacobian_dot_qd_hand.components());
        close("J'", rates[0], rates[1], 1e-11);
        close_poses(found.link_pose_hand, expected.link_pose_hand);
    };

    // Results in structures, one for each state.
    let mut each = vec![Arm::control(&[0.0; 7], &[0.0; 7]); STATES];
    Arm::control_each_with(&params, &q, &qd, &mut each).expect("sizes");
    each.iter().enumerate().for_each(|(k, found)| compare(k, found));

    // A slice for each number of the arguments and the results.
    let coordinate = |all: &[[f64; 7]], i: usize| all.iter().map(|x| x[i]).collect::<Vec<f64>>();
    let (q_columns, qd_columns): (Vec<_>, Vec<_>) =
        (0..7).map(|i| (coordinate(&q, i), coordinate(&qd, i))).unzip();
    let numbers = 49 + 7 + 6 * 7 + 6 + 12;
    let mut results = vec![vec![f64::NAN; STATES]; numbers];
    let mut slices = results.iter_mut().map(Vec::as_mut_slice);
    let mut next = || slices.next().expect("a slice");
    let mass_matrix = std::array::from_fn(|_| std::array::from_fn(|_| next()));
    let bias_forces = std::array::from_fn(|_| next());
    let mut twist = || {
        let [linear, angular] = std::array::from_fn(|_| Vector3(std::array::from_fn(|_| next())));
        Twist { linear, angular }
    };
    let jacobian: [Twist<&mut [f64]>; 7] = std::array::from_fn(|_| twist());
    let rate = twist();
    let rotation = std::array::from_fn(|_| std::array::from_fn(|_| next()));
    let pose = Pose { rotation, translation: std::array::from_fn(|_| next()) };
    Arm::control_batch_with(
        &params,
        std::array::from_fn(|i| &*q_columns[i]),
        std::array::from_fn(|i| &*qd_columns[i]),
        mass_matrix,
        bias_forces,
        jacobian,
        rate,
        pose,
    )
    .expect("sizes");
    for k in 0..STATES {
        let mut place = results.iter().map(|column| column[k]);
        let mut next = || place.next().expect("a number");
        let mass_matrix = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let bias_forces = std::array::from_fn(|_| next());
        let mut twist = || Twist::from_components(std::array::from_fn(|_| next()));
        let jacobian_hand = std::array::from_fn(|_| twist());
        let jacobian_dot_qd_hand = twist();
        let rotation = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let link_pose_hand = Pose { rotation, translation: std::array::from_fn(|_| next()) };
        let found = ArmControl {
            mass_matrix,
            bias_forces,
            jacobian_hand,
            jacobian_dot_qd_hand,
            link_pose_hand,
        };
        compare(k, &found);
    }

    // An argument that is a number, and results in structures of the runtime.
    let steps = vec![0.01; STATES];
    let mut linear = vec![Arm::linear(&q[0], &qd[0], &qd[0], 0.0); STATES];
    Arm::linear_each_with(&params, &q, &qd, &qd, &steps, &mut linear).expect("sizes");
    for (k, found) in linear.iter().enumerate() {
        let expected = Arm::linear_with(&params, &q[k], &qd[k], &qd[k], 0.01);
        close("q", found.step_semi_implicit.q, expected.step_semi_implicit.q, 1e-10);
        let of = |all: &ArmLinear| all.forward_dynamics_derivatives;
        close_columns("dqdd_dq", of(found).dqdd_dq, of(&expected).dqdd_dq, 1e-9);
        close_columns("dqdd_dtau", of(found).dqdd_dtau, of(&expected).dqdd_dtau, 1e-9);
    }
    let error = Arm::control_each(&q, &qd[1..], &mut each).expect_err("other numbers of states");
    assert!(error.to_string().contains("qd"), "{error}");
}
