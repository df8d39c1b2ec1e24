//! The mass matrix and its inverse where equal limbs are merged into one limb of lanes.
//!
//! The compiler packs equal limbs into the lanes of one limb ([`MergedMechanism`]). A value of the
//! merged limb has a lane for each limb. A value of the trunk, which carries the limbs, is the same
//! in all lanes. A matrix entry has lanes if its row or its column belongs to a limb. A limb's
//! column stands for one column of each limb; its entries in rows of the trunk have lanes, too.
//!
//! The mass matrix has zeros between limbs. Its inverse does not, since a limb moves the trunk and
//! the trunk moves the other limbs: the forces on one limb accelerate the trunk, and -U^T times
//! that acceleration is the acceleration of another limb, the last step of (60): [`cross_limb`].

use alloc::{vec, vec::Vec};

use super::layout::UduLayout;
use super::partition::ModulePartition;
use crate::equations::Workspace;
use crate::mechanism::{BodyTree, Mechanism, MergedMechanism, TreeAccess};
use crate::{LaneScalar, Scalar};

/// A merged limb: the representative of several equal limbs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limb {
    /// The limb's first body.
    first: usize,
    /// The number of limbs that are merged.
    count: usize,
}

impl Limb {
    /// Returns the number of limbs that are merged.
    pub(in crate::equations) fn count(self) -> usize {
        self.count
    }
}

/// Returns the merged limb of each degree of freedom; `None` on the trunk.
fn of_dofs<S: LaneScalar>(tree: &MergedMechanism<S>) -> Vec<Option<Limb>> {
    let model = tree.mechanism();
    let mut of_bodies: Vec<Option<Limb>> = Vec::with_capacity(model.bodies.len());
    for (first, body) in model.bodies.iter().enumerate() {
        of_bodies.push(match tree.limb_root(first) {
            None => body.parent.and_then(|parent| of_bodies[parent]),
            Some(root) => Some(Limb { first, count: root.limbs }),
        });
    }
    model.dofs.iter().map(|dof| of_bodies[dof.body]).collect()
}

/// A layout of factors that `solve` accepts: a [`UduLayout`], or a [`MergedUduLayout`] for a
/// mechanism whose limbs are merged. The trait cannot be implemented for other types.
pub trait FactorLayout<S: Scalar>: LimbAccess<S> {}

/// The merged limbs of a [`FactorLayout`], and sums over limbs.
pub trait LimbAccess<S: Scalar> {
    /// Returns the storage layout.
    fn layout(&self) -> &UduLayout;

    /// Returns the merged limb of a degree of freedom; `None` on the trunk.
    fn limb_of_dof(&self, _dof: usize) -> Option<Limb> {
        None
    }

    /// Returns the sum of the first `count` lanes of `x`; `x` itself if `count` is 1.
    fn sum_limbs(&self, x: S, _count: usize) -> S {
        x
    }

    /// Returns the merged limb of module `m`; `None` on the trunk.
    fn limb_of_module(&self, m: usize) -> Option<Limb> {
        self.layout().blocks()[m].dofs.clone().next().and_then(|dof| self.limb_of_dof(dof))
    }

    /// Returns the number of limbs that are summed where module `m` acts on the preceding degree of
    /// freedom `dof`.
    fn summed_limbs(&self, m: usize, dof: usize) -> usize {
        summed_limb_count(self.limb_of_module(m), self.limb_of_dof(dof))
    }
}

impl<S: Scalar> FactorLayout<S> for UduLayout {}

impl<S: Scalar> LimbAccess<S> for UduLayout {
    fn layout(&self) -> &UduLayout {
        self
    }
}

/// The layout for a mechanism whose limbs are merged.
#[derive(Clone, Debug)]
pub struct MergedUduLayout {
    layout: UduLayout,
    /// The merged limb of each degree of freedom; `None` on the trunk.
    limbs: Vec<Option<Limb>>,
}

impl MergedUduLayout {
    /// Returns `layout`, which belongs to modules of `tree`, with the limbs of `tree`.
    #[must_use]
    pub fn new<S: LaneScalar>(tree: &MergedMechanism<S>, layout: UduLayout) -> Self {
        Self { layout, limbs: of_dofs(tree) }
    }

    /// Returns the layout for a partition of `tree`.
    #[must_use]
    pub fn by_modules<S: LaneScalar>(
        tree: &MergedMechanism<S>,
        partition: ModulePartition,
    ) -> Self {
        Self::new(tree, UduLayout::of(tree.mechanism(), partition))
    }

    fn module_limb(&self, m: usize) -> Option<Limb> {
        let mut dofs = self.layout.blocks()[m].dofs.clone();
        dofs.next().and_then(|dof| self.limbs[dof])
    }
}

impl<S: LaneScalar> FactorLayout<S> for MergedUduLayout {}

impl<S: LaneScalar> LimbAccess<S> for MergedUduLayout {
    fn layout(&self) -> &UduLayout {
        &self.layout
    }

    fn limb_of_dof(&self, dof: usize) -> Option<Limb> {
        self.limbs[dof]
    }

    fn sum_limbs(&self, x: S, count: usize) -> S {
        if count == 1 { x } else { x.sum_lanes(0..count) }
    }
}

/// A tree of bodies, and the type of the layout for its factors.
pub trait Factorizable<S: Scalar>: BodyTree<S> {
    /// The layout.
    type Layout: FactorLayout<S>;
}

impl<S: Scalar> Factorizable<S> for Mechanism<S> {
    type Layout = UduLayout;
}

impl<S: LaneScalar> Factorizable<S> for MergedMechanism<S> {
    type Layout = MergedUduLayout;
}

/// Returns the number of limbs to sum over for the effect of a degree of freedom in `limb` on one
/// in `other`.
fn summed_limb_count(limb: Option<Limb>, other: Option<Limb>) -> usize {
    limb.filter(|_| limb != other).map_or(1, |limb| limb.count)
}

/// Returns the sum of the terms of a row, one term for each column. Terms in columns of a limb are
/// summed over its limbs, unless the row belongs to the same limb.
pub(in crate::equations) fn sum_row<S: Scalar, L: FactorLayout<S>>(
    layout: &L,
    row: usize,
    terms: impl Iterator<Item = S>,
) -> Option<S> {
    let row = layout.limb_of_dof(row);
    let mut whole: Option<S> = None;
    // The running sum of one limb's columns, and that limb.
    let mut part: Option<(S, Option<Limb>)> = None;
    let add = |whole: Option<S>, (part, limb): (S, Option<Limb>)| {
        let part = layout.sum_limbs(part, summed_limb_count(limb, row));
        Some(whole.map_or(part, |whole| whole + part))
    };
    for (dof, term) in terms.enumerate() {
        let limb = layout.limb_of_dof(dof);
        part = match part {
            Some((sum, same)) if same == limb => Some((sum + term, limb)),
            Some(done) => {
                whole = add(whole, done);
                Some((term, limb))
            }
            None => Some((term, limb)),
        };
    }
    part.map_or(whole, |part| add(whole, part))
}

/// Returns the entries of solved columns in the rows of other limbs than the column's own limb: for
/// each column, an entry for each degree of freedom and limb, with lanes as in the column. Entries
/// are meaningless for rows of the trunk, and where column and row belong to the same limb.
///
/// Expects the factors that
/// [`forward_dynamics_derivatives`](crate::equations::derivatives::forward_dynamics_derivatives)
/// computes.
#[must_use]
pub fn cross_limb<S: LaneScalar>(
    tree: &MergedMechanism<S>,
    merged: &MergedUduLayout,
    workspace: &Workspace<S>,
    columns: &[S],
) -> Vec<S> {
    let layout = &merged.layout;
    let limbs = &merged.limbs;
    let u = &workspace.factors[layout.u()];
    let counts: Vec<usize> = limbs.iter().map(|limb| limb.map_or(1, |limb| limb.count)).collect();
    let most = counts.iter().copied().max().unwrap_or(1);
    let mut rows_of_limbs = Vec::new();
    for (column, limb_of_column) in columns.chunks(limbs.len().max(1)).zip(limbs) {
        // For each limb, the column with the rows of that limb.
        let mut rows = vec![column.to_vec(); most];
        for (limb, x) in rows.iter_mut().enumerate().filter(|_| limb_of_column.is_some()) {
            for (m, block) in layout.blocks().iter().enumerate() {
                if merged.module_limb(m).is_none_or(|it| limb >= it.count) {
                    continue;
                }
                x[block.dofs.clone()].fill(S::zero());
                for (dof, row) in layout.rows(m) {
                    if merged.module_limb(m).is_some_and(|it| !moves_limb(tree, dof, it, limb)) {
                        continue;
                    }
                    for (j, i) in block.dofs.clone().enumerate() {
                        x[i] = x[i] - u[row + j].extract_lane(limb) * x[dof];
                    }
                }
            }
        }
        for (row, &count) in counts.iter().enumerate() {
            rows_of_limbs.extend(rows[..count].iter().map(|x| x[row]));
        }
    }
    rows_of_limbs
}

/// Returns whether a degree of freedom moves limb `limb` of the merged limb `of`. It does not if
/// the limb is attached to an ancestor of the degree of freedom's body, or to another tree.
fn moves_limb<S: LaneScalar>(
    tree: &MergedMechanism<S>,
    dof: usize,
    carrier: Limb,
    limb: usize,
) -> bool {
    let model = tree.mechanism();
    let parents = tree.parents(carrier.first).unwrap_or_default();
    let mut on = parents.get(limb).copied().unwrap_or(model.bodies[carrier.first].parent);
    while let Some(body) = on.filter(|&body| body != model.dofs[dof].body) {
        on = model.bodies[body].parent;
    }
    on.is_some() || model.dofs[dof].body >= carrier.first
}
