//! Forward dynamics of closed loops, and how well they are closed.

use super::{Interpreter, ShapeError, check};
use crate::Scalar;
use crate::equations::brge::Layout;
use crate::equations::{ClosureWorkspace, closures};
use crate::figures::ClosureSettings;
use crate::model::ModuleTree;
use crate::spatial::{Twist, Wrench};

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
        let Self { prepared, workspace, model, links, closing, .. } = self;
        let layout = links.get_or_insert_with(|| Layout::new(prepared, &ModuleTree::links(model)));
        let room = closing.get_or_insert_with(|| ClosureWorkspace::new(prepared, layout));
        closures::constrained_forward_dynamics(
            prepared,
            layout,
            (q, qd, tau),
            settings,
            (workspace, room),
            (qdd, forces),
        );
        Ok(())
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
        closures::closure_errors(&self.prepared, (q, qd), &mut self.workspace, errors);
        Ok(())
    }
}
