//! Closed loops.
//!
//! Settings are alpha, beta and the tolerance; a twist or a wrench is three angular numbers, then
//! three linear ones.

use modyn_runtime::ClosureSettings;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::{ClosureWorkspace, Workspace, closures};
use modyn_runtime::spatial::{Twist, Wrench};

use super::Tracer;
use crate::expr::{Expr, Graph};

impl Tracer<'_> {
    /// The accelerations, then a wrench a closure, from `q`, `qd`, `tau` and settings, through the
    /// factors of the GIM in this layout.
    #[must_use]
    pub fn constrained_forward_dynamics(&self, layout: &UduLayout) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 3], |model, [q, qd, tau, settings]| {
            let (mut qdd, mut forces) = (self.vector(), vec![Wrench::zero(); model.closures.len()]);
            let room = &mut ClosureWorkspace::new(model, layout);
            closures::constrained_forward_dynamics(
                model,
                layout,
                (&q, &qd, &tau),
                &settings_of(&settings),
                (&mut Workspace::new(model), room),
                (&mut qdd, &mut forces),
            );
            qdd.into_iter().chain(forces.iter().flat_map(Wrench::components)).collect()
        })
    }

    /// A displacement a closure, then a velocity each, from `q`, `qd`.
    #[must_use]
    pub fn closure_errors(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let twists = || vec![Twist::zero(); model.closures.len()];
            let (mut displacements, mut velocities) = (twists(), twists());
            let errors = (&mut *displacements, &mut *velocities);
            closures::closure_errors(model, (&q, &qd), &mut Workspace::new(model), errors);
            displacements.iter().chain(&velocities).flat_map(Twist::components).collect()
        })
    }

    /// The step and the change of velocities from `q`, `qd` and settings.
    #[must_use]
    pub fn closing_step(&self, layout: &UduLayout) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, 3], |model, [q, qd, settings]| {
            let (mut dq, mut dqd) = (self.vector(), self.vector());
            let room = &mut ClosureWorkspace::new(model, layout);
            closures::closing_step(
                model,
                layout,
                (&q, &qd),
                &settings_of(&settings),
                (&mut Workspace::new(model), room),
                (&mut dq, &mut dqd),
            );
            [dq, dqd].concat()
        })
    }
}

fn settings_of(numbers: &[Expr]) -> ClosureSettings<Expr> {
    ClosureSettings { alpha: numbers[0], beta: numbers[1], tolerance: numbers[2] }
}
