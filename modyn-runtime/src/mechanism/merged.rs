//! A mechanism in which one limb stands for several equal ones.

use alloc::vec::Vec;
use core::ops::Range;

use super::Mechanism;
use super::tree::{BodyTree, LimbRoot, TreeAccess};
use crate::LaneScalar;

/// A mechanism whose numbers may be packs of lanes: equal limbs (legs, arms, fingers) merged into
/// one, a limb a lane, or several columns of derivatives side by side.
///
/// Numbers of a merged limb differ from lane to lane; those of the bodies that carry limbs are the
/// same in all lanes. So a limb's forces are summed over the lanes where they reach their parent, and a
/// parent's motion is broadcast to them. Equations that do so are generic over [`BodyTree`]:
///
/// ```
/// use modyn_runtime::LaneScalar;
/// use modyn_runtime::equations::{Workspace, dynamics::gravity_torques};
/// use modyn_runtime::mechanism::MergedMechanism;
///
/// fn torques<S: LaneScalar>(robot: &MergedMechanism<S>, q: &[S], tau: &mut [S]) {
///     gravity_torques(robot, q, &mut Workspace::new(robot), tau);
/// }
/// ```
///
/// All other equations take a [`Mechanism`], and giving them this one does not compile:
///
/// ```compile_fail,E0308
/// use modyn_runtime::LaneScalar;
/// use modyn_runtime::equations::{Workspace, dynamics::potential_energy};
/// use modyn_runtime::mechanism::MergedMechanism;
///
/// fn energy<S: LaneScalar>(robot: &MergedMechanism<S>, q: &[S]) -> S {
///     potential_energy(robot, q, &mut Workspace::new(robot))
/// }
/// ```
///
/// nor does merging limbs on numbers that have no lanes:
///
/// ```compile_fail,E0277
/// use modyn_runtime::mechanism::{LimbRoot, Mechanism, MergedMechanism};
///
/// fn merged(robot: Mechanism<f64>, limbs: Vec<Option<LimbRoot>>) -> MergedMechanism<f64> {
///     MergedMechanism::new(robot, limbs)
/// }
/// ```
#[derive(Clone, Debug)]
pub struct MergedMechanism<S> {
    mechanism: Mechanism<S>,
    /// By body.
    roots: Vec<Option<LimbRoot>>,
    column_lanes: usize,
}

impl<S: LaneScalar> MergedMechanism<S> {
    /// `mechanism` with limbs merged: `roots` has, by body, the limbs that it is the first body of.
    ///
    /// Links, frames, coordinates and loops of the description have no meaning for merged limbs and
    /// are left out.
    #[must_use]
    pub fn new(mut mechanism: Mechanism<S>, roots: Vec<Option<LimbRoot>>) -> Self {
        mechanism.links.clear();
        mechanism.frames.clear();
        mechanism.coordinates.clear();
        mechanism.constraints.clear();
        Self { mechanism, roots, column_lanes: 1 }
    }

    /// `mechanism` with its limbs as they are, whose derivatives are computed `column_lanes` columns at a
    /// time, of joints that follow each other.
    #[must_use]
    pub fn with_column_lanes(mechanism: Mechanism<S>, column_lanes: usize) -> Self {
        Self { column_lanes, ..Self::new(mechanism, Vec::new()) }
    }

    /// The length of qd.
    #[must_use]
    pub fn nv(&self) -> usize {
        self.mechanism.nv
    }
}

impl<S: LaneScalar> BodyTree<S> for MergedMechanism<S> {}

impl<S: LaneScalar> TreeAccess<S> for MergedMechanism<S> {
    fn mechanism(&self) -> &Mechanism<S> {
        &self.mechanism
    }

    fn limb_root(&self, body: usize) -> Option<&LimbRoot> {
        self.roots.get(body)?.as_ref()
    }

    fn column_lanes(&self) -> usize {
        self.column_lanes
    }

    fn pack(&self, each: &[S]) -> S {
        S::pack(each)
    }

    fn extract_lane(&self, x: S, lane: usize) -> S {
        x.extract_lane(lane)
    }

    fn sum_lanes(&self, x: S, lanes: Range<usize>) -> S {
        x.sum_lanes(lanes)
    }
}
