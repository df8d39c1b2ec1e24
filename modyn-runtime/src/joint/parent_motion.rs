//! The motion in front of a joint.

use crate::spatial::Vector3;

/// The motion in front of a joint, in the axes behind it.
#[derive(Clone, Copy, Debug)]
pub struct ParentMotion<S> {
    /// Angular velocity.
    pub omega: Vector3<S>,
    /// Angular acceleration.
    pub alpha: Vector3<S>,
    /// The acceleration of the joint's frame's origin at coordinate zero.
    pub a: Vector3<S>,
}
