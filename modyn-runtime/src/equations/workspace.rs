//! What the recursions remember of each link: allocated once, used by every call.

use alloc::{vec, vec::Vec};

use super::Partition;
use crate::Scalar;
use crate::joint::Motion;
use crate::model::prepare::Prepared;
use crate::spatial::{ArticulatedInertia, Field, RigidInertia, Twist, Wrench};

/// Memory of the recursions, one entry a link; linear in the number of links, but for the pivot
/// blocks, which are quadratic in the length of a module.
#[derive(Clone, Debug)]
pub struct Workspace<S> {
    pub(super) motions: Vec<Motion<S>>,
    pub(super) fields: Vec<Field<S>>,
    pub(super) twists: Vec<Twist<S>>,
    pub(super) wrenches: Vec<Wrench<S>>,
    pub(super) composite: Vec<RigidInertia<S>>,
    /// What eliminated modules leave to the link they hang on; `None` where none does.
    pub(super) articulated: Vec<Option<ArticulatedInertia<S>>>,
    /// By component, for each link's joint: the wrench at its module's first link (Psi), reduced by
    /// the pivot's factor; and that over the pivot.
    pub(super) columns: [Vec<S>; 6],
    pub(super) gains: [Vec<S>; 6],
    /// For each link's joint: reciprocal of its scalar pivot within the block.
    pub(super) reciprocals: Vec<S>,
    pub(super) torques: Vec<S>,
    /// Each module's block, then its unit triangular factor.
    pub(super) pivots: Vec<S>,
}

impl<S: Scalar> Workspace<S> {
    /// Room for a model of that many links, eliminated by these modules.
    #[must_use]
    pub fn new(links: usize, partition: &Partition) -> Self {
        let zero = S::zero();
        Self {
            motions: vec![Motion::Prismatic(zero); links],
            fields: vec![Field::zero(); links],
            twists: vec![Twist::zero(); links],
            wrenches: vec![Wrench::zero(); links],
            composite: vec![RigidInertia::zero(); links],
            articulated: vec![None; links],
            columns: core::array::from_fn(|_| vec![zero; links]),
            gains: core::array::from_fn(|_| vec![zero; links]),
            reciprocals: vec![zero; links],
            torques: vec![zero; links],
            pivots: vec![zero; partition.pivots],
        }
    }

    /// The joints at `q`.
    pub(super) fn move_to(&mut self, model: &Prepared<S>, q: &[S]) {
        for ((motion, body), &q) in self.motions.iter_mut().zip(&model.bodies).zip(q) {
            *motion = body.motion(q);
        }
    }
}
