//! The pose of a frame.

use crate::Scalar;

/// The pose of a frame in a reference frame.
///
/// ```
/// use modyn_runtime::Pose;
///
/// let quarter_about_z = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
/// let pose = Pose { rotation: quarter_about_z, translation: [0.0, 0.0, 1.0] };
/// assert_eq!(pose.transform_point([1.0, 0.0, 0.0]), [0.0, 1.0, 1.0]);
/// assert_eq!(pose.compose(&Pose::identity()), pose);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose<S> {
    /// The rotation matrix, by rows. Its columns are the frame's axes in the reference frame.
    pub rotation: [[S; 3]; 3],
    /// The frame's origin in the reference frame, m.
    pub translation: [S; 3],
}

impl<S: Scalar> Pose<S> {
    /// Returns the pose of a frame that coincides with the reference frame.
    #[must_use]
    pub fn identity() -> Self {
        let o = S::zero();
        let i = S::one();
        Self { rotation: [[i, o, o], [o, i, o], [o, o, i]], translation: [o; 3] }
    }

    /// Returns the pose with `f` applied to its numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> Pose<T> {
        Pose {
            rotation: self.rotation.map(|row| row.map(&mut f)),
            translation: self.translation.map(&mut f),
        }
    }

    /// Returns a point in the reference frame, m, from its coordinates in this frame.
    #[must_use]
    pub fn transform_point(&self, point: [S; 3]) -> [S; 3] {
        let rotated = self.rotate(point);
        core::array::from_fn(|i| self.translation[i] + rotated[i])
    }

    /// Returns a direction in the reference frame, from its components in this frame.
    #[must_use]
    pub fn rotate(&self, direction: [S; 3]) -> [S; 3] {
        let [x, y, z] = direction;
        self.rotation.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    /// Returns the pose in the reference frame of a frame whose pose in this frame is `inner`.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        let b = &inner.rotation;
        let rotation = self.rotation.map(|row| {
            core::array::from_fn(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j])
        });
        Self { rotation, translation: self.transform_point(inner.translation) }
    }
}
