//! The motion of a joint's parent frame.

use crate::spatial::Vector3;

/// The motion of a joint's parent frame at the joint's origin, in the axes of the child frame.
#[derive(Clone, Copy, Debug)]
pub struct ParentMotion<S> {
    /// The angular velocity, rad/s.
    pub omega: Vector3<S>,
    /// The angular acceleration, rad/s^2.
    pub alpha: Vector3<S>,
    /// The classical acceleration of the joint frame's origin at coordinate zero, m/s^2.
    pub a: Vector3<S>,
}
