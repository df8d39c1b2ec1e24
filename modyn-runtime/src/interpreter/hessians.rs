//! Contracted Hessians: the first derivatives on numbers with a derivative, once along each
//! displacement of q and qd. Generated functions differentiate graphs instead, and need far fewer
//! operations.

use alloc::{vec, vec::Vec};

use super::errors::{ShapeError, check};
use super::{ForwardDerivatives, Interpreter, StepOutputs};
use crate::Scalar;
use crate::equations::brge::UduLayout;
use crate::equations::dynamics::mass_matrix;
use crate::equations::kinematics::coordinates::velocity_to_qdot;
use crate::equations::steps::step_semi_implicit_derivatives;
use crate::equations::{
    ForwardInput, Motion, StepWorkspace, TimeStepInput, Workspace, derivatives,
};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::scalar::Tangent;

/// The results of [`Interpreter::inverse_dynamics_hessian`] and
/// [`Interpreter::forward_dynamics_hessian`]. The third variable is qdd of inverse dynamics, tau of
/// forward dynamics.
#[derive(Debug)]
pub struct HessianOutputs<'a, S> {
    /// The joint forces tau of inverse dynamics, or the accelerations qdd of forward dynamics: nv
    /// entries.
    pub value: &'a mut [S],
    /// The gradients with respect to q (in the tangent space), qd and the third variable: nv
    /// entries each.
    pub gradients: [&'a mut [S]; 3],
    /// The second derivatives with respect to q and q, q and qd, qd and qd, q and the third
    /// variable: nv x nv matrices by columns. The second of the two variables has the columns.
    pub hessian: [&'a mut [S]; 4],
}

/// The results of [`Interpreter::step_semi_implicit_hessian`]. A state has the nv entries of q (in
/// the tangent space), then the entries of qd. Matrices are stored by columns.
#[derive(Debug)]
pub struct StepHessianOutputs<'a, S> {
    /// The coordinates after the step.
    pub q: &'a mut [S],
    /// The velocities after the step.
    pub qd: &'a mut [S],
    /// The gradient with respect to the state before the step: 2 nv entries.
    pub grad_x: &'a mut [S],
    /// The gradient with respect to tau: nv entries.
    pub grad_tau: &'a mut [S],
    /// The second derivatives with respect to the state before the step: 2 nv columns of 2 nv
    /// entries.
    pub hess_x_x: &'a mut [S],
    /// The second derivatives with respect to the state before the step and tau: nv columns of 2 nv
    /// entries.
    pub hess_x_tau: &'a mut [S],
    /// The second derivatives with respect to tau: nv columns of nv entries.
    pub hess_tau_tau: &'a mut [S],
}

/// The gradients of a weighted sum with respect to q, qd and the third variable.
pub(super) type Gradients<S> = [Vec<Tangent<S>>; 3];

/// Adds to the gradients the gradients of the sum of a function's results with these weights;
/// `matrices` are the derivatives of the function with respect to each variable, by columns.
pub(super) fn add_weighted<S: Scalar>(
    matrices: &[Vec<Tangent<S>>; 3],
    weights: &[S],
    gradients: &mut Gradients<S>,
) {
    for (matrix, gradient) in matrices.iter().zip(gradients) {
        for (column, entry) in matrix.chunks(weights.len().max(1)).zip(gradient) {
            let products = column.iter().zip(weights);
            *entry = products.fold(*entry, |sum, (&x, &w)| sum + x * Tangent::constant(w));
        }
    }
}

/// Returns memory for nv x nv matrices.
pub(super) fn matrices<S: Scalar>(n: usize) -> [Vec<Tangent<S>>; 3] {
    core::array::from_fn(|_| vec![Tangent::zero(); n * n])
}

impl<S: Scalar> Interpreter<S> {
    /// Computes the joint forces tau of the accelerations `qdd`, and the gradients and the Hessian
    /// of `cotangent`^T tau with respect to q (in the tangent space), qd and qdd. The blocks of qd
    /// and qdd, and of qdd and qdd, are zero.
    ///
    /// The second derivatives with respect to q are those along [`integrate`](Self::integrate), and
    /// symmetric. Takes more than 2 nv times as long as the first derivatives, and allocates memory
    /// at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_hessian(
        &mut self,
        Motion { q, qd, qdd }: Motion<'_, S>,
        cotangent: &[S],
        outputs: HessianOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        let HessianOutputs { value, gradients, hessian } = outputs;
        self.check_hessian(&hessian)?;
        self.inverse_dynamics_vjp(Motion { q, qd, qdd }, cotangent, value, gradients)?;
        let mut jacobians = matrices(self.model.nv());
        let derive = |model: &Mechanism<_>, [q, qd, qdd]: [&[_]; 3], by: &mut Gradients<S>| {
            let [dtau_dq, dtau_dqd, dtau_dqdd] = &mut jacobians;
            let workspace = &mut Workspace::new(model);
            derivatives::inverse_dynamics_derivatives(
                model,
                Motion { q, qd, qdd },
                workspace,
                dtau_dq,
                dtau_dqd,
            );
            mass_matrix(model, q, workspace, dtau_dqdd);
            add_weighted(&jacobians, cotangent, by);
        };
        self.differentiate([q, qd, qdd], derive, hessian);
        Ok(())
    }

    /// Computes the accelerations qdd under the joint forces `tau`, and the gradients and the
    /// Hessian of `cotangent`^T qdd with respect to q (in the tangent space), qd and tau. The
    /// blocks of qd and tau, and of tau and tau, are zero.
    ///
    /// The second derivatives with respect to q are those along [`integrate`](Self::integrate), and
    /// symmetric. Takes more than 2 nv times as long as the first derivatives, and allocates memory
    /// at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_hessian(
        &mut self,
        ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
        cotangent: &[S],
        outputs: HessianOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        let HessianOutputs { value, gradients, hessian } = outputs;
        self.check_hessian(&hessian)?;
        self.forward_dynamics_vjp(ForwardInput { q, qd, tau }, cotangent, value, gradients)?;
        let layout = UduLayout::new(&self.mechanism, &ModuleTree::links(&self.model));
        let mut jacobians = matrices(self.model.nv());
        let derive = |model: &Mechanism<_>, [q, qd, tau]: [&[_]; 3], by: &mut Gradients<S>| {
            let [dqdd_dq, dqdd_dqd, dqdd_dtau] = &mut jacobians;
            let qdd = &mut vec![Tangent::zero(); model.nv];
            let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
            let workspace = &mut Workspace::new(model);
            let input = ForwardInput { q, qd, tau };
            derivatives::forward_dynamics_derivatives(model, &layout, input, workspace, outputs);
            add_weighted(&jacobians, cotangent, by);
        };
        self.differentiate([q, qd, tau], derive, hessian);
        Ok(())
    }

    /// Computes the state after the time `dt` (s) by the semi-implicit Euler method, and the
    /// gradients and the Hessian of `state_cotangent`^T state with respect to the state before the
    /// step and tau. The first nv entries of `state_cotangent` are the weights of q, the others the
    /// weights of qd.
    ///
    /// The Hessian is taken for displacements along [`integrate`](Self::integrate) before the step
    /// and along [`difference`](Self::difference) after it, both in the tangent space, and
    /// symmetric. Takes more than 3 nv times as long as the first derivatives, and allocates memory
    /// at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_semi_implicit_hessian(
        &mut self,
        TimeStepInput { q, qd, tau, dt }: TimeStepInput<'_, S>,
        state_cotangent: &[S],
        outputs: StepHessianOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        let StepHessianOutputs {
            q: next_q,
            qd: next_qd,
            grad_x,
            grad_tau,
            hess_x_x,
            hess_x_tau,
            hess_tau_tau,
        } = outputs;
        let n = self.model.nv();
        check("state_cotangent", state_cotangent, 2 * n)?;
        check("grad_x", grad_x, 2 * n)?;
        self.check_vectors(&[("grad_tau", grad_tau)])?;
        check("hess_x_x", hess_x_x, 4 * n * n)?;
        check("hess_x_tau", hess_x_tau, 2 * n * n)?;
        self.check_matrices(&[("hess_tau_tau", hess_tau_tau)])?;
        self.step_semi_implicit(TimeStepInput { q, qd, tau, dt }, next_q, next_qd)?;
        let model = self.mechanism.map(Tangent::constant);
        let layout = UduLayout::new(&self.mechanism, &ModuleTree::links(&self.model));
        let workspace = &mut Workspace::new(&model);
        let memory = &mut StepWorkspace::new(&model);
        let numbers = |n: usize| vec![Tangent::<S>::zero(); n];
        let mut results = [numbers(q.len()), numbers(n), numbers(4 * n * n), numbers(2 * n * n)];
        // The changes of the 3 nv entries of the gradient along each of the 3 nv displacements.
        let mut changes = vec![S::zero(); 9 * n * n];
        let mut rates = vec![S::zero(); q.len()];
        for (j, changes) in changes.chunks_mut((3 * n).max(1)).enumerate() {
            let mut unit = vec![S::zero(); 3 * n];
            unit[j] = S::one();
            velocity_to_qdot(&self.mechanism, q, &unit[..n], &mut rates);
            let moved = |x: &[S], dx: &[S]| -> Vec<Tangent<S>> {
                x.iter().zip(dx).map(|(&x, &dx)| Tangent { x, dx }).collect()
            };
            let q = moved(q, &rates);
            let qd = moved(qd, &unit[n..2 * n]);
            let tau = moved(tau, &unit[2 * n..]);
            let [next_q, next_qd, a, b] = &mut results;
            let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
            let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: Tangent::constant(dt) };
            step_semi_implicit_derivatives(&model, &layout, input, workspace, memory, outputs);
            let columns = results[2].chunks(2 * n).chain(results[3].chunks(2 * n));
            for (i, (column, change)) in columns.zip(changes).enumerate() {
                let sum = column
                    .iter()
                    .zip(state_cotangent)
                    .fold(Tangent::zero(), |sum, (entry, &weight)| {
                        sum + *entry * Tangent::constant(weight)
                    });
                *change = sum.dx;
                let gradient = if i < 2 * n { &mut grad_x[i] } else { &mut grad_tau[i - 2 * n] };
                *gradient = sum.x;
            }
        }
        // Displacements do not commute, neither before the step nor after it: the Hessian is the
        // symmetric part.
        let half = S::from_f64(0.5);
        let entry = |i: usize, j: usize| half * (changes[j * 3 * n + i] + changes[i * 3 * n + j]);
        for j in 0..n {
            for i in 0..n {
                hess_tau_tau[j * n + i] = entry(2 * n + i, 2 * n + j);
            }
        }
        for i in 0..2 * n {
            for j in 0..2 * n {
                hess_x_x[j * 2 * n + i] = entry(i, j);
            }
            for j in 0..n {
                hess_x_tau[j * 2 * n + i] = entry(i, 2 * n + j);
            }
        }
        Ok(())
    }

    /// Differentiates gradients along each displacement of q and qd. `derive` adds the gradients to
    /// zeros.
    pub(super) fn differentiate(
        &self,
        [q, qd, last]: [&[S]; 3],
        mut derive: impl FnMut(&Mechanism<Tangent<S>>, [&[Tangent<S>]; 3], &mut Gradients<S>),
        [hess_q_q, hess_q_qd, hess_qd_qd, hess_q_last]: [&mut [S]; 4],
    ) {
        let n = self.model.nv();
        let model = self.mechanism.map(Tangent::constant);
        let mut by: Gradients<S> = core::array::from_fn(|_| vec![Tangent::zero(); n]);
        let constant =
            |x: &[S]| -> Vec<Tangent<S>> { x.iter().map(|&x| Tangent::constant(x)).collect() };
        let still_q = constant(q);
        let still_qd = constant(qd);
        let last = constant(last);
        let mut rates = vec![S::zero(); q.len()];
        let mut unit = vec![S::zero(); n];
        for j in 0..n {
            unit.fill(S::zero());
            unit[j] = S::one();
            velocity_to_qdot(&self.mechanism, q, &unit, &mut rates);
            let moved: Vec<_> = q.iter().zip(&rates).map(|(&x, &dx)| Tangent { x, dx }).collect();
            by.iter_mut().for_each(|gradient| gradient.fill(Tangent::zero()));
            derive(&model, [&moved, &still_qd, &last], &mut by);
            let [by_q, by_qd, by_last] = &by;
            for i in 0..n {
                hess_q_q[j * n + i] = by_q[i].dx;
                hess_q_qd[i * n + j] = by_qd[i].dx;
                hess_q_last[i * n + j] = by_last[i].dx;
            }
            let faster: Vec<_> = qd.iter().zip(&unit).map(|(&x, &dx)| Tangent { x, dx }).collect();
            by.iter_mut().for_each(|gradient| gradient.fill(Tangent::zero()));
            derive(&model, [&still_q, &faster, &last], &mut by);
            let [_, by_qd, _] = &by;
            for i in 0..n {
                hess_qd_qd[j * n + i] = by_qd[i].dx;
            }
        }
        // Displacements of one rotation or pose do not commute: the second derivative along a
        // displacement is the symmetric part.
        let half = S::from_f64(0.5);
        for j in 0..n {
            for i in 0..j {
                let mean = half * (hess_q_q[j * n + i] + hess_q_q[i * n + j]);
                (hess_q_q[j * n + i], hess_q_q[i * n + j]) = (mean, mean);
            }
        }
    }

    pub(super) fn check_hessian(&self, blocks: &[&mut [S]; 4]) -> Result<(), ShapeError> {
        self.check_matrices(&blocks.each_ref().map(|block| ("hessian", &**block)))
    }
}
