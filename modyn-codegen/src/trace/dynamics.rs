//! The graphs of dynamics: forces, accelerations, the mass matrix and energies.

use modyn_runtime::Scalar;
use modyn_runtime::equations::derivatives::generalized_forces;
use modyn_runtime::equations::dynamics::{
    Elimination, forward_dynamics, gravity_torques, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy, recursive_forward_dynamics, recursive_newton_euler,
};
use modyn_runtime::equations::kinematics::Axes;
use modyn_runtime::equations::{Forces, Workspace};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::spatial::Wrench;

use super::Tracer;
use crate::graph::{Expr, Graph};

fn in_axes(forces: &[Wrench<Expr>], axes: Axes) -> Forces<'_, Expr> {
    match axes {
        Axes::Link => Forces::InLinkAxes(forces),
        Axes::World => Forces::InWorldAxes(forces),
    }
}

/// Returns the wrenches with these numbers, six each.
fn wrenches(numbers: &[Expr]) -> Vec<Wrench<Expr>> {
    let wrench = |six: &[Expr]| Wrench::from_components(std::array::from_fn(|i| six[i]));
    numbers.chunks(6).map(wrench).collect()
}

impl Tracer<'_> {
    /// Returns the graph of the accelerations, with this solver. Inputs: `q`, `qd`, `tau`.
    #[must_use]
    pub fn forward_dynamics(&self, elimination: &Elimination) -> Graph {
        let Elimination::Recursive(partition) = elimination else {
            return self.trace(|model, [q, qd, tau]| {
                let mut qdd = self.vector();
                let (state, workspace) = ((&*q, &*qd, &*tau), &mut Workspace::new(model));
                forward_dynamics(model, elimination, state, None, workspace, &mut qdd);
                qdd
            });
        };
        self.trace_joints(1, |model, [q, qd, tau]| {
            let mut qdd = vec![Expr::zero(); model.nv()];
            let (state, workspace) = ((&*q, &*qd, &*tau), &mut Workspace::new(model));
            recursive_forward_dynamics(model, partition, state, workspace, &mut qdd);
            qdd
        })
    }

    /// Returns the graph of the joint forces. Inputs: `q`, `qd`, `qdd`.
    #[must_use]
    pub fn inverse_dynamics(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd, qdd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let (motion, workspace) = ((&*q, &*qd, Some(&*qdd)), &mut Workspace::new(model));
            recursive_newton_euler(model, motion, workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the accelerations under external wrenches. Inputs: `q`, `qd`, `tau`, and six numbers (moment,
    /// force) for each link of the description.
    #[must_use]
    pub fn forward_dynamics_external(&self, elimination: &Elimination, axes: Axes) -> Graph {
        self.with_forces(|model, [q, qd, tau], forces| {
            let mut qdd = self.vector();
            let (state, workspace) = ((q, qd, tau), &mut Workspace::new(model));
            let solve = forward_dynamics;
            solve(model, elimination, state, Some(in_axes(forces, axes)), workspace, &mut qdd);
            qdd
        })
    }

    /// Returns the graph of the joint forces under external wrenches. Inputs: `q`, `qd`, `qdd`, and six numbers for each
    /// link of the description.
    #[must_use]
    pub fn inverse_dynamics_external(&self, axes: Axes) -> Graph {
        self.with_forces(|model, [q, qd, qdd], forces| {
            let mut tau = self.vector();
            let (motion, workspace) = ((q, qd, Some(qdd)), &mut Workspace::new(model));
            let forces = Some(in_axes(forces, axes));
            inverse_dynamics(model, motion, forces, workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the generalized forces of external wrenches, and of their derivatives by q, by columns. Inputs:
    /// `q`, and six numbers (moment, force) for each link of the description.
    #[must_use]
    pub fn generalized_forces(&self, axes: Axes) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, 6 * self.model.frames.len()], |model, [q, forces]| {
            let (forces, workspace) = (wrenches(&forces), &mut Workspace::new(model));
            let (mut tau, mut dq) = (self.vector(), vec![Expr::zero(); nv * nv]);
            let motion = (&*q, in_axes(&forces, axes));
            generalized_forces(model, motion, workspace, (&mut tau, &mut dq));
            [tau, dq].concat()
        })
    }

    fn with_forces(
        &self,
        equations: impl FnOnce(&Mechanism<Expr>, [&[Expr]; 3], &[Wrench<Expr>]) -> Vec<Expr>,
    ) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 6 * self.model.frames.len()], |model, [q, a, b, forces]| {
            equations(model, [&q, &a, &b], &wrenches(&forces))
        })
    }

    /// Returns the graph of the bias forces. Inputs: `q`, `qd`.
    #[must_use]
    pub fn bias_forces(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let (motion, workspace) = ((&*q, &*qd, None), &mut Workspace::new(model));
            recursive_newton_euler(model, motion, workspace, &mut tau);
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

    /// Returns the graph of the kinetic energy. Inputs: `q`, `qd`.
    #[must_use]
    pub fn kinetic_energy(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut Workspace::new(model);
            vec![kinetic_energy(model, &q, &qd, workspace)]
        })
    }

    /// Returns the graph of the potential energy. Inputs: `q`.
    #[must_use]
    pub fn potential_energy(&self) -> Graph {
        self.trace(|model, [q]| vec![potential_energy(model, &q, &mut Workspace::new(model))])
    }
}
