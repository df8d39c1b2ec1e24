//! The paper's own matrices of the block decomposition, dense, for study: (1)-(57), A.2 and A.3.
//!
//! They are built as the paper builds them, from products of 6n^i-sized matrices, and share nothing
//! with the recursion in `elimination` and `brge` but what inverts a pivot block. Joints may have
//! several degrees of freedom, modules any partition. Rotors, which the paper does not have, stand on
//! the diagonal of their module's mass matrix. Joints that mimic others couple modules across the tree, which
//! these forms cannot say.

use alloc::vec::Vec;
use core::ops::Range;

use super::Dense;
use super::denoc::{DeNoc, denoc};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::factorization::ModulePartition;
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;

/// The block decomposition of the mass matrix at a posture, by modules.
///
/// Modules are counted from 0, in the order of the [`ModuleTree`]; `i` is one in front, `j` one of those
/// that originate from it. Rows of twists stand body by body, as in [`DeNoc`].
#[derive(Clone, Debug)]
pub struct Decomposition<S> {
    denoc: DeNoc<S>,
    /// Bodies of each module.
    bodies: Vec<Range<usize>>,
    /// Entries of the joint vectors of each module.
    dofs: Vec<Range<usize>>,
    parents: Vec<Option<usize>>,
    rotors: Vec<S>,
    /// M_hat, Psi and I_hat^-1 of each module.
    articulated: Vec<Articulated<S>>,
}

/// What an articulated module has.
#[derive(Clone, Debug)]
struct Articulated<S> {
    mass: Dense<S>,
    psi: Dense<S>,
    pivot: Dense<S>,
    pivot_inverse: Dense<S>,
}

impl<S: Scalar> Decomposition<S> {
    /// The decomposition at `q`, by modules that fit the model; `None` where joints mimic others.
    #[must_use]
    pub fn new(
        model: &Mechanism<S>,
        modules: &ModuleTree,
        q: &[S],
        workspace: &mut Workspace<S>,
    ) -> Option<Self> {
        if model.has_mimics() {
            return None;
        }
        let partition = ModulePartition::new(model, modules);
        let mut decomposition = Self {
            denoc: denoc(model, q, workspace),
            bodies: partition.blocks.iter().map(|block| block.bodies.clone()).collect(),
            dofs: partition.blocks.iter().map(|block| block.dofs.clone()).collect(),
            parents: modules.modules().iter().map(|module| module.parent).collect(),
            rotors: model.dofs.iter().map(|dof| dof.armature.unwrap_or_else(S::zero)).collect(),
            articulated: Vec::new(),
        };
        decomposition.articulate();
        Some(decomposition)
    }

    /// (46)-(49), from the last module to the first.
    fn articulate(&mut self) {
        let mut masses: Vec<Dense<S>> = (0..self.modules()).map(|i| self.mass(i)).collect();
        let mut articulated = Vec::new();
        for i in (0..self.modules()).rev() {
            let (mass, joints) = (masses[i].clone(), self.joints(i));
            let psi = mass.times(&joints);
            let pivot = joints.transposed().times(&psi).plus(&self.rotor_block(i));
            let pivot_inverse = pivot.symmetric_inverse();
            if let Some(parent) = self.parents[i] {
                let phi = phi(&psi, &pivot_inverse, &joints);
                let left = phi.times(&mass).congruence(&self.propagation(i, parent));
                masses[parent] = masses[parent].plus(&left);
            }
            articulated.push(Articulated { mass, psi, pivot, pivot_inverse });
        }
        articulated.reverse();
        self.articulated = articulated;
    }

    /// How many modules there are: s of the paper.
    #[must_use]
    pub fn modules(&self) -> usize {
        self.bodies.len()
    }

    /// The entries of the joint vectors that module `i` has.
    #[must_use]
    pub fn entries(&self, i: usize) -> Range<usize> {
        self.dofs[i].clone()
    }

    /// The module that module `j` hangs on: beta of the paper.
    #[must_use]
    pub fn parent(&self, j: usize) -> Option<usize> {
        self.parents[j]
    }

    /// Whether module `j` originates from module `i`: j in gamma_i, Fig. 3.
    #[must_use]
    pub fn descends_from(&self, j: usize, i: usize) -> bool {
        core::iter::successors(self.parents[j], |&parent| self.parents[parent]).any(|h| h == i)
    }

    /// Rows of module `i` in twists.
    fn rows(&self, i: usize) -> Range<usize> {
        6 * self.bodies[i].start..6 * self.bodies[i].end
    }

    fn rotor_block(&self, i: usize) -> Dense<S> {
        let dofs = self.entries(i);
        let mut block = Dense::zero(dofs.len(), dofs.len());
        dofs.enumerate().for_each(|(k, d)| block.set(k, k, self.rotors[d]));
        block
    }

    /// The module's mass matrix M_i, (2).
    #[must_use]
    pub fn mass(&self, i: usize) -> Dense<S> {
        self.denoc.mass.block(self.rows(i), self.rows(i))
    }

    /// N_i,l: twist propagation inside the module, (A.5).
    #[must_use]
    pub fn propagation_within(&self, i: usize) -> Dense<S> {
        self.denoc.propagation.block(self.rows(i), self.rows(i))
    }

    /// N_i,d: the joint-motion propagations of the module's joints, (A.5).
    #[must_use]
    pub fn joints_alone(&self, i: usize) -> Dense<S> {
        self.denoc.joints.block(self.rows(i), self.entries(i))
    }

    /// The module-joint-motion propagation N_i = N_i,l N_i,d, (A.4), (A.7).
    #[must_use]
    pub fn joints(&self, i: usize) -> Dense<S> {
        self.propagation_within(i).times(&self.joints_alone(i))
    }

    /// The module-twist propagation A_j,i, (A.7): from the last link of module `i` to the links of `j`;
    /// the identity for the module itself, zero where `j` does not originate from `i`.
    #[must_use]
    pub fn propagation(&self, j: usize, i: usize) -> Dense<S> {
        let (rows, columns) = (self.rows(j), self.rows(i));
        if i == j {
            return Dense::identity(rows.len());
        }
        let mut propagation = Dense::zero(rows.len(), columns.len());
        if self.descends_from(j, i) {
            let last = columns.end - 6..columns.end;
            let block = self.denoc.propagation.block(rows, last);
            propagation.set_block(0, columns.len() - 6, &block);
        }
        propagation
    }

    /// M of all modules, (1).
    #[must_use]
    pub fn masses(&self) -> &Dense<S> {
        &self.denoc.mass
    }

    /// N_l of all modules, (4), (A.12).
    #[must_use]
    pub fn propagations(&self) -> Dense<S> {
        let size = self.denoc.mass.rows;
        self.assembled(size, size, Self::rows, Self::rows, Self::propagation)
    }

    /// N_d of all modules, (4).
    #[must_use]
    pub fn all_joints(&self) -> Dense<S> {
        let (rows, columns) = (self.denoc.joints.rows, self.denoc.joints.columns);
        let mut matrix = Dense::zero(rows, columns);
        for i in 0..self.modules() {
            matrix.set_block(self.rows(i).start, self.entries(i).start, &self.joints(i));
        }
        matrix
    }

    /// The mass matrix of the composite module, by (8): from those of its children.
    #[must_use]
    pub fn composite(&self, i: usize) -> Dense<S> {
        let children = (0..self.modules()).filter(|&j| self.parents[j] == Some(i));
        children.fold(self.mass(i), |sum, j| {
            sum.plus(&self.composite(j).congruence(&self.propagation(j, i)))
        })
    }

    /// The block element I_i,j of the mass matrix (`i` behind `j` or the same), (10); rotors are on the diagonal.
    #[must_use]
    pub fn mass_matrix_block(&self, i: usize, j: usize) -> Dense<S> {
        let wrenches = self.composite(i).times(&self.propagation(i, j)).times(&self.joints(j));
        let block = self.joints(i).transposed().times(&wrenches);
        if i == j { block.plus(&self.rotor_block(i)) } else { block }
    }

    /// The mass matrix from its blocks, (9).
    #[must_use]
    pub fn mass_matrix(&self) -> Dense<S> {
        let n = self.denoc.joints.columns;
        self.assembled(n, n, Self::entries, Self::entries, |s, i, j| {
            if i >= j { s.mass_matrix_block(i, j) } else { s.mass_matrix_block(j, i).transposed() }
        })
    }

    /// A matrix of a block for each pair of modules.
    fn assembled(
        &self,
        rows: usize,
        columns: usize,
        row: impl Fn(&Self, usize) -> Range<usize>,
        column: impl Fn(&Self, usize) -> Range<usize>,
        block: impl Fn(&Self, usize, usize) -> Dense<S>,
    ) -> Dense<S> {
        let mut matrix = Dense::zero(rows, columns);
        for i in 0..self.modules() {
            for j in 0..self.modules() {
                matrix.set_block(row(self, i).start, column(self, j).start, &block(self, i, j));
            }
        }
        matrix
    }

    /// The mass matrix M_hat_i of the articulated module, (48).
    #[must_use]
    pub fn articulated(&self, i: usize) -> &Dense<S> {
        &self.articulated[i].mass
    }

    /// Psi_i = M_hat_i N_i, (47).
    #[must_use]
    pub fn psi(&self, i: usize) -> &Dense<S> {
        &self.articulated[i].psi
    }

    /// The block pivot I_hat_i = N_i^T M_hat_i N_i, (46): the mass matrix of the articulated module.
    #[must_use]
    pub fn pivot(&self, i: usize) -> &Dense<S> {
        &self.articulated[i].pivot
    }

    /// The matrix of the articulated-module transformation Phi_i, (49).
    #[must_use]
    pub fn phi(&self, i: usize) -> Dense<S> {
        let Articulated { psi, pivot_inverse, .. } = &self.articulated[i];
        phi(psi, pivot_inverse, &self.joints(i))
    }

    /// The articulated module-twist propagation A_hat_j,i, (56)-(57): along the modules between, each of
    /// which gives way at its joints.
    #[must_use]
    pub fn articulated_propagation(&self, j: usize, i: usize) -> Dense<S> {
        match self.parents[j] {
            Some(h) if h != i && self.descends_from(h, i) => {
                let through = self.phi(h).transposed().times(&self.articulated_propagation(h, i));
                self.propagation(j, h).times(&through)
            }
            _ => self.propagation(j, i),
        }
    }

    /// N_i^T X^T Psi_j I_hat_j^-1: what is common to (46) and (55).
    fn coefficient(&self, i: usize, j: usize, propagation: &Dense<S>) -> Dense<S> {
        let Articulated { psi, pivot_inverse, .. } = &self.articulated[j];
        propagation.times(&self.joints(i)).transposed().times(&psi.times(pivot_inverse))
    }

    /// The block coefficient U_i,j, (46).
    #[must_use]
    pub fn u_block(&self, i: usize, j: usize) -> Dense<S> {
        self.coefficient(i, j, &self.propagation(j, i))
    }

    /// The block U_hat_i,j of U^-1, (55).
    #[must_use]
    pub fn u_inverse_block(&self, i: usize, j: usize) -> Dense<S> {
        let coefficient = self.coefficient(i, j, &self.articulated_propagation(j, i));
        Dense::zero(coefficient.rows, coefficient.columns).minus(&coefficient)
    }

    /// The elementary block upper triangular matrix (EBUTM) of block column `j`, (36).
    #[must_use]
    pub fn ebutm(&self, j: usize) -> Dense<S> {
        let n = self.denoc.joints.columns;
        let annihilated = self.u_column(j).times(&self.unit_column(j).transposed());
        Dense::identity(n).minus(&annihilated)
    }

    /// Its inverse, (40).
    #[must_use]
    pub fn ebutm_inverse(&self, j: usize) -> Dense<S> {
        let n = self.denoc.joints.columns;
        let annihilated = self.u_column(j).times(&self.unit_column(j).transposed());
        Dense::identity(n).plus(&annihilated)
    }

    /// U'_j, (37): the blocks U_i,j above the diagonal.
    #[must_use]
    pub fn u_column(&self, j: usize) -> Dense<S> {
        let mut column = Dense::zero(self.denoc.joints.columns, self.dofs[j].len());
        for i in (0..j).filter(|&i| self.descends_from(j, i)) {
            column.set_block(self.dofs[i].start, 0, &self.u_block(i, j));
        }
        column
    }

    /// V_j, (38): the identity in the rows of module `j`.
    #[must_use]
    pub fn unit_column(&self, j: usize) -> Dense<S> {
        let mut column = Dense::zero(self.denoc.joints.columns, self.dofs[j].len());
        column.set_block(self.dofs[j].start, 0, &Dense::identity(self.dofs[j].len()));
        column
    }

    /// U from its blocks, (43).
    #[must_use]
    pub fn u(&self) -> Dense<S> {
        self.triangular(Self::u_block)
    }

    /// U^-1 from its blocks, (54).
    #[must_use]
    pub fn u_inverse(&self) -> Dense<S> {
        self.triangular(Self::u_inverse_block)
    }

    fn triangular(&self, block: impl Fn(&Self, usize, usize) -> Dense<S>) -> Dense<S> {
        let mut matrix = Dense::identity(self.denoc.joints.columns);
        for j in 0..self.modules() {
            for i in (0..j).filter(|&i| self.descends_from(j, i)) {
                matrix.set_block(self.dofs[i].start, self.dofs[j].start, &block(self, i, j));
            }
        }
        matrix
    }

    /// D, (45).
    #[must_use]
    pub fn d(&self) -> Dense<S> {
        self.diagonal(|articulated| &articulated.pivot)
    }

    /// D^-1, (54).
    #[must_use]
    pub fn d_inverse(&self) -> Dense<S> {
        self.diagonal(|articulated| &articulated.pivot_inverse)
    }

    fn diagonal(&self, block: impl Fn(&Articulated<S>) -> &Dense<S>) -> Dense<S> {
        let n = self.denoc.joints.columns;
        let mut matrix = Dense::zero(n, n);
        for (dofs, articulated) in self.dofs.iter().zip(&self.articulated) {
            matrix.set_block(dofs.start, dofs.start, block(articulated));
        }
        matrix
    }

    /// The mass matrix as the elimination leaves it, I^(j), (16), (35): block columns from `j` on are annihilated
    /// above the diagonal; with `j` past the last module it is the mass matrix itself.
    #[must_use]
    pub fn eliminated(&self, j: usize) -> Dense<S> {
        (j..self.modules())
            .rev()
            .fold(self.mass_matrix(), |mass_matrix, column| self.ebutm(column).times(&mass_matrix))
    }
}

/// 1 - Psi I_hat^-1 N^T.
fn phi<S: Scalar>(psi: &Dense<S>, pivot_inverse: &Dense<S>, joints: &Dense<S>) -> Dense<S> {
    let taken = psi.times(pivot_inverse).times(&joints.transposed());
    Dense::identity(taken.rows).minus(&taken)
}
