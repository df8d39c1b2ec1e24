//! The contracted Hessian of forward dynamics with loop constraints and contacts: its first
//! derivatives on numbers with a derivative.

use alloc::{vec, vec::Vec};

use super::Interpreter;
use super::errors::{ShapeError, check};
use super::hessians::{Gradients, add_weighted, matrices};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::equations::brge::UduLayout;
use crate::equations::constraints::{
    self, ConstrainedCotangent, ConstrainedDerivatives, ConstrainedOutputs, ConstraintInput,
    ConstraintWorkspaces,
};
use crate::equations::{ConstraintWorkspace, ForwardInput, Workspace};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::scalar::Tangent;
use crate::spatial::{Twist, Wrench};

/// The results of [`Interpreter::constrained_forward_dynamics_hessian`].
#[derive(Debug)]
pub struct ConstrainedHessianOutputs<'a, S> {
    /// The joint accelerations: nv entries.
    pub qdd: &'a mut [S],
    /// The wrench of each constraint, in the axes of
    /// [`constrained_forward_dynamics`](Interpreter::constrained_forward_dynamics).
    pub wrenches: &'a mut [Wrench<S>],
    /// The gradients with respect to q (in the tangent space), qd and tau: nv entries each.
    pub gradients: [&'a mut [S]; 3],
    /// The second derivatives with respect to q and q, q and qd, qd and qd, q and tau: nv x nv
    /// matrices by columns. The second of the two variables has the columns.
    pub hessian: [&'a mut [S]; 4],
}

impl<S: Scalar> Interpreter<S> {
    /// Computes the accelerations qdd and the wrenches of
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics), and the gradients and
    /// the Hessian of their sum with weights, with respect to q (in the tangent space), qd and tau.
    /// Returns the number of independent constraint rows, an integer. The weights are `cotangent`
    /// for the accelerations, and `wrench_cotangent` for the components of the wrenches: in the
    /// first frame's axes for loop constraints, in world axes for contacts. The blocks of qd and
    /// tau, and of tau and tau, are zero.
    ///
    /// The rank is assumed constant, and rows not to contradict each other at this state and near
    /// it to first order. Rows may depend on others, as the rows of a hinge of a planar loop or of
    /// four feet on one body, where `wrench_cotangent` is zero: the accelerations do not depend on
    /// how such rows share the load. Weights of wrenches need independent rows, or compliance.
    /// Takes more than 2 nv times as long as the first derivatives, and allocates memory at each
    /// call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_forward_dynamics_hessian(
        &mut self,
        input: ForwardInput<'_, S>,
        cotangent: ConstrainedCotangent<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedHessianOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        let count = self.model.constraints();
        self.check_forward_input(input)?;
        self.check_vectors(&[("qdd", outputs.qdd)])?;
        check("wrenches", outputs.wrenches, count)?;
        self.check_vectors(&[("cotangent", cotangent.qdd)])?;
        check("wrench_cotangent", cotangent.wrenches, count)?;
        self.check_vectors(&outputs.gradients.each_ref().map(|x| ("gradients", &**x)))?;
        self.check_hessian(&outputs.hessian)?;
        self.set_active(active, settings)?;
        Ok(self.solve_hessian(input, cotangent, settings, outputs))
    }

    /// Computes the Hessian with the set of active contacts that was stored last. Lengths are not
    /// checked.
    pub(crate) fn solve_hessian(
        &mut self,
        ForwardInput { q, qd, tau }: ForwardInput<'_, S>,
        cotangent: ConstrainedCotangent<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedHessianOutputs<'_, S>,
    ) -> S {
        let ConstrainedHessianOutputs { qdd, wrenches, gradients, hessian } = outputs;
        let n = self.model.nv();
        let count = self.model.constraints();
        let residuals = &mut vec![Twist::zero(); count];
        let value = ConstrainedOutputs { qdd, wrenches, residuals };
        let rank = self.solve_constrained(ForwardInput { q, qd, tau }, settings, value);

        let mechanism = self.mechanism.map(Tangent::constant);
        let layout = UduLayout::new(&mechanism, &ModuleTree::links(&self.model));
        let mut memory = ConstraintWorkspace::new(&mechanism, &layout);
        let workspace = &mut Workspace::new(&mechanism);
        let in_tangents = |target: &ContactTarget<S>| {
            ContactTarget::from_numbers(target.numbers().map(Tangent::constant))
        };
        let targets: Vec<_> = settings.targets.as_ref().iter().map(in_tangents).collect();
        let settings =
            ConstraintSettings::from_numbers(settings.numbers().map(Tangent::constant), targets);
        let active: Vec<Tangent<S>> =
            self.active.iter().map(|&active| Tangent::constant(active)).collect();
        let mut jacobians = matrices(n);
        let mut changes: [Vec<Wrench<Tangent<S>>>; 3] =
            core::array::from_fn(|_| vec![Wrench::zero(); n * count]);
        let mut qdd = vec![Tangent::zero(); n];
        let mut wrenches = vec![Wrench::zero(); count];
        let mut derive = |model: &Mechanism<_>, [q, qd, tau]: [&[_]; 3], by: &mut Gradients<S>| {
            let outputs =
                ConstrainedDerivatives::new(&mut qdd, &mut wrenches, &mut jacobians, &mut changes);
            let workspaces = ConstraintWorkspaces { workspace, memory: &mut memory };
            let constraints = ConstraintInput { active: &active, settings: &settings };
            let input = ForwardInput { q, qd, tau };
            constraints::constrained_forward_dynamics_derivatives(
                model,
                &layout,
                input,
                constraints,
                workspaces,
                outputs,
            );
            add_weighted(&jacobians, cotangent.qdd, by);
            for (changes, gradient) in changes.iter().zip(by) {
                for (of_constraint, weights) in changes.chunks(n.max(1)).zip(cotangent.wrenches) {
                    for (change, entry) in of_constraint.iter().zip(&mut *gradient) {
                        let products = change.components().into_iter().zip(weights.components());
                        *entry =
                            products.fold(*entry, |sum, (x, w)| sum + x * Tangent::constant(w));
                    }
                }
            }
        };
        let constant =
            |x: &[S]| -> Vec<Tangent<S>> { x.iter().map(|&x| Tangent::constant(x)).collect() };
        let mut by: Gradients<S> = core::array::from_fn(|_| vec![Tangent::zero(); n]);
        derive(&mechanism, [&constant(q), &constant(qd), &constant(tau)], &mut by);
        for (gradient, jacobians) in gradients.into_iter().zip(&by) {
            gradient.iter_mut().zip(jacobians).for_each(|(entry, value)| *entry = value.x);
        }
        self.differentiate([q, qd, tau], derive, hessian);
        rank
    }
}
