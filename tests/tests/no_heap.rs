//! No function of a generated robot asks for memory, by whichever door it came.

use std::hint::black_box;

use modyn::Nalgebra;
use modyn_tests::counting::{Counting, measure};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

modyn::modyn!("../../robots/gripper.urdf");
modyn::modyn!("../../robots/quadruped.urdf", modules = links);
modyn::modyn!("../../robots/humanoid.urdf");
modyn::modyn!(Single = "../../robots/arm7.urdf", scalar = f32);

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
    allocates_nothing!(Humanoid, HumanoidJoint, f64);
    allocates_nothing!(Single, SingleJoint, f32);
}
