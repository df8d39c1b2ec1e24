//! Forward dynamics of closed loops and contacts, and their residuals.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::equations::brge::UduLayout;
pub use crate::equations::constraints::ConstrainedDerivatives;
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

    /// Computes the velocities `after` an impact (rad/s or m/s) that closes the loops and puts the active contacts at rest
    /// relative to their targets at once, and for each constraint the impulse on its second link (N m s, N s), as
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) has its wrench. Along its normal, a contact
    /// leaves with its share `restitution` of the speed that it arrived with. Returns the number of independent
    /// constraint rows, an integer. Stabilization does not matter.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn contact_impulse(
        &mut self,
        (q, qd): (&[S], &[S]),
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        (after, impulses): (&mut [S], &mut [Wrench<S>]),
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("after", after, n)?;
        check("impulses", impulses, self.model.constraints())?;
        self.set_active(active, settings)?;
        let Constraints { mechanism, layout, active, rooms } = self.constraints();
        let solve = constraints::contact_impulse;
        Ok(solve(mechanism, layout, (q, qd), (active, settings), rooms, (after, impulses)))
    }

    /// Computes the joint torques or forces `tau` (N m or N) of the accelerations `qdd`, and the wrenches of the active
    /// contacts (N m, N, at their frames' origins in world axes; zero for loop constraints) that carry the floating
    /// bases: of all that do, those with the smallest sum of (force^2 + (moment / l)^2) / weight over the contacts. The
    /// entries of `tau` of a floating base are the force on it that no contact can carry. Returns the number of
    /// independent directions in which the contacts carry the bases, an integer.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_inverse_dynamics(
        &mut self,
        (q, qd, qdd): (&[S], &[S], &[S]),
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        (tau, wrenches): (&mut [S], &mut [Wrench<S>]),
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("qdd", qdd, n)?;
        check("tau", tau, n)?;
        check("wrenches", wrenches, self.model.constraints())?;
        self.set_active(active, settings)?;
        let Constraints { mechanism, active, rooms, .. } = self.constraints();
        let solve = constraints::constrained_inverse_dynamics;
        Ok(solve(mechanism, (q, qd, qdd), (active, settings), rooms, (tau, wrenches)))
    }

    /// Computes the Jacobian of the constraints into `columns`, for each constraint one for each entry of qd: of a loop
    /// constraint the constrained part of the twist of its second frame relative to its first, in the first frame's
    /// axes; of a contact, active or not, that of its frame in world axes.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_jacobian(
        &mut self,
        q: &[S],
        columns: &mut [Twist<S>],
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("columns", columns, self.model.constraints() * self.model.nv())?;
        let Constraints { mechanism, rooms, .. } = self.constraints();
        constraints::constraint_jacobian(mechanism, q, rooms, columns);
        Ok(())
    }

    /// Computes the time derivative of [`constraint_jacobian`](Self::constraint_jacobian) times qd: for each constraint
    /// the acceleration of its frames without joint accelerations (rad/s^2, m/s^2), in the same axes.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_bias_acceleration(
        &mut self,
        (q, qd): (&[S], &[S]),
        accelerations: &mut [Twist<S>],
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("qd", qd, self.model.nv())?;
        check("accelerations", accelerations, self.model.constraints())?;
        let Self { mechanism, workspace, .. } = self;
        constraints::constraint_bias_acceleration(mechanism, (q, qd), workspace, accelerations);
        Ok(())
    }

    /// Computes the inverse operational-space inertia J I^-1 J^T of the constraint rows (1/kg; the Delassus matrix) with
    /// the compliance of contacts, and its pseudo-inverse (kg), both by columns with a row for each constraint row
    /// ([`Model::constraint_rows`](crate::model::Model::constraint_rows)): of each constraint the constrained rotations,
    /// then displacements, of a loop constraint in the first frame's axes, of a contact in world axes. Rows and columns
    /// of inactive contacts are zero. Returns the number of independent rows, an integer.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn operational_inertia(
        &mut self,
        q: &[S],
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        (inverse, inertia): (&mut [S], &mut [S]),
    ) -> Result<S, ShapeError> {
        let rows = self.model.constraint_rows();
        check("q", q, self.model.nq())?;
        check("inverse", inverse, rows * rows)?;
        check("inertia", inertia, rows * rows)?;
        self.set_active(active, settings)?;
        let Constraints { mechanism, layout, active, rooms } = self.constraints();
        let solve = constraints::operational_inertia;
        Ok(solve(mechanism, layout, q, (active, settings), rooms, (inverse, inertia)))
    }

    /// Computes the accelerations and the wrenches of
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics), and their derivatives by q (in the tangent
    /// space), qd and tau: matrices nv x nv by columns, and for each constraint a wrench for each entry, in world axes.
    /// Where rows are redundant, the derivatives of the wrenches are the smallest that the derivatives of the equations
    /// allow. Returns the number of independent constraint rows, an integer. The first call allocates its memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length, or the model has loop constraints (`loop_constraints`): of these
    /// there are no derivatives.
    pub fn constrained_forward_dynamics_derivatives(
        &mut self,
        (q, qd, tau): (&[S], &[S], &[S]),
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedDerivatives<'_, S>,
    ) -> Result<S, ShapeError> {
        let (n, count) = (self.model.nv(), self.model.constraints());
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("tau", tau, n)?;
        check("loop_constraints", self.model.loop_constraints(), 0)?;
        check("qdd", outputs.qdd, n)?;
        check("wrenches", outputs.wrenches, count)?;
        check("dqdd_dq", outputs.dqdd_dq, n * n)?;
        check("dqdd_dqd", outputs.dqdd_dqd, n * n)?;
        check("dqdd_dtau", outputs.dqdd_dtau, n * n)?;
        check("dwrenches_dq", outputs.dwrenches_dq, n * count)?;
        check("dwrenches_dqd", outputs.dwrenches_dqd, n * count)?;
        check("dwrenches_dtau", outputs.dwrenches_dtau, n * count)?;
        self.set_active(active, settings)?;
        let Constraints { mechanism, layout, active, rooms } = self.constraints();
        let derive = constraints::constrained_forward_dynamics_derivatives;
        Ok(derive(mechanism, layout, (q, qd, tau), (active, settings), rooms, outputs))
    }
}
