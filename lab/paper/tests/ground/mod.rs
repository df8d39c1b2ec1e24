//! Robots on the ground: falls, bounces, sliding, joint stops, legged robots, and the same motions in MuJoCo.

mod blocks;
mod legged;
mod mujoco;
mod soft;
mod stops;

use modyn::simulate::State;
use modyn::spatial::Vector3;
use modyn::{ConstraintSettings, ContactTarget, Robot};

modyn::modyn! {
    "../mechanisms/block.urdf",
    base = floating,
    functions = [default, contact_problem],
    contacts = [
        "a": point("body", [0.15, 0.1, -0.05]),
        "b": point("body", [-0.15, 0.1, -0.05]),
        "c": point("body", [0.15, -0.1, -0.05]),
        "d": point("body", [-0.15, -0.1, -0.05]),
    ]
}

// Solo12's numbers.
modyn::modyn! {
    "../../../../robots/quadruped.urdf",
    base = floating,
    functions = [default, contact_problem],
    contacts = [
        "fl": point("front_left_foot"),
        "fr": point("front_right_foot"),
        "hl": point("hind_left_foot"),
        "hr": point("hind_right_foot"),
    ]
}

type Settings<const CONTACTS: usize = 4> = ConstraintSettings<f64, [ContactTarget<f64>; CONTACTS]>;

const GRAVITY: f64 = 9.81;
const STEP: f64 = 0.001;
/// The height of the block's origin on the ground, m.
const STANDING: f64 = 0.05;
/// The stiffness and the damping that hold the flap, N m/rad and N m s/rad.
const HINGE: [f64; 2] = [10.0, 0.1];

/// Returns the rotation by the angle about an axis: the matrix by rows, and the quaternion x y z w.
fn rotation(axis: [f64; 3], angle: f64) -> ([[f64; 3]; 3], [f64; 4]) {
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::from(axis));
    let quaternion = nalgebra::UnitQuaternion::from_axis_angle(&axis, angle);
    let matrix = quaternion.to_rotation_matrix();
    let rows = core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]));
    (rows, quaternion.coords.into())
}

/// Returns settings with this ground under all contacts.
fn on<const CONTACTS: usize>(ground: ContactTarget<f64>) -> Settings<CONTACTS> {
    ConstraintSettings { contacts: [ground; CONTACTS], ..Settings::DEFAULT }
}

/// Returns the torque that holds the flap at angle zero.
fn hold(state: &State<Block>) -> [f64; 7] {
    let [stiffness, damping] = HINGE;
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -stiffness * state.q[7] - damping * state.qd[6]]
}

/// Returns the heights of the contacts above their targets, m.
fn heights<R, const CONTACTS: usize>(
    state: &State<R>,
    settings: &Settings<CONTACTS>,
) -> [f64; CONTACTS]
where
    R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; CONTACTS]>
        + modyn::functions::ConstraintResidual,
{
    let found = R::constraint_residual(&state.q, &state.qd, settings).displacements;
    core::array::from_fn(|k| {
        let normal = Vector3(settings.contacts[k].pose.rotation.map(|row| row[2]));
        normal.dot(found.as_ref()[k].linear)
    })
}

/// Returns the height of the lowest contact, m.
fn lowest<R, const CONTACTS: usize>(state: &State<R>, settings: &Settings<CONTACTS>) -> f64
where
    R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; CONTACTS]>
        + modyn::functions::ConstraintResidual,
{
    heights(state, settings).into_iter().fold(f64::INFINITY, f64::min)
}
