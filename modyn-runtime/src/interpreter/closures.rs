//! Forward dynamics of closed loops, and how well they are closed.

use super::{Interpreter, ShapeError, check};
use crate::Scalar;
use crate::equations::brge::UduLayout;
use crate::equations::{ClosureWorkspace, Workspace, closures};
use crate::mechanism::Mechanism;
use crate::model::ModuleTree;
use crate::results::ClosureSettings;
use crate::spatial::{Twist, Wrench};

/// The memory that it works in.
type Rooms<'a, S> = (&'a mut Workspace<S>, &'a mut ClosureWorkspace<S>);

/// Closed loops: see [`Model::closures`](crate::model::Model::closures). A model without any is a
/// tree, for which nothing is written to slices by closures.
impl<S: Scalar> Interpreter<S> {
    /// The joint accelerations `qdd` under the joint torques or forces `tau` while the loops stay
    /// closed, and the `forces` that close them: for each closure the wrench on the second link at
    /// the second frame's origin, in the first frame's axes. Of redundant constraints the first
    /// have all forces. The first call allocates what it works in.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn constrained_forward_dynamics(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        settings: &ClosureSettings<S>,
        (qdd, forces): (&mut [S], &mut [Wrench<S>]),
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("tau", tau, n)?;
        check("qdd", qdd, n)?;
        check("forces", forces, self.model.closures().len())?;
        let (mechanism, layout, rooms) = self.closing();
        let state = (q, qd, tau);
        let solve = closures::constrained_forward_dynamics;
        solve(mechanism, layout, state, settings, rooms, (qdd, forces));
        Ok(())
    }

    /// The step `dq` that, to first order, closes the loops at `q`, and the change `dqd` of the
    /// velocities that keeps them closed: the smallest in the metric of the inertia matrix. Of
    /// `settings` the tolerance alone matters. The first call of this or of
    /// [`constrained_forward_dynamics`](Self::constrained_forward_dynamics) allocates. Repeated a few times from near by, with
    /// [`integrate`](Self::integrate), it puts a robot together.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn closing_step(
        &mut self,
        q: &[S],
        qd: &[S],
        settings: &ClosureSettings<S>,
        (dq, dqd): (&mut [S], &mut [S]),
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("dq", dq, n)?;
        check("dqd", dqd, n)?;
        let (mechanism, layout, rooms) = self.closing();
        closures::closing_step(mechanism, layout, (q, qd), settings, rooms, (dq, dqd));
        Ok(())
    }

    /// What closing loops works with.
    fn closing(&mut self) -> (&Mechanism<S>, &UduLayout, Rooms<'_, S>) {
        let Self { mechanism, workspace, model, links, closing, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let room = closing.get_or_insert_with(|| ClosureWorkspace::new(mechanism, layout));
        (mechanism, layout, (workspace, room))
    }

    /// How far the closures' frames are apart and how fast they part: of the second frame against
    /// the first, in the first one's axes, without what is free. Rotations are given by their axes
    /// times the sines of their angles.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn closure_errors(
        &mut self,
        q: &[S],
        qd: &[S],
        displacements: &mut [Twist<S>],
        velocities: &mut [Twist<S>],
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("qd", qd, self.model.nv())?;
        check("displacements", displacements, self.model.closures().len())?;
        check("velocities", velocities, self.model.closures().len())?;
        let errors = (displacements, velocities);
        closures::closure_errors(&self.mechanism, (q, qd), &mut self.workspace, errors);
        Ok(())
    }
}
