//! Forward dynamics of closed loops, and the residuals of loop constraints.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::brge::UduLayout;
use crate::equations::{ConstraintWorkspace, Workspace, constraints};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::results::ConstraintSettings;
use crate::spatial::{Twist, Wrench};

/// The workspaces that constrained dynamics needs.
type Workspaces<'a, S> = (&'a mut Workspace<S>, &'a mut ConstraintWorkspace<S>);

/// Functions of closed loops: see [`Model::loop_constraints`](crate::model::Model::loop_constraints). Slices with
/// an entry for each loop constraint are empty for a tree.
impl<S: Scalar> Interpreter<S> {
    /// Computes the joint accelerations `qdd` (rad/s^2 or m/s^2) under the joint forces `tau`, with the loops
    /// closed. Returns the number of independent constraint rows, an integer.
    ///
    /// `wrenches` receives the wrench on each loop constraint's second link (N m, N), and `residuals` the
    /// residual of its acceleration (rad/s^2, m/s^2). Both are at the second frame's origin, in the first
    /// frame's axes: see [`ConstrainedForwardDynamics`](crate::ConstrainedForwardDynamics). The first call
    /// allocates memory. Source: Featherstone 2008, chapter 8.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_forward_dynamics(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        settings: &ConstraintSettings<S>,
        (qdd, wrenches, residuals): (&mut [S], &mut [Wrench<S>], &mut [Twist<S>]),
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("tau", tau, n)?;
        check("qdd", qdd, n)?;
        check("wrenches", wrenches, self.model.loop_constraints().len())?;
        check("residuals", residuals, self.model.loop_constraints().len())?;
        let (mechanism, layout, rooms) = self.constraints();
        let state = (q, qd, tau);
        let solve = constraints::constrained_forward_dynamics;
        Ok(solve(mechanism, layout, state, settings, rooms, (qdd, wrenches, residuals)))
    }

    /// Computes the smallest step `dq` (rad or m, in tangent space) that closes the loops at `q` to first order,
    /// and the smallest change `dqd` of the velocities that keeps them closed. Returns the number of independent
    /// constraint rows, an integer.
    ///
    /// Steps are smallest in the metric of the mass matrix. The settings `alpha` and `beta` have no effect. The
    /// first call of this function or of [`constrained_forward_dynamics`](Self::constrained_forward_dynamics)
    /// allocates memory. To assemble a robot from nearby coordinates, repeat it with
    /// [`integrate`](Self::integrate) a few times.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn project_constraints(
        &mut self,
        q: &[S],
        qd: &[S],
        settings: &ConstraintSettings<S>,
        (dq, dqd): (&mut [S], &mut [S]),
    ) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("dq", dq, n)?;
        check("dqd", dqd, n)?;
        let (mechanism, layout, rooms) = self.constraints();
        let project = constraints::project_constraints;
        Ok(project(mechanism, layout, (q, qd), settings, rooms, (dq, dqd)))
    }

    /// Returns the mechanism, the layout of its factorization and the workspaces.
    fn constraints(&mut self) -> (&Mechanism<S>, &UduLayout, Workspaces<'_, S>) {
        let Self { mechanism, workspace, model, links, constraints, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let room = constraints.get_or_insert_with(|| ConstraintWorkspace::new(mechanism, layout));
        (mechanism, layout, (workspace, room))
    }

    /// Computes the displacement (m) and the velocity (rad/s, m/s) of each loop constraint's second frame relative
    /// to its first, in the first frame's axes.
    ///
    /// Components along free directions are zero. A rotation is its axis times the sine of its angle.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constraint_residual(
        &mut self,
        q: &[S],
        qd: &[S],
        displacements: &mut [Twist<S>],
        velocities: &mut [Twist<S>],
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("qd", qd, self.model.nv())?;
        check("displacements", displacements, self.model.loop_constraints().len())?;
        check("velocities", velocities, self.model.loop_constraints().len())?;
        let errors = (displacements, velocities);
        constraints::constraint_residual(&self.mechanism, (q, qd), &mut self.workspace, errors);
        Ok(())
    }
}
