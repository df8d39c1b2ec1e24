//! Trees of bodies for the recursions: how quantities pass from parents to children and back.

use alloc::vec::Vec;
use core::ops::Range;

use super::Mechanism;
use crate::Scalar;
use crate::joint::JointTransform;
use crate::spatial::{ArticulatedInertia, RigidInertia, Vector3, Wrench};

/// The limbs that are merged into one, for the first body of their representative.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LimbRoot {
    /// The number of limbs, at least two; each has a lane.
    pub limbs: usize,
    /// The parent body of each limb (`None` for the world); limbs with the same parent are
    /// adjacent. Empty if all limbs have the parent of the representative.
    pub parents: Vec<Option<usize>>,
}

/// A tree of bodies that a recursion can run over: a [`Mechanism`], or a
/// [`MergedMechanism`](super::MergedMechanism) with merged limbs. The trait cannot be implemented
/// for other types.
pub trait BodyTree<S: Scalar>: TreeAccess<S> {}

/// The contents of a [`BodyTree`], and the lane operations between limbs and the bodies that carry
/// them.
pub trait TreeAccess<S: Scalar> {
    /// Returns the bodies and their degrees of freedom.
    fn mechanism(&self) -> &Mechanism<S>;

    /// Returns the limbs whose representative `_body` is the first body of; `None` if it is no such
    /// body.
    fn limb_root(&self, _body: usize) -> Option<&LimbRoot> {
        None
    }

    /// Returns for each constraint of the robot its index among the constraints of
    /// [`mechanism`](Self::mechanism), and its lane.
    fn constraint_lanes(&self) -> Vec<(usize, usize)> {
        (0..self.mechanism().constraints.len()).map(|constraint| (constraint, 0)).collect()
    }

    /// Returns the number of derivative columns that are computed at a time.
    fn column_lanes(&self) -> usize {
        1
    }

    /// Returns the pack of these lanes; the first one for scalars without lanes.
    fn pack(&self, each: &[S]) -> S {
        each[0]
    }

    /// Returns a lane of a pack; the number itself for scalars without lanes.
    fn extract_lane(&self, x: S, _lane: usize) -> S {
        x
    }

    /// Returns the sum over lanes of a pack; the number itself for scalars without lanes.
    fn sum_lanes(&self, x: S, _lanes: Range<usize>) -> S {
        x
    }

    /// Returns the parents of the limbs of `body`; `None` if all limbs have the same parent.
    fn parents(&self, body: usize) -> Option<&[Option<usize>]> {
        let parents = self.limb_root(body).map(|root| &*root.parents);
        parents.filter(|parents| !parents.is_empty())
    }

    /// Returns values of the parent of `body`'s joint; `None` is the world. If limbs have different
    /// parents, each lane has the value of its limb's parent.
    fn broadcast_from_parents<const N: usize>(
        &self,
        body: usize,
        quantity_of: impl Fn(Option<usize>) -> [S; N],
    ) -> [S; N] {
        let Some(parents) = self.parents(body) else {
            return quantity_of(self.mechanism().bodies[body].parent);
        };
        let each: Vec<[S; N]> = parents.iter().map(|&parent| quantity_of(parent)).collect();
        core::array::from_fn(|n| self.pack(&each.iter().map(|x| x[n]).collect::<Vec<_>>()))
    }

    /// Returns a pack with the lanes of the limbs whose parent is `parent`, and zeros in the other
    /// lanes.
    fn only_on(&self, parents: &[Option<usize>], parent: usize, x: S) -> S {
        let on = |(limb, on): (usize, &Option<usize>)| {
            if *on == Some(parent) { self.extract_lane(x, limb) } else { S::zero() }
        };
        self.pack(&parents.iter().enumerate().map(on).collect::<Vec<_>>())
    }

    /// Passes the sum over limbs to each parent of `body`. `add` receives the parent and the result
    /// of `at_parent`, which applies the sum to each of its numbers.
    fn to_parents<X>(
        &self,
        body: usize,
        at_parent: impl Fn(&dyn Fn(S) -> S) -> X,
        mut add: impl FnMut(usize, X),
    ) {
        let mut give = |parent: Option<usize>, limbs: Range<usize>| {
            if let Some(parent) = parent {
                add(parent, at_parent(&|x| self.sum_lanes(x, limbs.clone())));
            }
        };
        let parent = self.mechanism().bodies[body].parent;
        let Some(root) = self.limb_root(body) else {
            if let Some(parent) = parent {
                add(parent, at_parent(&|x| x));
            }
            return;
        };
        if root.parents.is_empty() {
            return give(parent, 0..root.limbs);
        }
        let mut start = 0;
        for limbs in root.parents.chunk_by(|a, b| a == b) {
            give(limbs[0], start..start + limbs.len());
            start += limbs.len();
        }
    }

    /// Passes a mass on `body` and its first moment to each parent.
    fn mass_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        mass: S,
        first_moment: Vector3<S>,
        add: impl FnMut(usize, (S, Vector3<S>)),
    ) {
        let body_record = &self.mechanism().bodies[body];
        if body_record.parent.is_some() {
            let (mass, first_moment) = body_record.mass_to_parent(motion, mass, first_moment);
            self.to_parents(body, |sum| (sum(mass), Vector3(first_moment.0.map(sum))), add);
        }
    }

    /// Passes a wrench on `body` to each parent.
    fn wrench_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        w: Wrench<S>,
        add: impl FnMut(usize, Wrench<S>),
    ) {
        let body_record = &self.mechanism().bodies[body];
        if body_record.parent.is_some() {
            let at_parent = body_record.wrench_to_parent(motion, w).components();
            self.to_parents(body, |sum| Wrench::from_components(at_parent.map(sum)), add);
        }
    }

    /// Passes a rigid inertia on `body` to each parent.
    fn rigid_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        i: &RigidInertia<S>,
        add: impl FnMut(usize, RigidInertia<S>),
    ) {
        let body_record = &self.mechanism().bodies[body];
        if body_record.parent.is_some() {
            let at_parent = body_record.rigid_to_parent(motion, i);
            self.to_parents(body, |sum| at_parent.map(sum), add);
        }
    }

    /// Passes an articulated inertia on `body` to each parent.
    fn articulated_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        i: &ArticulatedInertia<S>,
        add: impl FnMut(usize, ArticulatedInertia<S>),
    ) {
        let body_record = &self.mechanism().bodies[body];
        if body_record.parent.is_some() {
            let at_parent = body_record.articulated_to_parent(motion, i);
            let entry = |row, column| at_parent.entry(row, column);
            self.to_parents(
                body,
                |sum| ArticulatedInertia::from_fn(|row, column| sum(entry(row, column))),
                add,
            );
        }
    }
}

impl<S: Scalar> BodyTree<S> for Mechanism<S> {}

impl<S: Scalar> TreeAccess<S> for Mechanism<S> {
    fn mechanism(&self) -> &Mechanism<S> {
        self
    }
}

/// Values that are transformed from a body towards the root. If limbs have different parents, each
/// lane is added where its own limb meets the path.
pub(crate) struct RootwardAccumulator<'a, S, T, const N: usize> {
    tree: &'a T,
    /// The values of such limbs at their parents, to be added on the path.
    limbs: Option<(&'a [Option<usize>], [S; N])>,
}

impl<'a, S: Scalar, T: BodyTree<S>, const N: usize> RootwardAccumulator<'a, S, T, N> {
    pub(crate) fn new(tree: &'a T) -> Self {
        Self { tree, limbs: None }
    }

    /// Returns the values at `parent`: the values of `body` there, `at_parent`, plus the lanes of
    /// limbs that join the path there.
    pub(crate) fn accumulate(&mut self, body: usize, parent: usize, at_parent: [S; N]) -> [S; N] {
        let tree = self.tree;
        if let Some(parents) = tree.parents(body) {
            self.limbs = Some((parents, at_parent));
            return at_parent.map(|x| tree.only_on(parents, parent, x));
        }
        match &self.limbs {
            Some((parents, left)) if parents.contains(&Some(parent)) => {
                core::array::from_fn(|k| at_parent[k] + tree.only_on(parents, parent, left[k]))
            }
            _ => at_parent,
        }
    }
}
