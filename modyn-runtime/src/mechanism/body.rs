//! A body of the mechanism and how quantities are carried across its joint.

use alloc::vec::Vec;
use core::ops::Range;

use crate::Scalar;
use crate::joint::{Motion, Primitive, Zero};
use crate::model::Inertial;
use crate::spatial::{
    ArticulatedInertia, Placement, Pose, RigidInertia, Symmetric3, Twist, Vector3, VelocityMoments,
    Wrench,
};

/// A moving link, or a massless body inside a universal or planar joint, in its turned and shifted
/// frame.
#[derive(Clone, Debug)]
pub struct Body<S> {
    /// The body it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// What motion its joint allows, along z if along an axis.
    pub primitive: Primitive,
    /// Where its first coordinate stands in q.
    pub q: usize,
    /// The ratio and offset of its coordinate to that one, for a joint that mimics.
    pub mimic: Option<(S, S)>,
    /// Its degrees of freedom, among those of [`Prepared::dofs`].
    pub dofs: Range<usize>,
    /// The joint's zero.
    pub zero: Zero<S>,
    /// Where the joint stands on the parent.
    pub placement: Placement<S>,
    /// The model's link frame in this one; without meaning for a body inside a joint.
    pub link: Pose<S>,
    /// The inertia as the model has it.
    pub inertia: RigidInertia<S>,
    /// The inertia in minimal parameters: equal to `inertia` for all joint-space dynamics.
    pub minimal: RigidInertia<S>,
    /// How many limbs it is the first body of, where they are computed as one; else 1. What hangs on a
    /// parent adds up over them.
    pub limbs: usize,
    /// What each of these limbs hangs on, if that is not the same for all; else none. `parent` is then the
    /// last one.
    pub parents: Vec<Option<usize>>,
}

impl<S: Scalar> Body<S> {
    /// Each number through `f`.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Body<T> {
        Body {
            parent: self.parent,
            primitive: self.primitive,
            q: self.q,
            mimic: self.mimic.map(|(multiplier, offset)| (f(multiplier), f(offset))),
            dofs: self.dofs.clone(),
            zero: self.zero.map(f),
            placement: self.placement.map(f),
            link: self.link.map(f),
            inertia: self.inertia.map(f),
            minimal: self.minimal.map(f),
            limbs: self.limbs,
            parents: self.parents.clone(),
        }
    }

    /// The joint where the robot's coordinates are `q`.
    #[must_use]
    pub fn motion(&self, q: &[S]) -> Motion<S> {
        let own = &q[self.q..self.q + self.primitive.nq()];
        match (self.mimic, own) {
            (Some((multiplier, offset)), &[q]) => {
                Motion::new(self.primitive, self.zero, &[multiplier * q + offset])
            }
            _ => Motion::new(self.primitive, self.zero, own),
        }
    }

    /// A direction of the parent's frame, seen from this body.
    #[must_use]
    pub fn to_child(&self, motion: &Motion<S>, v: Vector3<S>) -> Vector3<S> {
        motion.to_child(self.placement.to_child(v))
    }

    /// A direction of this body's frame, seen from the parent.
    #[must_use]
    pub fn to_parent(&self, motion: &Motion<S>, v: Vector3<S>) -> Vector3<S> {
        self.placement.to_parent(motion.to_parent(v))
    }

    /// The parent's twist carried rigidly to this body: A t of the paper.
    #[must_use]
    pub fn twist_to_child(&self, motion: &Motion<S>, t: Twist<S>) -> Twist<S> {
        motion.twist_to_child(self.placement.twist_to_child(t))
    }

    /// A wrench on this body at its parent: A^T w.
    #[must_use]
    pub fn wrench_to_parent(&self, motion: &Motion<S>, w: Wrench<S>) -> Wrench<S> {
        self.placement.wrench_to_parent(motion.wrench_to_parent(w))
    }

    /// A rigid inertia on this body at its parent: A^T M A.
    #[must_use]
    pub fn rigid_to_parent(&self, motion: &Motion<S>, i: &RigidInertia<S>) -> RigidInertia<S> {
        self.placement.rigid_to_parent(&motion.rigid_to_parent(i))
    }

    /// Moments of velocities against this body's frame, of points of inertia `i`, at its parent and
    /// against the parent's frame.
    #[must_use]
    pub fn velocities_to_parent(
        &self,
        motion: &Motion<S>,
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
        motion: &Motion<S>,
        i: &ArticulatedInertia<S>,
    ) -> ArticulatedInertia<S> {
        self.placement.articulated_to_parent(&motion.articulated_to_parent(i))
    }

    /// A mass on this body and its first moment, at its parent.
    #[must_use]
    pub fn mass_to_parent(
        &self,
        motion: &Motion<S>,
        mass: S,
        first_moment: Vector3<S>,
    ) -> (S, Vector3<S>) {
        let turned = motion.to_parent(first_moment);
        let at_joint = motion.displacement().map_or(turned, |d| turned + d.scale(mass));
        (mass, self.placement.to_parent(at_joint) + self.placement.origin().scale(mass))
    }

    /// The numbers that its joint gets from what it hangs on: those of a body, or of the world (`None`).
    pub fn from_parents<const N: usize>(&self, of: impl Fn(Option<usize>) -> [S; N]) -> [S; N] {
        if self.parents.is_empty() {
            return of(self.parent);
        }
        let each: Vec<[S; N]> = self.parents.iter().map(|&parent| of(parent)).collect();
        core::array::from_fn(|n| S::by_limb(&each.iter().map(|x| x[n]).collect::<Vec<_>>()))
    }

    /// Of numbers of limbs that hang on different bodies: those of limbs on body `parent`, and zeros.
    pub(crate) fn only_on(&self, parent: usize, x: S) -> S {
        let on = |(limb, on): (usize, &Option<usize>)| {
            if *on == Some(parent) { x.of_limb(limb) } else { S::zero() }
        };
        S::by_limb(&self.parents.iter().enumerate().map(on).collect::<Vec<_>>())
    }

    /// Gives each body that it hangs on what the limbs there leave together: `add` gets the body and what
    /// `left` makes of the sum over them.
    pub fn to_parents<X>(
        &self,
        left: impl Fn(&dyn Fn(S) -> S) -> X,
        mut add: impl FnMut(usize, X),
    ) {
        let mut give = |parent: Option<usize>, limbs: Range<usize>| {
            if let Some(parent) = parent {
                add(parent, left(&|x: S| x.over_limbs(limbs.clone())));
            }
        };
        if self.parents.is_empty() {
            return give(self.parent, 0..self.limbs);
        }
        let mut start = 0;
        for limbs in self.parents.chunk_by(|a, b| a == b) {
            give(limbs[0], start..start + limbs.len());
            start += limbs.len();
        }
    }

    /// Gives them a mass on this body and its first moment.
    pub fn mass_to_parents(
        &self,
        motion: &Motion<S>,
        mass: S,
        first_moment: Vector3<S>,
        add: impl FnMut(usize, (S, Vector3<S>)),
    ) {
        if self.parent.is_some() {
            let (mass, first_moment) = self.mass_to_parent(motion, mass, first_moment);
            self.to_parents(|sum| (sum(mass), Vector3(first_moment.0.map(sum))), add);
        }
    }

    /// Gives them a wrench on this body.
    pub fn wrench_to_parents(
        &self,
        motion: &Motion<S>,
        w: Wrench<S>,
        add: impl FnMut(usize, Wrench<S>),
    ) {
        if self.parent.is_some() {
            let carried = self.wrench_to_parent(motion, w).components();
            self.to_parents(|sum| Wrench::from_components(carried.map(sum)), add);
        }
    }

    /// Gives them a rigid inertia on this body.
    pub fn rigid_to_parents(
        &self,
        motion: &Motion<S>,
        i: &RigidInertia<S>,
        add: impl FnMut(usize, RigidInertia<S>),
    ) {
        if self.parent.is_some() {
            let carried = self.rigid_to_parent(motion, i);
            self.to_parents(|sum| carried.map(sum), add);
        }
    }

    /// Gives them an articulated inertia on this body.
    pub fn articulated_to_parents(
        &self,
        motion: &Motion<S>,
        i: &ArticulatedInertia<S>,
        add: impl FnMut(usize, ArticulatedInertia<S>),
    ) {
        if self.parent.is_some() {
            let carried = self.articulated_to_parent(motion, i);
            let entry = |row, column| carried.entry(row, column);
            self.to_parents(
                |sum| ArticulatedInertia::from_fn(|row, column| sum(entry(row, column))),
                add,
            );
        }
    }
}

/// The mass, first moment and second moment of an inertia about its frame's origin.
#[must_use]
pub fn rigid_inertia(inertial: &Inertial) -> RigidInertia<f64> {
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let inertia = Symmetric3 { xx, xy, xz, yy, yz, zz };
    RigidInertia::new(inertial.mass, Vector3(inertial.center_of_mass), &inertia)
}
