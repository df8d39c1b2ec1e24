//! Run-time inertias, payloads and gravity in the robot's own scalar: the combinations that are errors, and derivatives
//! by them.

use modyn::{Inertial, ParameterError, Robot, Scalar, functions};
use modyn_runtime::num_dual::Dual64;

modyn::modyn! {
    Arm = "../../../robots/arm7.urdf",
    joint_friction = none,
    runtime_gravity = true,
    runtime_inertia = ["link7", "hand", "link4"],
    payload = ["hand"],
    functions = [default, forward_dynamics_derivatives]
}
modyn::modyn! {
    Single = "../../../robots/arm7.urdf",
    joint_friction = none,
    scalar = f32,
    runtime_gravity = true,
    runtime_inertia = ["link4"],
    payload = ["hand"],
    functions = [forward_dynamics, inverse_dynamics]
}
// All links after the wrist have run-time inertias: without these and the payload, the last joint has no inertia.
modyn::modyn! {
    Wrist = "../../../robots/arm7.urdf",
    joint_friction = none,
    runtime_inertia = ["link7", "hand", "left_finger", "right_finger"],
    payload = ["grasp_point"],
    functions = [forward_dynamics]
}

/// A state in general position.
const Q: [f64; 7] = [0.3, -0.7, 0.9, -1.8, 0.4, 1.6, -0.6];
const QD: [f64; 7] = [0.5, -1.2, 0.8, 0.3, -0.9, 1.1, -0.4];
const TAU: [f64; 7] = [3.0, -8.0, 5.0, 2.0, -1.0, 0.7, 0.2];

/// A payload in the hand.
const LOAD: Inertial = Inertial {
    mass: 1.5,
    center_of_mass: [0.03, -0.02, 0.11],
    inertia: [0.012, 0.001, -0.002, 0.015, 0.0005, 0.009],
};

const NONE: Inertial = Inertial { mass: 0.0, center_of_mass: [0.0; 3], inertia: [0.0; 6] };

/// Returns all accelerations that depend on `params`, for any robot and scalar.
fn accelerations<R: Robot + functions::ForwardDynamics, T: Scalar>(
    params: &R::Params<T>,
    q: &R::Q<T>,
    qd: &R::V<T>,
    tau: &R::V<T>,
) -> R::V<T> {
    R::forward_dynamics_with(params, q, qd, tau)
}

/// Asserts that the derivatives of forward dynamics by the number that `set` changes are the same on dual numbers
/// through the trait and by central differences.
fn check_derivative(
    what: &str,
    value: f64,
    set: impl Fn(&mut ArmParams<f64>, f64),
    set_dual: impl Fn(&mut ArmParams<Dual64>, Dual64),
) {
    let dual = |x: [f64; 7]| x.map(Dual64::from_re);
    let mut loaded = ArmParams::DEFAULT;
    loaded.set_payload_of_hand(LOAD).expect("a body's");
    let mut params = loaded.map(Dual64::from_re);
    set_dual(&mut params, Dual64::from_re(value).derivative());
    let found = accelerations::<Arm, Dual64>(&params, &dual(Q), &dual(QD), &dual(TAU));
    let at = |value: f64| {
        let mut params = loaded;
        set(&mut params, value);
        accelerations::<Arm, f64>(&params, &Q, &QD, &TAU)
    };
    for (found, expected) in found.iter().zip(at(value)) {
        assert!((found.re - expected).abs() < 1e-12 * expected.abs().max(1.0), "{what}");
    }
    let h = 1e-4;
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(value + k * h));
    let largest = found.iter().fold(0.0, |largest: f64, x| largest.max(x.eps.abs()));
    assert!(largest > 1e-3, "{what}: it matters");
    for i in 0..7 {
        let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h);
        let close = (found[i].eps - difference).abs() < 1e-8 * largest;
        assert!(close, "{what}: {} instead of {difference}", found[i].eps);
    }
}

#[test]
fn accelerations_by_gravity() {
    for k in 0..3 {
        let with =
            |gravity: [f64; 3], x| std::array::from_fn(|i| if i == k { x } else { gravity[i] });
        check_derivative(
            &format!("gravity {k}"),
            ArmParams::DEFAULT.gravity()[k],
            |params, x| params.set_gravity(with(params.gravity(), x)),
            |params, x| {
                let mut gravity = params.gravity();
                gravity[k] = x;
                params.set_gravity(gravity);
            },
        );
    }
}

#[test]
fn accelerations_by_masses_and_inertias() {
    check_derivative(
        "mass of the load",
        LOAD.mass,
        |params, mass| params.set_payload_of_hand(Inertial { mass, ..LOAD }).expect("a body's"),
        |params, mass| {
            let load = Inertial { mass, ..LOAD.map(Dual64::from_re) };
            params.set_payload_of_hand(load).expect("a body's");
        },
    );
    let link4 = ArmParams::DEFAULT.inertia_of_link4();
    check_derivative(
        "mass of a link",
        link4.mass,
        |params, mass| params.set_inertia_of_link4(Inertial { mass, ..link4 }).expect("a body's"),
        |params, mass| {
            let own = Inertial { mass, ..params.inertia_of_link4() };
            params.set_inertia_of_link4(own).expect("a body's");
        },
    );
    let with = |mut own: Inertial, x| {
        own.inertia[5] = x;
        own
    };
    let link7 = ArmParams::DEFAULT.inertia_of_link7();
    check_derivative(
        "moment of inertia of a link",
        link7.inertia[5],
        |params, x| params.set_inertia_of_link7(with(link7, x)).expect("a body's"),
        |params, x| {
            let mut own = params.inertia_of_link7();
            own.inertia[5] = x;
            params.set_inertia_of_link7(own).expect("a body's");
        },
    );
    // Invalid inertias are refused on dual numbers as well.
    let mut params = ArmParams::<Dual64>::default();
    let negative = Inertial { mass: Dual64::from_re(-1.0), ..params.inertia_of_link4() };
    assert!(matches!(params.set_inertia_of_link4(negative), Err(ParameterError::Defect(_))));
    assert_eq!(params, ArmParams::default());
}

#[test]
fn no_joint_is_left_without_inertia() {
    let error = ParameterError::NoInertia { joint: "joint7" };
    let refused = Err(error);
    let mut params = WristParams::DEFAULT;
    params.set_inertia_of_link7(NONE).expect("the hand is left");
    params.set_inertia_of_hand(NONE).expect("the fingers are left");
    params.set_inertia_of_left_finger(NONE).expect("the right one is left");
    let last = params;
    assert_eq!(params.set_inertia_of_right_finger(NONE), refused);
    assert_eq!(params, last, "nothing has changed");
    // A point mass on the last joint's axis gives that joint no inertia; a point mass beside the axis does.
    let mass = |x: f64| Inertial { mass: 0.5, center_of_mass: [x, 0.0, 0.1], ..NONE };
    assert_eq!(params.set_inertia_of_right_finger(NONE), refused);
    params.set_inertia_of_link7(mass(0.05)).expect("beside the axis");
    params.set_inertia_of_right_finger(NONE).expect("the link is left");
    assert_eq!(params.set_inertia_of_link7(mass(0.0)), refused);
    // A payload can give the joint its inertia; then the payload must stay.
    params.set_payload_of_grasp_point(LOAD).expect("a body's");
    params.set_inertia_of_link7(NONE).expect("the payload is left");
    assert_eq!(params.set_payload_of_grasp_point(NONE), refused);
    let qdd = Wrist::forward_dynamics_with(&params, &Q, &QD, &TAU);
    assert!(qdd.iter().all(|x| x.is_finite() && x.abs() < 1e4), "{qdd:?}");
    let message = error.to_string();
    assert!(message.contains("`joint7`") && message.contains("infinite"), "{message}");
    // Where other links give the joints their inertia, any inertia is accepted.
    let mut params = ArmParams::DEFAULT;
    params.set_inertia_of_link4(NONE).expect("the links after it have inertia");
}

#[test]
fn parameters_are_in_the_robots_own_scalar() {
    let mut params = SingleParams::DEFAULT;
    assert_eq!(params, SingleParams::default());
    params.set_gravity([0.5_f32, -0.25, -1.62]);
    params.set_payload_of_hand(LOAD.map(|x| x as f32)).expect("a body's");
    let own: Inertial<f32> = params.inertia_of_link4();
    params.set_inertia_of_link4(Inertial { mass: 2.0 * own.mass, ..own }).expect("a body's");
    let single = |x: [f64; 7]| x.map(|x| x as f32);
    let found: [f32; 7] =
        Single::inverse_dynamics_with(&params, &single(Q), &single(QD), &single(TAU));
    let mut exact = SingleParams::<f64>::default();
    exact.set_gravity([0.5, -0.25, -1.62]);
    exact.set_payload_of_hand(LOAD).expect("a body's");
    let own = exact.inertia_of_link4();
    exact.set_inertia_of_link4(Inertial { mass: 2.0 * own.mass, ..own }).expect("a body's");
    let expected = <Single as Robot>::inverse_dynamics_with(&exact, &Q, &QD, &TAU);
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(
            (f64::from(found) - expected).abs() < 2e-5 * expected.abs().max(10.0),
            "{found} {expected}"
        );
    }
    let tiny = Inertial { mass: f32::NAN, ..Inertial::default() };
    assert!(matches!(params.set_payload_of_hand(tiny), Err(ParameterError::Defect(_))));
}
