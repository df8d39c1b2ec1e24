//! Links of the description as frames on bodies.

use crate::Scalar;
use crate::spatial::Pose;

/// A link of the description, as a frame on a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyFrame<S> {
    /// The body that carries it; `None` for the world.
    pub body: Option<usize>,
    /// Its pose in the body's turned frame, or in the world.
    pub pose: Pose<S>,
}

impl<S: Scalar> BodyFrame<S> {
    /// Each number through `f`.
    pub(super) fn map<T>(&self, f: impl FnMut(S) -> T) -> BodyFrame<T> {
        BodyFrame { body: self.body, pose: self.pose.map(f) }
    }
}
