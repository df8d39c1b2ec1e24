//! The factorization of a robot's mass matrix.

use core::convert::Infallible;
use core::marker::PhantomData;

use crate::Scalar;

/// The factorization I = U D U^T of a mass matrix by kinematic modules, (35)-(57).
pub trait Factorization<T: Scalar> {
    /// Joint vectors.
    type V;
    /// Matrices, an array of columns.
    type M;

    /// The block upper triangular U, (43).
    fn u(&self) -> Self::M;
    /// The block diagonal D, (45).
    fn d(&self) -> Self::M;
    /// U^-1, (54).
    fn u_inverse(&self) -> Self::M;
    /// D^-1, (54).
    fn d_inverse(&self) -> Self::M;
    /// The x with I x = `rhs`, by the three steps of (60).
    fn solve(&self, rhs: &Self::V) -> Self::V;
    /// The inverse, (50).
    fn inverse(&self) -> Self::M;
    /// The natural logarithm of the determinant.
    fn log_determinant(&self) -> T;
    /// The condition number (2-norm) of module `module`'s pivot block; `None` if there is none.
    fn condition_number(&self, module: usize) -> Option<T>;
}

/// In place of a factorization that a robot was not given; there is no value of it.
#[derive(Clone, Copy, Debug)]
pub struct NotGenerated<V, M>(Infallible, PhantomData<(V, M)>);

impl<T: Scalar, V, M> Factorization<T> for NotGenerated<V, M> {
    type V = V;
    type M = M;
    fn u(&self) -> M {
        match self.0 {}
    }
    fn d(&self) -> M {
        match self.0 {}
    }
    fn u_inverse(&self) -> M {
        match self.0 {}
    }
    fn d_inverse(&self) -> M {
        match self.0 {}
    }
    fn solve(&self, _: &V) -> V {
        match self.0 {}
    }
    fn inverse(&self) -> M {
        match self.0 {}
    }
    fn log_determinant(&self) -> T {
        match self.0 {}
    }
    fn condition_number(&self, _: usize) -> Option<T> {
        match self.0 {}
    }
}
