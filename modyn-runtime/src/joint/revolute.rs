//! Revolute and continuous joints: rotation about z.

use super::{JointOffset, ParentMotion};
use crate::Scalar;
use crate::spatial::{
    ArticulatedInertia, Axis, AxisRotation, Field, RigidInertia, Twist, Vector3, Wrench,
};

/// Returns the rotation at angle `q`.
pub(super) fn rotation<S: Scalar>(offset: JointOffset<S>, q: S) -> AxisRotation<S> {
    match offset {
        JointOffset::Quarters(n) => {
            let (sin, cos) = q.sin_cos();
            let (cos, sin) = match n {
                0 => (cos, sin),
                1 => (-sin, cos),
                2 => (-cos, -sin),
                _ => (sin, -cos),
            };
            AxisRotation::Angle { cos, sin }
        }
        JointOffset::Angle(offset) => {
            let (sin, cos) = (q + offset).sin_cos();
            AxisRotation::Angle { cos, sin }
        }
    }
}

pub(super) fn twist_to_child<S: Scalar>(rotation: AxisRotation<S>, t: Twist<S>) -> Twist<S> {
    let back = rotation.inverse();
    Twist { angular: back.vector(Axis::Z, t.angular), linear: back.vector(Axis::Z, t.linear) }
}

pub(super) fn wrench_to_parent<S: Scalar>(rotation: AxisRotation<S>, w: Wrench<S>) -> Wrench<S> {
    Wrench { moment: rotation.vector(Axis::Z, w.moment), force: rotation.vector(Axis::Z, w.force) }
}

pub(super) fn rigid_to_parent<S: Scalar>(
    rotation: AxisRotation<S>,
    i: &RigidInertia<S>,
) -> RigidInertia<S> {
    RigidInertia {
        mass: i.mass,
        first_moment: rotation.vector(Axis::Z, i.first_moment),
        second_moment: rotation.symmetric(Axis::Z, &i.second_moment),
    }
}

pub(super) fn articulated_to_parent<S: Scalar>(
    rotation: AxisRotation<S>,
    i: &ArticulatedInertia<S>,
) -> ArticulatedInertia<S> {
    i.rotated_about(rotation, Axis::Z)
}

pub(super) fn accelerate<S: Scalar>(
    ParentMotion { omega, mut alpha, a }: ParentMotion<S>,
    rate: S,
    acceleration: Option<S>,
) -> Field<S> {
    alpha += omega.cross_z(rate);
    if let Some(acceleration) = acceleration {
        alpha[2] = alpha[2] + acceleration;
    }
    Field { a, ..Field::rotating(omega + Vector3::along_z(rate), alpha) }
}
