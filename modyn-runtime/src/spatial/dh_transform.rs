//! The constant pose of a joint on its parent link.

use super::{
    ArticulatedInertia, Axis, AxisRotation, Matrix3, RigidInertia, Twist, Vector3, VelocityMoments,
    Wrench,
};
use crate::Scalar;

/// The constant pose of a joint's frame in the frame of the parent link:
/// Rz(azimuth) Trans(translation) Rx(tilt).
///
/// Two rotations reach any direction of the joint's axis; the third angle is the joint's own
/// offset. Each costs four products for a vector, a full rotation matrix nine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DhTransform<S> {
    /// The rotation about the parent's z axis.
    pub azimuth: AxisRotation<S>,
    /// The translation in the axes after the azimuth, m.
    pub translation: Vector3<S>,
    /// The rotation about the x axis after the azimuth.
    pub tilt: AxisRotation<S>,
}

impl<S: Scalar> DhTransform<S> {
    /// Returns the pose with `f` applied to its numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> DhTransform<T> {
        DhTransform {
            azimuth: self.azimuth.map(&mut f),
            translation: Vector3(self.translation.0.map(&mut f)),
            tilt: self.tilt.map(&mut f),
        }
    }

    /// Returns a direction in the joint's axes, from the parent's axes.
    #[must_use]
    pub fn to_child(&self, v: Vector3<S>) -> Vector3<S> {
        self.tilt.inverse().vector(Axis::X, self.azimuth.inverse().vector(Axis::Z, v))
    }

    /// Returns a direction in the parent's axes, from the joint's axes.
    #[must_use]
    pub fn to_parent(&self, v: Vector3<S>) -> Vector3<S> {
        self.azimuth.vector(Axis::Z, self.tilt.vector(Axis::X, v))
    }

    /// Returns a point in the joint's frame, from the parent's frame.
    #[must_use]
    pub fn point_to_child(&self, point: Vector3<S>) -> Vector3<S> {
        let shifted = self.azimuth.inverse().vector(Axis::Z, point) - self.translation;
        self.tilt.inverse().vector(Axis::X, shifted)
    }

    /// Returns a point in the parent's frame, from the joint's frame.
    #[must_use]
    pub fn point_to_parent(&self, point: Vector3<S>) -> Vector3<S> {
        self.azimuth.vector(Axis::Z, self.tilt.vector(Axis::X, point) + self.translation)
    }

    /// Returns the twist at the joint's frame, from a twist of the parent: the matrix A of the
    /// paper's twist propagation. It transforms perturbations of accelerations, too.
    #[must_use]
    pub fn twist_to_child(&self, t: Twist<S>) -> Twist<S> {
        let to_axes = |v| self.azimuth.inverse().vector(Axis::Z, v);
        let angular = to_axes(t.angular);
        let rotated = to_axes(t.linear);
        let linear = rotated + angular.cross(self.translation);
        let tilt = self.tilt.inverse();
        Twist { angular: tilt.vector(Axis::X, angular), linear: tilt.vector(Axis::X, linear) }
    }

    /// Returns a wrench at the parent's frame, from the joint's frame: A^T.
    #[must_use]
    pub fn wrench_to_parent(&self, w: Wrench<S>) -> Wrench<S> {
        let force = self.tilt.vector(Axis::X, w.force);
        let moment = self.tilt.vector(Axis::X, w.moment) + self.translation.cross(force);
        Wrench {
            moment: self.azimuth.vector(Axis::Z, moment),
            force: self.azimuth.vector(Axis::Z, force),
        }
    }

    /// Returns a rigid inertia at the parent's frame, from the joint's frame.
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

    /// Returns velocity moments at the parent's frame, from the joint's frame.
    #[must_use]
    pub fn velocities_to_parent(&self, v: &VelocityMoments<S>) -> VelocityMoments<S> {
        v.rotated_about(self.tilt, Axis::X)
            .shifted(self.translation)
            .rotated_about(self.azimuth, Axis::Z)
    }

    /// Returns an articulated inertia at the parent's frame, from the joint's frame: A^T M A.
    #[must_use]
    pub fn articulated_to_parent(&self, i: &ArticulatedInertia<S>) -> ArticulatedInertia<S> {
        let tilted = i.rotated_about(self.tilt, Axis::X).shifted(self.translation);
        tilted.rotated_about(self.azimuth, Axis::Z)
    }

    /// Returns the joint's axes, from the parent's axes; both as columns, in some third frame.
    #[must_use]
    pub fn rotate_axes(&self, axes: &Matrix3<S>) -> Matrix3<S> {
        self.tilt.columns(Axis::X, &self.azimuth.columns(Axis::Z, axes))
    }

    /// Returns the joint's origin in the parent's frame, m.
    #[must_use]
    pub fn origin(&self) -> Vector3<S> {
        self.azimuth.vector(Axis::Z, self.translation)
    }
}
