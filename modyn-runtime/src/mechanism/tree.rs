//! Trees of bodies that the recursions run over: quantities from parents, and onto parents.

use alloc::vec::Vec;
use core::ops::Range;

use super::Mechanism;
use crate::Scalar;
use crate::joint::JointTransform;
use crate::spatial::{ArticulatedInertia, RigidInertia, Vector3, Wrench};

/// The limbs that a merged limb's first body stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LimbRoot {
    /// The number of limbs, a lane each; at least two.
    pub limbs: usize,
    /// The body that each limb hangs on (`None` for the world), limbs of one body next to each other;
    /// empty if that is the body's own parent for all.
    pub parents: Vec<Option<usize>>,
}

/// A tree of bodies that a recursion can run over: a [`Mechanism`], or a
/// [`MergedMechanism`](super::MergedMechanism), where one limb stands for several. No other type can
/// be one.
pub trait BodyTree<S: Scalar>: TreeAccess<S> {}

/// The numbers of a [`BodyTree`], and how lanes come in and are summed up where limbs meet the bodies
/// that carry them.
pub trait TreeAccess<S: Scalar> {
    /// The bodies and their degrees of freedom.
    fn mechanism(&self) -> &Mechanism<S>;

    /// The limbs that a body is the first one of, where it stands for several.
    fn limb_root(&self, _body: usize) -> Option<&LimbRoot> {
        None
    }

    /// The number of columns of derivatives that are computed at a time.
    fn column_lanes(&self) -> usize {
        1
    }

    /// The pack of these numbers; the first one where numbers have no lanes.
    fn pack(&self, each: &[S]) -> S {
        each[0]
    }

    /// A lane of a pack; the number itself where numbers have no lanes.
    fn extract_lane(&self, x: S, _lane: usize) -> S {
        x
    }

    /// The sum over lanes of a pack; the number itself where numbers have no lanes.
    fn sum_lanes(&self, x: S, _lanes: Range<usize>) -> S {
        x
    }

    /// The bodies that limbs hang on, if not all limbs of the body's hang on its parent.
    fn parents(&self, body: usize) -> Option<&[Option<usize>]> {
        let parents = self.limb_root(body).map(|root| &*root.parents);
        parents.filter(|parents| !parents.is_empty())
    }

    /// The numbers that `body`'s joint gets from the body that it hangs on, or from the world
    /// (`None`): lane by lane, where limbs hang on different bodies.
    fn broadcast_from_parents<const N: usize>(
        &self,
        body: usize,
        of: impl Fn(Option<usize>) -> [S; N],
    ) -> [S; N] {
        let Some(parents) = self.parents(body) else {
            return of(self.mechanism().bodies[body].parent);
        };
        let each: Vec<[S; N]> = parents.iter().map(|&parent| of(parent)).collect();
        core::array::from_fn(|n| self.pack(&each.iter().map(|x| x[n]).collect::<Vec<_>>()))
    }

    /// A pack with the lanes of the limbs that hang on `parent`, and zeros in the others.
    fn only_on(&self, parents: &[Option<usize>], parent: usize, x: S) -> S {
        let on = |(limb, on): (usize, &Option<usize>)| {
            if *on == Some(parent) { self.extract_lane(x, limb) } else { S::zero() }
        };
        self.pack(&parents.iter().enumerate().map(on).collect::<Vec<_>>())
    }

    /// Gives each body that `body` hangs on the sum over its limbs there: `add` gets the parent
    /// and the result of `carried`, which puts each of its numbers through the sum.
    fn to_parents<X>(
        &self,
        body: usize,
        carried: impl Fn(&dyn Fn(S) -> S) -> X,
        mut add: impl FnMut(usize, X),
    ) {
        let mut give = |parent: Option<usize>, limbs: Range<usize>| {
            if let Some(parent) = parent {
                add(parent, carried(&|x| self.sum_lanes(x, limbs.clone())));
            }
        };
        let parent = self.mechanism().bodies[body].parent;
        let Some(root) = self.limb_root(body) else {
            if let Some(parent) = parent {
                add(parent, carried(&|x| x));
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

    /// Gives them a mass on `body` and its first moment.
    fn mass_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        (mass, first_moment): (S, Vector3<S>),
        add: impl FnMut(usize, (S, Vector3<S>)),
    ) {
        let own = &self.mechanism().bodies[body];
        if own.parent.is_some() {
            let (mass, first_moment) = own.mass_to_parent(motion, mass, first_moment);
            self.to_parents(body, |sum| (sum(mass), Vector3(first_moment.0.map(sum))), add);
        }
    }

    /// Gives them a wrench on `body`.
    fn wrench_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        w: Wrench<S>,
        add: impl FnMut(usize, Wrench<S>),
    ) {
        let own = &self.mechanism().bodies[body];
        if own.parent.is_some() {
            let carried = own.wrench_to_parent(motion, w).components();
            self.to_parents(body, |sum| Wrench::from_components(carried.map(sum)), add);
        }
    }

    /// Gives them a rigid inertia on `body`.
    fn rigid_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        i: &RigidInertia<S>,
        add: impl FnMut(usize, RigidInertia<S>),
    ) {
        let own = &self.mechanism().bodies[body];
        if own.parent.is_some() {
            let carried = own.rigid_to_parent(motion, i);
            self.to_parents(body, |sum| carried.map(sum), add);
        }
    }

    /// Gives them an articulated inertia on `body`.
    fn articulated_to_parents(
        &self,
        body: usize,
        motion: &JointTransform<S>,
        i: &ArticulatedInertia<S>,
        add: impl FnMut(usize, ArticulatedInertia<S>),
    ) {
        let own = &self.mechanism().bodies[body];
        if own.parent.is_some() {
            let carried = own.articulated_to_parent(motion, i);
            let entry = |row, column| carried.entry(row, column);
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

/// Numbers that are carried from a body to the root. Where limbs hang on different bodies, each lane is
/// added where its own limb meets the path.
pub(crate) struct RootwardAccumulator<'a, S, T, const N: usize> {
    tree: &'a T,
    /// The numbers that such limbs have carried to the bodies that they hang on.
    limbs: Option<(&'a [Option<usize>], [S; N])>,
}

impl<'a, S: Scalar, T: BodyTree<S>, const N: usize> RootwardAccumulator<'a, S, T, N> {
    pub(crate) fn new(tree: &'a T) -> Self {
        Self { tree, limbs: None }
    }

    /// The numbers at `parent`, of those that are `carried` to it from `body` and of the lanes that are
    /// added there.
    pub(crate) fn accumulate(&mut self, body: usize, parent: usize, carried: [S; N]) -> [S; N] {
        let tree = self.tree;
        if let Some(parents) = tree.parents(body) {
            self.limbs = Some((parents, carried));
            return carried.map(|x| tree.only_on(parents, parent, x));
        }
        match &self.limbs {
            Some((parents, left)) if parents.contains(&Some(parent)) => {
                core::array::from_fn(|k| carried[k] + tree.only_on(parents, parent, left[k]))
            }
            _ => carried,
        }
    }
}
