//! Derivatives of inverse and forward dynamics.

use modyn_runtime::Scalar;
use modyn_runtime::equations::Workspace;
use modyn_runtime::equations::brge::Layout;
use modyn_runtime::equations::derivatives::{self, ForwardDerivatives};

use super::Tracer;
use crate::expr::{Expr, Graph};

impl Tracer<'_> {
    /// The derivatives of the torques from `q`, `qd`, `qdd`: by q, then by qd, column by column.
    #[must_use]
    pub fn inverse_dynamics_derivatives(&self) -> Graph {
        self.trace(|model, [q, qd, qdd]| {
            let (mut dq, mut dqd) = (self.square(), self.square());
            let (motion, workspace) = ((&*q, &*qd, &*qdd), &mut Workspace::new(model));
            let derive = derivatives::inverse_dynamics_derivatives;
            derive(model, motion, workspace, &mut dq, &mut dqd);
            [dq, dqd].concat()
        })
    }

    /// The accelerations from `q`, `qd`, `tau` and their derivatives by q, qd and tau, column by
    /// column, through the factors of the GIM in this layout.
    #[must_use]
    pub fn forward_dynamics_derivatives(&self, layout: &Layout) -> Graph {
        self.trace(|model, [q, qd, tau]| {
            let mut qdd = self.vector();
            let (mut dq, mut dqd, mut dtau) = (self.square(), self.square(), self.square());
            let outputs = ForwardDerivatives {
                qdd: &mut qdd,
                dqdd_dq: &mut dq,
                dqdd_dqd: &mut dqd,
                dqdd_dtau: &mut dtau,
            };
            let (state, workspace) = ((&*q, &*qd, &*tau), &mut Workspace::new(model));
            derivatives::forward_dynamics_derivatives(model, layout, state, workspace, outputs);
            [qdd, dq, dqd, dtau].concat()
        })
    }

    /// Room for a matrix of nv x nv numbers.
    fn square(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nv * self.model.nv]
    }
}
