//! Block reverse Gaussian elimination of the GIM: I = U D U^T by modules, (35)-(57).
//!
//! All factors are kept packed, without the zeros of other branches: see [`Layout`].

use alloc::vec::Vec;
use core::ops::Range;

use super::Workspace;
use super::elimination::{
    eliminate, factor, freed, pivot, reduce_columns, solve_lower, solve_upper, split, start,
};
use super::partition::{Block, Partition};
use crate::model::ModuleTree;
use crate::model::prepare::Prepared;
use crate::spatial::Wrench;
use crate::{Scalar, jacobi};

/// Where the numbers of the factorization lie.
///
/// First D: each module's block, by rows, module after module. Then its factors, block =
/// V Delta V^T: what stands above the diagonal of V, by columns, module after module, and the
/// reciprocals of Delta, one a joint. Then U: for each module, for each link in front of it on the
/// way from the root, a row as long as the module.
#[derive(Clone, Debug)]
pub struct Layout {
    partition: Partition,
    /// Where each module's V starts.
    factors: Vec<usize>,
    /// For each module the links in front of it, from the root outwards.
    ancestors: Vec<Vec<usize>>,
    /// Where each module's rows of U start, counted from the first number of U.
    rows: Vec<usize>,
    reciprocals: usize,
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
        let partition = Partition::from(modules);
        let mut factors = Vec::new();
        let mut next = partition.pivots;
        for module in modules.modules() {
            let in_front = module.parent.map_or_else(Vec::new, |parent| {
                let mut in_front = ancestors[parent].clone();
                in_front.extend(modules.modules()[parent].links.clone());
                in_front
            });
            let size = module.links.len();
            factors.push(next);
            next += size * size.saturating_sub(1) / 2;
            rows.push(coupling);
            coupling += in_front.len() * size;
            ancestors.push(in_front);
        }
        Self { partition, factors, ancestors, rows, reciprocals: next, coupling, links }
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

    /// V of module `m` above its diagonal, by row and column.
    fn v<'a, S: Scalar>(
        &self,
        m: usize,
        factors: &'a [S],
    ) -> impl Fn(usize, usize) -> S + Copy + 'a {
        let start = self.factors[m];
        move |row, column| factors[start + column * (column - 1) / 2 + row]
    }

    /// Where the reciprocals of Delta lie.
    #[must_use]
    pub fn reciprocals(&self) -> Range<usize> {
        self.reciprocals..self.reciprocals + self.links
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

/// Fills `factors` with D, its factors and U at `q`, laid out by `layout`.
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
        let mut entries = factors[layout.factors[m]..].iter_mut();
        for column in 0..block.links.len() {
            for (row, entry) in (0..column).zip(&mut entries) {
                *entry = factor(block, &workspace.pivots)(row, column);
            }
        }
        for i in block.links.clone() {
            factors[layout.reciprocals().start + i] = workspace.reciprocals[i];
        }
        if model.bodies[first].parent.is_none() {
            continue;
        }
        reduce_columns(block, workspace);
        eliminate(model, block, workspace);
        // (46): the columns of Psi I_hat^-1, carried inwards, as each joint there feels them.
        finish_gains(block, workspace);
        for (j, i) in block.links.clone().enumerate() {
            let mut wrench =
                Wrench::from_components(core::array::from_fn(|row| workspace.gains[row][i]));
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
    let freed = freed(block, workspace);
    for row in (0..6).filter(|&row| row != freed) {
        let gains = &mut workspace.gains[row][block.links.clone()];
        solve_lower(factor(block, &workspace.pivots), gains);
    }
    // Psi's row along the first joint is the first row of I_hat itself.
    let gains = &mut workspace.gains[freed][block.links.clone()];
    gains.fill(S::zero());
    gains[0] = S::one();
}

/// x := I_hat^-1 x for module `m`.
fn solve_block<S: Scalar>(layout: &Layout, factors: &[S], m: usize, x: &mut [S]) {
    let v = layout.v(m, factors);
    let reciprocals = &factors[layout.reciprocals()][layout.blocks()[m].links.clone()];
    solve_upper(v, x);
    for (x, &reciprocal) in x.iter_mut().zip(reciprocals) {
        *x = *x * reciprocal;
    }
    solve_lower(v, x);
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
        solve_block(layout, factors, m, &mut x[block.links.clone()]);
        for (link, row) in layout.rows(m) {
            for (j, i) in block.links.clone().enumerate() {
                x[i] = x[i] - u[row + j] * x[link];
            }
        }
    }
}

/// D as a full matrix by columns, (45).
pub fn diagonal<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for block in layout.blocks() {
        let size = block.links.len();
        for (j, column) in block.links.clone().enumerate() {
            for (i, row) in block.links.clone().enumerate() {
                columns[column * n + row] = factors[block.pivot + i * size + j];
            }
        }
    }
}

/// D^-1 as a full matrix by columns, (54).
pub fn diagonal_inverse<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for column in block.links.clone() {
            columns[column * n + column] = S::one();
            let rows = column * n + block.links.start..column * n + block.links.end;
            solve_block(layout, factors, m, &mut columns[rows]);
        }
        mirror(n, block.links.clone(), columns);
    }
}

/// Copies what stands above the diagonal of these rows and columns below it.
fn mirror<S: Scalar>(n: usize, range: Range<usize>, columns: &mut [S]) {
    for column in range.clone() {
        for row in range.start..column {
            columns[row * n + column] = columns[column * n + row];
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

/// The inverse of the GIM as a full matrix by columns, (50): U^-T D^-1 U^-1, applied to each
/// column of the identity.
pub fn inverse<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.links;
    columns.fill(S::zero());
    for (j, column) in columns.chunks_mut(n).enumerate() {
        column[j] = S::one();
        solve(layout, factors, column);
    }
    mirror(n, 0..n, columns);
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
