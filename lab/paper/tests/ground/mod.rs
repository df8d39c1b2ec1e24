//! Legged robots on the ground, and a ground of springs.

mod legged;
mod soft;

use modyn::simulate::State;
use modyn::{ConstraintSettings, ContactSurface, ContactTarget, Robot, StepSettings};

// Solo12's numbers.
modyn::modyn! {
    "../../../../robots/quadruped.urdf",
    base = floating,
    functions = [default, step],
    contacts = [
        "fl": point("front_left_foot"),
        "fr": point("front_right_foot"),
        "hl": point("hind_left_foot"),
        "hr": point("hind_right_foot"),
    ]
}

type Settings<const CONTACTS: usize = 4> = ConstraintSettings<f64, [ContactTarget<f64>; CONTACTS]>;

/// A nearly rigid ground for steps of two milliseconds or less.
const GROUND: ContactSurface<f64> = ContactSurface {
    solref: [0.004, 1.0],
    solimp: [0.99, 0.999, 0.0005, 0.5],
    ..ContactSurface::<f64>::GROUND
};
const GRAVITY: f64 = 9.81;
const STEP: f64 = 0.001;

/// Returns the rotation by the angle about an axis: the matrix by rows, and the quaternion x y z w.
fn rotation(axis: [f64; 3], angle: f64) -> ([[f64; 3]; 3], [f64; 4]) {
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::from(axis));
    let quaternion = nalgebra::UnitQuaternion::from_axis_angle(&axis, angle);
    let matrix = quaternion.to_rotation_matrix();
    let rows = core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]));
    (rows, quaternion.coords.into())
}

/// Returns settings of steps with the ground under all contacts.
fn on_ground<const CONTACTS: usize>() -> StepSettings<f64, [ContactSurface<f64>; CONTACTS]> {
    StepSettings { surfaces: [GROUND; CONTACTS], ..StepSettings::<f64, _>::DEFAULT }
}

/// Returns the heights of the contacts above the plane z = 0, m.
fn heights<R, const CONTACTS: usize>(state: &State<R>) -> [f64; CONTACTS]
where
    R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; CONTACTS]>
        + modyn::functions::ConstraintResidual,
{
    let settings = Settings::DEFAULT;
    let displacements = R::constraint_residual(&state.q, &state.qd, &settings).displacements;
    core::array::from_fn(|k| displacements.as_ref()[k].linear[2])
}

/// Returns the height of the lowest contact above the plane z = 0, m.
fn lowest<R, const CONTACTS: usize>(state: &State<R>) -> f64
where
    R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; CONTACTS]>
        + modyn::functions::ConstraintResidual,
{
    heights(state).into_iter().fold(f64::INFINITY, f64::min)
}
