//! The paper's matrices of the block decomposition, dense, for study: (1)-(57), A.2 and A.3.
//!
//! The matrices are built as in the paper, as products of 6n^i-sized matrices. They share no code
//! with the recursion in `factorization` and `brge`, except the inversion of a pivot block. Joints
//! may have several degrees of freedom, and any partition into modules is accepted. The paper has
//! no rotors; here their inertia is added to the diagonal of the module's pivot block. Robots with
//! mimic joints are not supported: mimic joints couple modules across the tree, which these forms
//! cannot express.

use alloc::vec::Vec;
use core::ops::Range;

use super::Dense;
use super::denoc::{DeNoc, denoc};
use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::factorization::ModulePartition;
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;

/// The block decomposition of the mass matrix at a configuration, by modules.
///
/// Modules are counted from 0, in the order of the [`ModuleTree`]. In the methods, module `i` is an
/// ancestor of module `j`. The rows of twists are ordered by body, as in [`DeNoc`].
#[derive(Clone, Debug)]
pub struct Decomposition<S> {
    denoc: DeNoc<S>,
    /// The bodies of each module.
    bodies: Vec<Range<usize>>,
    /// The entries of the joint vectors of each module.
    dofs: Vec<Range<usize>>,
    parents: Vec<Option<usize>>,
    rotors: Vec<S>,
    /// M_hat, Psi and I_hat^-1 of each module.
    articulated: Vec<Articulated<S>>,
}

/// The matrices of an articulated module.
#[derive(Clone, Debug)]
struct Articulated<S> {
    mass: Dense<S>,
    psi: Dense<S>,
    pivot: Dense<S>,
    pivot_inverse: Dense<S>,
}

impl<S: Scalar> Decomposition<S> {
    /// Returns the decomposition at `q`, by modules that fit the model; `None` for robots with
    /// mimic joints.
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

    /// Computes (46)-(49), from the last module to the first.
    fn articulate(&mut self) {
        let mut masses: Vec<Dense<S>> = (0..self.modules()).map(|i| self.mass(i)).collect();
        let mut articulated = Vec::new();
        for i in (0..self.modules()).rev() {
            let mass = masses[i].clone();
            let joints = self.joints(i);
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

    /// Returns the number of modules: s of the paper.
    #[must_use]
    pub fn modules(&self) -> usize {
        self.bodies.len()
    }

    /// Returns the entries of the joint vectors that belong to module `i`.
    #[must_use]
    pub fn entries(&self, i: usize) -> Range<usize> {
        self.dofs[i].clone()
    }

    /// Returns the parent module of module `j`: beta of the paper.
    #[must_use]
    pub fn parent(&self, j: usize) -> Option<usize> {
        self.parents[j]
    }

    /// Returns whether module `j` is a descendant of module `i`: j in gamma_i, Fig. 3.
    #[must_use]
    pub fn descends_from(&self, j: usize, i: usize) -> bool {
        core::iter::successors(self.parents[j], |&parent| self.parents[parent]).any(|h| h == i)
    }

    /// Returns the rows of module `i` in twists.
    fn rows(&self, i: usize) -> Range<usize> {
        6 * self.bodies[i].start..6 * self.bodies[i].end
    }

    fn rotor_block(&self, i: usize) -> Dense<S> {
        let dofs = self.entries(i);
        let mut block = Dense::zero(dofs.len(), dofs.len());
        dofs.enumerate().for_each(|(k, d)| block.set(k, k, self.rotors[d]));
        block
    }

    /// Returns the module's mass matrix M_i, (2).
    #[must_use]
    pub fn mass(&self, i: usize) -> Dense<S> {
        self.denoc.mass.block(self.rows(i), self.rows(i))
    }

    /// Returns N_i,l: the twist propagation inside module `i`, (A.5).
    #[must_use]
    pub fn propagation_within(&self, i: usize) -> Dense<S> {
        self.denoc.propagation.block(self.rows(i), self.rows(i))
    }

    /// Returns N_i,d: the joint-motion propagations of the joints of module `i`, (A.5).
    #[must_use]
    pub fn joint_motion_propagation(&self, i: usize) -> Dense<S> {
        self.denoc.joints.block(self.rows(i), self.entries(i))
    }

    /// Returns the module-joint-motion propagation N_i = N_i,l N_i,d, (A.4), (A.7).
    #[must_use]
    pub fn joints(&self, i: usize) -> Dense<S> {
        self.propagation_within(i).times(&self.joint_motion_propagation(i))
    }

    /// Returns the module-twist propagation A_j,i, (A.7): from the last link of module `i` to the
    /// links of module `j`. It is the identity for i = j, and zero if `j` is not a descendant of
    /// `i`.
    #[must_use]
    pub fn propagation(&self, j: usize, i: usize) -> Dense<S> {
        let columns = self.rows(i);
        let rows = self.rows(j);
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

    /// Returns M of all modules, (1).
    #[must_use]
    pub fn masses(&self) -> &Dense<S> {
        &self.denoc.mass
    }

    /// Returns N_l of all modules, (4), (A.12).
    #[must_use]
    pub fn propagations(&self) -> Dense<S> {
        let size = self.denoc.mass.rows;
        self.assembled(size, size, Self::rows, Self::rows, Self::propagation)
    }

    /// Returns N_d of all modules, (4).
    #[must_use]
    pub fn all_joints(&self) -> Dense<S> {
        let rows = self.denoc.joints.rows;
        let columns = self.denoc.joints.columns;
        let mut matrix = Dense::zero(rows, columns);
        for i in 0..self.modules() {
            matrix.set_block(self.rows(i).start, self.entries(i).start, &self.joints(i));
        }
        matrix
    }

    /// Returns the mass matrix of the composite module `i`, from the mass matrices of its children,
    /// (8).
    #[must_use]
    pub fn composite(&self, i: usize) -> Dense<S> {
        let children = (0..self.modules()).filter(|&j| self.parents[j] == Some(i));
        children.fold(self.mass(i), |sum, j| {
            sum.plus(&self.composite(j).congruence(&self.propagation(j, i)))
        })
    }

    /// Returns the block element I_i,j of the mass matrix, (10), for `i` equal to `j` or a
    /// descendant of `j`. Diagonal blocks include the rotors.
    #[must_use]
    pub fn mass_matrix_block(&self, i: usize, j: usize) -> Dense<S> {
        let wrenches = self.composite(i).times(&self.propagation(i, j)).times(&self.joints(j));
        let block = self.joints(i).transposed().times(&wrenches);
        if i == j { block.plus(&self.rotor_block(i)) } else { block }
    }

    /// Returns the mass matrix, assembled from its blocks, (9).
    #[must_use]
    pub fn mass_matrix(&self) -> Dense<S> {
        let n = self.denoc.joints.columns;
        self.assembled(n, n, Self::entries, Self::entries, |s, i, j| {
            if i >= j { s.mass_matrix_block(i, j) } else { s.mass_matrix_block(j, i).transposed() }
        })
    }

    /// Returns a matrix assembled from one block for each pair of modules.
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

    /// Returns the mass matrix M_hat_i of the articulated module `i`, (48).
    #[must_use]
    pub fn articulated(&self, i: usize) -> &Dense<S> {
        &self.articulated[i].mass
    }

    /// Returns Psi_i = M_hat_i N_i, (47).
    #[must_use]
    pub fn psi(&self, i: usize) -> &Dense<S> {
        &self.articulated[i].psi
    }

    /// Returns the block pivot I_hat_i = N_i^T M_hat_i N_i, (46): the mass matrix of the
    /// articulated module.
    #[must_use]
    pub fn pivot(&self, i: usize) -> &Dense<S> {
        &self.articulated[i].pivot
    }

    /// Returns the matrix of the articulated-module transformation Phi_i, (49).
    #[must_use]
    pub fn phi(&self, i: usize) -> Dense<S> {
        let Articulated { psi, pivot_inverse, .. } = &self.articulated[i];
        phi(psi, pivot_inverse, &self.joints(i))
    }

    /// Returns the articulated module-twist propagation A_hat_j,i, (56)-(57): through the modules
    /// between `i` and `j`, with their joints free.
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

    /// Returns N_i^T X^T Psi_j I_hat_j^-1, the common factor of (46) and (55).
    fn coefficient(&self, i: usize, j: usize, propagation: &Dense<S>) -> Dense<S> {
        let Articulated { psi, pivot_inverse, .. } = &self.articulated[j];
        propagation.times(&self.joints(i)).transposed().times(&psi.times(pivot_inverse))
    }

    /// Returns the block coefficient U_i,j, (46).
    #[must_use]
    pub fn u_block(&self, i: usize, j: usize) -> Dense<S> {
        self.coefficient(i, j, &self.propagation(j, i))
    }

    /// Returns the block U_hat_i,j of U^-1, (55).
    #[must_use]
    pub fn u_inverse_block(&self, i: usize, j: usize) -> Dense<S> {
        let coefficient = self.coefficient(i, j, &self.articulated_propagation(j, i));
        Dense::zero(coefficient.rows, coefficient.columns).minus(&coefficient)
    }

    /// Returns the elementary block upper triangular matrix (EBUTM) of block column `j`, (36).
    #[must_use]
    pub fn ebutm(&self, j: usize) -> Dense<S> {
        let n = self.denoc.joints.columns;
        let annihilated = self.u_column(j).times(&self.unit_column(j).transposed());
        Dense::identity(n).minus(&annihilated)
    }

    /// Returns the inverse of the EBUTM of block column `j`, (40).
    #[must_use]
    pub fn ebutm_inverse(&self, j: usize) -> Dense<S> {
        let n = self.denoc.joints.columns;
        let annihilated = self.u_column(j).times(&self.unit_column(j).transposed());
        Dense::identity(n).plus(&annihilated)
    }

    /// Returns U'_j, (37): the blocks U_i,j above the diagonal.
    #[must_use]
    pub fn u_column(&self, j: usize) -> Dense<S> {
        let mut column = Dense::zero(self.denoc.joints.columns, self.dofs[j].len());
        for i in (0..j).filter(|&i| self.descends_from(j, i)) {
            column.set_block(self.dofs[i].start, 0, &self.u_block(i, j));
        }
        column
    }

    /// Returns V_j, (38): the identity in the rows of module `j`.
    #[must_use]
    pub fn unit_column(&self, j: usize) -> Dense<S> {
        let mut column = Dense::zero(self.denoc.joints.columns, self.dofs[j].len());
        column.set_block(self.dofs[j].start, 0, &Dense::identity(self.dofs[j].len()));
        column
    }

    /// Returns U, assembled from its blocks, (43).
    #[must_use]
    pub fn u(&self) -> Dense<S> {
        self.triangular(Self::u_block)
    }

    /// Returns U^-1, assembled from its blocks, (54).
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

    /// Returns D, (45).
    #[must_use]
    pub fn d(&self) -> Dense<S> {
        self.diagonal(|articulated| &articulated.pivot)
    }

    /// Returns D^-1, (54).
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

    /// Returns the mass matrix I^(j) during the elimination, (16), (35): block columns from `j` on
    /// are zero above the diagonal. With `j` equal to the number of modules it is the mass matrix
    /// itself.
    #[must_use]
    pub fn eliminated(&self, j: usize) -> Dense<S> {
        (j..self.modules())
            .rev()
            .fold(self.mass_matrix(), |mass_matrix, column| self.ebutm(column).times(&mass_matrix))
    }
}

/// Returns 1 - Psi I_hat^-1 N^T.
fn phi<S: Scalar>(psi: &Dense<S>, pivot_inverse: &Dense<S>, joints: &Dense<S>) -> Dense<S> {
    let taken = psi.times(pivot_inverse).times(&joints.transposed());
    Dense::identity(taken.rows).minus(&taken)
}
