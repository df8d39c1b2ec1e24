//! Block reverse Gaussian elimination of the GIM: I = U D U^T by modules, (35)-(57).
//!
//! All factors are kept packed, without the zeros of other branches: see [`Layout`].

use alloc::{vec, vec::Vec};
use core::ops::Range;

use super::Workspace;
use super::elimination::{eliminate, freed, pivot, reduce_columns, solve_lower, split, start};
use super::partition::{Block, Partition};
use crate::model::ModuleTree;
use crate::model::prepare::Prepared;
use crate::spatial::Wrench;
use crate::{Scalar, jacobi};

/// Where the numbers of the factorization lie.
///
/// First D: each module's block, by rows, module after module. Then D^-1 in the same order. Then
/// U: for each module, for each link in front of it on the way from the root, a row as long as
/// the module.
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
    pub fn len(&self) -> usize {
        2 * self.partition.pivots + self.coupling
    }

    /// Whether it holds none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
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

    /// Where U lies.
    #[must_use]
    pub fn u(&self) -> Range<usize> {
        2 * self.partition.pivots..self.len()
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
        let (first, size) = (block.links.start, block.links.len());
        pivot(model, block, workspace);
        factors[layout.d(m)].copy_from_slice(&workspace.pivots[layout.d(m)]);
        split(block, workspace);
        inverse_block(block, workspace, &mut factors[layout.d_inverse(m)]);
        let Some(parent) = model.bodies[first].parent else {
            continue;
        };
        reduce_columns(&layout.partition, block, workspace);
        eliminate(model, block, workspace);
        // (46): the columns of Psi I_hat^-1, carried inwards, as each joint there feels them.
        let freed = freed(block, workspace);
        let v = &workspace.pivots[layout.d(m)];
        let mut columns = vec![[S::zero(); 6]; size];
        for row in 0..6 {
            let mut gains: Vec<S> = if row == freed {
                // Psi's row along the first joint is the first row of I_hat itself.
                (0..size).map(|j| if j == 0 { S::one() } else { S::zero() }).collect()
            } else {
                block.links.clone().map(|i| workspace.gains[i][row]).collect()
            };
            if row != freed {
                solve_lower(v, &mut gains);
            }
            columns.iter_mut().zip(gains).for_each(|(column, gain)| column[row] = gain);
        }
        let rows: Vec<usize> = layout.rows(m).map(|(_, at)| layout.u().start + at).collect();
        for (j, column) in columns.into_iter().enumerate() {
            let mut wrench = Wrench::from_components(column);
            let (mut behind, mut at) = (first, Some(parent));
            for row in rows.iter().rev() {
                let Some(link) = at else { break };
                wrench = model.bodies[behind].wrench_to_parent(&workspace.motions[behind], wrench);
                factors[row + j] = workspace.motions[link].project(&wrench);
                (behind, at) = (link, model.bodies[link].parent);
            }
        }
    }
}

/// I_hat^-1 = V^-T Delta^-1 V^-1 of a split block.
fn inverse_block<S: Scalar>(block: &Block, workspace: &Workspace<S>, inverse: &mut [S]) {
    let size = block.links.len();
    let v = &workspace.pivots[block.pivot..block.pivot + size * size];
    // Columns of V^-1: e_j, then up the rows.
    let mut upper = vec![S::zero(); size * size];
    for j in 0..size {
        upper[j * size + j] = S::one();
        for i in (0..j).rev() {
            let sum = (i + 1..j)
                .map(|k| v[i * size + k] * upper[k * size + j])
                .fold(v[i * size + j], |sum, x| sum + x);
            upper[i * size + j] = -sum;
        }
    }
    for i in 0..size {
        for j in i..size {
            let entry = (0..=i)
                .map(|k| {
                    let scaled = upper[k * size + i] * workspace.reciprocals[block.links.start + k];
                    scaled * upper[k * size + j]
                })
                .reduce(|sum, x| sum + x)
                .unwrap_or_else(S::zero);
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
    let mut sum = S::zero();
    for (m, block) in layout.blocks().iter().enumerate() {
        let size = block.links.len();
        let mut a = factors[layout.d(m)].to_vec();
        for k in (0..size).rev() {
            let pivot = a[k * size + k];
            sum = sum + pivot.ln();
            let reciprocal = pivot.recip();
            for i in 0..k {
                let factor = a[i * size + k] * reciprocal;
                for j in 0..=i {
                    a[j * size + i] = a[j * size + i] - factor * a[j * size + k];
                }
            }
        }
    }
    sum
}

/// The condition number of module `m`'s pivot block, in the 2-norm.
pub fn condition_number<S: Scalar>(layout: &Layout, factors: &[S], m: usize) -> S {
    let mut block = factors[layout.d(m)].to_vec();
    jacobi::condition_number(&mut block, layout.blocks()[m].links.len())
}
