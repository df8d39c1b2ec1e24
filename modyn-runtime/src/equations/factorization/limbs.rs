//! Equal limbs that are computed as one, in the GIM and its inverse.
//!
//! The compiler puts equal limbs side by side ([`Body::limbs`](crate::mechanism::Body::limbs)):
//! numbers of the one limb are then lanes, a limb each, and numbers of the trunk that carries them are the
//! same in all lanes. In a matrix an entry of a trunk's and a limb's degree of freedom, or of two of a limb,
//! is lanes. A limb's column stands for one of each limb, and its entries in rows of the trunk are lanes, too.
//!
//! The GIM has zeros between limbs; its inverse does not, since limbs move the trunk and the trunk moves
//! them. The forces on one limb let the trunk accelerate, and another one follows by -U^T of that, the
//! last step of (60): [`across`].

use alloc::{vec, vec::Vec};

use super::brge::Layout;
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::{Body, Prepared};

/// A limb that stands for equal ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::equations) struct Limb {
    /// Its first body.
    first: usize,
    /// For how many it stands.
    count: usize,
}

/// By degree of freedom: the limb that it belongs to, if that stands for several.
pub(in crate::equations) fn of_dofs<S>(model: &Prepared<S>) -> Vec<Option<Limb>> {
    let mut of_bodies: Vec<Option<Limb>> = Vec::with_capacity(model.bodies.len());
    for (first, body) in model.bodies.iter().enumerate() {
        of_bodies.push(match body.limbs {
            1 => body.parent.and_then(|parent| of_bodies[parent]),
            count => Some(Limb { first, count }),
        });
    }
    model.dofs.iter().map(|dof| of_bodies[dof.body]).collect()
}

/// Numbers on their way from a body to the root: where limbs hang on different bodies, each lane comes in
/// at its own.
pub(in crate::equations) struct Way<'a, S, const N: usize> {
    /// What such limbs have carried to what they hang on.
    limbs: Option<(&'a Body<S>, [S; N])>,
}

impl<'a, S: Scalar, const N: usize> Way<'a, S, N> {
    pub(in crate::equations) fn new() -> Self {
        Self { limbs: None }
    }

    /// What of numbers that are `carried` from `body` is on its parent, with those that come in there.
    pub(in crate::equations) fn onto(
        &mut self,
        body: &'a Body<S>,
        parent: usize,
        carried: [S; N],
    ) -> [S; N] {
        if !body.parents.is_empty() {
            self.limbs = Some((body, carried));
            return carried.map(|x| body.only_on(parent, x));
        }
        match &self.limbs {
            Some((limbs, left)) if limbs.parents.contains(&Some(parent)) => {
                core::array::from_fn(|k| carried[k] + limbs.only_on(parent, left[k]))
            }
            _ => carried,
        }
    }
}

/// Over how many limbs adds up what one of `limb` leaves on one of `other`.
pub(in crate::equations) fn over(limb: Option<Limb>, other: Option<Limb>) -> usize {
    limb.filter(|_| limb != other).map_or(1, |limb| limb.count)
}

/// The sum of the terms of a row, one a column: those of limbs' columns over the limbs, unless the row is
/// a limb's itself.
pub(in crate::equations) fn sum<S: Scalar>(
    layout: &Layout,
    row: usize,
    terms: impl Iterator<Item = S>,
) -> Option<S> {
    let row = layout.limbs()[row];
    let mut whole: Option<S> = None;
    // Of the limb that the columns are in, and over how many.
    let mut part: Option<(S, Option<Limb>)> = None;
    let add = |whole: Option<S>, (part, limb): (S, Option<Limb>)| {
        let part = part.over_limbs(0..over(limb, row));
        Some(whole.map_or(part, |whole| whole + part))
    };
    for (term, &limb) in terms.zip(layout.limbs()) {
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
pub fn across<S: Scalar>(
    model: &Prepared<S>,
    layout: &Layout,
    workspace: &Workspace<S>,
    columns: &[S],
) -> Vec<S> {
    let u = &workspace.factors[layout.u()];
    let limbs = layout.limbs();
    let counts: Vec<usize> = limbs.iter().map(|limb| limb.map_or(1, |limb| limb.count)).collect();
    let most = counts.iter().copied().max().unwrap_or(1);
    let mut across = Vec::new();
    for (column, own) in columns.chunks(limbs.len().max(1)).zip(limbs) {
        // By limb: the column with the rows of that one.
        let mut rows = vec![column.to_vec(); most];
        for (limb, x) in rows.iter_mut().enumerate().filter(|_| own.is_some()) {
            for (m, block) in layout.blocks().iter().enumerate() {
                if layout.limb(m).is_none_or(|it| limb >= it.count) {
                    continue;
                }
                x[block.dofs.clone()].fill(S::zero());
                for (dof, row) in layout.rows(m) {
                    if layout.limb(m).is_some_and(|it| !moves(model, dof, it, limb)) {
                        continue;
                    }
                    for (j, i) in block.dofs.clone().enumerate() {
                        x[i] = x[i] - u[row + j].of_limb(limb) * x[dof];
                    }
                }
            }
        }
        for (row, &count) in counts.iter().enumerate() {
            across.extend(rows[..count].iter().map(|x| x[row]));
        }
    }
    across
}

/// Whether a degree of freedom moves the one of these limbs: not if the limb hangs on a body in front of it, or
/// on another tree.
fn moves<S>(model: &Prepared<S>, dof: usize, of: Limb, limb: usize) -> bool {
    let first = &model.bodies[of.first];
    let mut on = first.parents.get(limb).copied().unwrap_or(first.parent);
    while let Some(body) = on.filter(|&body| body != model.dofs[dof].body) {
        on = model.bodies[body].parent;
    }
    on.is_some() || model.dofs[dof].body >= of.first
}
