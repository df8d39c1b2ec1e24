//! Equal limbs that are computed as one, in the mass matrix and its inverse.
//!
//! The compiler puts equal limbs side by side ([`MergedMechanism`]):
//! numbers of the one limb are then lanes, a limb each, and numbers of the trunk that carries them are the
//! same in all lanes. In a matrix an entry of a trunk's and a limb's degree of freedom, or of two of a limb,
//! is lanes. A limb's column stands for one of each limb, and its entries in rows of the trunk are lanes, too.
//!
//! The mass matrix has zeros between limbs; its inverse does not, since limbs move the trunk and the trunk moves
//! them. The forces on one limb let the trunk accelerate, and another one follows by -U^T of that, the
//! last step of (60): [`cross_limb`].

use alloc::{vec, vec::Vec};

use super::layout::UduLayout;
use super::partition::ModulePartition;
use crate::equations::Workspace;
use crate::mechanism::{BodyTree, Mechanism, MergedMechanism, TreeAccess};
use crate::{LaneScalar, Scalar};

/// A limb that stands for equal ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limb {
    /// Its first body.
    first: usize,
    /// For how many it stands.
    count: usize,
}

/// By degree of freedom: the limb that it belongs to, if that stands for several.
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

/// A layout of factors that solving can run on: a [`UduLayout`], or a [`MergedUduLayout`] for a mechanism
/// whose limbs are merged. No other type can be one.
pub trait FactorLayout<S: Scalar>: LimbAccess<S> {}

/// The limbs of a [`FactorLayout`], and the sums over them.
pub trait LimbAccess<S: Scalar> {
    /// Where the numbers lie.
    fn layout(&self) -> &UduLayout;

    /// The limb that a degree of freedom belongs to, where it stands for several.
    fn limb_of_dof(&self, _dof: usize) -> Option<Limb> {
        None
    }

    /// The sum of the numbers of that many limbs; the number itself where that is one.
    fn sum_limbs(&self, x: S, _count: usize) -> S {
        x
    }

    /// The limb that module `m` is in.
    fn limb_of_module(&self, m: usize) -> Option<Limb> {
        self.layout().blocks()[m].dofs.clone().next().and_then(|dof| self.limb_of_dof(dof))
    }

    /// The number of limbs that are summed where module `m` acts on degree of freedom `dof` in
    /// front of it.
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

/// A layout for a mechanism whose limbs are merged.
#[derive(Clone, Debug)]
pub struct MergedUduLayout {
    layout: UduLayout,
    /// By degree of freedom: the limb that it belongs to, if that stands for several.
    limbs: Vec<Option<Limb>>,
}

impl MergedUduLayout {
    /// `layout`, which is one of `tree`'s modules.
    #[must_use]
    pub fn new<S: LaneScalar>(tree: &MergedMechanism<S>, layout: UduLayout) -> Self {
        Self { layout, limbs: of_dofs(tree) }
    }

    /// The layout for modules of `tree`.
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

/// A tree of bodies with the layout that its factors have.
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

/// Over how many limbs adds up what one of `limb` leaves on one of `other`.
fn summed_limb_count(limb: Option<Limb>, other: Option<Limb>) -> usize {
    limb.filter(|_| limb != other).map_or(1, |limb| limb.count)
}

/// The sum of the terms of a row, one a column: those of limbs' columns over the limbs, unless the row is
/// a limb's itself.
pub(in crate::equations) fn sum_row<S: Scalar, L: FactorLayout<S>>(
    layout: &L,
    row: usize,
    terms: impl Iterator<Item = S>,
) -> Option<S> {
    let row = layout.limb_of_dof(row);
    let mut whole: Option<S> = None;
    // Of the limb that the columns are in, and over how many.
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

/// What solved columns have in the rows of other limbs than the column's own: for each column, by degree
/// of freedom and limb, lanes as in the column. Without meaning for the trunk, and where column and row are
/// of one limb.
///
/// Expects the factors as [`forward_dynamics_derivatives`](crate::equations::derivatives::forward_dynamics_derivatives)
/// leaves them.
#[must_use]
pub fn cross_limb<S: LaneScalar>(
    tree: &MergedMechanism<S>,
    merged: &MergedUduLayout,
    workspace: &Workspace<S>,
    columns: &[S],
) -> Vec<S> {
    let (layout, limbs) = (&merged.layout, &merged.limbs);
    let u = &workspace.factors[layout.u()];
    let counts: Vec<usize> = limbs.iter().map(|limb| limb.map_or(1, |limb| limb.count)).collect();
    let most = counts.iter().copied().max().unwrap_or(1);
    let mut rows_of_limbs = Vec::new();
    for (column, own) in columns.chunks(limbs.len().max(1)).zip(limbs) {
        // By limb: the column with the rows of that one.
        let mut rows = vec![column.to_vec(); most];
        for (limb, x) in rows.iter_mut().enumerate().filter(|_| own.is_some()) {
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

/// Whether a degree of freedom moves the one of these limbs: not if the limb hangs on a body in front of it, or
/// on another tree.
fn moves_limb<S: LaneScalar>(tree: &MergedMechanism<S>, dof: usize, of: Limb, limb: usize) -> bool {
    let model = tree.mechanism();
    let parents = tree.parents(of.first).unwrap_or_default();
    let mut on = parents.get(limb).copied().unwrap_or(model.bodies[of.first].parent);
    while let Some(body) = on.filter(|&body| body != model.dofs[dof].body) {
        on = model.bodies[body].parent;
    }
    on.is_some() || model.dofs[dof].body >= of.first
}
