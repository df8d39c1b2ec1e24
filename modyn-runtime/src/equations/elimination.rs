//! A module's part in the block reverse Gaussian elimination, (35)-(49).
//!
//! Inside a module inertia travels as a rigid composite (10 numbers), in the last link together
//! with what eliminated child modules left there (21 numbers from there on). The module's pivot
//! is the block I_hat = N^T Psi, (46), with Psi = M_hat N, (47); it is split as V Delta V^T by
//! reverse Gaussian elimination, and the module's parent then sees Phi M_hat, (48)-(49):
//! M_hat - Psi I_hat^-1 Psi^T.

use super::Workspace;
use super::partition::Block;
use crate::Scalar;
use crate::model::prepare::Prepared;
use crate::spatial::ArticulatedInertia;

/// Sets each link's inertia to its own.
pub(super) fn start<S: Scalar>(model: &Prepared<S>, workspace: &mut Workspace<S>) {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.minimal;
    }
    workspace.articulated.fill(None);
}

/// Forms the module's pivot block and its columns Psi at the module's first link, and gathers the
/// inertia of the links behind there.
pub(super) fn pivot<S: Scalar>(model: &Prepared<S>, block: &Block, workspace: &mut Workspace<S>) {
    let (first, size) = (block.links.start, block.links.len());
    for j in (0..size).rev() {
        let i = first + j;
        let motion = workspace.motions[i];
        let (composite, articulated) = (workspace.composite[i], workspace.articulated[i]);
        let whole = articulated.map(|a| a + composite.articulated());
        let mut wrench = match &whole {
            Some(whole) => whole.column(motion.component()),
            None => motion.unit_wrench(&composite),
        };
        workspace.pivots[block.pivot + j * size + j] = motion.project(&wrench);
        for row in (0..j).rev() {
            let behind = first + row + 1;
            let carried = model.bodies[behind].wrench_to_parent(&workspace.motions[behind], wrench);
            wrench = carried;
            let felt = workspace.motions[first + row].project(&wrench);
            workspace.pivots[block.pivot + row * size + j] = felt;
            workspace.pivots[block.pivot + j * size + row] = felt;
        }
        for (column, component) in workspace.columns.iter_mut().zip(wrench.components()) {
            column[i] = component;
        }
        if j == 0 {
            continue;
        }
        if let Some(whole) = whole {
            leave(model, workspace, i, &whole);
        } else {
            let carried = model.bodies[i].rigid_to_parent(&motion, &composite);
            workspace.composite[i - 1] = workspace.composite[i - 1] + carried;
        }
    }
}

/// Splits the pivot block as V Delta V^T in place: V above the diagonal, Delta's reciprocals aside.
pub(super) fn split<S: Scalar>(block: &Block, workspace: &mut Workspace<S>) {
    let (first, size) = (block.links.start, block.links.len());
    let v = &mut workspace.pivots[block.pivot..block.pivot + size * size];
    for a in (0..size).rev() {
        let reciprocal = v[a * size + a].recip();
        workspace.reciprocals[first + a] = reciprocal;
        for b in 0..a {
            let factor = v[b * size + a] * reciprocal;
            for c in 0..=b {
                v[c * size + b] = v[c * size + b] - factor * v[c * size + a];
            }
        }
        for b in 0..a {
            v[b * size + a] = v[b * size + a] * reciprocal;
        }
    }
}

/// x := V^-1 x, backwards; `v(row, column)` is V above its diagonal.
pub(super) fn solve_upper<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in (0..x.len()).rev() {
        for b in 0..a {
            x[b] = x[b] - v(b, a) * x[a];
        }
    }
}

/// x := V^-T x, forwards.
pub(super) fn solve_lower<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in 0..x.len() {
        for b in 0..a {
            x[a] = x[a] - v(b, a) * x[b];
        }
    }
}

/// V of a split block.
pub(super) fn factor<'a, S: Scalar>(
    block: &Block,
    pivots: &'a [S],
) -> impl Fn(usize, usize) -> S + Copy + 'a {
    let (start, size) = (block.pivot, block.links.len());
    move |row, column| pivots[start + row * size + column]
}

/// The component of the module's first joint, in which nothing is left for its parent: what the
/// joint does not hold, it gives way to.
pub(super) fn freed<S: Scalar>(block: &Block, workspace: &Workspace<S>) -> usize {
    workspace.motions[block.links.start].component()
}

/// Turns the columns Psi into V^-1 Psi^T and, over Delta, into `gains`: row by row but the freed
/// one. Expects the split pivot.
pub(super) fn reduce_columns<S: Scalar>(block: &Block, workspace: &mut Workspace<S>) {
    let freed = freed(block, workspace);
    let v = factor(block, &workspace.pivots);
    for row in (0..6).filter(|&row| row != freed) {
        solve_upper(v, &mut workspace.columns[row][block.links.clone()]);
        for i in block.links.clone() {
            workspace.gains[row][i] = workspace.columns[row][i] * workspace.reciprocals[i];
        }
    }
}

/// Gives the module's inertia, with its joints eliminated, to the link it hangs on: (48).
pub(super) fn eliminate<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
    workspace: &mut Workspace<S>,
) {
    let first = block.links.start;
    let freed = freed(block, workspace);
    let rigid = workspace.composite[first].articulated();
    let whole = workspace.articulated[first].map_or(rigid, |a| a + rigid);
    let left = ArticulatedInertia::from_fn(|row, column| {
        if row == freed || column == freed {
            return S::zero();
        }
        let taken = block
            .links
            .clone()
            .map(|i| workspace.columns[row][i] * workspace.gains[column][i])
            .reduce(|sum, x| sum + x);
        taken.map_or(whole.entry(row, column), |taken| whole.entry(row, column) - taken)
    });
    leave(model, workspace, first, &left);
}

/// Adds an articulated inertia at link `i` to what its parent carries.
fn leave<S: Scalar>(
    model: &Prepared<S>,
    workspace: &mut Workspace<S>,
    i: usize,
    inertia: &ArticulatedInertia<S>,
) {
    if let Some(parent) = model.bodies[i].parent {
        let carried = model.bodies[i].articulated_to_parent(&workspace.motions[i], inertia);
        let sum = workspace.articulated[parent].map_or(carried, |a| a + carried);
        workspace.articulated[parent] = Some(sum);
    }
}
