//! A body of the mechanism and how quantities are carried across its joint.

use core::ops::Range;

use super::Dof;
use crate::Scalar;
use crate::joint::{ElementaryJoint, JointOffset, JointTransform};
use crate::model::{Inertial, Model};
use crate::spatial::{
    ArticulatedInertia, DhTransform, Pose, RigidInertia, Symmetric3, Twist, Vector3,
    VelocityMoments, Wrench,
};

/// A moving link, or a massless body inside a universal or planar joint, in its Denavit-Hartenberg
/// frame.
#[derive(Clone, Debug)]
pub struct Body<S> {
    /// The parent body; `None` for the world.
    pub parent: Option<usize>,
    /// Its joint; an axis is z.
    pub elementary_joint: ElementaryJoint,
    /// The index of its first coordinate in q.
    pub q: usize,
    /// The ratio and offset of its coordinate to that one, for a joint that mimics.
    pub mimic: Option<(S, S)>,
    /// Its degrees of freedom, as a range of [`Mechanism::dofs`](super::Mechanism::dofs).
    pub dofs: Range<usize>,
    /// The joint's zero.
    pub zero: JointOffset<S>,
    /// The joint's constant pose on the parent.
    pub placement: DhTransform<S>,
    /// The pose of the model's link frame in this one; without meaning for a body inside a joint.
    pub link: Pose<S>,
    /// The inertia that the model states.
    pub inertia: RigidInertia<S>,
    /// The inertia in base parameters: equivalent to `inertia` for all joint-space dynamics.
    pub base_inertia: RigidInertia<S>,
}

impl<S: Scalar> Body<S> {
    /// Each number through `f`.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Body<T> {
        Body {
            parent: self.parent,
            elementary_joint: self.elementary_joint,
            q: self.q,
            mimic: self.mimic.map(|(multiplier, offset)| (f(multiplier), f(offset))),
            dofs: self.dofs.clone(),
            zero: self.zero.map(f),
            placement: self.placement.map(f),
            link: self.link.map(f),
            inertia: self.inertia.map(f),
            base_inertia: self.base_inertia.map(f),
        }
    }

    /// The transform of its joint where the robot's coordinates are `q`.
    #[must_use]
    pub fn motion(&self, q: &[S]) -> JointTransform<S> {
        let own = &q[self.q..self.q + self.elementary_joint.nq()];
        match (self.mimic, own) {
            (Some((multiplier, offset)), &[q]) => {
                JointTransform::new(self.elementary_joint, self.zero, &[multiplier * q + offset])
            }
            _ => JointTransform::new(self.elementary_joint, self.zero, own),
        }
    }

    /// A direction of the parent's frame, seen from this body.
    #[must_use]
    pub fn to_child(&self, motion: &JointTransform<S>, v: Vector3<S>) -> Vector3<S> {
        motion.to_child(self.placement.to_child(v))
    }

    /// A direction of this body's frame, seen from the parent.
    #[must_use]
    pub fn to_parent(&self, motion: &JointTransform<S>, v: Vector3<S>) -> Vector3<S> {
        self.placement.to_parent(motion.to_parent(v))
    }

    /// The parent's twist carried rigidly to this body: A t of the paper.
    #[must_use]
    pub fn twist_to_child(&self, motion: &JointTransform<S>, t: Twist<S>) -> Twist<S> {
        motion.twist_to_child(self.placement.twist_to_child(t))
    }

    /// A wrench on this body at its parent: A^T w.
    #[must_use]
    pub fn wrench_to_parent(&self, motion: &JointTransform<S>, w: Wrench<S>) -> Wrench<S> {
        self.placement.wrench_to_parent(motion.wrench_to_parent(w))
    }

    /// A rigid inertia on this body at its parent: A^T M A.
    #[must_use]
    pub fn rigid_to_parent(
        &self,
        motion: &JointTransform<S>,
        i: &RigidInertia<S>,
    ) -> RigidInertia<S> {
        self.placement.rigid_to_parent(&motion.rigid_to_parent(i))
    }

    /// Moments of velocities against this body's frame, of points of inertia `i`, at its parent and
    /// against the parent's frame.
    #[must_use]
    pub fn velocities_to_parent(
        &self,
        motion: &JointTransform<S>,
        velocities: &VelocityMoments<S>,
        i: &RigidInertia<S>,
        rates: &[S],
    ) -> VelocityMoments<S> {
        self.placement.velocities_to_parent(&motion.velocities_to_parent(velocities, i, rates))
    }

    /// An articulated inertia on this body at its parent: A^T M A.
    #[must_use]
    pub fn articulated_to_parent(
        &self,
        motion: &JointTransform<S>,
        i: &ArticulatedInertia<S>,
    ) -> ArticulatedInertia<S> {
        self.placement.articulated_to_parent(&motion.articulated_to_parent(i))
    }

    /// A mass on this body and its first moment, at its parent.
    #[must_use]
    pub fn mass_to_parent(
        &self,
        motion: &JointTransform<S>,
        mass: S,
        first_moment: Vector3<S>,
    ) -> (S, Vector3<S>) {
        let turned = motion.to_parent(first_moment);
        let at_joint = motion.displacement().map_or(turned, |d| turned + d.scale(mass));
        (mass, self.placement.to_parent(at_joint) + self.placement.origin().scale(mass))
    }
}

/// The place of a body in the tree and in the joint vectors: all that the size and the layout of
/// results depend on, without its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyStructure {
    parent: Option<usize>,
    elementary_joint: ElementaryJoint,
    q: usize,
    /// The entry of qd of its first degree of freedom.
    v: Option<usize>,
    mimics: bool,
}

impl<S> Body<S> {
    /// The structure of this body, one of a mechanism with these degrees of freedom.
    pub(super) fn structure(&self, dofs: &[Dof<S>]) -> BodyStructure {
        BodyStructure {
            parent: self.parent,
            elementary_joint: self.elementary_joint,
            q: self.q,
            v: dofs.get(self.dofs.start).map(|dof| dof.v),
            mimics: self.mimic.is_some(),
        }
    }
}

/// The mass, first moment and second moment of an inertia about its frame's origin.
#[must_use]
pub fn rigid_inertia<S: Scalar>(inertial: &Inertial<S>) -> RigidInertia<S> {
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let inertia = Symmetric3 { xx, xy, xz, yy, yz, zz };
    RigidInertia::new(inertial.mass, Vector3(inertial.center_of_mass), &inertia)
}

/// The inertia of moving link `link` of `model` without the own inertias of the `removed` links that are fixed to it
/// (indices of [`Model::frames`], itself among them), about its origin in its own axes. A difference that is
/// rounding is zero.
#[must_use]
pub fn inertia_without(
    model: &Model,
    link: usize,
    removed: impl Fn(usize) -> bool,
) -> RigidInertia<f64> {
    /// Relative to the terms of the difference.
    const ROUNDING: f64 = 1e-13;
    let whole = rigid_inertia(&model.links()[link].inertial);
    let frames = model.frames().iter().enumerate();
    let parts = frames
        .filter(|(i, frame)| frame.link == Some(link) && removed(*i))
        .map(|(_, frame)| rigid_inertia(&frame.inertial).placed(&frame.pose))
        .fold(RigidInertia::zero(), |sum, part| sum + part);
    let trace = |i: &RigidInertia<f64>| {
        let Symmetric3 { xx, yy, zz, .. } = i.second_moment;
        xx.abs() + yy.abs() + zz.abs()
    };
    let mass = ROUNDING * (whole.mass.abs() + parts.mass.abs());
    let second = ROUNDING * (trace(&whole) + trace(&parts));
    let first = libm::sqrt(mass * second);
    let rounded = |x: f64, rounding: f64| if x.abs() <= rounding { 0.0 } else { x };
    let left = whole.minus(&parts);
    RigidInertia {
        mass: rounded(left.mass, mass),
        first_moment: Vector3(left.first_moment.0.map(|x| rounded(x, first))),
        second_moment: left.second_moment.map(|x| rounded(x, second)),
    }
}
