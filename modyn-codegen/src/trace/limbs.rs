//! Limb packing: equal limbs as one limb of lanes, such as legs on a trunk, arms on a torso,
//! fingers on a palm.
//!
//! Limbs are equal if they have the same joint types in the same tree; their numbers may differ.
//! They are packed into one limb with a lane for each: a body of the merged limb represents one
//! body of each limb, and its numbers have a lane for each. The same equations run on it. The
//! forces of merged limbs on their parent are summed over the lanes
//! ([`MergedMechanism`](modyn_runtime::mechanism::MergedMechanism)); the parent's motion is
//! broadcast to them.
//!
//! Chains on different bodies can be merged, too (legs and arms). Each lane then has its own
//! parent. Shorter chains are extended by joints that move nothing.
//!
//! Only equations that sum over the lanes accept a `MergedMechanism`: they are generic over
//! `BodyTree`, whose `.._to_parents` adds up the bodies on a parent. All other equations take a
//! `Mechanism`, so misuse does not compile. The lane operations belong to `LaneScalar`, which
//! expressions implement and numbers do not. A trunk that moves couples the limbs, so the inverse
//! of the mass matrix has no zeros between them: `factorization/limb_coupling.rs` of the runtime
//! computes these blocks. The graph becomes a program on vectors, or loops over the limbs
//! (`program/repeat.rs`).

mod contacts;
pub(crate) mod groups;
mod merged;
mod touching;
mod unpack;

pub(in crate::trace) use contacts::ContactPacking;
use std::iter;
use std::ops::Range;
pub(in crate::trace) use touching::TouchingPacking;

use modyn_runtime::mechanism::{Body, Mechanism};

use crate::graph::Expr;
pub use groups::LimbLimits;
use groups::{groups, join, longest};

/// The limbs of a robot that are merged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LimbPacking {
    /// The bodies of the merged robot.
    bodies: Vec<Merged>,
    /// For each degree of freedom of the merged robot: the entry of the robot's joint vectors in
    /// each lane, and the group of limbs that it belongs to.
    velocities: Vec<(Lanes, Option<usize>)>,
    /// For each degree of freedom of the merged robot: the root body of the tree in each lane.
    roots: Vec<Lanes>,
    /// For each coordinate of the merged robot: the robot's coordinate in each lane.
    coordinates: Vec<Lanes>,
}

/// The index in each lane; `None` after the end of a shorter limb.
type Lanes = Vec<Option<usize>>;

/// A body of the merged robot.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Merged {
    /// The bodies of the robot that it represents.
    of: Lanes,
    /// The body with the structure of all of them.
    representative: usize,
    /// Whether the bodies are the first bodies of limbs.
    first: bool,
}

impl LimbPacking {
    /// Returns the equal limbs on one body; `None` if there are none.
    #[must_use]
    pub fn find(model: &Mechanism<f64>, limits: &LimbLimits) -> Option<Self> {
        let groups = groups(model, limits);
        (!groups.is_empty()).then(|| Self::new(model, &groups))
    }

    /// Returns the equal limbs, also of chains on different bodies; `None` if no such chains are
    /// equal.
    #[must_use]
    pub fn joined(model: &Mechanism<f64>, limits: &LimbLimits) -> Option<Self> {
        let equal = groups(model, limits);
        let joined = join(model, &equal, limits);
        (joined.len() < equal.len()).then(|| Self::new(model, &joined))
    }

    /// Returns the candidates, equal limbs on one body first; with `join`, chains on different
    /// bodies are merged, too.
    #[must_use]
    pub fn candidates(model: &Mechanism<f64>, limits: &LimbLimits, join: bool) -> Vec<Self> {
        let joined = join.then(|| Self::joined(model, limits)).flatten();
        Self::find(model, limits).into_iter().chain(joined).collect()
    }

    /// Returns whether the parents of limbs are on one path to the root, so that the limbs'
    /// quantities can be transformed together.
    #[must_use]
    pub fn share_root_path(&self, model: &Mechanism<f64>) -> bool {
        let on_one_path = |bodies_of_lanes: &Lanes| {
            let parents: Vec<usize> =
                bodies_of_lanes.iter().flatten().filter_map(|&b| model.bodies[b].parent).collect();
            let Some(&last) = parents.iter().max() else { return true };
            let path: Vec<usize> =
                iter::successors(Some(last), |&body| model.bodies[body].parent).collect();
            parents.iter().all(|parent| path.contains(parent))
        };
        self.bodies.iter().filter(|merged| merged.first).all(|merged| on_one_path(&merged.of))
    }

    fn new(model: &Mechanism<f64>, groups: &[Vec<Range<usize>>]) -> Self {
        let mut bodies = Vec::new();
        let mut velocities = Vec::new();
        let mut coordinates = Vec::new();
        let mut roots = Vec::new();
        let mut root_of: Vec<usize> = Vec::new();
        for (i, body) in model.bodies.iter().enumerate() {
            root_of.push(body.parent.map_or(i, |parent| root_of[parent]));
        }
        let mut add = |merged: Merged, group| {
            let body = &model.bodies[merged.representative];
            let lanes = |number: &dyn Fn(&Body<f64>) -> usize| {
                merged.of.iter().map(|body| body.map(|b| number(&model.bodies[b]))).collect()
            };
            for k in 0..body.dofs.len() {
                velocities.push((lanes(&|body| model.dofs[body.dofs.start + k].v), group));
                roots.push(merged.of.iter().map(|body| body.map(|b| root_of[b])).collect());
            }
            coordinates.extend((0..body.elementary_joint.nq()).map(|k| lanes(&|body| body.q + k)));
            bodies.push(merged);
        };
        for i in 0..model.bodies.len() {
            let Some(g) = groups.iter().position(|g| g.iter().any(|limb| limb.contains(&i))) else {
                add(Merged { of: vec![Some(i)], representative: i, first: false }, None);
                continue;
            };
            // The merged limb takes the place of the last limb, after all parents.
            let limbs = &groups[g];
            if limbs.iter().map(|limb| limb.start).max() != Some(i) {
                continue;
            }
            let longest = longest(limbs);
            for place in 0..longest.len() {
                let bodies = limbs.iter().map(|limb| limb.clone().nth(place)).collect();
                add(
                    Merged { of: bodies, representative: longest.start + place, first: place == 0 },
                    Some(g),
                );
            }
        }
        Self { bodies, velocities, roots, coordinates }
    }

    /// Returns, for each degree of freedom of the merged robot, the entry of the robot's joint
    /// vectors in each lane, and the group of limbs that it belongs to (`None` on the trunk, which
    /// has one lane).
    pub(in crate::trace) fn velocities(
        &self,
    ) -> impl Iterator<Item = (&[Option<usize>], Option<usize>)> {
        self.velocities.iter().map(|(lanes, group)| (&**lanes, *group))
    }

    /// Returns the coordinate of the merged robot that has this coordinate of the robot in a lane.
    pub(in crate::trace) fn coordinate(&self, coordinate: usize) -> usize {
        let place = self.coordinates.iter().position(|lanes| lanes.contains(&Some(coordinate)));
        place.expect("all coordinates are in some lane")
    }

    /// Returns whether no limb moves another: all are attached to the world.
    #[must_use]
    pub fn independent(&self, model: &Mechanism<f64>) -> bool {
        let first = self.bodies.iter().filter(|merged| merged.first);
        first
            .flat_map(|merged| merged.of.iter().flatten())
            .all(|&b| model.bodies[b].parent.is_none())
    }
}

fn constant(value: f64) -> Expr {
    <Expr as modyn_runtime::Scalar>::from_f64(value)
}

fn pack(numbers: impl Iterator<Item = Expr>) -> Expr {
    Expr::pack(&numbers.collect::<Vec<_>>())
}
