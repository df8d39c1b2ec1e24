//! Forward dynamics of closed loops and contacts, and the functions of constraints.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::constraint_settings::{ConstraintSettings, ContactTarget};
use crate::equations::brge::UduLayout;
pub use crate::equations::constraints::ConstrainedDerivatives;
use crate::equations::constraints::{
    ConstrainedInverseOutputs, ConstrainedOutputs, ConstraintInput, ConstraintWorkspaces,
    ImpulseOutputs, OperationalSpaceInertiaOutputs, ProjectionOutputs, ResidualOutputs,
};
use crate::equations::{ConstraintWorkspace, ForwardInput, Motion, State, constraints};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::spatial::Twist;

/// The arguments and the workspaces that constrained dynamics needs.
struct Constraints<'a, S> {
    mechanism: &'a Mechanism<S>,
    layout: &'a UduLayout,
    /// For each contact, 1 if it is active, else 0.
    active: &'a [S],
    workspaces: ConstraintWorkspaces<'a, S>,
}

/// Functions of closed loops and contacts: see
/// [`Model::loop_constraints`](crate::model::Model::loop_constraints) and
/// [`Model::contacts`](crate::model::Model::contacts). Slices with an entry for each constraint
/// have the loop constraints first, then the contacts; they are empty for a tree.
impl<S: Scalar> Interpreter<S> {
    /// Computes the joint accelerations `qdd` (rad/s^2 or m/s^2) under the joint forces `tau`, with
    /// the loops closed and the `active` contacts held. Returns the number of independent
    /// constraint rows, an integer.
    ///
    /// `wrenches` receives the wrench on each constraint's second link (N m, N), and `residuals`
    /// the residual of its acceleration (rad/s^2, m/s^2). Those of loop constraints are at the
    /// second frame's origin, in the first frame's axes; the wrenches of contacts at the frame's
    /// origin, in world axes: see
    /// [`ConstrainedForwardDynamics`](crate::ConstrainedForwardDynamics). The first call allocates
    /// memory. Source: Featherstone 2008, chapter 8.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_forward_dynamics(
        &mut self,
        input: ForwardInput<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        self.check_forward_input(input)?;
        self.check_vectors(&[("qdd", outputs.qdd)])?;
        check("wrenches", outputs.wrenches, self.model.constraints())?;
        check("residuals", outputs.residuals, self.model.constraints())?;
        self.set_active(active, settings)?;
        Ok(self.solve_constrained(input, settings, outputs))
    }

    /// Computes the smallest step `step_q` (rad or m, in tangent space) that closes the loops at
    /// `q` and moves the `active` contacts to their targets to first order, and the smallest change
    /// `step_qd` of the velocities that keeps them there. Returns the number of independent
    /// constraint rows, an integer.
    ///
    /// Steps are smallest in the metric of the mass matrix. The settings `alpha` and `beta` have no
    /// effect. The first call of this function or of
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) allocates memory. To
    /// assemble a robot from nearby coordinates, repeat it with [`integrate`](Self::integrate) a
    /// few times.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn project_constraints(
        &mut self,
        state: State<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ProjectionOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        self.check_state(state)?;
        self.check_vectors(&[("step_q", outputs.step_q), ("step_qd", outputs.step_qd)])?;
        self.set_active(active, settings)?;
        Ok(self.solve_projection(state, settings, outputs))
    }

    /// Stores the set of active contacts, and checks the number of targets.
    pub(super) fn set_active(
        &mut self,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
    ) -> Result<(), ShapeError> {
        let contacts = self.model.contacts().len();
        check("active", active, contacts)?;
        check("settings.targets", settings.targets.as_ref(), contacts)?;
        for (number, &active) in self.active.iter_mut().zip(active) {
            *number = if active { S::one() } else { S::zero() };
        }
        Ok(())
    }

    fn constraints(&mut self) -> Constraints<'_, S> {
        let Self { mechanism, workspace, model, links, constraints, active, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let memory = constraints.get_or_insert_with(|| ConstraintWorkspace::new(mechanism, layout));
        Constraints {
            mechanism,
            layout,
            active,
            workspaces: ConstraintWorkspaces { workspace, memory },
        }
    }

    /// Computes the displacement (m) and the velocity (rad/s, m/s) of each loop constraint's second
    /// frame relative to its first, in the first frame's axes, and of each contact's frame, active
    /// or not, relative to its target, in world axes.
    ///
    /// Components along free directions are zero. A rotation is its axis times the sine of its
    /// angle. The first call of a function of constraints allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_residual(
        &mut self,
        state: State<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        ResidualOutputs { displacements, velocities }: ResidualOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_state(state)?;
        check("displacements", displacements, self.model.constraints())?;
        check("velocities", velocities, self.model.constraints())?;
        let targets = settings.targets.as_ref();
        check("settings.targets", targets, self.model.contacts().len())?;
        let Constraints { mechanism, workspaces, .. } = self.constraints();
        constraints::constraint_residual(
            mechanism,
            state,
            targets,
            workspaces,
            ResidualOutputs { displacements, velocities },
        );
        Ok(())
    }

    /// Computes the velocities `after` an impact (rad/s or m/s) that closes the loops and stops the
    /// active contacts relative to their targets at the same instant. Returns the number of
    /// independent constraint rows, an integer.
    ///
    /// `impulses` receives the impulse on each constraint's second link (N m s, N s), in the axes
    /// and at the point of its wrench in
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics). Along its normal, a
    /// contact leaves with `restitution` times the speed before the impact. The settings `alpha`
    /// and `beta` have no effect.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn impact_dynamics(
        &mut self,
        state: State<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ImpulseOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        self.check_state(state)?;
        self.check_vectors(&[("after", outputs.qd)])?;
        check("impulses", outputs.impulses, self.model.constraints())?;
        self.set_active(active, settings)?;
        Ok(self.solve_impulse(state, settings, outputs))
    }

    /// Computes the joint forces `tau` (N m or N) of the accelerations `qdd`, and the wrenches of
    /// the active contacts that carry the floating bases. Returns the number of independent
    /// directions in which the contacts carry the bases, an integer.
    ///
    /// `wrenches` receives the wrench on each contact's link (N m, N), at the frame's origin in
    /// world axes; the entries of loop constraints are zero. The wrenches have the smallest sum of
    /// (force^2 + (moment / l)^2) / weight over the contacts, with the characteristic length l of
    /// each. The entries of `tau` of a floating base are the wrench on it that no contact can
    /// carry.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_inverse_dynamics(
        &mut self,
        motion: Motion<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedInverseOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        self.check_motion(motion)?;
        self.check_vectors(&[("tau", outputs.tau)])?;
        check("wrenches", outputs.wrenches, self.model.constraints())?;
        self.set_active(active, settings)?;
        Ok(self.solve_torques(motion, settings, outputs))
    }

    /// Computes the Jacobian of each constraint into `columns`: a column for each entry of qd,
    /// constraint by constraint. The product with qd is, for a loop constraint, the constrained
    /// part of the twist of its second frame relative to its first, in the first frame's axes; for
    /// a contact, active or not, the constrained part of its frame's twist in world axes.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_jacobian(
        &mut self,
        q: &[S],
        columns: &mut [Twist<S>],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        check("columns", columns, self.model.constraints() * self.model.nv())?;
        let Constraints { mechanism, workspaces, .. } = self.constraints();
        constraints::constraint_jacobian(mechanism, q, workspaces, columns);
        Ok(())
    }

    /// Computes the bias acceleration of each constraint (rad/s^2, m/s^2): the time derivative of
    /// [`constraint_jacobian`](Self::constraint_jacobian) times qd, in the same axes.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_jacobian_dot_qd(
        &mut self,
        state: State<'_, S>,
        accelerations: &mut [Twist<S>],
    ) -> Result<(), ShapeError> {
        self.check_state(state)?;
        check("accelerations", accelerations, self.model.constraints())?;
        let Self { mechanism, workspace, .. } = self;
        constraints::constraint_jacobian_dot_qd(mechanism, state, workspace, accelerations);
        Ok(())
    }

    /// Computes the Delassus matrix J M^-1 J^T of the constraint rows (1/kg), with the compliance of
    /// contacts, and its pseudo-inverse, the operational-space inertia (kg). Returns the
    /// number of independent rows, an integer.
    ///
    /// Both matrices are by columns, with a row for each constraint row
    /// ([`Model::constraint_rows`](crate::model::Model::constraint_rows)). Each constraint has its
    /// constrained displacements, then its constrained rotations: in the first frame's axes for a
    /// loop constraint, in world axes for a contact. The rows and columns of inactive contacts are
    /// zero.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn operational_space_inertia(
        &mut self,
        q: &[S],
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: OperationalSpaceInertiaOutputs<'_, S>,
    ) -> Result<S, ShapeError> {
        let rows = self.model.constraint_rows();
        self.check_coordinates(q)?;
        check("delassus", outputs.delassus, rows * rows)?;
        check("inertia", outputs.inertia, rows * rows)?;
        self.set_active(active, settings)?;
        Ok(self.solve_inertia(q, settings, outputs))
    }

    /// Computes the accelerations and the wrenches of
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics), and their derivatives
    /// with respect to q (in tangent space), qd and tau. Returns the number of independent
    /// constraint rows, an integer.
    ///
    /// Matrices are nv x nv, by columns. Derivatives of wrenches have a wrench for each entry of
    /// the variable, constraint by constraint, in the axes of the wrenches. The rank is assumed
    /// constant; redundant rows get the derivatives of smallest norm. The first call allocates
    /// memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_forward_dynamics_derivatives(
        &mut self,
        input: ForwardInput<'_, S>,
        active: &[bool],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedDerivatives<'_, S>,
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        let count = self.model.constraints();
        self.check_forward_input(input)?;
        self.check_vectors(&[("qdd", outputs.qdd)])?;
        check("wrenches", outputs.wrenches, count)?;
        self.check_matrices(&[
            ("dqdd_dq", outputs.dqdd_dq),
            ("dqdd_dqd", outputs.dqdd_dqd),
            ("dqdd_dtau", outputs.dqdd_dtau),
        ])?;
        check("dwrenches_dq", outputs.dwrenches_dq, n * count)?;
        check("dwrenches_dqd", outputs.dwrenches_dqd, n * count)?;
        check("dwrenches_dtau", outputs.dwrenches_dtau, n * count)?;
        self.set_active(active, settings)?;
        Ok(self.solve_derivatives(input, settings, outputs))
    }
}

/// The functions of constraints with the set of active contacts that was stored last. Lengths are
/// not checked.
impl<S: Scalar> Interpreter<S> {
    /// Stores the set of active contacts: for each contact 1 or 0.
    pub(crate) fn activate(&mut self, active: &[S]) {
        self.active.copy_from_slice(active);
    }

    pub(crate) fn solve_constrained(
        &mut self,
        input: ForwardInput<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedOutputs<'_, S>,
    ) -> S {
        let Constraints { mechanism, layout, active, workspaces } = self.constraints();
        let constraints = ConstraintInput { active, settings };
        constraints::constrained_forward_dynamics(
            mechanism,
            layout,
            input,
            constraints,
            workspaces,
            outputs,
        )
    }

    pub(crate) fn solve_projection(
        &mut self,
        state: State<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ProjectionOutputs<'_, S>,
    ) -> S {
        let Constraints { mechanism, layout, active, workspaces } = self.constraints();
        let constraints = ConstraintInput { active, settings };
        constraints::project_constraints(mechanism, layout, state, constraints, workspaces, outputs)
    }

    pub(crate) fn solve_impulse(
        &mut self,
        state: State<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ImpulseOutputs<'_, S>,
    ) -> S {
        let Constraints { mechanism, layout, active, workspaces } = self.constraints();
        let constraints = ConstraintInput { active, settings };
        constraints::impact_dynamics(mechanism, layout, state, constraints, workspaces, outputs)
    }

    pub(crate) fn solve_torques(
        &mut self,
        motion: Motion<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedInverseOutputs<'_, S>,
    ) -> S {
        let Constraints { mechanism, active, workspaces, .. } = self.constraints();
        let constraints = ConstraintInput { active, settings };
        constraints::constrained_inverse_dynamics(
            mechanism,
            motion,
            constraints,
            workspaces,
            outputs,
        )
    }

    pub(crate) fn solve_inertia(
        &mut self,
        q: &[S],
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: OperationalSpaceInertiaOutputs<'_, S>,
    ) -> S {
        let Constraints { mechanism, layout, active, workspaces } = self.constraints();
        let constraints = ConstraintInput { active, settings };
        constraints::operational_space_inertia(
            mechanism,
            layout,
            q,
            constraints,
            workspaces,
            outputs,
        )
    }

    pub(crate) fn solve_derivatives(
        &mut self,
        input: ForwardInput<'_, S>,
        settings: &ConstraintSettings<S, impl AsRef<[ContactTarget<S>]>>,
        outputs: ConstrainedDerivatives<'_, S>,
    ) -> S {
        let Constraints { mechanism, layout, active, workspaces } = self.constraints();
        let constraints = ConstraintInput { active, settings };
        constraints::constrained_forward_dynamics_derivatives(
            mechanism,
            layout,
            input,
            constraints,
            workspaces,
            outputs,
        )
    }
}
