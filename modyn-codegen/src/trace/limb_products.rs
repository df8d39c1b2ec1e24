//! Products of matrices of a robot with equal limbs, whose lanes are the limbs.
//!
//! An entry belongs to two degrees of freedom of the robot with merged limbs. All entries of the
//! same two, in the same relation of their limbs (the same limb, the next one, ...), are computed
//! in the lanes of one pack. Products of zeros are left out, so the zeros between limbs cost
//! nothing.

use std::collections::BTreeMap;

use super::composition::Composition;
use super::limbs::LimbPacking;
use crate::graph::Id;

/// The factors of the terms of a sum of products.
type Factors = Vec<(Id, Id)>;

/// A degree of freedom of the robot: the degree of freedom of the merged robot, the group of limbs,
/// and the limb.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Place {
    merged: usize,
    group: Option<usize>,
    limb: usize,
}

/// The places of a robot's square matrices.
pub(super) struct LimbMatrices {
    places: Vec<Place>,
    /// For each group, the number of its limbs.
    limbs: BTreeMap<usize, usize>,
    /// The entries (row, column) that share the lanes of a pack.
    packs: Vec<Vec<(usize, usize)>>,
}

impl LimbMatrices {
    /// Returns the places of matrices of `nv` columns.
    pub fn new(limbs: &LimbPacking, nv: usize) -> Self {
        let mut places = vec![Place { merged: 0, group: None, limb: 0 }; nv];
        let mut counts = BTreeMap::new();
        for (merged, (lanes, group)) in limbs.velocities().enumerate() {
            for (limb, v) in lanes.iter().enumerate().filter_map(|(limb, v)| Some((limb, (*v)?))) {
                places[v] = Place { merged, group, limb };
            }
            if let Some(group) = group {
                counts.insert(group, lanes.len());
            }
        }
        let mut all = Self { places, limbs: counts, packs: Vec::new() };
        let mut packs: BTreeMap<_, Vec<(usize, usize)>> = BTreeMap::new();
        for column in 0..nv {
            for row in 0..nv {
                let r = all.places[row];
                let c = all.places[column];
                let relation = match (r.group, c.group) {
                    (Some(one), Some(other)) if one == other => all.distance(one, r, c),
                    // Of limbs of two groups: the lanes of the row.
                    (Some(_), Some(_)) => c.limb,
                    _ => 0,
                };
                packs.entry((c.merged, r.merged, relation)).or_default().push((row, column));
            }
        }
        all.packs = packs.into_values().collect();
        for pack in &mut all.packs {
            // In the order of the limbs.
            pack.sort_by_key(|&(row, column)| {
                let r = all.places[row];
                let c = all.places[column];
                if r.group.is_some() { r.limb } else { c.limb }
            });
        }
        all
    }

    /// Returns the number of limbs from one place to another of the same group, in a circle.
    fn distance(&self, group: usize, from: Place, to: Place) -> usize {
        let count = self.limbs[&group];
        (to.limb + count - from.limb) % count
    }

    /// Returns the place of `k` relative to the limb of an entry, the same for all lanes of a pack.
    fn relative(&self, row: usize, column: usize, k: usize) -> (usize, usize) {
        let own_place = self.places[k];
        let Some(group) = own_place.group else { return (own_place.merged, 0) };
        let entry = [row, column].map(|entry| self.places[entry]);
        let same = entry.iter().find(|place| place.group == Some(group));
        (
            own_place.merged,
            same.map_or(own_place.limb, |place| self.distance(group, *place, own_place)),
        )
    }

    /// Returns the product of two matrices, by columns.
    pub fn multiply(&self, all: &mut Composition, a: &[Id], b: &[Id]) -> Vec<Id> {
        let n = self.places.len();
        let zero = all.constant(0.0);
        let mut product = vec![zero; n * n];
        for pack in &self.packs {
            // The factors of each lane, by their relative place.
            let mut terms: BTreeMap<(usize, usize), Factors> = BTreeMap::new();
            for (lane, &(row, column)) in pack.iter().enumerate() {
                for k in 0..n {
                    let factors = (a[k * n + row], b[column * n + k]);
                    if factors.0 != zero && factors.1 != zero {
                        let lanes = terms.entry(self.relative(row, column, k)).or_default();
                        lanes.resize(lanes.len().max(lane + 1), (zero, zero));
                        lanes[lane] = factors;
                    }
                }
            }
            for factors in terms.values_mut() {
                factors.resize(pack.len(), (zero, zero));
            }
            if let &[(row, column)] = &**pack {
                product[column * n + row] = self.sum_over_limbs(all, &terms);
                continue;
            }
            let packed = terms.values().map(|factors| {
                let (a, b): (Vec<Id>, Vec<Id>) = factors.iter().copied().unzip();
                (all.pack(&a), all.pack(&b))
            });
            let factors: Vec<(Id, Id)> = packed.collect();
            let sum = all.graph.sum_of_products(factors);
            for (lane, &(row, column)) in pack.iter().enumerate() {
                product[column * n + row] = all.lane(sum, lane);
            }
        }
        product
    }

    /// Returns the sum of products of an entry of the trunk: the products of a group of limbs are
    /// computed in lanes, then added.
    fn sum_over_limbs(
        &self,
        all: &mut Composition,
        terms: &BTreeMap<(usize, usize), Factors>,
    ) -> Id {
        let mut by_group: BTreeMap<Option<usize>, BTreeMap<usize, Factors>> = BTreeMap::new();
        for (&(merged, _), factors) in terms {
            let place = self.places.iter().find(|place| place.merged == merged);
            let group = place.and_then(|place| place.group);
            by_group.entry(group).or_default().entry(merged).or_default().extend(factors);
        }
        let mut sum = all.constant(0.0);
        for (group, of_joints) in by_group {
            let lanes = group.map_or(1, |group| self.limbs[&group]);
            let complete = of_joints.values().all(|factors| factors.len() == lanes);
            if lanes == 1 || !complete {
                let products = all.graph.sum_of_products(of_joints.into_values().flatten());
                sum = all.sum(sum, products);
                continue;
            }
            let packed_factors = of_joints.values().map(|factors| {
                let (a, b): (Vec<Id>, Vec<Id>) = factors.iter().copied().unzip();
                (all.pack(&a), all.pack(&b))
            });
            let factors: Vec<(Id, Id)> = packed_factors.collect();
            let packed = all.graph.sum_of_products(factors);
            let each: Vec<Id> = (0..lanes).map(|lane| all.lane(packed, lane)).collect();
            let products = all.graph.pairwise_sum(&each);
            sum = all.sum(sum, products);
        }
        sum
    }
}
