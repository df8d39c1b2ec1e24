//! Poses, motion and Jacobians of the links.

use super::Interpreter;
use super::errors::{LinkError, ShapeError, check};
use crate::Scalar;
use crate::equations::kinematics::{self, Axes};
use crate::equations::{Motion, State};
use crate::spatial::{Pose, Twist};

/// Functions of one link. `link` is the link's index in
/// [`Model::links`](crate::model::Model::links), which
/// [`Model::link_index`](crate::model::Model::link_index) finds by name; fixed links have one,
/// too. Motion is the motion of the link's origin; a link that is fixed to the world does not move.
/// A call takes time linear in the depth of the link, apart from zero columns.
impl<S: Scalar> Interpreter<S> {
    fn check_link(&self, link: usize) -> Result<(), LinkError> {
        let count = self.mechanism.frames.len();
        if link < count { Ok(()) } else { Err(LinkError::NoLink { link, count }) }
    }

    fn check_link_state(&self, link: usize, state: State<'_, S>) -> Result<(), LinkError> {
        self.check_link(link)?;
        Ok(self.check_state(state)?)
    }

    /// Returns the pose of a link in the world.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let pendulum = Interpreter::<f64>::new(model);
    /// let bob = pendulum.model().link_index("bob").expect("a link");
    /// let pose = pendulum.link_pose(&[0.0], bob)?;
    /// assert!((pose.translation[2] + 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::LinkError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_pose(&self, q: &[S], link: usize) -> Result<Pose<S>, LinkError> {
        self.check_link(link)?;
        self.check_coordinates(q)?;
        Ok(kinematics::link_pose(&self.mechanism, link, q))
    }

    /// Returns the velocity of a link relative to the world, at the link's origin in world axes,
    /// rad/s and m/s.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let bob = pendulum.model().link_index("bob").expect("a link");
    /// let twist = pendulum.link_velocity(&[0.0], &[2.0], bob)?;
    /// assert!((twist.angular[1] - 2.0).abs() < 1e-12 && (twist.linear[0] + 1.0).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::LinkError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_velocity(&mut self, q: &[S], qd: &[S], link: usize) -> Result<Twist<S>, LinkError> {
        self.velocity(q, qd, link, Axes::World)
    }

    /// Returns the velocity of a link relative to the world, at the link's origin in the link's own
    /// axes, rad/s and m/s.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_velocity_local(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
    ) -> Result<Twist<S>, LinkError> {
        self.velocity(q, qd, link, Axes::Link)
    }

    fn velocity(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
        axes: Axes,
    ) -> Result<Twist<S>, LinkError> {
        self.check_link_state(link, State { q, qd })?;
        let Self { mechanism, workspace, .. } = self;
        Ok(kinematics::link_velocity(mechanism, link, State { q, qd }, axes, workspace))
    }

    /// Returns the angular acceleration of a link, rad/s^2, and the classical acceleration of its
    /// origin, m/s^2, in world axes. Gravity is not included.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_acceleration(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        link: usize,
    ) -> Result<Twist<S>, LinkError> {
        self.acceleration(Motion { q, qd, qdd }, link, Axes::World)
    }

    /// Returns the angular acceleration of a link and the classical acceleration of its origin, in
    /// the link's own axes. Gravity is not included.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn link_acceleration_local(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        link: usize,
    ) -> Result<Twist<S>, LinkError> {
        self.acceleration(Motion { q, qd, qdd }, link, Axes::Link)
    }

    fn acceleration(
        &mut self,
        Motion { q, qd, qdd }: Motion<'_, S>,
        link: usize,
        axes: Axes,
    ) -> Result<Twist<S>, LinkError> {
        self.check_link_state(link, State { q, qd })?;
        self.check_vectors(&[("qdd", qdd)])?;
        let Self { mechanism, workspace, .. } = self;
        Ok(kinematics::link_acceleration(mechanism, link, Motion { q, qd, qdd }, axes, workspace))
    }

    /// Computes the Jacobian J of a link into `columns` (nv), at the link's origin in world axes
    /// (Pinocchio's `LOCAL_WORLD_ALIGNED`). J qd is the link's [velocity](Self::link_velocity).
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let bob = pendulum.model().link_index("bob").expect("a link");
    /// let mut columns = [modyn_runtime::Twist::zero()];
    /// pendulum.jacobian(&[0.0], bob, &mut columns)?;
    /// assert!((columns[0].angular[1] - 1.0).abs() < 1e-12 && (columns[0].linear[0] + 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::LinkError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian(
        &mut self,
        q: &[S],
        link: usize,
        columns: &mut [Twist<S>],
    ) -> Result<(), LinkError> {
        self.jacobian_in(q, link, Axes::World, columns)
    }

    /// Computes the Jacobian J of a link into `columns` (nv), at the link's origin in the link's
    /// own axes (Pinocchio's `LOCAL`). J qd is the link's [velocity](Self::link_velocity_local).
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian_local(
        &mut self,
        q: &[S],
        link: usize,
        columns: &mut [Twist<S>],
    ) -> Result<(), LinkError> {
        self.jacobian_in(q, link, Axes::Link, columns)
    }

    fn jacobian_in(
        &mut self,
        q: &[S],
        link: usize,
        axes: Axes,
        columns: &mut [Twist<S>],
    ) -> Result<(), LinkError> {
        self.check_link(link)?;
        self.check_coordinates(q)?;
        check("columns", columns, self.model.nv())?;
        let Self { mechanism, workspace, .. } = self;
        kinematics::jacobian(mechanism, link, q, axes, workspace, columns);
        Ok(())
    }

    /// Computes the time derivative dJ/dt of a link's [`jacobian`](Self::jacobian) J, in world
    /// axes, a column for each entry of qd: dJ/dt qd is
    /// [`jacobian_dot_qd`](Self::jacobian_dot_qd).
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian_time_derivative(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
        columns: &mut [Twist<S>],
    ) -> Result<(), LinkError> {
        self.jacobian_time_derivative_in(State { q, qd }, link, Axes::World, columns)
    }

    /// Computes the time derivative dJ/dt of a link's [`jacobian_local`](Self::jacobian_local) J,
    /// in the link's own axes, a column for each entry of qd: dJ/dt qd is
    /// [`jacobian_dot_qd_local`](Self::jacobian_dot_qd_local).
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian_time_derivative_local(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
        columns: &mut [Twist<S>],
    ) -> Result<(), LinkError> {
        self.jacobian_time_derivative_in(State { q, qd }, link, Axes::Link, columns)
    }

    fn jacobian_time_derivative_in(
        &mut self,
        State { q, qd }: State<'_, S>,
        link: usize,
        axes: Axes,
        columns: &mut [Twist<S>],
    ) -> Result<(), LinkError> {
        self.check_link_state(link, State { q, qd })?;
        check("columns", columns, self.model.nv())?;
        let Self { mechanism, workspace, .. } = self;
        let state = State { q, qd };
        kinematics::jacobian_time_derivative(mechanism, link, state, axes, workspace, columns);
        Ok(())
    }

    /// Returns the bias acceleration dJ/dt qd of a link in world axes: its
    /// [acceleration](Self::link_acceleration) at zero joint accelerations.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian_dot_qd(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
    ) -> Result<Twist<S>, LinkError> {
        self.jacobian_dot_qd_in(q, qd, link, Axes::World)
    }

    /// Returns the bias acceleration dJ/dt qd of a link in its own axes: the time derivative of the
    /// components of [`link_velocity_local`](Self::link_velocity_local) at constant qd.
    ///
    /// Its linear part is the classical acceleration in these axes minus the cross product of the
    /// angular and the linear velocity.
    ///
    /// # Errors
    ///
    /// If there is no such link, or if a slice does not have the model's length.
    pub fn jacobian_dot_qd_local(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
    ) -> Result<Twist<S>, LinkError> {
        self.jacobian_dot_qd_in(q, qd, link, Axes::Link)
    }

    fn jacobian_dot_qd_in(
        &mut self,
        q: &[S],
        qd: &[S],
        link: usize,
        axes: Axes,
    ) -> Result<Twist<S>, LinkError> {
        self.check_link_state(link, State { q, qd })?;
        let Self { mechanism, workspace, .. } = self;
        Ok(kinematics::jacobian_dot_qd(mechanism, link, State { q, qd }, axes, workspace))
    }
}

/// Functions of all links at once.
impl<S: Scalar> Interpreter<S> {
    /// Computes the poses in the world of all links of the description, fixed links included, in
    /// the order of [`Model::links`](crate::model::Model::links).
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut poses = [modyn_runtime::Pose::identity(); 2];
    /// pendulum.link_poses(&[0.0], &mut poses)?;
    /// assert!((poses[1].translation[2] + 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn link_poses(&mut self, q: &[S], poses: &mut [Pose<S>]) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        check("poses", poses, self.mechanism.frames.len())?;
        let Self { mechanism, workspace, body_poses, .. } = self;
        kinematics::link_poses(mechanism, q, workspace, body_poses, poses);
        Ok(())
    }
}
