//! Block reverse Gaussian elimination of the GIM: I = U D U^T by modules, (35)-(57).
//!
//! All factors are kept packed, without the zeros of other branches: see [`Layout`]. They come from
//! the recursion over the tree, or, where joints mimic others, from the GIM itself.

use alloc::{collections::BTreeSet, vec, vec::Vec};
use core::ops::Range;

use super::elimination::{
    eliminate, factor, freed, pivot, reduce_columns, solve_lower, solve_upper, split, split_block,
    start,
};
use super::limbs::{self, Limb};
use super::partition::{Block, Partition};
use crate::equations::Workspace;
use crate::equations::dynamics::mass_matrix;
use crate::mechanism::Prepared;
use crate::model::ModuleTree;
use crate::spatial::Wrench;
use crate::{Scalar, jacobi};

/// Where the numbers of the factorization lie.
///
/// First D: each module's block, by rows, module after module. Then its factors, block =
/// V Delta V^T: what stands above the diagonal of V, by columns, module after module, and the
/// reciprocals of Delta, one a degree of freedom. Then U: for each module, for each degree of
/// freedom in front of it that it is coupled with, a row as long as the module.
#[derive(Clone, Debug)]
pub struct Layout {
    partition: Partition,
    /// Where each module's V starts.
    factors: Vec<usize>,
    /// For each module the degrees of freedom in front of it that it is coupled with, ascending:
    /// those on the way from the root, and with mimics some of other branches.
    in_front: Vec<Vec<usize>>,
    /// Where each module's rows of U start, counted from the first number of U.
    rows: Vec<usize>,
    reciprocals: usize,
    coupling: usize,
    /// By degree of freedom: the limb that it belongs to, where equal limbs are computed as one.
    limbs: Vec<Option<Limb>>,
    n: usize,
}

impl Layout {
    /// The layout for a model's modules.
    #[must_use]
    pub fn new<S: Scalar>(model: &Prepared<S>, modules: &ModuleTree) -> Self {
        if !model.has_mimics() {
            return Self::of(model, Partition::new(model, modules));
        }
        let (partition, in_front) = coupled(model, modules);
        Self::with(vec![None; model.nv], partition, in_front)
    }

    /// The layout for modules of a model without mimics.
    #[must_use]
    pub fn of<S>(model: &Prepared<S>, partition: Partition) -> Self {
        let in_front = ancestors(model, &partition);
        Self::with(limbs::of_dofs(model), partition, in_front)
    }

    fn with(limbs: Vec<Option<Limb>>, partition: Partition, in_front: Vec<Vec<usize>>) -> Self {
        let (mut rows, mut factors) = (Vec::new(), Vec::new());
        let (mut coupling, mut next) = (0, partition.pivots);
        for (block, in_front) in partition.blocks.iter().zip(&in_front) {
            let size = block.dofs.len();
            factors.push(next);
            next += size * size.saturating_sub(1) / 2;
            rows.push(coupling);
            coupling += in_front.len() * size;
        }
        let n = limbs.len();
        Self { partition, factors, in_front, rows, reciprocals: next, coupling, limbs, n }
    }

    /// The limb that module `m` is in, where equal limbs are computed as one.
    pub(in crate::equations) fn limb(&self, m: usize) -> Option<Limb> {
        self.limbs[self.partition.blocks[m].dofs.clone()].first().copied().flatten()
    }

    /// The same for each degree of freedom.
    pub(in crate::equations) fn limbs(&self) -> &[Option<Limb>] {
        &self.limbs
    }

    /// Over how many limbs adds up what module `m` leaves to degree of freedom `dof` in front of it.
    fn over(&self, m: usize, dof: usize) -> usize {
        limbs::over(self.limb(m), self.limbs[dof])
    }

    /// The modules, with room for their pivots.
    #[must_use]
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// The modules.
    #[must_use]
    pub fn blocks(&self) -> &[Block] {
        &self.partition.blocks
    }

    /// How many numbers all pivot blocks hold together.
    #[must_use]
    pub fn pivots(&self) -> usize {
        self.partition.pivots
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
        block.pivot..block.pivot + block.dofs.len() * block.dofs.len()
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
        self.reciprocals..self.reciprocals + self.n
    }

    /// Where U lies.
    #[must_use]
    pub fn u(&self) -> Range<usize> {
        let start = self.reciprocals().end;
        start..start + self.coupling
    }

    /// The rows of U above module `m`: pairs of a degree of freedom and where its row starts in U.
    pub(in crate::equations) fn rows(
        &self,
        m: usize,
    ) -> impl DoubleEndedIterator<Item = (usize, usize)> + '_ {
        let size = self.partition.blocks[m].dofs.len();
        let start = self.rows[m];
        self.in_front[m].iter().enumerate().map(move |(k, &dof)| (dof, start + k * size))
    }
}

/// For each module the degrees of freedom on the way to it from the root.
fn ancestors<S>(model: &Prepared<S>, partition: &Partition) -> Vec<Vec<usize>> {
    let mut ancestors: Vec<Vec<usize>> = Vec::new();
    for block in &partition.blocks {
        let parent = model.bodies[block.bodies.start].parent.and_then(|parent| {
            partition.blocks.iter().position(|block| block.bodies.contains(&parent))
        });
        ancestors.push(parent.map_or_else(Vec::new, |parent| {
            let mut in_front = ancestors[parent].clone();
            in_front.extend(partition.blocks[parent].dofs.clone());
            in_front
        }));
    }
    ancestors
}

/// The same where joints mimic others: each module has the entries of the joint vectors that its
/// own joints have (none, if all follow others), and the GIM's pattern is followed through the
/// elimination.
fn coupled<S: Scalar>(model: &Prepared<S>, modules: &ModuleTree) -> (Partition, Vec<Vec<usize>>) {
    let mut partition = Partition::new(model, modules);
    let mut module_of = vec![0; model.nv];
    let (mut next, mut pivots) = (0, 0);
    for (m, block) in partition.blocks.iter_mut().enumerate() {
        let own = model.dofs[block.dofs.clone()].iter().filter(|dof| dof.multiplier.is_none());
        block.dofs = next..next + own.count();
        module_of[block.dofs.clone()].fill(m);
        block.pivot = pivots;
        next = block.dofs.end;
        pivots += block.dofs.len() * block.dofs.len();
    }
    partition.pivots = pivots;
    let mut in_front = vec![BTreeSet::new(); partition.blocks.len()];
    let couple = |a: usize, b: usize, in_front: &mut [BTreeSet<usize>]| {
        let (a, b) = (a.min(b), a.max(b));
        if module_of[a] != module_of[b] {
            in_front[module_of[b]].insert(a);
        }
    };
    for (i, body) in model.bodies.iter().enumerate() {
        let mut at = Some(body);
        while let Some(other) = at {
            for dof in model.dofs_of(i) {
                for other in &model.dofs[other.dofs.clone()] {
                    couple(dof.v, other.v, &mut in_front);
                }
            }
            at = other.parent.map(|parent| &model.bodies[parent]);
        }
    }
    for m in (0..in_front.len()).rev() {
        let rows: Vec<usize> = in_front[m].iter().copied().collect();
        for (k, &a) in rows.iter().enumerate() {
            for &b in &rows[k + 1..] {
                couple(a, b, &mut in_front);
            }
        }
    }
    (partition, in_front.into_iter().map(|rows| rows.into_iter().collect()).collect())
}

/// Fills `factors` with D, its factors and U at `q`, laid out by `layout`.
pub fn factorize<S: Scalar>(
    model: &Prepared<S>,
    layout: &Layout,
    q: &[S],
    workspace: &mut Workspace<S>,
    factors: &mut [S],
) {
    if model.has_mimics() {
        workspace.make_room(layout.pivots(), model.nv * model.nv, 0);
        let mut matrix = core::mem::take(&mut workspace.matrix);
        mass_matrix(model, q, workspace, &mut matrix);
        factorize_matrix(layout, &mut matrix, &mut workspace.pivots, factors);
        workspace.matrix = matrix;
        return;
    }
    workspace.make_room(layout.pivots(), 0, 0);
    workspace.move_to(model, q);
    start(model, workspace);
    for (m, block) in layout.blocks().iter().enumerate().rev() {
        let first = block.bodies.start;
        pivot(model, block, workspace);
        factors[layout.d(m)].copy_from_slice(&workspace.pivots[layout.d(m)]);
        split(block, workspace);
        store_v(layout, m, &workspace.pivots, factors);
        for d in block.dofs.clone() {
            factors[layout.reciprocals().start + d] = workspace.reciprocals[d];
        }
        if model.bodies[first].parent.is_none() {
            continue;
        }
        reduce_columns(model, block, workspace);
        eliminate(model, block, workspace);
        // (46): the columns of Psi I_hat^-1, carried inwards, as each joint there feels them.
        finish_gains(model, block, workspace);
        for (j, d) in block.dofs.clone().enumerate() {
            let mut wrench =
                Wrench::from_components(core::array::from_fn(|row| workspace.gains[row][d]));
            let mut at = first;
            for (other, row) in layout.rows(m).rev() {
                while at != model.dofs[other].body {
                    let body = &model.bodies[at];
                    wrench = body.wrench_to_parent(&workspace.motions[at], wrench);
                    let Some(parent) = body.parent else { break };
                    at = parent;
                }
                let component = model.dofs[other].component;
                factors[layout.u().start + row + j] = wrench.components()[component];
            }
        }
    }
}

/// The same from the GIM itself, by columns, which is used up: (16)-(45), block by block, where
/// nothing is known of the GIM but which entries are zero.
pub fn factorize_matrix<S: Scalar>(
    layout: &Layout,
    matrix: &mut [S],
    pivots: &mut [S],
    factors: &mut [S],
) {
    let n = layout.n;
    for (m, block) in layout.blocks().iter().enumerate().rev() {
        let (start, size) = (block.dofs.start, block.dofs.len());
        for (row, entries) in factors[layout.d(m)].chunks_mut(size.max(1)).enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry = matrix[(start + column) * n + start + row];
            }
        }
        pivots[layout.d(m)].copy_from_slice(&factors[layout.d(m)]);
        let reciprocals = layout.reciprocals();
        let own = reciprocals.start + start..reciprocals.start + start + size;
        split_block(&mut pivots[layout.d(m)], size, &mut factors[own.clone()]);
        store_v(layout, m, pivots, factors);
        let v = factor(block, pivots);
        for (dof, row) in layout.rows(m) {
            let row = layout.u().start + row;
            for j in 0..size {
                factors[row + j] = matrix[(start + j) * n + dof];
            }
            let (before, after) = factors.split_at_mut(row);
            let entries = &mut after[..size];
            solve_upper(v, entries);
            for (entry, &reciprocal) in entries.iter_mut().zip(&before[own.clone()]) {
                *entry = *entry * reciprocal;
            }
            solve_lower(v, entries);
        }
        for (a, row) in layout.rows(m) {
            let row = &factors[layout.u().start + row..][..size];
            for &b in layout.in_front[m].iter().filter(|&&b| b <= a) {
                let taken = (0..size).map(|j| row[j] * matrix[(start + j) * n + b]);
                if let Some(taken) = taken.reduce(|sum, x| sum + x) {
                    let taken = taken.over_limbs(0..layout.over(m, a).min(layout.over(m, b)));
                    let left = matrix[a * n + b] - taken;
                    (matrix[a * n + b], matrix[b * n + a]) = (left, left);
                }
            }
        }
    }
}

/// Keeps V of a split pivot block.
fn store_v<S: Scalar>(layout: &Layout, m: usize, pivots: &[S], factors: &mut [S]) {
    let block = &layout.blocks()[m];
    let v = factor(block, pivots);
    let mut entries = factors[layout.factors[m]..].iter_mut();
    for column in 0..block.dofs.len() {
        for (row, entry) in (0..column).zip(&mut entries) {
            *entry = v(row, column);
        }
    }
}

/// Turns the gains Psi V^-T Delta^-1 into Psi I_hat^-1, all six rows.
fn finish_gains<S: Scalar>(model: &Prepared<S>, block: &Block, workspace: &mut Workspace<S>) {
    let freed = freed(model, block);
    for (row, freed) in freed.into_iter().enumerate() {
        let gains = &mut workspace.gains[row][block.dofs.clone()];
        if let Some(d) = freed {
            // Psi's row along a freed component is a row of I_hat itself.
            gains.fill(S::zero());
            gains[d - block.dofs.start] = S::one();
        } else {
            solve_lower(factor(block, &workspace.pivots), gains);
        }
    }
}

/// x := I_hat^-1 x for module `m`.
fn solve_block<S: Scalar>(layout: &Layout, factors: &[S], m: usize, x: &mut [S]) {
    let v = layout.v(m, factors);
    let reciprocals = &factors[layout.reciprocals()][layout.blocks()[m].dofs.clone()];
    solve_upper(v, x);
    for (x, &reciprocal) in x.iter_mut().zip(reciprocals) {
        *x = *x * reciprocal;
    }
    solve_lower(v, x);
}

/// The solution x of I x = rhs, in place, by the three steps of (60).
///
/// Where equal limbs are computed as one, `rhs` is the same for all of them.
pub fn solve<S: Scalar>(layout: &Layout, factors: &[S], x: &mut [S]) {
    solve_for(layout, factors, None, x);
}

/// The same for a right-hand side that is the column of a degree of freedom. Where equal limbs are
/// computed as one, a limb's is each limb's own, zero on the others, and the rows of those are left out:
/// see [`limbs`].
pub fn solve_column<S: Scalar>(layout: &Layout, factors: &[S], column: usize, x: &mut [S]) {
    solve_for(layout, factors, layout.limbs[column], x);
}

fn solve_for<S: Scalar>(layout: &Layout, factors: &[S], own: Option<Limb>, x: &mut [S]) {
    let u = &factors[layout.u()];
    let others = |m: usize| own.is_some() && layout.limb(m).is_some_and(|limb| own != Some(limb));
    for (m, block) in layout.blocks().iter().enumerate().rev().filter(|(m, _)| !others(*m)) {
        for (dof, row) in layout.rows(m) {
            let over = if own.is_none() { layout.over(m, dof) } else { 1 };
            let shares = block.dofs.clone().enumerate().map(|(j, i)| u[row + j] * x[i]);
            x[dof] = if over == 1 {
                shares.fold(x[dof], |x, share| x - share)
            } else {
                x[dof] - shares.fold(S::zero(), |sum, x| sum + x).over_limbs(0..over)
            };
        }
    }
    for (m, block) in layout.blocks().iter().enumerate().filter(|(m, _)| !others(*m)) {
        solve_block(layout, factors, m, &mut x[block.dofs.clone()]);
        for (dof, row) in layout.rows(m) {
            for (j, i) in block.dofs.clone().enumerate() {
                x[i] = x[i] - u[row + j] * x[dof];
            }
        }
    }
}

/// D as a full matrix by columns, (45).
pub fn diagonal<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.n;
    columns.fill(S::zero());
    for block in layout.blocks() {
        let size = block.dofs.len();
        for (j, column) in block.dofs.clone().enumerate() {
            for (i, row) in block.dofs.clone().enumerate() {
                columns[column * n + row] = factors[block.pivot + i * size + j];
            }
        }
    }
}

/// D^-1 as a full matrix by columns, (54).
pub fn diagonal_inverse<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.n;
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for column in block.dofs.clone() {
            columns[column * n + column] = S::one();
            let rows = column * n + block.dofs.start..column * n + block.dofs.end;
            solve_block(layout, factors, m, &mut columns[rows]);
        }
        mirror(n, block.dofs.clone(), columns);
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
    let n = layout.n;
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for (j, column) in block.dofs.clone().enumerate() {
            columns[column * n + column] = S::one();
            for (dof, row) in layout.rows(m) {
                columns[column * n + dof] = u[row + j];
            }
        }
    }
}

/// U^-1 as a full matrix by columns, (53)-(54): each block column of U is carried through the
/// block columns of the modules in front of it.
pub fn upper_inverse<S: Scalar>(layout: &Layout, u: &[S], columns: &mut [S]) {
    let n = layout.n;
    columns.fill(S::zero());
    for (m, block) in layout.blocks().iter().enumerate() {
        for (j, column) in block.dofs.clone().enumerate() {
            columns[column * n + column] = S::one();
            // Column `column` of U^-1 is e - sum over what stands in front of U's entry times their
            // column. (With mimics that reaches more entries than U has.)
            for (dof, row) in layout.rows(m) {
                let factor = u[row + j];
                for above in 0..=dof {
                    let entry = columns[dof * n + above];
                    columns[column * n + above] = columns[column * n + above] - factor * entry;
                }
            }
        }
    }
}

/// The inverse of the GIM as a full matrix by columns, (50): U^-T D^-1 U^-1, applied to each
/// column of the identity.
pub fn inverse<S: Scalar>(layout: &Layout, factors: &[S], columns: &mut [S]) {
    let n = layout.n;
    columns.fill(S::zero());
    for (j, column) in columns.chunks_mut(n.max(1)).enumerate() {
        column[j] = S::one();
        solve_column(layout, factors, j, column);
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
    jacobi::condition_number(&mut block, layout.blocks()[m].dofs.len())
}
