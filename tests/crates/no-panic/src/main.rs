//! This program links only if no function of these robots has a path that panics: the panic handler calls a function
//! that does not exist, so the linker fails unless it can drop the handler.
#![no_std]
#![no_main]

use core::hint::black_box;

use modyn::Inertial;
use modyn::simulate::{Gains, Reference, State};
use modyn::spatial::Wrench;

modyn::modyn!("../../../../robots/gripper.urdf");
modyn::modyn!(Arm = "../../../../robots/arm7.urdf");
modyn::modyn!(Small = "../../../../robots/arm7.urdf", scalar = f32, modules = links);
modyn::modyn!(
    Zoo = "../../../../robots/joint_zoo.urdf",
    functions = all,
    joint_friction = coulomb,
    runtime_gravity = true,
    runtime_inertia = ["tip"],
    payload = ["tip"],
);

// The C library calls `main`. A function that no crate defines cannot be declared without `unsafe`; this is the only
// use of it.
#[link(name = "c")]
unsafe extern "C" {
    safe fn a_function_of_modyn_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    a_function_of_modyn_can_panic()
}

macro_rules! call_everything {
    ($robot:ident, $joint:ident, $link:ident, $scalar:ident) => {{
        let x = black_box([[0.5 as $scalar; $robot::NV]; 3]);
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
        black_box(brge.condition_numbers());
        black_box(modyn::Factorization::condition_number(&brge, black_box(7)));
        black_box((black_box($joint::ALL[0]).name(), black_box($link::ALL[0]).index()));
        black_box(<$robot as modyn::Robot>::forward_dynamics(&x[0], &x[1], &x[2]));
        black_box(<$robot as modyn::Robot>::MODULES);
    }};
}

/// Calls all functions.
fn call_all() {
    let (q, v) = black_box((Zoo::NEUTRAL, [0.5; Zoo::NV]));
    let forces = black_box([Wrench::<f64>::zero(); Zoo::LINK_NAMES.len()]);
    let gravity = black_box([0.0, 0.0, -1.0]);
    let mut params = ZooParams::DEFAULT;
    params.set_gravity(gravity);
    black_box(params.set_inertia_of_tip(black_box(Inertial::default()))).ok();
    black_box(params.set_payload_of_tip(black_box(params.inertia_of_tip()))).ok();
    black_box(Zoo::forward_dynamics_with(&params, &q, &v, &v));
    black_box(Zoo::inverse_dynamics_with(&params, &q, &v, &v));
    black_box(Zoo::brge_with(&params, &q).condition_numbers());
    black_box(Zoo::forward_dynamics_external_local(&q, &v, &v, &forces));
    black_box(Zoo::forward_dynamics_external(&q, &v, &v, &forces));
    black_box(Zoo::inverse_dynamics_external_local(&q, &v, &v, &forces));
    black_box(Zoo::inverse_dynamics_external(&q, &v, &v, &forces));
    black_box(Zoo::generalized_forces_local(&q, &forces));
    black_box(Zoo::generalized_forces(&q, &forces));
    black_box(Zoo::inverse_dynamics_derivatives(&q, &v, &v));
    black_box(Zoo::forward_dynamics_derivatives_with(&params, &q, &v, &v));
    black_box(Zoo::regressor(&q, &v, &v));
    black_box((Zoo::center_of_mass(&q), Zoo::center_of_mass_jacobian(&q)));
    black_box((Zoo::centroidal_momentum_matrix(&q), Zoo::centroidal_momentum(&q, &v)));
    let link = black_box(ZooLink::Hand);
    black_box((Zoo::link_pose(&q, link), Zoo::link_velocity(&q, &v, link)));
    black_box((Zoo::link_velocity_local(&q, &v, link), Zoo::jacobian(&q, link)));
    black_box(Zoo::link_acceleration(&q, &v, &v, link));
    black_box(Zoo::link_acceleration_local(&q, &v, &v, link));
    black_box((Zoo::jacobian_local(&q, link), Zoo::jacobian_dot_qd(&q, &v, link)));
    black_box(Zoo::jacobian_dot_qd_local(&q, &v, link));
    let moved = black_box(Zoo::integrate(&q, &v));
    black_box((Zoo::difference(&q, &moved), Zoo::velocity_to_qdot(&q, &v)));
    black_box((Zoo::normalize_configuration(&moved), Zoo::random_configuration(|| black_box(0.5))));
    black_box((black_box(ZooJoint::Wrist).coordinates(), black_box(ZooJoint::Wrist).velocities()));
    let goal = Reference::<Zoo>::at_rest(moved);
    let gains = Gains { kp: 1.0, kd: 2.0 };
    let next = State::<Zoo>::at_rest(q).runge_kutta_4(0.01, |state| {
        let tau = state.computed_torque(&goal, gains);
        Zoo::forward_dynamics(&state.q, &state.qd, &tau)
    });
    black_box(next.semi_implicit_euler(0.01, |state| state.qd).q);
}

#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    call_everything!(Gripper, GripperJoint, GripperLink, f64);
    call_everything!(Arm, ArmJoint, ArmLink, f64);
    call_everything!(Small, SmallJoint, SmallLink, f32);
    call_all();
    #[cfg(feature = "panics")]
    black_box([1, 2, 3][black_box(3)]);
    0
}
