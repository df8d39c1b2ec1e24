//! The graphs of dynamics: forces, accelerations and the mass matrix, with limbs or columns in
//! lanes.

use modyn_runtime::Scalar;
use modyn_runtime::equations::dynamics::{
    Elimination, forward_dynamics, gravity_torques, mass_matrix, recursive_forward_dynamics,
    recursive_newton_euler,
};
use modyn_runtime::equations::{ForwardInput, State, Workspace};

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the accelerations, with this solver. Inputs: `q`, `qd`, `tau`.
    #[must_use]
    pub fn forward_dynamics(&self, elimination: &Elimination) -> Graph {
        let Elimination::Recursive(partition) = elimination else {
            return self.trace(|model, [q, qd, tau]| {
                let mut qdd = self.vector();
                let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
                let workspace = &mut Workspace::new(model);
                forward_dynamics(model, elimination, input, None, workspace, &mut qdd);
                qdd
            });
        };
        self.trace_joints(1, |model, [q, qd, tau]| {
            let mut qdd = vec![Expr::zero(); model.nv()];
            let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
            let workspace = &mut Workspace::new(model);
            recursive_forward_dynamics(model, partition, input, workspace, &mut qdd);
            qdd
        })
    }

    /// Returns the graph of the joint forces. Inputs: `q`, `qd`, `qdd`.
    #[must_use]
    pub fn inverse_dynamics(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd, qdd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let state = State { q: &q, qd: &qd };
            let workspace = &mut Workspace::new(model);
            recursive_newton_euler(model, state, Some(&qdd), workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the bias forces. Inputs: `q`, `qd`.
    #[must_use]
    pub fn bias_forces(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let state = State { q: &q, qd: &qd };
            let workspace = &mut Workspace::new(model);
            recursive_newton_euler(model, state, None, workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the gravity torques. Inputs: `q`.
    #[must_use]
    pub fn gravity_torques(&self) -> Graph {
        self.trace_joints(1, |model, [q]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            gravity_torques(model, &q, &mut Workspace::new(model), &mut tau);
            tau
        })
    }

    /// Returns the graph of the mass matrix by columns. Inputs: `q`.
    #[must_use]
    pub fn mass_matrix(&self) -> Graph {
        self.trace_joints(0, |model, [q]| {
            let mut columns = vec![Expr::zero(); model.nv() * model.nv()];
            let workspace = &mut Workspace::new(model);
            mass_matrix(model, &q, workspace, &mut columns);
            columns
        })
    }
}
