//! Vectors and matrices of the robot in lanes, and out of the lanes of the robot with merged limbs.

use super::{Lanes, LimbPacking, constant, pack};
use crate::graph::Expr;

/// An entry of the robot's joint vectors: a degree of freedom of the merged robot, and the limb.
type Entry = (usize, usize);

impl LimbPacking {
    /// Returns the coordinates of the merged robot.
    pub(in crate::trace) fn coordinates(&self, q: &[Expr]) -> Vec<Expr> {
        self.coordinates.iter().map(|lanes| lanes_of(lanes, q)).collect()
    }

    /// Returns a joint vector of the merged robot.
    pub(in crate::trace) fn vector(&self, x: &[Expr]) -> Vec<Expr> {
        self.velocities.iter().map(|(lanes, _)| lanes_of(lanes, x)).collect()
    }

    /// Returns the robot's joint vector, from a joint vector of the merged robot.
    pub(in crate::trace) fn unpack_vector(&self, x: &[Expr], nv: usize) -> Vec<Expr> {
        let mut unpacked = vec![constant(0.0); nv];
        for (&x, (lanes, _)) in x.iter().zip(&self.velocities) {
            for (lane, i) in lanes.iter().enumerate() {
                if let Some(i) = *i {
                    unpacked[i] = x.extract_lane(lane);
                }
            }
        }
        unpacked
    }

    /// Returns the robot's matrix by columns, from a matrix of the merged robot. Entries between
    /// different limbs are zero.
    pub(in crate::trace) fn unpack_matrix(&self, columns: &[Expr], nv: usize) -> Vec<Expr> {
        let n = self.velocities.len();
        let mut unpacked = vec![constant(0.0); nv * nv];
        for (c, (column, of_column)) in self.velocities.iter().enumerate() {
            for (r, (row, other)) in self.velocities.iter().enumerate() {
                if of_column.is_some() && other.is_some() && of_column != other {
                    continue;
                }
                for lane in 0..column.len().max(row.len()) {
                    let at = |lanes: &Lanes| lanes[lane.min(lanes.len() - 1)];
                    // Trees with different root bodies do not couple.
                    if at(&self.roots[c]) != at(&self.roots[r]) {
                        continue;
                    }
                    if let (Some(column), Some(row)) = (at(column), at(row)) {
                        unpacked[column * nv + row] = columns[c * n + r].extract_lane(lane);
                    }
                }
            }
        }
        unpacked
    }

    /// Returns the robot's matrix by columns, from a matrix of the merged robot and the entries
    /// `cross_limb` between limbs.
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
            each.flat_map(|(d, (lanes, _))| {
                lanes.iter().enumerate().filter_map(move |(k, v)| Some(((*v)?, (d, k))))
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
            let before: usize = self.velocities[..row.0].iter().map(|(lanes, _)| lanes.len()).sum();
            let rows = cross_limb.len() / self.velocities.len();
            return cross_limb[column.0 * rows + before + row.1].extract_lane(column.1);
        }
        // An entry of the trunk is the same in all lanes.
        let limb = if group(column).is_some() { column.1 } else { row.1 };
        columns[column.0 * self.velocities.len() + row.0].extract_lane(limb)
    }
}

/// Returns the pack of the entries of `x` that belong to these lanes.
fn lanes_of(lanes: &Lanes, x: &[Expr]) -> Expr {
    pack(lanes.iter().map(|i| i.map_or(constant(0.0), |i| x[i])))
}
