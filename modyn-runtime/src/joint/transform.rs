//! The transform of a joint at given coordinates: the one place where the equations depend on joint
//! types.
//!
//! The equations have four elementary joints. A universal joint is two revolute joints with a
//! massless body between them, a planar joint two prismatic joints and a revolute joint
//! (`mechanism::elementary`).

use super::parent_motion::ParentMotion;
use super::{ElementaryJoint, JointOffset, floating, prismatic, revolute, rotated, spherical};
use crate::Scalar;
use crate::spatial::{
    ArticulatedInertia, Axis, AxisRotation, Field, Matrix3, RigidInertia, Twist, Vector3,
    VelocityMoments, Wrench,
};

/// The transform across a joint at given coordinates.
#[derive(Clone, Copy, Debug)]
pub enum JointTransform<S> {
    /// A rotation about z.
    Revolute(AxisRotation<S>),
    /// A translation along z by this distance, m.
    Prismatic(S),
    /// A rotation by this matrix, whose columns are the child's axes.
    Spherical(Matrix3<S>),
    /// A translation and a rotation.
    Floating {
        /// The child's axes in the parent frame, as columns.
        rotation: Matrix3<S>,
        /// The child's origin in the parent frame, m.
        position: Vector3<S>,
    },
}

impl<S: Scalar> JointTransform<S> {
    /// Returns the transform of `joint` at the coordinates `q`; `offset` is the frame's offset.
    #[must_use]
    pub fn new(joint: ElementaryJoint, offset: JointOffset<S>, q: &[S]) -> Self {
        match (joint, q) {
            (ElementaryJoint::Prismatic, &[q]) => Self::Prismatic(q),
            (ElementaryJoint::Spherical, &[x, y, z, w]) => {
                Self::Spherical(spherical::rotation(offset, [x, y, z, w]))
            }
            (ElementaryJoint::Floating, &[px, py, pz, x, y, z, w]) => Self::Floating {
                rotation: spherical::rotation(offset, [x, y, z, w]),
                position: offset.rotation().vector(Axis::Z, Vector3([px, py, pz])),
            },
            (_, q) => Self::Revolute(revolute::rotation(offset, q[0])),
        }
    }

    /// Returns the displacement of the child's origin in the parent's axes; `None` for joints that
    /// only rotate.
    #[must_use]
    pub fn displacement(&self) -> Option<Vector3<S>> {
        match self {
            Self::Revolute(_) | Self::Spherical(_) => None,
            Self::Prismatic(q) => Some(Vector3::along_z(*q)),
            Self::Floating { position, .. } => Some(*position),
        }
    }

    /// Returns the motion of the child frame, from the motion of the parent frame and the joint's
    /// rates and accelerations (`None` for zero).
    #[must_use]
    pub fn accelerate(
        &self,
        from_parent: ParentMotion<S>,
        rates: &[S],
        accelerations: Option<&[S]>,
    ) -> Field<S> {
        match self {
            Self::Revolute(_) => {
                revolute::accelerate(from_parent, rates[0], accelerations.map(|a| a[0]))
            }
            Self::Prismatic(q) => {
                prismatic::accelerate(*q, from_parent, rates[0], accelerations.map(|a| a[0]))
            }
            Self::Spherical(_) => spherical::accelerate(from_parent, rates, accelerations),
            Self::Floating { rotation, position } => {
                let displacement = rotation.transposed().mul_vector(*position);
                floating::accelerate(displacement, from_parent, rates, accelerations)
            }
        }
    }

    /// Returns a direction in the child's axes, from the parent's axes.
    #[must_use]
    pub fn to_child(&self, v: Vector3<S>) -> Vector3<S> {
        match self {
            Self::Revolute(rotation) => rotation.inverse().vector(Axis::Z, v),
            Self::Prismatic(_) => v,
            Self::Spherical(rotation) | Self::Floating { rotation, .. } => {
                rotation.transposed().mul_vector(v)
            }
        }
    }

    /// Returns a direction in the parent's axes, from the child's axes.
    #[must_use]
    pub fn to_parent(&self, v: Vector3<S>) -> Vector3<S> {
        match self {
            Self::Revolute(rotation) => rotation.vector(Axis::Z, v),
            Self::Prismatic(_) => v,
            Self::Spherical(rotation) | Self::Floating { rotation, .. } => rotation.mul_vector(v),
        }
    }

    /// Returns a point in the child frame, from the parent frame.
    #[must_use]
    pub fn point_to_child(&self, point: Vector3<S>) -> Vector3<S> {
        self.to_child(self.displacement().map_or(point, |displacement| point - displacement))
    }

    /// Returns a point in the parent frame, from the child frame.
    #[must_use]
    pub fn point_to_parent(&self, point: Vector3<S>) -> Vector3<S> {
        let rotated = self.to_parent(point);
        self.displacement().map_or(rotated, |displacement| rotated + displacement)
    }

    /// Returns the child's axes, from the parent's axes; both as columns, in some third frame.
    #[must_use]
    pub fn rotate_axes(&self, axes: &Matrix3<S>) -> Matrix3<S> {
        match self {
            Self::Revolute(rotation) => rotation.columns(Axis::Z, axes),
            Self::Prismatic(_) => *axes,
            Self::Spherical(rotation) | Self::Floating { rotation, .. } => axes.times(rotation),
        }
    }

    /// Returns the twist of the child if it moved rigidly with the parent (twist propagation). It
    /// transforms perturbations of accelerations, too.
    #[must_use]
    pub fn twist_to_child(&self, t: Twist<S>) -> Twist<S> {
        match self {
            Self::Revolute(rotation) => revolute::twist_to_child(*rotation, t),
            Self::Prismatic(q) => prismatic::twist_to_child(*q, t),
            Self::Spherical(rotation) => rotated::twist_to_child(rotation, t),
            Self::Floating { rotation, position } => {
                let linear = t.linear + t.angular.cross(*position);
                rotated::twist_to_child(rotation, Twist { linear, ..t })
            }
        }
    }

    /// Returns a wrench in the parent frame, from the child frame.
    #[must_use]
    pub fn wrench_to_parent(&self, w: Wrench<S>) -> Wrench<S> {
        match self {
            Self::Revolute(rotation) => revolute::wrench_to_parent(*rotation, w),
            Self::Prismatic(q) => prismatic::wrench_to_parent(*q, w),
            Self::Spherical(rotation) => rotated::wrench_to_parent(rotation, w),
            Self::Floating { rotation, position } => {
                let w = rotated::wrench_to_parent(rotation, w);
                Wrench { moment: w.moment + position.cross(w.force), ..w }
            }
        }
    }

    /// Returns a rigid inertia in the parent frame, from the child frame.
    #[must_use]
    pub fn rigid_to_parent(&self, i: &RigidInertia<S>) -> RigidInertia<S> {
        match self {
            Self::Revolute(rotation) => revolute::rigid_to_parent(*rotation, i),
            Self::Prismatic(q) => prismatic::rigid_to_parent(*q, i),
            Self::Spherical(rotation) => i.rotated(rotation),
            Self::Floating { rotation, position } => i.rotated(rotation).shifted(*position),
        }
    }

    /// Returns the velocity moments of the child's points relative to the parent frame, in the
    /// parent frame. `velocities` are relative to the child frame; `body` is the points' inertia.
    #[must_use]
    pub fn velocities_to_parent(
        &self,
        velocities: &VelocityMoments<S>,
        body: &RigidInertia<S>,
        rates: &[S],
    ) -> VelocityMoments<S> {
        let twice = |doubled: &[S]| Vector3(core::array::from_fn(|k| doubled[k] + doubled[k]));
        match self {
            Self::Revolute(rotation) => {
                let rotated = self.rigid_to_parent(body);
                let spin = Vector3::along_z(rates[0] + rates[0]);
                velocities.rotated_about(*rotation, Axis::Z).with_angular_velocity(spin, &rotated)
            }
            Self::Prismatic(q) => {
                let slide = Vector3::along_z(rates[0] + rates[0]);
                velocities.with_linear_velocity(slide, body).shifted(Vector3::along_z(*q))
            }
            Self::Spherical(rotation) => {
                let spin = rotation.mul_vector(twice(rates));
                velocities.rotated(rotation).with_angular_velocity(spin, &body.rotated(rotation))
            }
            Self::Floating { rotation, position } => {
                let slide = twice(rates);
                let spin = twice(&rates[3..]);
                let rotated = body.rotated(rotation);
                velocities
                    .rotated(rotation)
                    .with_angular_velocity(rotation.mul_vector(spin), &rotated)
                    .with_linear_velocity(rotation.mul_vector(slide), &rotated)
                    .shifted(*position)
            }
        }
    }

    /// Returns the velocity of the child's origin relative to the parent frame, in the parent's
    /// axes; `None` for joints that only rotate.
    #[must_use]
    pub fn origin_velocity(&self, rates: &[S]) -> Option<Vector3<S>> {
        match self {
            Self::Revolute(_) | Self::Spherical(_) => None,
            Self::Prismatic(_) => Some(Vector3::along_z(rates[0])),
            Self::Floating { rotation, .. } => {
                Some(rotation.mul_vector(Vector3([rates[0], rates[1], rates[2]])))
            }
        }
    }

    /// Returns an articulated inertia in the parent frame, from the child frame.
    #[must_use]
    pub fn articulated_to_parent(&self, i: &ArticulatedInertia<S>) -> ArticulatedInertia<S> {
        match self {
            Self::Revolute(rotation) => revolute::articulated_to_parent(*rotation, i),
            Self::Prismatic(q) => prismatic::articulated_to_parent(*q, i),
            Self::Spherical(rotation) => i.rotated(rotation),
            Self::Floating { rotation, position } => i.rotated(rotation).shifted(*position),
        }
    }
}
