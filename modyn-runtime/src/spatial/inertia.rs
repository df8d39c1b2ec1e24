//! Inertias: of a rigid body in 10 numbers, of an articulated body in 21.

use core::ops::Add;

use super::{Axis, AxisRotation, Matrix3, Pose, SpatialAxis, Symmetric3, Twist, Vector3, Wrench};
use crate::Scalar;

/// The inertia of a rigid (or composite) body about its frame's origin.
///
/// It consists of mass, first and second moment of mass: `m`, `integral r dm`, `integral r r^T dm`.
/// Transforms to another frame are cheaper than with the rotational inertia `trace(S) 1 - S`, the I
/// of (2). The part without effect on a joint axis is a component of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidInertia<S> {
    /// The mass, kg.
    pub mass: S,
    /// The mass times the centre of mass, kg m.
    pub first_moment: Vector3<S>,
    /// The second moment of mass about the origin, kg m^2.
    pub second_moment: Symmetric3<S>,
}

impl<S: Scalar> RigidInertia<S> {
    /// Returns the inertia of this mass, centre of mass, and rotational inertia about the centre of
    /// mass.
    #[must_use]
    pub fn new(mass: S, center: Vector3<S>, inertia: &Symmetric3<S>) -> Self {
        let Symmetric3 { xx, xy, xz, yy, yz, zz } = *inertia;
        let half_trace = (xx + yy + zz) * S::from_f64(0.5);
        let [x, y, z] = center.0;
        let first_moment = center.scale(mass);
        let [mx, my, mz] = first_moment.0;
        let second_moment = Symmetric3 {
            xx: half_trace - xx + mx * x,
            xy: mx * y - xy,
            xz: mx * z - xz,
            yy: half_trace - yy + my * y,
            yz: my * z - yz,
            zz: half_trace - zz + mz * z,
        };
        Self { mass, first_moment, second_moment }
    }

    /// Returns the inertia of no mass.
    #[must_use]
    pub fn zero() -> Self {
        Self { mass: S::zero(), first_moment: Vector3::zero(), second_moment: Symmetric3::zero() }
    }

    /// Returns the inertia with `f` applied to its numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> RigidInertia<T> {
        RigidInertia {
            mass: f(self.mass),
            first_moment: Vector3(self.first_moment.0.map(&mut f)),
            second_moment: self.second_moment.map(&mut f),
        }
    }

    /// Returns the inertia about the origin of a parallel frame, in which this frame's origin is at
    /// `p`.
    #[must_use]
    pub fn shifted(&self, p: Vector3<S>) -> Self {
        let c = self.first_moment;
        let shifted = c + p.scale(self.mass);
        let s = self.second_moment.full().0;
        Self {
            mass: self.mass,
            first_moment: shifted,
            // S + p c^T + c p^T + m p p^T
            second_moment: Symmetric3::from_fn(|i, j| s[i][j] + (p[i] * shifted[j] + c[i] * p[j])),
        }
    }

    /// Returns the inertia minus `other`.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        *self + other.map(|x| -x)
    }

    /// Returns the inertia in a frame in which this frame has the pose `pose`.
    #[must_use]
    pub fn placed(&self, pose: &Pose<S>) -> Self {
        self.rotated(&Matrix3(pose.rotation)).shifted(Vector3(pose.translation))
    }

    /// Returns the inertia in new axes; the columns of `rotation` are the present axes in the new
    /// ones.
    #[must_use]
    pub fn rotated(&self, rotation: &Matrix3<S>) -> Self {
        let second_moment = rotation.congruence(&self.second_moment.full()).0;
        Self {
            mass: self.mass,
            first_moment: rotation.mul_vector(self.first_moment),
            second_moment: Symmetric3::from_fn(|i, j| second_moment[i][j]),
        }
    }

    /// Returns the wrench of an acceleration; for a velocity, the momentum about the origin.
    #[must_use]
    pub fn times(&self, t: &Twist<S>) -> Wrench<S> {
        let c = self.first_moment;
        Wrench {
            moment: self.rotational().full().mul_vector(t.angular) + c.cross(t.linear),
            force: t.linear.scale(self.mass) + t.angular.cross(c),
        }
    }

    /// Returns the wrench of a unit acceleration in component `j` (linear x, y, z, angular x, y,
    /// z).
    #[must_use]
    pub fn column(&self, j: usize) -> Wrench<S> {
        match SpatialAxis::of(j) {
            SpatialAxis::Linear(k) => {
                let axis = Vector3::unit(k);
                Wrench { moment: self.first_moment.cross(axis), force: axis.scale(self.mass) }
            }
            SpatialAxis::Angular(k) => {
                let moment = self.rotational().full().column(k);
                Wrench { moment, force: Vector3::unit(k).cross(self.first_moment) }
            }
        }
    }

    /// Returns the rotational inertia about the origin, `trace(S) 1 - S`: the I of (2).
    #[must_use]
    pub fn rotational(&self) -> Symmetric3<S> {
        let Symmetric3 { xx, xy, xz, yy, yz, zz } = self.second_moment;
        Symmetric3 { xx: yy + zz, xy: -xy, xz: -xz, yy: xx + zz, yz: -yz, zz: xx + yy }
    }

    /// Returns the same inertia as an articulated inertia: the matrix of (2).
    #[must_use]
    pub fn articulated(&self) -> ArticulatedInertia<S> {
        ArticulatedInertia {
            rotational: self.rotational(),
            coupling: Matrix3::cross(self.first_moment),
            translational: Symmetric3::diagonal(self.mass),
        }
    }
}

impl<S: Scalar> Add for RigidInertia<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            second_moment: self.second_moment + other.second_moment,
        }
    }
}

/// The articulated inertia of a tree of links at its root link: a symmetric 6x6 matrix
/// `[translational, coupling^T; coupling, rotational]` from acceleration to wrench.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArticulatedInertia<S> {
    /// The block from angular acceleration to moment.
    pub rotational: Symmetric3<S>,
    /// The block from linear acceleration to moment.
    pub coupling: Matrix3<S>,
    /// The block from linear acceleration to force.
    pub translational: Symmetric3<S>,
}

impl<S: Scalar> ArticulatedInertia<S> {
    /// The inertia of nothing.
    #[must_use]
    pub fn zero() -> Self {
        Self::from_fn(|_, _| S::zero())
    }

    /// Returns the inertia times a number.
    #[must_use]
    pub fn scaled(&self, factor: S) -> Self {
        Self::from_fn(|i, j| self.entry(i, j) * factor)
    }

    /// Returns the wrench of a unit acceleration in component `j` (linear x, y, z, angular x, y,
    /// z).
    #[must_use]
    pub fn column(&self, j: usize) -> Wrench<S> {
        match SpatialAxis::of(j) {
            SpatialAxis::Linear(k) => Wrench {
                moment: self.coupling.column(k),
                force: self.translational.full().column(k),
            },
            SpatialAxis::Angular(k) => {
                Wrench { moment: self.rotational.full().column(k), force: self.coupling.row(k) }
            }
        }
    }

    /// Returns the wrench of an acceleration.
    #[must_use]
    pub fn times(&self, t: &Twist<S>) -> Wrench<S> {
        let rotational = self.rotational.full();
        let translational = self.translational.full();
        let rotated = self.coupling.transposed();
        let coupled = &self.coupling;
        Wrench {
            moment: rotational.mul_vector(t.angular) + coupled.mul_vector(t.linear),
            force: rotated.mul_vector(t.angular) + translational.mul_vector(t.linear),
        }
    }

    /// Returns the inertia with this upper triangle of the 6x6 matrix: `entry(row, column)`.
    #[must_use]
    pub fn from_fn(mut entry: impl FnMut(usize, usize) -> S) -> Self {
        Self {
            translational: Symmetric3::from_fn(&mut entry),
            coupling: Matrix3(core::array::from_fn(|i| core::array::from_fn(|j| entry(j, i + 3)))),
            rotational: Symmetric3::from_fn(|i, j| entry(i + 3, j + 3)),
        }
    }

    /// Returns the entry of the 6x6 matrix at row `i` and column `j`, `i <= j`.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> S {
        match [i, j].map(SpatialAxis::of) {
            [SpatialAxis::Linear(i), SpatialAxis::Linear(j)] => self.translational.full().0[i][j],
            [SpatialAxis::Angular(i), SpatialAxis::Angular(j)] => self.rotational.full().0[i][j],
            [SpatialAxis::Linear(linear), SpatialAxis::Angular(angular)]
            | [SpatialAxis::Angular(angular), SpatialAxis::Linear(linear)] => {
                self.coupling.0[angular][linear]
            }
        }
    }

    /// Returns the inertia in the original axes, from the axes rotated by `rotation`.
    #[must_use]
    pub fn rotated_about(&self, rotation: AxisRotation<S>, about: Axis) -> Self {
        Self {
            rotational: rotation.symmetric(about, &self.rotational),
            coupling: rotation.matrix(about, &self.coupling),
            translational: rotation.symmetric(about, &self.translational),
        }
    }

    /// Returns the inertia in new axes; the columns of `rotation` are the present axes in the new
    /// ones.
    #[must_use]
    pub fn rotated(&self, rotation: &Matrix3<S>) -> Self {
        let rotated = |m: &Symmetric3<S>| {
            let rotated = rotation.congruence(&m.full()).0;
            Symmetric3::from_fn(|i, j| rotated[i][j])
        };
        Self {
            rotational: rotated(&self.rotational),
            coupling: rotation.congruence(&self.coupling),
            translational: rotated(&self.translational),
        }
    }

    /// Returns the inertia about the origin of a parallel frame, in which this frame's origin is at
    /// `p`.
    #[must_use]
    pub fn shifted(&self, p: Vector3<S>) -> Self {
        // With P = p x: H' = H + P M and A' = A + P H'^T + H P^T.
        let m = self.translational.full();
        let shift = |v: Vector3<S>| p.cross(v);
        let pm: [Vector3<S>; 3] = core::array::from_fn(|j| shift(m.column(j)));
        let h = Matrix3(core::array::from_fn(|i| {
            core::array::from_fn(|j| self.coupling.0[i][j] + pm[j][i])
        }));
        // Column j of P H'^T is p x (row j of H'); row i of H P^T is p x (row i of H).
        let ph: [Vector3<S>; 3] = core::array::from_fn(|j| shift(h.row(j)));
        let hp: [Vector3<S>; 3] = core::array::from_fn(|i| shift(self.coupling.row(i)));
        let a = self.rotational.full().0;
        Self {
            rotational: Symmetric3::from_fn(|i, j| a[i][j] + (ph[j][i] + hp[i][j])),
            coupling: h,
            translational: self.translational,
        }
    }
}

impl<S: Scalar> Add for ArticulatedInertia<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            rotational: self.rotational + other.rotational,
            coupling: self.coupling + other.coupling,
            translational: self.translational + other.translational,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ArticulatedInertia;
    use crate::spatial::Twist;

    #[test]
    fn columns_entries_and_products_agree() {
        let number = |i: usize, j: usize| (10 * i.min(j) + i.max(j)) as f64;
        // The coupling block is not symmetric: entry (i, j + 3) is a number of its own.
        let inertia = ArticulatedInertia::from_fn(number);
        for j in 0..6 {
            let column = inertia.column(j).components();
            let unit =
                Twist::from_components(core::array::from_fn(|i| f64::from(u8::from(i == j))));
            assert_eq!(inertia.times(&unit).components(), column);
            for (i, entry) in column.into_iter().enumerate() {
                assert_eq!(entry, number(i, j), "row {i}, column {j}");
                assert_eq!(inertia.entry(i.min(j), i.max(j)), entry);
            }
        }
    }
}
