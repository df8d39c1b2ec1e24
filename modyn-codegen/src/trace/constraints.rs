//! The graphs of loop constraints.
//!
//! Settings are alpha, beta, tolerance and rounding. A twist or a wrench is three angular, then three linear
//! components.

use modyn_runtime::ConstraintSettings;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::{ConstraintWorkspace, Workspace, constraints};
use modyn_runtime::spatial::{Twist, Wrench};

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the accelerations, a wrench and a residual for each loop constraint, and the rank. Inputs:
    /// `q`, `qd`, `tau` and settings. The mass matrix is factorized with `layout`.
    #[must_use]
    pub fn constrained_forward_dynamics(&self, layout: &UduLayout) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, SETTINGS], |model, [q, qd, tau, settings]| {
            let loops = model.loop_constraints.len();
            let (mut qdd, mut wrenches) = (self.vector(), vec![Wrench::zero(); loops]);
            let mut residuals = vec![Twist::zero(); loops];
            let room = &mut ConstraintWorkspace::new(model, layout);
            let rank = constraints::constrained_forward_dynamics(
                model,
                layout,
                (&q, &qd, &tau),
                &constraint_settings(&settings),
                (&mut Workspace::new(model), room),
                (&mut qdd, &mut wrenches, &mut residuals),
            );
            let wrenches = wrenches.iter().flat_map(Wrench::components);
            let residuals = residuals.iter().flat_map(Twist::components);
            qdd.into_iter().chain(wrenches).chain(residuals).chain([rank]).collect()
        })
    }

    /// Returns the graph of the displacement, then the velocity of each loop constraint. Inputs: `q`, `qd`.
    #[must_use]
    pub fn constraint_residual(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let twists = || vec![Twist::zero(); model.loop_constraints.len()];
            let (mut displacements, mut velocities) = (twists(), twists());
            let errors = (&mut *displacements, &mut *velocities);
            constraints::constraint_residual(model, (&q, &qd), &mut Workspace::new(model), errors);
            displacements.iter().chain(&velocities).flat_map(Twist::components).collect()
        })
    }

    /// Returns the graph of the step, the change of the velocities and the rank. Inputs: `q`, `qd` and settings.
    #[must_use]
    pub fn project_constraints(&self, layout: &UduLayout) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, SETTINGS], |model, [q, qd, settings]| {
            let (mut dq, mut dqd) = (self.vector(), self.vector());
            let room = &mut ConstraintWorkspace::new(model, layout);
            let rank = constraints::project_constraints(
                model,
                layout,
                (&q, &qd),
                &constraint_settings(&settings),
                (&mut Workspace::new(model), room),
                (&mut dq, &mut dqd),
            );
            [dq, dqd, vec![rank]].concat()
        })
    }
}

/// The number of settings.
const SETTINGS: usize = 4;

fn constraint_settings(numbers: &[Expr]) -> ConstraintSettings<Expr> {
    let &[alpha, beta, tolerance, rounding] = numbers else { unreachable!("four settings") };
    ConstraintSettings { alpha, beta, tolerance, rounding }
}
