//! Links only if no function of these robots has a path that panics: the panic handler calls a
//! function that does not exist, so the linker complains unless it can drop the handler.
#![no_std]
#![no_main]

use core::hint::black_box;

modyn::modyn!("../../../../robots/gripper.urdf");
modyn::modyn!(Arm = "../../../../robots/arm7.urdf");
modyn::modyn!(Small = "../../../../robots/arm7.urdf", scalar = f32, modules = links);

// The C library starts `main`. What no crate defines cannot be declared without `unsafe`; nothing else here is.
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

#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    call_everything!(Gripper, GripperJoint, GripperLink, f64);
    call_everything!(Arm, ArmJoint, ArmLink, f64);
    call_everything!(Small, SmallJoint, SmallLink, f32);
    #[cfg(feature = "panics")]
    black_box([1, 2, 3][black_box(3)]);
    0
}
