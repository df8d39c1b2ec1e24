//! Links of the description as frames on bodies.

use crate::Scalar;
use crate::spatial::Pose;

/// A link of the description, as a frame on a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyFrame<S> {
    /// The body that carries the link; `None` for the world.
    pub body: Option<usize>,
    /// The link's pose in the body's rotated frame, or in the world.
    pub pose: Pose<S>,
}

impl<S: Scalar> BodyFrame<S> {
    /// Returns the frame with `f` applied to its numbers.
    pub(super) fn map<T>(&self, f: impl FnMut(S) -> T) -> BodyFrame<T> {
        BodyFrame { body: self.body, pose: self.pose.map(f) }
    }
}
