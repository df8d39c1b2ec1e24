//! Prismatic joints: translation along z.

use crate::Scalar;
use crate::spatial::{ArticulatedInertia, RigidInertia, Twist, Vector3, Wrench};

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

/// A unit linear acceleration along z.
pub(super) fn unit_wrench<S: Scalar>(i: &RigidInertia<S>) -> Wrench<S> {
    let c = i.first_moment;
    Wrench { moment: Vector3([c[1], -c[0], S::zero()]), force: Vector3::along_z(i.mass) }
}
