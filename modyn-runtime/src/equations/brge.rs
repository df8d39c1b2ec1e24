//! Block reverse Gaussian elimination of the GIM: I = U D U^T by modules, (35)-(57).
//!
//! All factors are kept packed, without the zeros of other branches: see [`Layout`].

use alloc::vec::Vec;
use core::ops::Range;

use super::Workspace;
use super::elimination::{eliminate, freed, pivot, reduce_columns, split, start};
use super::partition::{Block, Partition};
use crate::model::ModuleTree;
use crate::model::prepare::Prepared;
use crate::spatial::Wrench;
use crate::{Scalar, jacobi};

/// Where the numbers of the factorization lie.
///
/// First D: each module's block, by rows, module after module. Then D^-1 in the same order. Then
/// the reciprocals of the scalar pivots within the blocks, one a joint. Then U: for each module,
/// for each link in front of it on the way from the root, a row as long as the module.
#[derive(Clone, Debug)]
pub struct Layout {
    partition: Partition,
    /// For each module the links in front of it, from the root outwards.
    ancestors: Vec<Vec<usize>>,
    /// Where each module's rows of U start, counted from the first number of U.
    rows: Vec<usize>,
    coupling: usize,
    links: usize,
}

impl Layout {
    /// The layout for a module tree of a model with `links` links.
    #[must_use]
    pub fn new(modules: &ModuleTree, links: usize) -> Self {
        let mut ancestors: Vec<Vec<usize>> = Vec::new();
        let mut rows = Vec::new();
        let mut coupling = 0;
        for module in modules.modules() {
            let in_front = module.parent.map_or_else(Vec::new, |parent| {
                let mut in_front = ancestors[parent].clone();
                in_front.extend(modules.modules()[parent].links.clone());
                in_front
            });
            rows.push(coupling);
            coupling += in_front.len() * module.links.len();
            ancestors.push(in_front);
        }
        Self { partition: modules.into(), ancestors, rows, coupling, links }
    }

    /// The modules.
    #[must_use]
    pub fn blocks(&self) -> &[Block] {
        &self.partition.blocks
    }

    /// The partition to give a workspace room for.
    #[must_use]
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// How many numbers the factorization holds.
    #[must_use]
    pub fn size(&self) -> usize {
        self.u().start + self.coupling
    }

    /// Where D's block of module `m` lies.
    #[must_use]
    pub fn d(&self, m: usize) -> Range<usize> {
        let block = &self.partition.blocks[m];
        block.pivot..block.pivot + block.links.len() * block.links.len()
    }

    /// Where D^-1's block of module `m` lies.
    #[must_use]
    pub fn d_inverse(&self, m: usize) -> Range<usize> {
        let Range { start, end } = self.d(m);
        start + self.partition.pivots..end + self.partition.pivots
    }

    /// Where the reciprocals of the scalar pivots lie.
    #[must_use]
    pub fn reciprocals(&self) -> Range<usize> {
        let start = 2 * self.partition.pivots;
        start..start + self.links
    }

    /// Where U lies.
    #[must_use]
    pub fn u(&self) -> Range<usize> {
        let start = self.reciprocals().end;
        start..start + self.coupling
    }

    /// The rows of U above module `m`: pairs of a link and where its row starts in U.
    fn rows(&self, m: usize) -> impl DoubleEndedIterator<Item = (usize, usize)> + '_ {
        let size = self.partition.blocks[m].links.len();
        let start = self.rows[m];
        self.ancestors[m].iter().enumerate().map(move |(k, &link)| (link, start + k * size))
    }
}

/// Fills `factors` with D, D^-1 and U at `q`, laid out by `layout`.
pub fn factorize<S: Scalar>(
    model: &Prepared<S>,
    layout: &Layout,
    q: &[S],
    workspace: &mut Workspace<S>,
    factors: &mut [S],
) {
    workspace.move_to(model, q);
    start(model, workspace);
    for (m, block) in layout.blocks().iter().enumerate().rev() {
        let first = block.links.start;
        pivot(model, block, workspace);
        factors[layout.d(m)].copy_from_slice(&workspace.pivots[layout.d(m)]);
        split(block, workspace);
        inverse_block(block, workspace, &mut factors[layout.d_inverse(m)]);
        for i in block.links.clone() {
            factors[layout.reciprocals().start + i] = workspace.reciprocals[i];
        }
        if model.bodies[first].parent.is_none() {
            continue;
        }
        reduce_columns(&layout.partition, block, workspace);
        eliminate(model, block, workspace);
        // (46): the columns of Psi I_hat^-1, carried inwards, as each joint there feels them.
        finish_gains(block, workspace);
        for (j, i) in block.links.clone().enumerate() {
            let mut wrench = Wrench::from_components(workspace.gains[i]);
            let mut behind = first;
            for (link, row) in layout.rows(m).rev() {
                wrench = model.bodies[behind].wrench_to_parent(&workspace.motions[behind], wrench);
                factors[layout.u().start + row + j] = workspace.motions[link].project(&wrench);
                behind = link;
            }
        }
    }
}

/// Turns the gains Psi V^-T Delta^-1 into Psi I_hat^-1, all six rows.
fn finish_gains<S: Scalar>(block: &Block, workspace: &mut Workspace<S>) {
    let (first, size) = (block.links.start, block.links.len());
    let freed = freed(block, workspace);
    let v = &workspace.pivots[block.pivot..block.pivot + size * size];
    for row in (0..6).filter(|&row| row != freed) {
        // The same as `solve_lower`, on one row of the gains.
        for a in 0..size {
            for b in 0..a {
                let taken = v[b * size + a] * workspace.gains[first + b][row];
                workspace.gains[first + a][row] = workspace.gains[first + a][row] - taken;
            }
        }
    }
    // Psi's row along the first joint is the first row of I_hat itself.
    for i in block.links.clone() {
        workspace.gains[i][freed] = if i == first { S::one() } else { S::zero() };
    }
}

/// I_hat^-1 = V^-T Delta^-1 V^-1 of a split block.
fn inverse_block<S: Scalar>(block: &Block, workspace: &Workspace<S>, inverse: &mut [S]) {
    let size = block.links.len();
    let v = &workspace.pivots[block.pivot..block.pivot + size * size];
    // V^-1 above the diagonal; its ones on the diagonal are not stored.
    for j in 0..size {
        for i in (0..j).rev() {
            let sum = (i + 1..j)
                .map(|k| v[i * size + k] * inverse[k * size + j])
                .fold(v[i * size + j], |sum, x| sum + x);
            inverse[i * size + j] = -sum;
        }
    }
    // Entry (i, j) needs the columns i and j down to row i: from the last row up, and in it from
    // the last column on, nothing is overwritten that is still needed.
    for i in (0..size).rev() {
        for j in (i..size).rev() {
            let of_row_i = if i == j { S::one() } else { inverse[i * size + j] };
            let last = workspace.reciprocals[block.links.start + i] * of_row_i;
            let entry = (0..i)
                .map(|k| {
                    let scaled =
                        inverse[k * size + i] * workspace.reciprocals[block.links.start + k];
                    scaled * inverse[k * size + j]
                })
                .fold(last, |sum, x| sum + x);
            inverse[i * size + j] = entry;
            inverse[j * size + i] = entry;
        }
    }
}

/// The solution x of I x = rhs, in place, by the three steps of (60).
pub fn solve<S: Scalar>(layout: &Layout, factors: &[S], x: &mut [S]) {
    let u = &factors[layout.u()];
    for (m, block) in layout.blocks().iter().enumerate().rev() {
        for (link, row) in layout.rows(m) {
            for (j, i) in block.links.clone().enumerate() {
                x[link] = x[link] - u[row + j] * x[i];
            }
        }
    }
    for (m, block) in layout.blocks().iter().enumerate() {
        let size = block.links.len();
        let inverse = &factors[layout.d_inverse(m)];
        let scaled: Vec<S> = (0..size)
            .map(|i| {
                let row = &inverse[i * size..(i + 1) * size];
                let products = row.iter().zip(&x[block.links.clone()]).map(|(&a, &b)| a * b);
                products.reduce(|sum, x| sum + x).unwrap_or_else(S::zero)
            })
            .collect();
        x[block.links.clone()].copy_from_slice(&scaled);
        for (link, row) in layout.rows(m) {
            for (j, i) in block.links.clone().enumerate() {
                x[i] = x[i] - u[row + j] * x[link];
            }
        }
    }
}

/// D (or, given its numbers, D^-1) as a full matrix by columns.
pub fn diagonal<S: Scalar>(layout: &Layout, blocks: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for block in layout.blocks() {
        let size = block.links.len();
        for (j, column) in block.links.clone().enumerate() {
            for (i, row) in block.links.clone().enumerate() {
                columns[column * n + row] = blocks[block.pivot + i * size + j];
            }
        }
    }
}

/// U as a full matrix by columns, (43).
pub fn upper<S: Scalar>(layout: &Layout, u: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for (j, column) in block.links.clone().enumerate() {
            columns[column * n + column] = S::one();
            for (link, row) in layout.rows(m) {
                columns[column * n + link] = u[row + j];
            }
        }
    }
}

/// U^-1 as a full matrix by columns, (53)-(54): each block column of U is carried through the
/// block columns of the modules in front of it.
pub fn upper_inverse<S: Scalar>(layout: &Layout, u: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for (j, column) in block.links.clone().enumerate() {
            columns[column * n + column] = S::one();
            // Column `column` of U^-1 is e - sum over links in front of U's entry times their column.
            for (link, row) in layout.rows(m) {
                let factor = u[row + j];
                for (above, _) in layout.rows(m).take_while(|&(above, _)| above <= link) {
                    let entry = columns[link * n + above];
                    columns[column * n + above] = columns[column * n + above] - factor * entry;
                }
            }
        }
    }
}

/// The inverse of the GIM as a full matrix by columns, (50).
pub fn inverse<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for (j, column) in columns.chunks_mut(n).enumerate() {
        column[j] = S::one();
        solve(layout, factors, column);
    }
}

/// The logarithm of the GIM's determinant: that of D, since U's is one.
pub fn log_determinant<S: Scalar>(layout: &Layout, factors: &[S]) -> S {
    let reciprocals = &factors[layout.reciprocals()];
    -reciprocals.iter().fold(S::zero(), |sum, reciprocal| sum + reciprocal.ln())
}

/// The condition number of module `m`'s pivot block, in the 2-norm.
pub fn condition_number<S: Scalar>(layout: &Layout, factors: &[S], m: usize) -> S {
    let mut block = factors[layout.d(m)].to_vec();
    jacobi::condition_number(&mut block, layout.blocks()[m].links.len())
}
