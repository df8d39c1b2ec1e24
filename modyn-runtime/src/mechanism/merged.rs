//! A mechanism whose equal limbs are merged into one limb of lanes.

use alloc::vec::Vec;
use core::ops::Range;

use super::tree::{BodyTree, LimbRoot, TreeAccess};
use super::{ConstrainedFrames, Mechanism};
use crate::LaneScalar;

/// A mechanism whose numbers may be packs of lanes. Equal limbs (legs, arms, fingers) are merged
/// into one limb with a lane for each, or several columns of derivatives are computed at a time.
///
/// Values of a merged limb differ from lane to lane. Values of the bodies that carry limbs are the
/// same in all lanes. Limbs' forces are therefore summed over the lanes where they reach the
/// parent, and the parent's motion is broadcast to the limbs. Equations that do so are generic over
/// [`BodyTree`]:
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
/// All other equations take a [`Mechanism`]. Calling them with a merged mechanism is a compile
/// error:
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
/// Merging limbs on scalars without lanes is a compile error, too:
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
    /// For each body, the limbs whose representative it is the first body of.
    roots: Vec<Option<LimbRoot>>,
    column_lanes: usize,
    /// For each contact of the robot, its index among the merged contacts, and its lane.
    contact_lanes: Vec<(usize, usize)>,
}

impl<S: LaneScalar> MergedMechanism<S> {
    /// Returns `mechanism` with limbs merged. For each body, `roots` has the limbs whose
    /// representative it is the first body of.
    ///
    /// Links, frames, coordinates and constraints of the description have no meaning for merged
    /// limbs and are left empty.
    #[must_use]
    pub fn new(mut mechanism: Mechanism<S>, roots: Vec<Option<LimbRoot>>) -> Self {
        mechanism.links.clear();
        mechanism.frames.clear();
        mechanism.coordinates.clear();
        mechanism.constraints.clear();
        Self { mechanism, roots, column_lanes: 1, contact_lanes: Vec::new() }
    }

    /// Returns `mechanism` with its limbs unmerged. Derivatives are computed `column_lanes` columns
    /// at a time; these columns belong to consecutive joints.
    #[must_use]
    pub fn with_column_lanes(mut mechanism: Mechanism<S>, column_lanes: usize) -> Self {
        let constraints = core::mem::take(&mut mechanism.constraints);
        let lanes = (0..constraints.len()).map(|constraint| (constraint, 0)).collect();
        let coordinates = core::mem::take(&mut mechanism.coordinates);
        let mut merged = Self::new(mechanism, Vec::new()).with_contacts(constraints, lanes);
        merged.mechanism.coordinates = coordinates;
        Self { column_lanes, ..merged }
    }

    /// Returns the mechanism with contacts. Contacts on the bodies of a merged limb are merged as
    /// the bodies are. For each contact of the robot, `lanes` has its index in `contacts` and its
    /// lane.
    ///
    /// The limbs that carry contacts must have one parent: a contact's kinematic path is the
    /// representative's path.
    #[must_use]
    pub fn with_contacts(
        mut self,
        contacts: Vec<ConstrainedFrames<S>>,
        lanes: Vec<(usize, usize)>,
    ) -> Self {
        (self.mechanism.constraints, self.contact_lanes) = (contacts, lanes);
        self
    }

    /// Returns the length of qd.
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

    fn constraint_lanes(&self) -> Vec<(usize, usize)> {
        self.contact_lanes.clone()
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
