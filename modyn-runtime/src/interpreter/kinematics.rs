//! Where the links stand and how they move, one link at a time; the centre of mass and the
//! momentum about it.

use core::fmt;

use super::{Interpreter, ShapeError, check};
use crate::Scalar;
use crate::equations::dynamics::{centroidal_momentum, centroidal_momentum_matrix};
use crate::equations::kinematics::{self, Axes, center_of_mass, center_of_mass_jacobian};
use crate::spatial::{Momentum, Pose, Twist, Vector3};

/// Why a quantity of one link cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// There is no link of that index.
    NoFrame {
        /// The index.
        frame: usize,
        /// How many links the description has.
        count: usize,
    },
    /// A slice has the wrong length.
    Shape(ShapeError),
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFrame { frame, count } => {
                write!(f, "there is no link {frame}; the description has {count}")
            }
            Self::Shape(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for FrameError {}

impl From<ShapeError> for FrameError {
    fn from(error: ShapeError) -> Self {
        Self::Shape(error)
    }
}

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
        Ok(kinematics::link_pose(&self.prepared, frame, q))
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
        let Self { prepared, workspace, .. } = self;
        Ok(kinematics::link_velocity(prepared, frame, (q, qd), axes, workspace))
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
        let Self { prepared, workspace, .. } = self;
        Ok(kinematics::link_acceleration(prepared, frame, (q, qd, qdd), axes, workspace))
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
        let Self { prepared, workspace, .. } = self;
        kinematics::jacobian(prepared, frame, q, axes, workspace, columns);
        Ok(())
    }

    /// The time derivative of [`jacobian`](Self::jacobian) times qd: the link's
    /// [acceleration](Self::link_acceleration) while qd does not change.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian_rate(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.jacobian_rate_in(q, qd, frame, Axes::World)
    }

    /// The time derivative of [`local_jacobian`](Self::local_jacobian) times qd: the rate at which
    /// the velocity's numbers in the link's own axes change while qd does not. Its linear part is
    /// the classical acceleration in these axes less the angular velocity times (as vectors) the
    /// linear one.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn local_jacobian_rate(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
    ) -> Result<Twist<S>, FrameError> {
        self.jacobian_rate_in(q, qd, frame, Axes::Link)
    }

    fn jacobian_rate_in(
        &mut self,
        q: &[S],
        qd: &[S],
        frame: usize,
        axes: Axes,
    ) -> Result<Twist<S>, FrameError> {
        self.check_motion(frame, q, qd)?;
        let Self { prepared, workspace, .. } = self;
        Ok(kinematics::jacobian_rate(prepared, frame, (q, qd), axes, workspace))
    }
}

/// Quantities of the moving links as a whole, in world axes.
impl<S: Scalar> Interpreter<S> {
    /// The centre of mass, m; not a number where there is no mass.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn center_of_mass(&mut self, q: &[S]) -> Result<Vector3<S>, ShapeError> {
        check("q", q, self.model.nq())?;
        Ok(center_of_mass(&self.prepared, q, &mut self.workspace))
    }

    /// The Jacobian of the centre of mass into `columns` (nv): its velocity is their sum times qd.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn center_of_mass_jacobian(
        &mut self,
        q: &[S],
        columns: &mut [Vector3<S>],
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("columns", columns, self.model.nv())?;
        center_of_mass_jacobian(&self.prepared, q, &mut self.workspace, columns);
        Ok(())
    }

    /// The centroidal momentum matrix A into `columns` (nv): the momentum about the centre of mass
    /// is A qd.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_momentum_matrix(
        &mut self,
        q: &[S],
        columns: &mut [Momentum<S>],
    ) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        check("columns", columns, self.model.nv())?;
        centroidal_momentum_matrix(&self.prepared, q, &mut self.workspace, columns);
        Ok(())
    }

    /// The momentum about the centre of mass.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_momentum(&mut self, q: &[S], qd: &[S]) -> Result<Momentum<S>, ShapeError> {
        check("q", q, self.model.nq())?;
        check("qd", qd, self.model.nv())?;
        Ok(centroidal_momentum(&self.prepared, (q, qd), &mut self.workspace))
    }
}
