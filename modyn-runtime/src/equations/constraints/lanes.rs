//! The rows of the robot's constraints among the rows of merged contacts.
//!
//! Where equal limbs are merged into one limb of lanes, so are their contacts: a row of a merged
//! contact has a lane for each limb. The factorization couples all contacts. Its rows are the rows
//! of the robot, in the robot's order. Without merged limbs both are the same rows.

use alloc::{vec, vec::Vec};
use core::ops::Range;

use crate::Scalar;
use crate::mechanism::BodyTree;

/// The places of the robot's constrained rows.
#[derive(Clone, Debug)]
pub(super) struct RowLanes {
    /// For each row of the robot, the row of the mechanism and the lane.
    rows: Vec<(usize, usize)>,
    /// For each row of the mechanism, the robot's row in each lane; `None` for a limb without this
    /// contact.
    lanes: Vec<Vec<Option<usize>>>,
    /// For each constraint of the robot, the constraint of the mechanism and the lane.
    constraints: Vec<(usize, usize)>,
}

impl RowLanes {
    /// Returns the places of the rows of `tree`. For each constraint of the mechanism, `limbs` has
    /// the number of merged limbs that carry it; 1 on the trunk.
    pub(super) fn new<S: Scalar, T: BodyTree<S>>(
        tree: &T,
        limbs: impl Iterator<Item = usize>,
    ) -> Self {
        let constraints = tree.constraint_lanes();
        let mut starts = Vec::new();
        let mut lanes = Vec::new();
        for (constraint, limbs) in tree.mechanism().constraints.iter().zip(limbs) {
            starts.push(lanes.len());
            lanes.extend(constraint.rows.iter().map(|_| vec![None; limbs]));
        }
        let mut rows = Vec::new();
        for &(constraint, lane) in &constraints {
            let count = tree.mechanism().constraints[constraint].rows.len();
            let start = starts[constraint];
            for (k, lanes) in lanes[start..start + count].iter_mut().enumerate() {
                lanes[lane] = Some(rows.len());
                rows.push((start + k, lane));
            }
        }
        Self { rows, lanes, constraints }
    }

    /// Returns the number of the robot's rows.
    pub(super) fn count(&self) -> usize {
        self.rows.len()
    }

    /// Returns the row of the mechanism and the lane of a row of the robot.
    pub(super) fn place(&self, row: usize) -> (usize, usize) {
        self.rows[row]
    }

    /// Returns for each constraint of the robot the constraint of the mechanism and the lane.
    pub(super) fn constraints(&self) -> &[(usize, usize)] {
        &self.constraints
    }

    /// Sets the numbers of the robot's rows from the numbers of the mechanism's rows.
    pub(super) fn unpack<S: Scalar, T: BodyTree<S>>(&self, tree: &T, packs: &[S], rows: &mut [S]) {
        for (number, &(row, lane)) in rows.iter_mut().zip(&self.rows) {
            *number = tree.extract_lane(packs[row], lane);
        }
    }

    /// Sets the numbers of the mechanism's rows from the numbers of the robot's rows; zero for a
    /// limb without the contact.
    pub(super) fn pack<S: Scalar, T: BodyTree<S>>(&self, tree: &T, rows: &[S], packs: &mut [S]) {
        let number = |row: &Option<usize>| row.map_or(S::zero(), |row| rows[row]);
        for (pack, lanes) in packs.iter_mut().zip(&self.lanes) {
            *pack = packed(tree, 0..lanes.len(), |lane| number(&lanes[lane]));
        }
    }
}

/// Returns the pack of a number for each of these indices; the number itself, without memory, for
/// one index.
pub(in crate::equations) fn packed<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    indices: Range<usize>,
    number: impl Fn(usize) -> S,
) -> S {
    if indices.len() == 1 {
        return number(indices.start);
    }
    tree.pack(&indices.map(number).collect::<Vec<_>>())
}
