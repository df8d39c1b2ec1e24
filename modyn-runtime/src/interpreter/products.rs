//! Products with the derivatives of inverse and forward dynamics, by the matrices. Generated
//! functions need no matrices.

use alloc::{vec, vec::Vec};

use super::errors::ShapeError;
use super::{ForwardDerivatives, Interpreter};
use crate::Scalar;
use crate::equations::{ForwardInput, Motion};

impl<S: Scalar> Interpreter<S> {
    /// Computes the joint forces tau of the accelerations `qdd`, and the gradients of `cotangent`^T
    /// tau with respect to q (in the tangent space), qd and qdd, nv entries each. Allocates memory
    /// for the matrices.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_vjp(
        &mut self,
        motion: Motion<'_, S>,
        cotangent: &[S],
        tau: &mut [S],
        [grad_q, grad_qd, grad_qdd]: [&mut [S]; 3],
    ) -> Result<(), ShapeError> {
        let by = self.inverse_matrices(motion, tau)?;
        self.check_vectors(&[
            ("cotangent", cotangent),
            ("grad_q", grad_q),
            ("grad_qd", grad_qd),
            ("grad_qdd", grad_qdd),
        ])?;
        for (by, out) in by.iter().zip([grad_q, grad_qd, grad_qdd]) {
            multiply_transposed(by, cotangent, out);
        }
        Ok(())
    }

    /// Computes the joint forces tau of the accelerations `qdd`, and their change under changes of
    /// q (in the tangent space), qd and qdd. Allocates memory for the matrices.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_jvp(
        &mut self,
        motion: Motion<'_, S>,
        [tangent_q, tangent_qd, tangent_qdd]: [&[S]; 3],
        tau: &mut [S],
        tangent_tau: &mut [S],
    ) -> Result<(), ShapeError> {
        let by = self.inverse_matrices(motion, tau)?;
        self.check_vectors(&[
            ("tangent_q", tangent_q),
            ("tangent_qd", tangent_qd),
            ("tangent_qdd", tangent_qdd),
            ("tangent_tau", tangent_tau),
        ])?;
        multiply(&by, [tangent_q, tangent_qd, tangent_qdd], tangent_tau);
        Ok(())
    }

    /// Computes the accelerations qdd under the joint forces `tau`, and the gradients of
    /// `cotangent`^T qdd with respect to q (in the tangent space), qd and tau, nv entries each.
    /// Allocates memory for the matrices.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_vjp(
        &mut self,
        input: ForwardInput<'_, S>,
        cotangent: &[S],
        qdd: &mut [S],
        [grad_q, grad_qd, grad_tau]: [&mut [S]; 3],
    ) -> Result<(), ShapeError> {
        let by = self.forward_matrices(input, qdd)?;
        self.check_vectors(&[
            ("cotangent", cotangent),
            ("grad_q", grad_q),
            ("grad_qd", grad_qd),
            ("grad_tau", grad_tau),
        ])?;
        for (by, out) in by.iter().zip([grad_q, grad_qd, grad_tau]) {
            multiply_transposed(by, cotangent, out);
        }
        Ok(())
    }

    /// Computes the accelerations qdd under the joint forces `tau`, and their change under changes
    /// of q (in the tangent space), qd and tau. Allocates memory for the matrices.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_jvp(
        &mut self,
        input: ForwardInput<'_, S>,
        [tangent_q, tangent_qd, tangent_tau]: [&[S]; 3],
        qdd: &mut [S],
        tangent_qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        let by = self.forward_matrices(input, qdd)?;
        self.check_vectors(&[
            ("tangent_q", tangent_q),
            ("tangent_qd", tangent_qd),
            ("tangent_tau", tangent_tau),
            ("tangent_qdd", tangent_qdd),
        ])?;
        multiply(&by, [tangent_q, tangent_qd, tangent_tau], tangent_qdd);
        Ok(())
    }

    /// Computes the joint forces, and returns their derivatives with respect to q, qd and qdd.
    fn inverse_matrices(
        &mut self,
        Motion { q, qd, qdd }: Motion<'_, S>,
        tau: &mut [S],
    ) -> Result<[Vec<S>; 3], ShapeError> {
        let mut by = self.matrices();
        let [dq, dqd, dqdd] = &mut by;
        self.inverse_dynamics(q, qd, qdd, tau)?;
        self.inverse_dynamics_derivatives(q, qd, qdd, dq, dqd)?;
        self.mass_matrix(q, dqdd)?;
        Ok(by)
    }

    /// Computes the accelerations, and returns their derivatives with respect to q, qd and tau.
    fn forward_matrices(
        &mut self,
        ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
        qdd: &mut [S],
    ) -> Result<[Vec<S>; 3], ShapeError> {
        let mut by = self.matrices();
        let [dqdd_dq, dqdd_dqd, dqdd_dtau] = &mut by;
        let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
        self.forward_dynamics_derivatives(q, qd, tau, outputs)?;
        Ok(by)
    }

    fn matrices(&self) -> [Vec<S>; 3] {
        core::array::from_fn(|_| vec![S::zero(); self.model.nv() * self.model.nv()])
    }
}

/// Computes the transposed matrix, stored by columns, times `x`.
fn multiply_transposed<S: Scalar>(columns: &[S], x: &[S], out: &mut [S]) {
    for (out, column) in out.iter_mut().zip(columns.chunks(x.len().max(1))) {
        *out = column.iter().zip(x).fold(S::zero(), |sum, (&a, &x)| sum + a * x);
    }
}

/// Computes the sum of the products of three matrices, stored by columns, and vectors.
fn multiply<S: Scalar>(matrices: &[Vec<S>; 3], vectors: [&[S]; 3], out: &mut [S]) {
    out.fill(S::zero());
    for (columns, x) in matrices.iter().zip(vectors) {
        for (column, &x) in columns.chunks(x.len().max(1)).zip(x) {
            for (out, &a) in out.iter_mut().zip(column) {
                *out = *out + a * x;
            }
        }
    }
}
