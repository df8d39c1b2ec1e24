//! Prismatic joints: translation along z.

use super::ParentMotion;
use crate::Scalar;
use crate::spatial::{ArticulatedInertia, Field, RigidInertia, Twist, Vector3, Wrench};

pub(super) fn twist_to_child<S: Scalar>(q: S, t: Twist<S>) -> Twist<S> {
    Twist { angular: t.angular, linear: t.linear + t.angular.cross_z(q) }
}

pub(super) fn wrench_to_parent<S: Scalar>(q: S, w: Wrench<S>) -> Wrench<S> {
    // z q x f = -(f x z q)
    Wrench { moment: w.moment - w.force.cross_z(q), force: w.force }
}

pub(super) fn rigid_to_parent<S: Scalar>(q: S, i: &RigidInertia<S>) -> RigidInertia<S> {
    i.shifted(Vector3::along_z(q))
}

pub(super) fn articulated_to_parent<S: Scalar>(
    q: S,
    i: &ArticulatedInertia<S>,
) -> ArticulatedInertia<S> {
    i.shifted(Vector3::along_z(q))
}

pub(super) fn accelerate<S: Scalar>(
    q: S,
    ParentMotion { omega, alpha, a }: ParentMotion<S>,
    rate: S,
    acceleration: Option<S>,
) -> Field<S> {
    let field = Field::rotating(omega, alpha);
    // The Coriolis acceleration is 2 omega x rate z.
    let mut a = a + field.relative_acceleration_along_z(q) + omega.cross_z(rate + rate);
    if let Some(acceleration) = acceleration {
        a[2] = a[2] + acceleration;
    }
    Field { a, ..field }
}
