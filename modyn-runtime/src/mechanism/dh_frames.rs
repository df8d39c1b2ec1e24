//! Frames rotated and shifted as by Denavit and Hartenberg, generalized to trees.

use alloc::vec::Vec;

use super::elementary::ElementaryBody;
use super::snapping::{Direction, ROUNDING, SNAP, ZERO_ANGLE, direction_of, snap, without};
use crate::joint::ElementaryJoint;
use crate::model::radius_of_gyration;
use crate::spatial::{Axis, Matrix3, Pose, Vector3};

/// The model's frames while they are being rotated and shifted.
pub(super) struct Frames {
    children: Vec<Vec<usize>>,
    elementary_joint: Vec<ElementaryJoint>,
    /// The length of the longest path from the root to a joint, m.
    longest: f64,
    /// The length at or below which a component of the translation is zero, m.
    negligible: Vec<f64>,
    /// The pose Rz(azimuth) Trans(translation) Rx(tilt) Rz(zero) in the parent's frame, with the
    /// joint at 0.
    pub(super) azimuth: Vec<Direction>,
    pub(super) translation: Vec<Vector3<f64>>,
    pub(super) tilt: Vec<Direction>,
    pub(super) offset: Vec<Direction>,
    /// The pose of the model's link frame in the rotated and shifted frame.
    pub(super) link: Vec<Pose<f64>>,
}

impl Frames {
    /// Returns the frames with every joint axis along z.
    pub(super) fn with_axes_along_z(elementary: &[ElementaryBody<'_>]) -> Self {
        let children = main_child_first(elementary);
        let longest = longest_path(elementary);
        let mut frames = Self {
            negligible: negligible_offsets(elementary, &children, longest),
            longest,
            children,
            elementary_joint: elementary.iter().map(|body| body.elementary_joint).collect(),
            azimuth: Vec::with_capacity(elementary.len()),
            translation: Vec::with_capacity(elementary.len()),
            tilt: Vec::with_capacity(elementary.len()),
            offset: Vec::with_capacity(elementary.len()),
            link: elementary
                .iter()
                .map(|a| Pose { rotation: a.frame.transposed().0, translation: [0.0; 3] })
                .collect(),
        };
        for body in elementary {
            let mut rotation = Matrix3(body.origin.rotation).times(&body.frame);
            let mut translation = Vector3(body.origin.translation);
            if let Some(parent) = body.parent {
                let back = elementary[parent].frame.transposed();
                rotation = back.times(&rotation);
                translation = back.mul_vector(translation);
            }
            let [azimuth, tilt, offset] = split(&rotation);
            frames.translation.push(azimuth.inverse().rotation().vector(Axis::Z, translation));
            frames.azimuth.push(azimuth);
            frames.tilt.push(tilt);
            frames.offset.push(offset);
        }
        frames
    }

    /// Rotates each frame about its own z axis. A prismatic joint's frame is rotated by the
    /// rotation after its tilt, a revolute joint's towards its main child, a leaf's towards its
    /// centre of mass. Joints without an axis keep the link's frame, since their velocities are in
    /// its axes.
    pub(super) fn rotate(&mut self, elementary: &[ElementaryBody<'_>]) {
        for (i, body) in elementary.iter().enumerate() {
            let by = match self.children[i].first() {
                _ if self.elementary_joint[i] == ElementaryJoint::Prismatic => {
                    self.offset[i].inverse()
                }
                _ if self.elementary_joint[i] != ElementaryJoint::Revolute => continue,
                // Parallel axes need no azimuth, so the rotation can simplify the translation.
                Some(&main) if self.tilt[main].sin == 0.0 => {
                    direction_of(self.translation[main], self.negligible[main])
                }
                Some(&main) => self.azimuth[main],
                None => {
                    let center = self.link[i].transform_point(body.inertial.center_of_mass);
                    direction_of(Vector3(center), self.negligible[i])
                }
            };
            // Rz(q) Rz(by): the new frame is ahead of the old frame by `by`.
            self.offset[i] = self.offset[i].combine(by);
            let back = by.inverse().rotation();
            let rotation = Matrix3(self.link[i].rotation).transposed().0;
            let columns = rotation.map(|c| back.vector(Axis::Z, Vector3(c)).0);
            self.link[i].rotation = Matrix3(columns).transposed().0;
            for &child in &self.children[i] {
                let azimuth = self.azimuth[child].combine(by.inverse());
                let Direction { cos, sin } = self.tilt[child];
                if sin == 0.0 {
                    // Rz(a) Rx(0 or pi) = Rx(0 or pi) Rz(a or -a): it merges with the child's
                    // offset.
                    let sense = if cos > 0.0 { azimuth } else { azimuth.inverse() };
                    self.offset[child] = sense.combine(self.offset[child]);
                    self.translation[child] =
                        azimuth.rotation().vector(Axis::Z, self.translation[child]);
                } else {
                    self.azimuth[child] = azimuth;
                }
            }
        }
    }

    /// Shifts each revolute joint's frame along its axis to the point where a component of the
    /// translation from its parent vanishes.
    ///
    /// The next joint's shift makes up for its parent's shift, divided by the cosine of the tilt:
    /// along a chain of many small tilts the shifts would grow like a power, and digits would be
    /// lost. A frame that would be shifted farther than twice the length of the longest path from
    /// the root stays in its place.
    pub(super) fn shift(&mut self) {
        for i in 0..self.children.len() {
            if self.elementary_joint[i] != ElementaryJoint::Revolute {
                continue;
            }
            // In the axes after the azimuth, the joint axis is (0, -sin, cos).
            let Direction { cos, sin } = self.tilt[i];
            let [x, y, z] = self.translation[i].0;
            let (by, shifted) = if sin.abs() > cos.abs() {
                (y / sin, [x, 0.0, z + y / sin * cos])
            } else {
                (-z / cos, [x, y + z / cos * sin, 0.0])
            };
            if by.abs() > 2.0 * self.longest {
                continue;
            }
            self.translation[i] = Vector3(shifted);
            self.link[i].translation[2] -= by;
            for &child in &self.children[i] {
                self.translation[child][2] -= by;
            }
        }
    }

    /// Returns the translation of body `i`, without components that are negligible.
    pub(super) fn kept_translation(&self, i: usize) -> Vector3<f64> {
        Vector3(self.translation[i].0.map(|x| without(self.negligible[i], x)))
    }
}

/// Returns azimuth, tilt and offset of `rotation` = Rz(azimuth) Rx(tilt) Rz(zero). Parallel axes
/// have azimuth zero.
fn split(rotation: &Matrix3<f64>) -> [Direction; 3] {
    let r = rotation.0.map(|row| row.map(snap));
    // The third column is (sin a sin t, -cos a sin t, cos t).
    let sin = libm::hypot(r[0][2], r[1][2]);
    let tilt = Direction { cos: r[2][2], sin }.snapped();
    let azimuth = if tilt.sin == 0.0 {
        ZERO_ANGLE
    } else {
        direction_of(Vector3([-r[1][2], r[0][2], 0.0]), 0.0)
    };
    let axis = Vector3([r[0][0], r[1][0], r[2][0]]);
    let first = azimuth.inverse().rotation().vector(Axis::Z, axis);
    [azimuth, tilt, direction_of(tilt.inverse().rotation().vector(Axis::X, first), 0.0)]
}

/// Returns the length of the longest path from the root to a joint, m.
fn longest_path(elementary: &[ElementaryBody<'_>]) -> f64 {
    let mut lengths: Vec<f64> = Vec::with_capacity(elementary.len());
    for body in elementary {
        let before = body.parent.map_or(0.0, |parent| lengths[parent]);
        lengths.push(before + length(body));
    }
    lengths.into_iter().fold(0.0, f64::max)
}

/// Returns, for each body, the length at or below which a component of its joint's translation is
/// zero, m. An offset changes an entry of the mass matrix by its ratio to the lengths that move
/// with the joint: the lengths of the joint's descendants, and the body's radius of gyration. So
/// the joints of a small hand on a large arm keep smaller offsets than the joints of the arm.
fn negligible_offsets(
    elementary: &[ElementaryBody<'_>],
    children: &[Vec<usize>],
    longest: f64,
) -> Vec<f64> {
    let mut reach = alloc::vec![0.0; elementary.len()];
    for (i, body) in elementary.iter().enumerate().rev() {
        let farthest = children[i].iter().map(|&child| reach[child]);
        reach[i] = length(body) + farthest.fold(radius_of_gyration(&body.inertial), f64::max);
    }
    reach.into_iter().map(|reach| (SNAP * reach).max(ROUNDING * longest)).collect()
}

/// Returns the distance of a joint from its parent's, m.
fn length(body: &ElementaryBody<'_>) -> f64 {
    let translation = Vector3(body.origin.translation);
    libm::sqrt(translation.dot(translation))
}

/// Returns the children of each body; the child with the largest subtree comes first.
fn main_child_first(elementary: &[ElementaryBody<'_>]) -> Vec<Vec<usize>> {
    let mut size = alloc::vec![1usize; elementary.len()];
    let mut children = alloc::vec![Vec::new(); elementary.len()];
    for (i, body) in elementary.iter().enumerate().rev() {
        if let Some(parent) = body.parent {
            size[parent] += size[i];
            children[parent].push(i);
        }
    }
    for siblings in &mut children {
        siblings.reverse();
        siblings.sort_by_key(|&child| core::cmp::Reverse(size[child]));
    }
    children
}
