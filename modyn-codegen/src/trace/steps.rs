//! The graphs of discrete dynamics.

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::steps::{
    StepOutputs, step_implicit_midpoint, step_implicit_midpoint_derivatives, step_rk4,
    step_rk4_derivatives, step_semi_implicit, step_semi_implicit_derivatives,
};
use modyn_runtime::equations::{MidpointWorkspace, RungeKuttaWorkspace, StepWorkspace, Workspace};

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the coordinates and velocities after a semi-implicit Euler step. Inputs: `q`, `qd`, `tau` and
    /// the time.
    #[must_use]
    pub fn step_semi_implicit(&self, elimination: &Elimination) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 1], |model, [q, qd, tau, dt]| {
            let (mut next_q, mut next_qd) = (vec![Expr::zero(); nq], vec![Expr::zero(); nv]);
            let workspaces = (&mut Workspace::new(model), &mut StepWorkspace::new(model));
            let (state, next) = ((&*q, &*qd, &*tau, dt[0]), (&mut *next_q, &mut *next_qd));
            step_semi_implicit(model, elimination, state, workspaces, next);
            [next_q, next_qd].concat()
        })
    }

    /// Returns the graph of the coordinates and velocities after a semi-implicit Euler step, and of their derivatives A and
    /// B by columns. Inputs: `q`, `qd`, `tau` and the time. The mass matrix is factorized with `layout`.
    #[must_use]
    pub fn step_semi_implicit_derivatives(&self, layout: &UduLayout) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 1], |model, [q, qd, tau, dt]| {
            let mut found = [nq, nv, 4 * nv * nv, 2 * nv * nv].map(|n| vec![Expr::zero(); n]);
            let [next_q, next_qd, a, b] = &mut found;
            let workspaces = (&mut Workspace::new(model), &mut StepWorkspace::new(model));
            let state = (&*q, &*qd, &*tau, dt[0]);
            let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
            step_semi_implicit_derivatives(model, layout, state, workspaces, outputs);
            found.concat()
        })
    }

    /// Returns the graph of the coordinates and velocities after a Runge-Kutta step. Inputs: `q`, `qd`, `tau` and the time.
    #[must_use]
    pub fn step_rk4(&self, elimination: &Elimination) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 1], |model, [q, qd, tau, dt]| {
            let (mut next_q, mut next_qd) = (vec![Expr::zero(); nq], vec![Expr::zero(); nv]);
            let workspaces = (&mut Workspace::new(model), &mut StepWorkspace::new(model));
            let (state, next) = ((&*q, &*qd, &*tau, dt[0]), (&mut *next_q, &mut *next_qd));
            step_rk4(model, elimination, state, workspaces, next);
            [next_q, next_qd].concat()
        })
    }

    /// Returns the graph of the coordinates and velocities after a Runge-Kutta step, and of their derivatives A and B by
    /// columns. Inputs: `q`, `qd`, `tau` and the time. The mass matrix is factorized with `layout`.
    #[must_use]
    pub fn step_rk4_derivatives(&self, layout: &UduLayout) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 1], |model, [q, qd, tau, dt]| {
            let mut found = [nq, nv, 4 * nv * nv, 2 * nv * nv].map(|n| vec![Expr::zero(); n]);
            let [next_q, next_qd, a, b] = &mut found;
            let rooms = (&mut Workspace::new(model), &mut RungeKuttaWorkspace::new(model));
            let state = (&*q, &*qd, &*tau, dt[0]);
            let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
            step_rk4_derivatives(model, layout, state, rooms, outputs);
            found.concat()
        })
    }

    /// Returns the graph of the coordinates and velocities after a step of the implicit midpoint rule. Inputs: `q`, `qd`,
    /// `tau` and the time.
    #[must_use]
    pub fn step_implicit_midpoint(&self) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 1], |model, [q, qd, tau, dt]| {
            let (mut next_q, mut next_qd) = (vec![Expr::zero(); nq], vec![Expr::zero(); nv]);
            let rooms = (&mut Workspace::new(model), &mut MidpointWorkspace::new(model));
            let (state, next) = ((&*q, &*qd, &*tau, dt[0]), (&mut *next_q, &mut *next_qd));
            step_implicit_midpoint(model, state, rooms, next);
            [next_q, next_qd].concat()
        })
    }

    /// Returns the graph of the coordinates and velocities after a step of the implicit midpoint rule, and of the
    /// derivatives A and B by columns. Inputs: `q`, `qd`, `tau` and the time.
    #[must_use]
    pub fn step_implicit_midpoint_derivatives(&self) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 1], |model, [q, qd, tau, dt]| {
            let mut found = [nq, nv, 4 * nv * nv, 2 * nv * nv].map(|n| vec![Expr::zero(); n]);
            let [next_q, next_qd, a, b] = &mut found;
            let rooms = (&mut Workspace::new(model), &mut MidpointWorkspace::new(model));
            let state = (&*q, &*qd, &*tau, dt[0]);
            let outputs = StepOutputs { q: next_q, qd: next_qd, a, b };
            step_implicit_midpoint_derivatives(model, state, rooms, outputs);
            found.concat()
        })
    }
}
