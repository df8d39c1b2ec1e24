//! The decoupled natural orthogonal complement (DeNOC) matrices, dense, for study: (1)-(5),
//! A.1 and A.2.

use alloc::{vec, vec::Vec};

use super::Workspace;
use crate::Scalar;
use crate::model::prepare::{Body, Prepared};
use crate::spatial::{Matrix3, Twist, Vector3, Wrench};

/// A dense matrix by rows, to be handed to whatever linear algebra is at hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense<S> {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Its entries, row by row.
    pub entries: Vec<S>,
}

impl<S: Scalar> Dense<S> {
    /// All zeros.
    #[must_use]
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: vec![S::zero(); rows * columns] }
    }

    /// The entry in row `i` and column `j`, if it exists.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> Option<S> {
        (j < self.columns).then(|| self.entries.get(i * self.columns + j).copied()).flatten()
    }

    fn transposed(&self) -> Self {
        let mut transposed = Self::zero(self.columns, self.rows);
        for (i, row) in self.entries.chunks(self.columns).enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                transposed.set(j, i, entry);
            }
        }
        transposed
    }

    /// The product; the sizes fit.
    fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.rows, other.columns);
        let rows = product.entries.chunks_mut(other.columns).zip(self.entries.chunks(self.columns));
        for (sums, row) in rows {
            for (&factor, terms) in row.iter().zip(other.entries.chunks(other.columns)) {
                for (sum, &term) in sums.iter_mut().zip(terms) {
                    *sum = *sum + factor * term;
                }
            }
        }
        product
    }

    fn set(&mut self, i: usize, j: usize, value: S) {
        self.entries[i * self.columns + j] = value;
    }

    /// Writes a twist into column `j`, from row `i` down.
    fn set_column(&mut self, i: usize, j: usize, twist: Twist<S>) {
        for (k, entry) in twist.components().into_iter().enumerate() {
            self.set(i + k, j, entry);
        }
    }
}

/// M, N_l and N_d with the GIM = N_d^T N_l^T M N_l N_d, (5a), without the rotors' inertia.
///
/// Rows stand body by body: the links, each in its own frame as the model has it, angular before
/// linear, and before a link on a universal or planar joint the massless bodies inside that joint.
/// Columns of N_d are those of qd. Modules are consecutive links, so these are the module-level
/// matrices of (4) as well.
#[derive(Clone, Debug, PartialEq)]
pub struct DeNoc<S> {
    /// The 6n times 6n mass matrix of the n free bodies, (1)-(2).
    pub mass: Dense<S>,
    /// The 6n times 6n matrix of twist propagations, (A.12).
    pub propagation: Dense<S>,
    /// The 6n times nv matrix of joint-motion propagations, (A.5).
    pub joints: Dense<S>,
}

impl<S: Scalar> DeNoc<S> {
    /// The GIM as (5a) has it, N^T M N with N = N_l N_d: the long way, for study.
    #[must_use]
    pub fn gim(&self) -> Dense<S> {
        let n = self.propagation.times(&self.joints);
        n.transposed().times(&self.mass.times(&n))
    }
}

/// The DeNOC matrices at `q`.
#[must_use]
pub fn denoc<S: Scalar>(model: &Prepared<S>, q: &[S], workspace: &mut Workspace<S>) -> DeNoc<S> {
    workspace.move_to(model, q);
    let n = model.bodies.len();
    let mut mass = Dense::zero(6 * n, 6 * n);
    let mut propagation = Dense::zero(6 * n, 6 * n);
    let mut joints = Dense::zero(6 * n, model.nv);
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let inertia = body.inertia.articulated();
        for dof in model.dofs_of(i) {
            let column = unit(dof.component).scale(dof.scale(S::one()));
            joints.set_column(6 * i, dof.v, to_link(body, column));
        }
        for k in 0..6 {
            propagation.set_column(6 * i, 6 * i + k, unit(k));
            let wrench = wrench_to_link(body, inertia.times(&from_link(body, unit(k))));
            for (row, entry) in wrench.components().into_iter().enumerate() {
                mass.set(6 * i + row, 6 * i + k, entry);
            }
        }
        // A row of blocks is the parent's, carried on: A_ij = A_ip A_pj.
        if let Some(parent) = body.parent {
            for column in 0..6 * (parent + 1) {
                let at = |row: usize| propagation.entries[(6 * parent + row) * 6 * n + column];
                let twist = Twist::from_components(core::array::from_fn(at));
                let at_body = from_link(&model.bodies[parent], twist);
                let carried = to_link(body, body.twist_to_child(motion, at_body));
                propagation.set_column(6 * i, column, carried);
            }
        }
    }
    DeNoc { mass, propagation, joints }
}

/// A unit twist in component `k`.
fn unit<S: Scalar>(k: usize) -> Twist<S> {
    Twist::from_components(core::array::from_fn(|i| if i == k { S::one() } else { S::zero() }))
}

/// A body's twist, at and in the axes of the model's link frame.
fn to_link<S: Scalar>(body: &Body<S>, t: Twist<S>) -> Twist<S> {
    let back = Matrix3(body.link.rotation).transposed();
    let linear = t.linear + t.angular.cross(Vector3(body.link.translation));
    Twist { angular: back.mul_vector(t.angular), linear: back.mul_vector(linear) }
}

/// A twist of the model's link frame, at and in the axes of the body's.
fn from_link<S: Scalar>(body: &Body<S>, t: Twist<S>) -> Twist<S> {
    let rotation = Matrix3(body.link.rotation);
    let angular = rotation.mul_vector(t.angular);
    let shift = angular.cross(Vector3(body.link.translation));
    Twist { angular, linear: rotation.mul_vector(t.linear) - shift }
}

/// A body's wrench, at and in the axes of the model's link frame.
fn wrench_to_link<S: Scalar>(body: &Body<S>, w: Wrench<S>) -> Wrench<S> {
    let back = Matrix3(body.link.rotation).transposed();
    let moment = w.moment - Vector3(body.link.translation).cross(w.force);
    Wrench { moment: back.mul_vector(moment), force: back.mul_vector(w.force) }
}

#[cfg(test)]
mod tests {
    use super::Dense;

    #[test]
    fn entries_are_found_by_row_and_column() {
        let mut matrix = Dense::<f64>::zero(2, 3);
        matrix.set(1, 0, 5.0);
        matrix.set(0, 2, 7.0);
        assert_eq!(matrix.entries, [0.0, 0.0, 7.0, 5.0, 0.0, 0.0]);
        assert_eq!((matrix.get(1, 0), matrix.get(0, 2)), (Some(5.0), Some(7.0)));
        assert_eq!((matrix.get(2, 0), matrix.get(0, 3)), (None, None));
    }

    #[test]
    fn products_are_products() {
        let matrix =
            |rows, columns, entries: &[f64]| Dense { rows, columns, entries: entries.to_vec() };
        let a = matrix(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let b = matrix(3, 1, &[7.0, 8.0, 9.0]);
        assert_eq!(a.times(&b), matrix(2, 1, &[50.0, 122.0]));
        assert_eq!(a.transposed(), matrix(3, 2, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
    }
}
