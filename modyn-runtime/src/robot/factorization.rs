//! The factorization of a robot's mass matrix.

use core::convert::Infallible;
use core::marker::PhantomData;

use crate::Scalar;

/// The factorization M = U D U^T of a mass matrix by kinematic modules, (35)-(57) of the paper.
pub trait Factorization<T: Scalar> {
    /// The type of joint vectors.
    type V;
    /// The type of matrices: an array of columns.
    type M;

    /// Returns the block upper triangular U, (43).
    fn u(&self) -> Self::M;
    /// Returns the block diagonal D, (45).
    fn d(&self) -> Self::M;
    /// Returns U^-1, (54).
    fn u_inverse(&self) -> Self::M;
    /// Returns D^-1, (54).
    fn d_inverse(&self) -> Self::M;
    /// Returns the solution x of M x = `rhs`, with the mass matrix M, by the three steps of
    /// equation 60 of the paper.
    fn solve(&self, rhs: &Self::V) -> Self::V;
    /// Returns the inverse of the mass matrix, (50).
    fn inverse(&self) -> Self::M;
    /// Returns the natural logarithm of the mass matrix's determinant.
    fn log_determinant(&self) -> T;
    /// Returns the condition number (2-norm) of module `module`'s pivot block; `None` if there is
    /// no such module.
    fn condition_number(&self, module: usize) -> Option<T>;
}

/// The type of a factorization that was not generated. It has no values.
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
