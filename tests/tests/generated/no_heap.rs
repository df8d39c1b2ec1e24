//! No function of a generated robot allocates memory, called through the type or through the trait.

use std::hint::black_box;

use modyn::simulate::{Gains, Reference, SpringGround, State, limit_effort};
use modyn::spatial::{Pose, Vector3, Wrench};
use modyn::{ConstraintSettings, ContactSurface, ContactTarget, Inertial, Nalgebra, StepSettings};
use modyn_tests::counting::measure;

modyn::modyn!("../../../robots/gripper.urdf");
modyn::modyn!("../../../robots/quadruped.urdf", modules = links);
modyn::modyn!(Single = "../../../robots/arm7.urdf", joint_friction = none, scalar = f32);
modyn::modyn!(
    "../../../robots/joint_zoo.urdf",
    functions = [
        default,
        forward_dynamics_external_local,
        forward_dynamics_external,
        inverse_dynamics_external_local,
        inverse_dynamics_external,
        generalized_forces_local,
        generalized_forces,
        inverse_dynamics_derivatives,
        forward_dynamics_derivatives,
        regressor,
        center_of_mass,
        center_of_mass_jacobian,
        centroidal_momentum_matrix,
        centroidal_momentum,
        link_velocity,
        link_velocity_local,
        link_acceleration,
        link_acceleration_local,
        jacobian,
        jacobian_local,
        jacobian_dot_qd,
        jacobian_dot_qd_local
    ],
    joint_friction = smooth(0.01),
    runtime_gravity = true,
    runtime_inertia = ["tip"],
    payload = ["tip"],
);
modyn::modyn!(
    Standing = "../../../robots/quadruped.urdf",
    base = floating,
    functions = [default, step, constrained_forward_dynamics_batch],
    contacts = ["fl": point("front_left_foot"), "hr": point("hind_right_foot")],
);

macro_rules! allocates_nothing {
    ($robot:ident, $joint:ident, $scalar:ident) => {{
        let x = black_box([[0.3 as $scalar; $robot::NV]; 3]);
        let ((), allocated) = measure(|| {
            black_box($robot::forward_dynamics(&x[0], &x[1], &x[2]));
            black_box($robot::inverse_dynamics(&x[0], &x[1], &x[2]));
            black_box($robot::bias_forces(&x[0], &x[1]));
            black_box($robot::gravity_torques(&x[0]));
            black_box($robot::mass_matrix(&x[0]));
            black_box($robot::kinetic_energy(&x[0], &x[1]));
            black_box($robot::potential_energy(&x[0]));
            black_box($robot::link_poses(&x[0]));
            let brge = black_box($robot::brge(&x[0]));
            black_box((brge.u(), brge.d(), brge.u_inverse(), brge.d_inverse(), brge.inverse()));
            black_box((brge.solve(&x[2]), brge.log_determinant(), brge.pivot_block_0()));
            black_box((brge.condition_numbers(), $joint::ALL.map($joint::name)));
            black_box(<$robot as modyn::Robot>::forward_dynamics(&x[0], &x[1], &x[2]));
            let y = [[0.3; $robot::NV]; 2].map(nalgebra::SVector::from);
            black_box(Nalgebra::<$robot>::bias_forces(&y[0], &y[1]));
            black_box(Nalgebra::<$robot>::mass_matrix(&y[0]));
            black_box(Nalgebra::<$robot>::link_poses(&y[0]));
        });
        assert_eq!((allocated.calls, allocated.peak), (0, 0), "{}", $robot::NAME);
    }};
}

#[test]
fn calls_allocate_nothing() {
    allocates_nothing!(Gripper, GripperJoint, f64);
    allocates_nothing!(Quadruped, QuadrupedJoint, f64);
    allocates_nothing!(Single, SingleJoint, f32);
}

#[test]
fn calls_with_parameters_allocate_nothing() {
    const V: usize = JointZoo::NV;
    let (q, v) = black_box((JointZoo::NEUTRAL, [0.3; V]));
    let forces = black_box([Wrench::<f64>::zero(); JointZoo::LINK_NAMES.len()]);
    let ((), allocated) = measure(|| {
        let mut params = JointZooParams::DEFAULT;
        params.set_gravity(black_box([0.0; 3]));
        params.set_inertia_of_tip(black_box(Inertial::default())).ok();
        params.set_payload_of_tip(black_box(Inertial::default())).ok();
        black_box(JointZoo::forward_dynamics(&q, &v, &v));
        black_box(JointZoo::forward_dynamics_with(&params, &q, &v, &v));
        black_box(JointZoo::inverse_dynamics_with(&params, &q, &v, &v));
        black_box(JointZoo::forward_dynamics_external_local(&q, &v, &v, &forces));
        black_box(JointZoo::forward_dynamics_external(&q, &v, &v, &forces));
        black_box(JointZoo::inverse_dynamics_external_local(&q, &v, &v, &forces));
        black_box(JointZoo::inverse_dynamics_external(&q, &v, &v, &forces));
        black_box(JointZoo::generalized_forces_local(&q, &forces));
        black_box(JointZoo::generalized_forces(&q, &forces));
        black_box(JointZoo::inverse_dynamics_derivatives(&q, &v, &v));
        black_box(JointZoo::forward_dynamics_derivatives_with(&params, &q, &v, &v));
        black_box(JointZoo::regressor(&q, &v, &v));
        black_box((JointZoo::center_of_mass(&q), JointZoo::center_of_mass_jacobian(&q)));
        black_box(JointZoo::centroidal_momentum_matrix(&q));
        black_box(JointZoo::centroidal_momentum(&q, &v));
        for link in JointZooLink::ALL {
            black_box((JointZoo::link_pose(&q, link), JointZoo::link_velocity(&q, &v, link)));
            black_box(JointZoo::link_velocity_local(&q, &v, link));
            black_box(JointZoo::link_acceleration(&q, &v, &v, link));
            black_box(JointZoo::link_acceleration_local(&q, &v, &v, link));
            black_box((JointZoo::jacobian(&q, link), JointZoo::jacobian_local(&q, link)));
            black_box(JointZoo::jacobian_dot_qd(&q, &v, link));
            black_box(JointZoo::jacobian_dot_qd_local(&q, &v, link));
        }
        let moved = black_box(JointZoo::integrate(&q, &v));
        black_box((JointZoo::difference(&q, &moved), JointZoo::velocity_to_qdot(&q, &v)));
        black_box((
            JointZoo::normalize_configuration(&moved),
            JointZoo::random_configuration(|| 0.5),
        ));
        let goal = Reference::<JointZoo>::at_rest(moved);
        let gains = Gains { kp: 1.0, kd: 2.0 };
        let next = State::<JointZoo>::at_rest(q).runge_kutta_4(0.01, |state| {
            let tau = state.computed_torque(&goal, gains);
            JointZoo::forward_dynamics(&state.q, &state.qd, &tau)
        });
        black_box(next.semi_implicit_euler(0.01, |state| state.qd));
    });
    assert_eq!((allocated.calls, allocated.peak), (0, 0));
}

/// Batches of states with sets of contacts allocate nothing, with any number of states.
#[test]
fn batches_with_contacts_allocate_nothing() {
    const V: usize = Standing::NV;
    const STATES: usize = 37;
    let settings = ConstraintSettings::<f64, [ContactTarget<f64>; 2]>::DEFAULT;
    let (q, v) = black_box(([Standing::NEUTRAL; STATES], [[0.3; V]; STATES]));
    let sets: [StandingContacts; STATES] =
        std::array::from_fn(|k| StandingContacts { fl: k % 2 == 0, hr: k % 3 == 0 });
    let empty = Standing::constrained_forward_dynamics(&q[0], &v[0], &v[0], sets[1], &settings);
    let mut found = [empty; STATES];
    for states in [1, 7, STATES] {
        let ((), allocated) = measure(|| {
            let (q, v, sets) = (&q[..states], &v[..states], &sets[..states]);
            let found = &mut found[..states];
            let called =
                Standing::constrained_forward_dynamics_each(q, v, v, sets, &settings, found);
            called.expect("one number of states");
        });
        assert_eq!((allocated.calls, allocated.peak), (0, 0));
        assert_eq!(black_box(&found[0]).rank, 6.0);
    }
}

/// Steps on the ground allocate nothing, with feet on the ground or a knee at its limit.
#[test]
fn steps_on_the_ground_allocate_nothing() {
    let settings = StepSettings::<f64, [ContactSurface<f64>; 2]>::DEFAULT;
    let spring = SpringGround {
        plane: Pose::identity(),
        stiffness: 1e3,
        damping: 10.0,
        friction: 0.5,
        slip: 0.01,
    };
    for (height, bend, touches) in [(0.3, 0.0, true), (1.0, 10.0, false)] {
        let mut q = Standing::NEUTRAL;
        (q[2], q[9]) = (height, bend);
        let mut tau = [0.0; Standing::NV];
        tau[8] = 5.0;
        let (state, tau) = black_box((State::<Standing>::at_rest(q), tau));
        let (last, allocated) = measure(|| {
            let tau = limit_effort::<Standing, f64>(&tau);
            let mut last = state.step(0.001, &tau, &settings);
            for _ in 0..3 {
                last = last.step(0.001, &tau, &settings);
            }
            black_box(spring.force([0.0, 0.0, -0.01], Vector3([0.1, 0.0, -0.1])));
            last
        });
        assert_eq!((allocated.calls, allocated.peak), (0, 0));
        assert_eq!(last.forces.iter().any(|force| force[2] > 0.0), touches);
        assert!(last.residual < 1e-8);
    }
}
