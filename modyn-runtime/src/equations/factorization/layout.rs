//! The storage layout of the factors of the mass matrix. Entries that couple branches are not
//! stored.

use alloc::{collections::BTreeSet, vec, vec::Vec};
use core::ops::Range;

use super::partition::{ModuleBlock, ModulePartition};
use crate::Scalar;
use crate::mechanism::{ConstrainedFrames, Mechanism};
use crate::model::ModuleTree;

/// The storage layout of the factorization M = U D U^T by modules.
///
/// First comes D: the blocks of the modules, each by rows. Then come the factors of these blocks, V
/// Delta V^T: the entries of V above its diagonal, by columns, module after module; and the
/// reciprocals of Delta, one for each degree of freedom. Then comes U: for each module, a row for
/// each preceding degree of freedom that the module is coupled with. A row has an entry for each
/// degree of freedom of the module.
#[derive(Clone, Debug)]
pub struct UduLayout {
    partition: ModulePartition,
    /// The start of each module's V.
    factors: Vec<usize>,
    /// For each module, the preceding degrees of freedom that it is coupled with, ascending: those
    /// of its ancestors, and, with mimic joints, some of other branches.
    in_front: Vec<Vec<usize>>,
    /// The start of each module's rows of U, relative to the start of U.
    rows: Vec<usize>,
    reciprocals: usize,
    coupling: usize,
    n: usize,
}

impl UduLayout {
    /// Returns the layout for a model and its modules.
    #[must_use]
    pub fn new<S: Scalar>(model: &Mechanism<S>, modules: &ModuleTree) -> Self {
        if !model.has_mimics() {
            return Self::of(model, ModulePartition::new(model, modules));
        }
        let (partition, in_front) = coupled(model, modules, []);
        Self::with(model.nv, partition, in_front)
    }

    /// Returns the layout for a matrix in which these entries of qd are coupled, too, and the entries
    /// that move a loop.
    #[must_use]
    pub fn with_couplings<S: Scalar>(
        model: &Mechanism<S>,
        modules: &ModuleTree,
        couplings: impl Iterator<Item = Vec<usize>>,
    ) -> Self {
        let count = model.constraints.len() - model.contacts();
        let loops = model.constraints[..count].iter().map(|constraint| moving(model, constraint));
        let (partition, in_front) = coupled(model, modules, loops.chain(couplings));
        Self::with(model.nv, partition, in_front)
    }

    /// Returns the layout for a partition of a model without mimic joints.
    #[must_use]
    pub fn of<S>(model: &Mechanism<S>, partition: ModulePartition) -> Self {
        let in_front = ancestors(model, &partition);
        Self::with(model.dofs.len(), partition, in_front)
    }

    fn with(n: usize, partition: ModulePartition, in_front: Vec<Vec<usize>>) -> Self {
        let mut rows = Vec::new();
        let mut factors = Vec::new();
        let mut coupling = 0;
        let mut next = partition.pivots;
        for (block, in_front) in partition.blocks.iter().zip(&in_front) {
            let size = block.dofs.len();
            factors.push(next);
            next += size * size.saturating_sub(1) / 2;
            rows.push(coupling);
            coupling += in_front.len() * size;
        }
        Self { partition, factors, in_front, rows, reciprocals: next, coupling, n }
    }

    /// Returns the modules and the layout of their pivot blocks.
    #[must_use]
    pub fn partition(&self) -> &ModulePartition {
        &self.partition
    }

    /// Returns the modules.
    #[must_use]
    pub fn blocks(&self) -> &[ModuleBlock] {
        &self.partition.blocks
    }

    /// Returns the number of entries of all pivot blocks.
    #[must_use]
    pub fn pivots(&self) -> usize {
        self.partition.pivots
    }

    /// Returns the number of entries of the factorization.
    #[must_use]
    pub fn size(&self) -> usize {
        self.u().start + self.coupling
    }

    /// Returns the number of rows of the mass matrix.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// Returns the start of the V of module `m`.
    pub(super) fn v_start(&self, m: usize) -> usize {
        self.factors[m]
    }

    /// Returns the preceding degrees of freedom that module `m` is coupled with, ascending.
    pub(super) fn ancestors(&self, m: usize) -> &[usize] {
        &self.in_front[m]
    }

    /// Returns the range of D's block of module `m`.
    #[must_use]
    pub fn d(&self, m: usize) -> Range<usize> {
        let block = &self.partition.blocks[m];
        block.pivot..block.pivot + block.dofs.len() * block.dofs.len()
    }

    /// Returns V of module `m` above its diagonal, as a function of row and column.
    pub(super) fn v<'a, S: Scalar>(
        &self,
        m: usize,
        factors: &'a [S],
    ) -> impl Fn(usize, usize) -> S + Copy + 'a {
        let start = self.factors[m];
        move |row, column| factors[start + column * (column - 1) / 2 + row]
    }

    /// Returns the range of the reciprocals of Delta.
    #[must_use]
    pub fn reciprocals(&self) -> Range<usize> {
        self.reciprocals..self.reciprocals + self.n
    }

    /// Returns the range of U.
    #[must_use]
    pub fn u(&self) -> Range<usize> {
        let start = self.reciprocals().end;
        start..start + self.coupling
    }

    /// Returns the rows of U above module `m`: pairs of a degree of freedom and the start of its
    /// row in U.
    pub(in crate::equations) fn rows(
        &self,
        m: usize,
    ) -> impl DoubleEndedIterator<Item = (usize, usize)> + '_ {
        let size = self.partition.blocks[m].dofs.len();
        let start = self.rows[m];
        self.in_front[m].iter().enumerate().map(move |(k, &dof)| (dof, start + k * size))
    }
}

/// Returns, for each module, the degrees of freedom of its ancestors.
fn ancestors<S>(model: &Mechanism<S>, partition: &ModulePartition) -> Vec<Vec<usize>> {
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

/// Returns the entries of qd that move the ends of a constraint.
fn moving<S: Scalar>(model: &Mechanism<S>, constraint: &ConstrainedFrames<S>) -> Vec<usize> {
    let ends = constraint.ends.iter();
    let bodies = ends.flat_map(|end| core::iter::successors(end.body, |&i| model.bodies[i].parent));
    bodies.flat_map(|i| model.dofs_of(i)).map(|dof| dof.v).collect()
}

/// Returns the partition and the couplings of a robot with mimic joints, or with these coupled
/// entries of qd. A module has the entries of the joint vectors that belong to its own joints; it
/// has none if all its joints are mimics. The sparsity pattern of the mass matrix is followed
/// through the elimination.
fn coupled<S: Scalar>(
    model: &Mechanism<S>,
    modules: &ModuleTree,
    couplings: impl IntoIterator<Item = Vec<usize>>,
) -> (ModulePartition, Vec<Vec<usize>>) {
    let mut partition = ModulePartition::new(model, modules);
    let mut module_of = vec![0; model.nv];
    let mut next = 0;
    let mut pivots = 0;
    for (m, block) in partition.blocks.iter_mut().enumerate() {
        let independent =
            model.dofs[block.dofs.clone()].iter().filter(|dof| dof.multiplier.is_none());
        block.dofs = next..next + independent.count();
        module_of[block.dofs.clone()].fill(m);
        block.pivot = pivots;
        next = block.dofs.end;
        pivots += block.dofs.len() * block.dofs.len();
    }
    partition.pivots = pivots;
    let mut in_front = vec![BTreeSet::new(); partition.blocks.len()];
    let couple = |a: usize, b: usize, in_front: &mut [BTreeSet<usize>]| {
        let first = a.min(b);
        let second = a.max(b);
        if module_of[first] != module_of[second] {
            in_front[module_of[second]].insert(first);
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
    for entries in couplings {
        for (k, &a) in entries.iter().enumerate() {
            entries[k + 1..].iter().for_each(|&b| couple(a, b, &mut in_front));
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
