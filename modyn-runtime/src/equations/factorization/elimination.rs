//! A module's part in the block reverse Gaussian elimination, (35)-(49).
//!
//! Inside a module inertia travels as a rigid composite (10 numbers), in the last link together
//! with what eliminated child modules left there (21 numbers from there on). The module's pivot
//! is the block I_hat = N^T Psi, (46), with Psi = M_hat N, (47), and the rotors' inertia on its
//! diagonal; it is split as V Delta V^T by reverse Gaussian elimination, and the module's parent
//! then sees Phi M_hat, (48)-(49): M_hat - Psi I_hat^-1 Psi^T.
//!
//! No joint mimics another here: each degree of freedom is an entry of the joint vectors.

use super::partition::Block;
use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::Prepared;
use crate::spatial::ArticulatedInertia;

/// Sets each body's inertia to its own.
pub(in crate::equations) fn start<S: Scalar>(model: &Prepared<S>, workspace: &mut Workspace<S>) {
    for (composite, body) in workspace.composite.iter_mut().zip(&model.bodies) {
        *composite = body.minimal;
    }
    workspace.articulated.fill(None);
}

/// Forms the module's pivot block and its columns Psi at the module's first body, and gathers the
/// inertia of the bodies behind there.
pub(in crate::equations) fn pivot<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
    workspace: &mut Workspace<S>,
) {
    let (start, size) = (block.dofs.start, block.dofs.len());
    for i in block.bodies.clone().rev() {
        let (composite, articulated) = (workspace.composite[i], workspace.articulated[i]);
        let whole = articulated.map(|a| a + composite.articulated());
        for d in model.bodies[i].dofs.clone() {
            let dof = &model.dofs[d];
            let mut wrench = match &whole {
                Some(whole) => whole.column(dof.component),
                None => composite.column(dof.component),
            };
            let j = d - start;
            let mut own = wrench.components()[dof.component];
            if let Some(armature) = dof.armature {
                own = own + armature;
            }
            workspace.pivots[block.pivot + j * size + j] = own;
            let mut at = i;
            for row in (0..j).rev() {
                let other = &model.dofs[start + row];
                while at > other.body {
                    wrench = model.bodies[at].wrench_to_parent(&workspace.motions[at], wrench);
                    at -= 1;
                }
                let felt = wrench.components()[other.component];
                workspace.pivots[block.pivot + row * size + j] = felt;
                workspace.pivots[block.pivot + j * size + row] = felt;
            }
            for (column, component) in workspace.columns.iter_mut().zip(wrench.components()) {
                column[d] = component;
            }
        }
        if i == block.bodies.start {
            continue;
        }
        if let Some(whole) = whole {
            leave(model, workspace, i, &whole);
        } else {
            let carried = model.bodies[i].rigid_to_parent(&workspace.motions[i], &composite);
            workspace.composite[i - 1] = workspace.composite[i - 1] + carried;
        }
    }
}

/// Splits the pivot block as V Delta V^T in place: V above the diagonal, Delta's reciprocals aside.
pub(in crate::equations) fn split<S: Scalar>(block: &Block, workspace: &mut Workspace<S>) {
    let size = block.dofs.len();
    let v = &mut workspace.pivots[block.pivot..block.pivot + size * size];
    split_block(v, size, &mut workspace.reciprocals[block.dofs.clone()]);
}

/// The same of a block by rows.
pub(in crate::equations) fn split_block<S: Scalar>(
    v: &mut [S],
    size: usize,
    reciprocals: &mut [S],
) {
    for a in (0..size).rev() {
        let reciprocal = v[a * size + a].recip();
        reciprocals[a] = reciprocal;
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
pub(in crate::equations) fn solve_upper<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in (0..x.len()).rev() {
        for b in 0..a {
            x[b] = x[b] - v(b, a) * x[a];
        }
    }
}

/// x := V^-T x, forwards.
pub(in crate::equations) fn solve_lower<S: Scalar>(v: impl Fn(usize, usize) -> S, x: &mut [S]) {
    for a in 0..x.len() {
        for b in 0..a {
            x[a] = x[a] - v(b, a) * x[b];
        }
    }
}

/// V of a split block.
pub(in crate::equations) fn factor<'a, S: Scalar>(
    block: &Block,
    pivots: &'a [S],
) -> impl Fn(usize, usize) -> S + Copy + 'a {
    let (start, size) = (block.pivot, block.dofs.len());
    move |row, column| pivots[start + row * size + column]
}

/// By component: the degree of freedom of the module's first joint that moves it, where nothing
/// is left for the parent: what the joint does not hold, it gives way to. (A rotor holds.)
pub(in crate::equations) fn freed<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
) -> [Option<usize>; 6] {
    let mut freed = [None; 6];
    for d in model.bodies[block.bodies.start].dofs.clone() {
        if model.dofs[d].armature.is_none() {
            freed[model.dofs[d].component] = Some(d);
        }
    }
    freed
}

/// Turns the columns Psi into V^-1 Psi^T and, over Delta, into `gains`: row by row but the freed
/// ones. Expects the split pivot.
pub(in crate::equations) fn reduce_columns<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
    workspace: &mut Workspace<S>,
) {
    let freed = freed(model, block);
    let v = factor(block, &workspace.pivots);
    for row in (0..6).filter(|&row| freed[row].is_none()) {
        solve_upper(v, &mut workspace.columns[row][block.dofs.clone()]);
        for d in block.dofs.clone() {
            workspace.gains[row][d] = workspace.columns[row][d] * workspace.reciprocals[d];
        }
    }
}

/// Gives the module's inertia, with its joints eliminated, to the link it hangs on: (48).
pub(in crate::equations) fn eliminate<S: Scalar>(
    model: &Prepared<S>,
    block: &Block,
    workspace: &mut Workspace<S>,
) {
    let first = block.bodies.start;
    let freed = freed(model, block);
    if freed.iter().all(Option::is_some) {
        return;
    }
    let rigid = workspace.composite[first].articulated();
    let whole = workspace.articulated[first].map_or(rigid, |a| a + rigid);
    let left = ArticulatedInertia::from_fn(|row, column| {
        if freed[row].is_some() || freed[column].is_some() {
            return S::zero();
        }
        let taken = block
            .dofs
            .clone()
            .map(|d| workspace.columns[row][d] * workspace.gains[column][d])
            .reduce(|sum, x| sum + x);
        taken.map_or(whole.entry(row, column), |taken| whole.entry(row, column) - taken)
    });
    leave(model, workspace, first, &left);
}

/// Adds an articulated inertia at body `i` to what its parent carries.
fn leave<S: Scalar>(
    model: &Prepared<S>,
    workspace: &mut Workspace<S>,
    i: usize,
    inertia: &ArticulatedInertia<S>,
) {
    model.bodies[i].articulated_to_parents(&workspace.motions[i], inertia, |parent, carried| {
        let sum = workspace.articulated[parent].map_or(carried, |a| a + carried);
        workspace.articulated[parent] = Some(sum);
    });
}
