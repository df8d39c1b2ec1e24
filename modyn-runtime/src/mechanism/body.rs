//! A body of the mechanism, and the transforms of quantities across its joint.

use core::ops::Range;

use super::{CompensatedMass, Dof, JointSpring};
use crate::Scalar;
use crate::joint::{ElementaryJoint, JointOffset, JointTransform};
use crate::model::{Inertial, Model};
use crate::spatial::{
    ArticulatedInertia, DhTransform, Pose, RigidInertia, Symmetric3, Twist, Vector3,
    VelocityMoments, Wrench,
};

/// A moving link in its Denavit-Hartenberg frame, or a massless body inside a universal or planar
/// joint.
#[derive(Clone, Debug)]
pub struct Body<S> {
    /// The parent body; `None` for the world.
    pub parent: Option<usize>,
    /// The joint towards the parent. Its axis is z.
    pub elementary_joint: ElementaryJoint,
    /// The index in q of the joint's first coordinate; for a mimic joint, of its leader's
    /// coordinate.
    pub q: usize,
    /// The multiplier and the offset of a mimic joint's coordinate.
    pub mimic: Option<(S, S)>,
    /// The joint's degrees of freedom, as a range of [`Mechanism::dofs`](super::Mechanism::dofs).
    pub dofs: Range<usize>,
    /// The offset between the joint's coordinate and the angle in this frame.
    pub offset: JointOffset<S>,
    /// The constant pose of the joint's frame in the parent.
    pub placement: DhTransform<S>,
    /// The pose of the model's link frame in this frame; without meaning for a body inside a joint.
    pub link: Pose<S>,
    /// The inertia in the model.
    pub inertia: RigidInertia<S>,
    /// The base inertia: equivalent to `inertia` for all joint-space dynamics.
    pub base_inertia: RigidInertia<S>,
    /// The spring of the joint; `None` without a spring.
    pub spring: Option<JointSpring<S>>,
    /// The mass whose weight is compensated; `None` without compensation.
    pub compensated: Option<CompensatedMass<S>>,
}

impl<S: Scalar> Body<S> {
    /// Returns the body with `f` applied to its numbers.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Body<T> {
        Body {
            parent: self.parent,
            elementary_joint: self.elementary_joint,
            q: self.q,
            mimic: self.mimic.map(|(multiplier, offset)| (f(multiplier), f(offset))),
            dofs: self.dofs.clone(),
            offset: self.offset.map(f),
            placement: self.placement.map(f),
            link: self.link.map(f),
            inertia: self.inertia.map(f),
            base_inertia: self.base_inertia.map(f),
            spring: self.spring.map(|spring| spring.map(f)),
            compensated: self.compensated.map(|mass| mass.map(f)),
        }
    }

    /// Returns the transform of the joint at the robot's coordinates `q`.
    #[must_use]
    pub fn motion(&self, q: &[S]) -> JointTransform<S> {
        let coordinates = &q[self.q..self.q + self.elementary_joint.nq()];
        match (self.mimic, coordinates) {
            (Some((multiplier, offset)), &[q]) => {
                JointTransform::new(self.elementary_joint, self.offset, &[multiplier * q + offset])
            }
            _ => JointTransform::new(self.elementary_joint, self.offset, coordinates),
        }
    }

    /// Returns a direction in this body's axes, from the parent's axes.
    #[must_use]
    pub fn to_child(&self, motion: &JointTransform<S>, v: Vector3<S>) -> Vector3<S> {
        motion.to_child(self.placement.to_child(v))
    }

    /// Returns a direction in the parent's axes, from this body's axes.
    #[must_use]
    pub fn to_parent(&self, motion: &JointTransform<S>, v: Vector3<S>) -> Vector3<S> {
        self.placement.to_parent(motion.to_parent(v))
    }

    /// Returns the twist of this body if it moved rigidly with the parent: A t of the paper.
    #[must_use]
    pub fn twist_to_child(&self, motion: &JointTransform<S>, t: Twist<S>) -> Twist<S> {
        motion.twist_to_child(self.placement.twist_to_child(t))
    }

    /// Returns a wrench in the parent frame, from this body's frame: A^T w.
    #[must_use]
    pub fn wrench_to_parent(&self, motion: &JointTransform<S>, w: Wrench<S>) -> Wrench<S> {
        self.placement.wrench_to_parent(motion.wrench_to_parent(w))
    }

    /// Returns a rigid inertia in the parent frame, from this body's frame: A^T M A.
    #[must_use]
    pub fn rigid_to_parent(
        &self,
        motion: &JointTransform<S>,
        i: &RigidInertia<S>,
    ) -> RigidInertia<S> {
        self.placement.rigid_to_parent(&motion.rigid_to_parent(i))
    }

    /// Returns velocity moments relative to the parent frame, in the parent frame. `velocities` are
    /// relative to this body's frame, of points of inertia `i`.
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

    /// Returns an articulated inertia in the parent frame, from this body's frame: A^T M A.
    #[must_use]
    pub fn articulated_to_parent(
        &self,
        motion: &JointTransform<S>,
        i: &ArticulatedInertia<S>,
    ) -> ArticulatedInertia<S> {
        self.placement.articulated_to_parent(&motion.articulated_to_parent(i))
    }

    /// Returns a mass and its first moment in the parent frame, from this body's frame.
    #[must_use]
    pub fn mass_to_parent(
        &self,
        motion: &JointTransform<S>,
        mass: S,
        first_moment: Vector3<S>,
    ) -> (S, Vector3<S>) {
        let rotated = motion.to_parent(first_moment);
        let at_joint = motion.displacement().map_or(rotated, |d| rotated + d.scale(mass));
        (mass, self.placement.to_parent(at_joint) + self.placement.origin().scale(mass))
    }
}

/// The place of a body in the tree and in the joint vectors. The size and layout of results depend
/// on these only, not on the body's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyStructure {
    parent: Option<usize>,
    elementary_joint: ElementaryJoint,
    q: usize,
    /// The entry of qd of the joint's first degree of freedom.
    v: Option<usize>,
    mimics: bool,
}

impl<S> Body<S> {
    /// Returns the structure of this body; `dofs` are the mechanism's degrees of freedom.
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

/// Returns the mass, first moment and second moment of an inertia about its frame's origin.
#[must_use]
pub fn rigid_inertia<S: Scalar>(inertial: &Inertial<S>) -> RigidInertia<S> {
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let inertia = Symmetric3 { xx, xy, xz, yy, yz, zz };
    RigidInertia::new(inertial.mass, Vector3(inertial.center_of_mass), &inertia)
}

/// Returns the inertia of moving link `link` of `model` without the own inertias of the `removed`
/// links, about its origin in its own axes. `removed` are indices of [`Model::links`]: links that
/// are fixed to `link`, or `link` itself. A difference within rounding is zero.
#[must_use]
pub fn inertia_without(
    model: &Model,
    link: usize,
    removed: impl Fn(usize) -> bool,
) -> RigidInertia<f64> {
    /// The rounding relative to the terms of the difference.
    const ROUNDING: f64 = 1e-13;
    let whole = rigid_inertia(&model.moving_links()[link].inertial);
    let frames = model.links().iter().enumerate();
    let parts = frames
        .filter(|(i, frame)| frame.moving_link == Some(link) && removed(*i))
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

impl<S: Scalar> Body<S> {
    /// Returns the mass whose weight is compensated, without second moment.
    #[must_use]
    pub fn compensated_inertia(&self) -> RigidInertia<S> {
        let zero = S::zero();
        let second_moment =
            Symmetric3 { xx: zero, xy: zero, xz: zero, yy: zero, yz: zero, zz: zero };
        self.compensated.map_or_else(
            RigidInertia::zero,
            |CompensatedMass { mass, first_moment }| RigidInertia {
                mass,
                first_moment,
                second_moment,
            },
        )
    }
}
