//! Poses, motion and Jacobians of the links.

use super::Interpreter;
use super::errors::{FrameError, ShapeError, check};
use crate::Scalar;
use crate::equations::kinematics::{self, Axes};
use crate::spatial::{Pose, Twist};

/// Quantities of one link: `frame` is its index in [`Model::frames`](crate::model::Model::frames),
/// fixed ones too, which [`Model::frame_index`](crate::model::Model::frame_index) finds by name.
/// Each takes time linear in the depth of the link (but for the columns that it does not move).
/// Motion is that of the link's origin; a link that is fixed to the world does not move.
impl<S: Scalar> Interpreter<S> {
    fn check_frame(&self, frame: usize) -> Result<(), FrameError> {
        let count = self.model.frames().len();
        if frame < count { Ok(()) } else { Err(FrameError::NoFrame { frame, count }) }
    }

    fn check_motion(&self, frame: usize, q: &[S], qd: &[S]) -> Result<(), FrameError> {
        self.check_frame(frame)?;
        check("q", q, self.model.nq())?;
        Ok(check("qd", qd, self.model.nv())?)
    }

    /// The pose of a link in the world.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_pose(&self, q: &[S], frame: usize) -> Result<Pose<S>, FrameError> {
        self.check_frame(frame)?;
        check("q", q, self.model.nq())?;
        Ok(kinematics::link_pose(&self.mechanism, frame, q))
    }

    /// The velocity of a link, in world axes.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_velocity(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.velocity(q, qd, frame, Axes::World)
    }

    /// The velocity of a link, in its own axes.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn local_link_velocity(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.velocity(q, qd, frame, Axes::Link)
    }

    fn velocity(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
        axes: Axes,
    ) -> Result<Twist<S>, FrameError> {
        self.check_motion(frame, q, qd)?;
        let Self { mechanism, workspace, .. } = self;
        Ok(kinematics::link_velocity(mechanism, frame, (q, qd), axes, workspace))
    }

    /// The angular acceleration of a link and the classical one of its origin, in world axes;
    /// gravity has no part in it.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_acceleration(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.acceleration((q, qd, qdd), frame, Axes::World)
    }

    /// The same in the link's own axes.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn local_link_acceleration(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.acceleration((q, qd, qdd), frame, Axes::Link)
    }

    fn acceleration(
        &mut self,
        (q, qd, qdd): (&[S], &[S], &[S]),
        frame: usize,
        axes: Axes,
    ) -> Result<Twist<S>, FrameError> {
        self.check_motion(frame, q, qd)?;
        check("qdd", qdd, self.model.nv())?;
        let Self { mechanism, workspace, .. } = self;
        Ok(kinematics::link_acceleration(mechanism, frame, (q, qd, qdd), axes, workspace))
    }

    /// The Jacobian J of a link into `columns` (nv), in world axes at its origin (Pinocchio's
    /// `LOCAL_WORLD_ALIGNED`): its velocity is J qd.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian(
        &mut self,
        q: &[S],
        frame: usize,
        columns: &mut [Twist<S>],
    ) -> Result<(), FrameError> {
        self.jacobian_in(q, frame, Axes::World, columns)
    }

    /// The Jacobian of a link into `columns` (nv), in its own axes (Pinocchio's `LOCAL`).
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn local_jacobian(
        &mut self,
        q: &[S],
        frame: usize,
        columns: &mut [Twist<S>],
    ) -> Result<(), FrameError> {
        self.jacobian_in(q, frame, Axes::Link, columns)
    }

    fn jacobian_in(
        &mut self,
        q: &[S],
        frame: usize,
        axes: Axes,
        columns: &mut [Twist<S>],
    ) -> Result<(), FrameError> {
        self.check_frame(frame)?;
        check("q", q, self.model.nq())?;
        check("columns", columns, self.model.nv())?;
        let Self { mechanism, workspace, .. } = self;
        kinematics::jacobian(mechanism, frame, q, axes, workspace, columns);
        Ok(())
    }

    /// The time derivative of [`jacobian`](Self::jacobian) times qd: the link's
    /// [acceleration](Self::link_acceleration) while qd does not change.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn bias_acceleration(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.bias_acceleration_in(q, qd, frame, Axes::World)
    }

    /// The time derivative of [`local_jacobian`](Self::local_jacobian) times qd: the rate at which
    /// the velocity's numbers in the link's own axes change while qd does not. Its linear part is
    /// the classical acceleration in these axes less the angular velocity times (as vectors) the
    /// linear one.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn local_bias_acceleration(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.bias_acceleration_in(q, qd, frame, Axes::Link)
    }

    fn bias_acceleration_in(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
        axes: Axes,
    ) -> Result<Twist<S>, FrameError> {
        self.check_motion(frame, q, qd)?;
        let Self { mechanism, workspace, .. } = self;
        Ok(kinematics::bias_acceleration(mechanism, frame, (q, qd), axes, workspace))
    }
}

/// All links at once.
impl<S: Scalar> Interpreter<S> {
    /// The poses in the world of all links of the description, fixed ones too, in the order of
    /// [`Model::frames`](crate::model::Model::frames).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn link_poses(&mut self, q: &[S], poses: &mut [Pose<S>]) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("poses", poses, self.model.frames().len())?;
        let Self { mechanism, workspace, body_poses, .. } = self;
        kinematics::link_poses(mechanism, q, workspace, body_poses, poses);
        Ok(())
    }
}
