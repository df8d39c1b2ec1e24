//! Where a joint stands on the link that carries it.

use super::{
    ArticulatedInertia, Axis, AxisRotation, Matrix3, RigidInertia, Twist, Vector3, VelocityMoments,
    Wrench,
};
use crate::Scalar;

/// The constant pose of a joint's frame in the frame of the parent link:
/// Rz(azimuth) Trans(translation) Rx(tilt).
///
/// Two turns are enough for any direction of the joint's axis; the third angle is the joint's
/// own zero. Each costs four products a vector, where a full rotation matrix costs nine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DhTransform<S> {
    /// Rotation about the parent's z axis.
    pub azimuth: AxisRotation<S>,
    /// Translation in the axes behind the azimuth, m.
    pub translation: Vector3<S>,
    /// Rotation about the x axis behind the azimuth.
    pub tilt: AxisRotation<S>,
}

impl<S: Scalar> DhTransform<S> {
    /// Each number through `f`.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> DhTransform<T> {
        DhTransform {
            azimuth: self.azimuth.map(&mut f),
            translation: Vector3(self.translation.0.map(&mut f)),
            tilt: self.tilt.map(&mut f),
        }
    }

    /// A direction of the parent's frame, seen from the joint's.
    #[must_use]
    pub fn to_child(&self, v: Vector3<S>) -> Vector3<S> {
        self.tilt.inverse().vector(Axis::X, self.azimuth.inverse().vector(Axis::Z, v))
    }

    /// A direction of the joint's frame, seen from the parent's.
    #[must_use]
    pub fn to_parent(&self, v: Vector3<S>) -> Vector3<S> {
        self.azimuth.vector(Axis::Z, self.tilt.vector(Axis::X, v))
    }

    /// A point of the parent's frame, seen from the joint's.
    #[must_use]
    pub fn point_to_child(&self, point: Vector3<S>) -> Vector3<S> {
        let shifted = self.azimuth.inverse().vector(Axis::Z, point) - self.translation;
        self.tilt.inverse().vector(Axis::X, shifted)
    }

    /// A point of the joint's frame, seen from the parent's.
    #[must_use]
    pub fn point_to_parent(&self, point: Vector3<S>) -> Vector3<S> {
        self.azimuth.vector(Axis::Z, self.tilt.vector(Axis::X, point) + self.translation)
    }

    /// The twist (or deviation of acceleration) of a rigid continuation of the parent, seen from
    /// the joint's frame: the matrix A of the paper's twist propagation.
    #[must_use]
    pub fn twist_to_child(&self, t: Twist<S>) -> Twist<S> {
        let to_axes = |v| self.azimuth.inverse().vector(Axis::Z, v);
        let (angular, linear) = (to_axes(t.angular), to_axes(t.linear));
        let linear = linear + angular.cross(self.translation);
        let tilt = self.tilt.inverse();
        Twist { angular: tilt.vector(Axis::X, angular), linear: tilt.vector(Axis::X, linear) }
    }

    /// A wrench on the child at the joint's frame, at the parent: A^T.
    #[must_use]
    pub fn wrench_to_parent(&self, w: Wrench<S>) -> Wrench<S> {
        let force = self.tilt.vector(Axis::X, w.force);
        let moment = self.tilt.vector(Axis::X, w.moment) + self.translation.cross(force);
        Wrench {
            moment: self.azimuth.vector(Axis::Z, moment),
            force: self.azimuth.vector(Axis::Z, force),
        }
    }

    /// A rigid inertia at the joint's frame, at the parent.
    #[must_use]
    pub fn rigid_to_parent(&self, i: &RigidInertia<S>) -> RigidInertia<S> {
        let tilted = RigidInertia {
            mass: i.mass,
            first_moment: self.tilt.vector(Axis::X, i.first_moment),
            second_moment: self.tilt.symmetric(Axis::X, &i.second_moment),
        }
        .shifted(self.translation);
        RigidInertia {
            mass: i.mass,
            first_moment: self.azimuth.vector(Axis::Z, tilted.first_moment),
            second_moment: self.azimuth.symmetric(Axis::Z, &tilted.second_moment),
        }
    }

    /// Moments of velocities against the joint's frame, at the parent.
    #[must_use]
    pub fn velocities_to_parent(&self, v: &VelocityMoments<S>) -> VelocityMoments<S> {
        v.rotated_about(self.tilt, Axis::X)
            .shifted(self.translation)
            .rotated_about(self.azimuth, Axis::Z)
    }

    /// An articulated inertia at the joint's frame, at the parent: A^T M A.
    #[must_use]
    pub fn articulated_to_parent(&self, i: &ArticulatedInertia<S>) -> ArticulatedInertia<S> {
        let tilted = i.rotated_about(self.tilt, Axis::X).shifted(self.translation);
        tilted.rotated_about(self.azimuth, Axis::Z)
    }

    /// The axes of the parent's frame (as columns, in some third frame) turned to the joint's.
    #[must_use]
    pub fn rotate_axes(&self, axes: &Matrix3<S>) -> Matrix3<S> {
        self.tilt.columns(Axis::X, &self.azimuth.columns(Axis::Z, axes))
    }

    /// The joint's origin in the parent's frame.
    #[must_use]
    pub fn origin(&self) -> Vector3<S> {
        self.azimuth.vector(Axis::Z, self.translation)
    }
}
