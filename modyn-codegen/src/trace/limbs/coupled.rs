//! Matrices that couple equal limbs through their trunk, unpacked from lanes.

use super::{LimbPacking, constant};
use crate::graph::Expr;

/// An entry of the robot's joint vectors: a degree of freedom of the merged robot, and the limb.
type Entry = (usize, usize);

impl LimbPacking {
    /// Returns the robot's matrix by columns, from a matrix of the merged robot and the entries `cross_limb` between limbs.
    pub(in crate::trace) fn unpack_coupled(
        &self,
        columns: &[Expr],
        cross_limb: &[Expr],
    ) -> Vec<Expr> {
        self.unpack_entries(|row, column| self.entry(columns, cross_limb, row, column))
    }

    /// Returns the robot's symmetric matrix: an entry and its mirror image are the same expression.
    pub(in crate::trace) fn unpack_symmetric(
        &self,
        columns: &[Expr],
        cross_limb: &[Expr],
    ) -> Vec<Expr> {
        self.unpack_entries(|row, column| {
            self.entry(columns, cross_limb, row.min(column), row.max(column))
        })
    }

    fn unpack_entries(&self, entry: impl Fn(Entry, Entry) -> Expr) -> Vec<Expr> {
        let all = || {
            let each = self.velocities.iter().enumerate();
            each.flat_map(|(d, (of, _))| {
                of.iter().enumerate().filter_map(move |(k, v)| Some(((*v)?, (d, k))))
            })
        };
        let nv = all().count();
        let mut unpacked = vec![constant(0.0); nv * nv];
        for (v, column) in all() {
            for (w, row) in all() {
                unpacked[v * nv + w] = entry(row, column);
            }
        }
        unpacked
    }

    fn entry(&self, columns: &[Expr], cross_limb: &[Expr], row: Entry, column: Entry) -> Expr {
        let root = |(d, k): Entry| self.roots[d][k];
        if root(row) != root(column) {
            return constant(0.0);
        }
        let group = |(d, _): Entry| self.velocities[d].1;
        let of_two = group(row).is_some() && group(column).is_some();
        if of_two && (group(row), row.1) != (group(column), column.1) {
            let before: usize = self.velocities[..row.0].iter().map(|(of, _)| of.len()).sum();
            let rows = cross_limb.len() / self.velocities.len();
            return cross_limb[column.0 * rows + before + row.1].extract_lane(column.1);
        }
        // An entry of the trunk is the same in all lanes.
        let limb = if group(column).is_some() { column.1 } else { row.1 };
        columns[column.0 * self.velocities.len() + row.0].extract_lane(limb)
    }
}
