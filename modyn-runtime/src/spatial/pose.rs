//! Where a frame stands.

use crate::Scalar;

/// A frame's pose in another frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose<S> {
    /// The rotation matrix, by rows: its columns are the frame's axes seen from the other frame.
    pub rotation: [[S; 3]; 3],
    /// The frame's origin seen from the other frame, m.
    pub translation: [S; 3],
}

impl<S: Scalar> Pose<S> {
    /// The two frames coincide.
    #[must_use]
    pub fn identity() -> Self {
        let (o, i) = (S::zero(), S::one());
        Self { rotation: [[i, o, o], [o, i, o], [o, o, i]], translation: [o; 3] }
    }

    /// Each number through `f`.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> Pose<T> {
        Pose {
            rotation: self.rotation.map(|row| row.map(&mut f)),
            translation: self.translation.map(&mut f),
        }
    }

    /// A point of the frame, seen from the other frame.
    #[must_use]
    pub fn transform_point(&self, point: [S; 3]) -> [S; 3] {
        let rotated = self.rotate(point);
        core::array::from_fn(|i| self.translation[i] + rotated[i])
    }

    /// A direction of the frame, seen from the other frame.
    #[must_use]
    pub fn rotate(&self, direction: [S; 3]) -> [S; 3] {
        let [x, y, z] = direction;
        self.rotation.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    /// The pose of a frame that stands at `inner` in this frame, seen from the other frame.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        let b = &inner.rotation;
        let rotation = self.rotation.map(|row| {
            core::array::from_fn(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j])
        });
        Self { rotation, translation: self.transform_point(inner.translation) }
    }
}
