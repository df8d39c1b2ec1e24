//! A joint at a value of its coordinate: the one place where the equations meet joint types.

use super::{JointType, prismatic, revolute};
use crate::Scalar;
use crate::model::prepare::Zero;
use crate::spatial::{
    ArticulatedInertia, Axis, Field, Matrix3, RigidInertia, Turn, Twist, Vector3, Wrench,
};

/// The motion of a joint along the z axis of its frame, at a value of its coordinate.
#[derive(Clone, Copy, Debug)]
pub enum Motion<S> {
    /// Turned about z.
    Revolute(Turn<S>),
    /// Shifted along z by so much.
    Prismatic(S),
}

/// The motion in front of a joint, in the axes behind it.
#[derive(Clone, Copy, Debug)]
pub struct Carried<S> {
    /// Angular velocity.
    pub omega: Vector3<S>,
    /// Angular acceleration.
    pub alpha: Vector3<S>,
    /// The acceleration of the joint's frame's origin at coordinate zero.
    pub a: Vector3<S>,
}

impl<S: Scalar> Motion<S> {
    /// The joint at coordinate `q`, where the frame's own zero stands at `zero`.
    #[must_use]
    pub fn new(joint_type: JointType, zero: Zero<S>, q: S) -> Self {
        match joint_type {
            JointType::Revolute | JointType::Continuous => Self::Revolute(revolute::turn(zero, q)),
            JointType::Prismatic => Self::Prismatic(q),
        }
    }

    /// Which of the six components (angular x, y, z, linear x, y, z) the joint moves: the one
    /// that is not zero in the paper's joint-motion propagation vector p.
    #[must_use]
    pub fn component(&self) -> usize {
        match self {
            Self::Revolute(_) => 2,
            Self::Prismatic(_) => 5,
        }
    }

    /// Where the joint has carried its frame's origin, in the axes behind the joint; `None` where
    /// it stays.
    #[must_use]
    pub fn displacement(&self) -> Option<Vector3<S>> {
        match self {
            Self::Revolute(_) => None,
            Self::Prismatic(q) => Some(Vector3::along_z(*q)),
        }
    }

    /// The motion behind the joint, from what is carried across it and the joint's own rate and
    /// acceleration; `None` where it has no acceleration.
    #[must_use]
    pub fn accelerate(&self, carried: Carried<S>, rate: S, acceleration: Option<S>) -> Field<S> {
        match self {
            Self::Revolute(_) => revolute::accelerate(carried, rate, acceleration),
            Self::Prismatic(q) => prismatic::accelerate(*q, carried, rate, acceleration),
        }
    }

    /// p^T w: the part of a wrench that the joint feels.
    #[must_use]
    pub fn project(&self, w: &Wrench<S>) -> S {
        match self {
            Self::Revolute(_) => w.moment[2],
            Self::Prismatic(_) => w.force[2],
        }
    }

    /// A direction in front of the joint, seen from behind it.
    #[must_use]
    pub fn to_child(&self, v: Vector3<S>) -> Vector3<S> {
        match self {
            Self::Revolute(turn) => turn.inverse().vector(Axis::Z, v),
            Self::Prismatic(_) => v,
        }
    }

    /// A direction behind the joint, seen from in front of it.
    #[must_use]
    pub fn to_parent(&self, v: Vector3<S>) -> Vector3<S> {
        match self {
            Self::Revolute(turn) => turn.vector(Axis::Z, v),
            Self::Prismatic(_) => v,
        }
    }

    /// The axes in front of the joint (as columns, in some third frame), turned behind it.
    #[must_use]
    pub fn turn_axes(&self, axes: &Matrix3<S>) -> Matrix3<S> {
        match self {
            Self::Revolute(turn) => turn.columns(Axis::Z, axes),
            Self::Prismatic(_) => *axes,
        }
    }

    /// A twist (or deviation of acceleration) carried rigidly across the joint, twist propagation.
    #[must_use]
    pub fn twist_to_child(&self, t: Twist<S>) -> Twist<S> {
        match self {
            Self::Revolute(turn) => revolute::twist_to_child(*turn, t),
            Self::Prismatic(q) => prismatic::twist_to_child(*q, t),
        }
    }

    /// `t` with the joint's own rate (or acceleration) added: t + p rate.
    #[must_use]
    pub fn add_rate(&self, mut t: Twist<S>, rate: S) -> Twist<S> {
        match self {
            Self::Revolute(_) => t.angular[2] = t.angular[2] + rate,
            Self::Prismatic(_) => t.linear[2] = t.linear[2] + rate,
        }
        t
    }

    /// A wrench behind the joint, carried in front of it.
    #[must_use]
    pub fn wrench_to_parent(&self, w: Wrench<S>) -> Wrench<S> {
        match self {
            Self::Revolute(turn) => revolute::wrench_to_parent(*turn, w),
            Self::Prismatic(q) => prismatic::wrench_to_parent(*q, w),
        }
    }

    /// A rigid inertia behind the joint, carried in front of it.
    #[must_use]
    pub fn rigid_to_parent(&self, i: &RigidInertia<S>) -> RigidInertia<S> {
        match self {
            Self::Revolute(turn) => revolute::rigid_to_parent(*turn, i),
            Self::Prismatic(q) => prismatic::rigid_to_parent(*q, i),
        }
    }

    /// An articulated inertia behind the joint, carried in front of it.
    #[must_use]
    pub fn articulated_to_parent(&self, i: &ArticulatedInertia<S>) -> ArticulatedInertia<S> {
        match self {
            Self::Revolute(turn) => revolute::articulated_to_parent(*turn, i),
            Self::Prismatic(q) => prismatic::articulated_to_parent(*q, i),
        }
    }

    /// The wrench of a unit joint acceleration on a rigid inertia: M p.
    #[must_use]
    pub fn unit_wrench(&self, i: &RigidInertia<S>) -> Wrench<S> {
        match self {
            Self::Revolute(_) => revolute::unit_wrench(i),
            Self::Prismatic(_) => prismatic::unit_wrench(i),
        }
    }
}
