//! Forward dynamics of closed loops and contacts, and their residuals.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::equations::brge::UduLayout;
use crate::equations::{ConstraintWorkspace, Workspace, constraints};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::spatial::{Twist, Wrench};

/// All that equations of constraints are given.
struct Constraints<'a, S> {
    mechanism: &'a Mechanism<S>,
    layout: &'a UduLayout,
    /// By contact: 1 if it is active, else 0.
    active: &'a [S],
    /// The memory that they work in.
    rooms: (&'a mut Workspace<S>, &'a mut ConstraintWorkspace<S>),
}

/// Closed loops and contacts: see [`Model::loop_constraints`](crate::model::Model::loop_constraints) and
/// [`Model::contacts`](crate::model::Model::contacts). The slices that have an entry for each constraint (the loop
/// constraints, then the contacts) are empty for a tree.
impl<S: Scalar> Interpreter<S> {
    /// Computes the joint accelerations `qdd` (rad/s^2 or m/s^2) under the joint torques or forces `tau`
    /// with the loops closed and the `active` contacts held, and for each constraint the wrench on its second link (N m,
    /// N) and the residual of its acceleration (rad/s^2, m/s^2): of loop constraints at the second frame's origin in the
    /// first frame's axes, of contacts at the frame's origin in world axes. See
    /// [`ConstrainedForwardDynamics`](crate::ConstrainedForwardDynamics). Returns the number of
    /// independent constraint rows, an integer. The first call allocates its memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_forward_dynamics(
        &mut self,
        (q, qd, tau): (&[S], &[S], &[S]),
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        (qdd, wrenches, residuals): (&mut [S], &mut [Wrench<S>], &mut [Twist<S>]),
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("tau", tau, n)?;
        check("qdd", qdd, n)?;
        check("wrenches", wrenches, self.model.constraints())?;
        check("residuals", residuals, self.model.constraints())?;
        self.set_active(active, settings)?;
        let Constraints { mechanism, layout, active, rooms } = self.constraints();
        let settings = (active, settings);
        let solve = constraints::constrained_forward_dynamics;
        Ok(solve(mechanism, layout, (q, qd, tau), settings, rooms, (qdd, wrenches, residuals)))
    }

    /// Computes the step `dq` (rad or m, in tangent space) that, to first order, meets the constraints at
    /// `q` (closed loops, and `active` contacts on their targets), and the change `dqd` of the velocities that keeps them
    /// met: the smallest in the metric of the mass
    /// matrix. Returns the number of independent constraint rows, an integer. Of `settings`, `alpha` and
    /// `beta` do not matter. The first call of this or of
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) allocates its memory. Repeated
    /// a few times from near by, with [`integrate`](Self::integrate), it assembles a robot.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn project_constraints(
        &mut self,
        (q, qd): (&[S], &[S]),
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        (dq, dqd): (&mut [S], &mut [S]),
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("dq", dq, n)?;
        check("dqd", dqd, n)?;
        self.set_active(active, settings)?;
        let Constraints { mechanism, layout, active, rooms } = self.constraints();
        let project = constraints::project_constraints;
        Ok(project(mechanism, layout, (q, qd), (active, settings), rooms, (dq, dqd)))
    }

    /// Takes over which contacts are active, and checks the number of their targets.
    fn set_active(
        &mut self,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
    ) -> Result<(), ShapeError> {
        let contacts = self.model.contacts().len();
        check("active", active, contacts)?;
        check("settings.contacts", settings.contacts.as_ref(), contacts)?;
        for (number, &active) in self.active.iter_mut().zip(active) {
            *number = if active { S::one() } else { S::zero() };
        }
        Ok(())
    }

    fn constraints(&mut self) -> Constraints<'_, S> {
        let Self { mechanism, workspace, model, links, constraints, active, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let room = constraints.get_or_insert_with(|| ConstraintWorkspace::new(mechanism, layout));
        Constraints { mechanism, layout, active, rooms: (workspace, room) }
    }

    /// Computes how far each loop constraint's second frame is displaced from its first (m; a rotation by
    /// its axis times the sine of its angle) and its relative velocity (rad/s, m/s), in the first frame's
    /// axes, without the free directions; and the displacement and the velocity of each contact's frame, active or not,
    /// relative to its target, in world axes. The first call of a function about constraints allocates their memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_residual(
        &mut self,
        (q, qd): (&[S], &[S]),
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        (displacements, velocities): (&mut [Twist<S>], &mut [Twist<S>]),
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("qd", qd, self.model.nv())?;
        check("displacements", displacements, self.model.constraints())?;
        check("velocities", velocities, self.model.constraints())?;
        let targets = settings.contacts.as_ref();
        check("settings.contacts", targets, self.model.contacts().len())?;
        let Constraints { mechanism, rooms, .. } = self.constraints();
        constraints::constraint_residual(
            mechanism,
            (q, qd),
            targets,
            rooms,
            (displacements, velocities),
        );
        Ok(())
    }
}
