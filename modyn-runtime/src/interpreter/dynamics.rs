//! Inverse and forward dynamics, the mass matrix, gravity and energy.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::Forces;
use crate::equations::dynamics::{
    forward_dynamics, gravity_torques, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy,
};

impl<S: Scalar> Interpreter<S> {
    /// The joint accelerations `qdd` (rad/s^2 or m/s^2) under the joint torques or forces `tau`:
    /// the inter- and intra-modular recursion, (60).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.accelerate((q, qd, tau), None, qdd)
    }

    /// The same under `forces` from outside: one wrench for each link of the description, fixed
    /// ones too, in the order of [`Model::frames`](crate::model::Model::frames).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_external(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        forces: Forces<'_, S>,
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.accelerate((q, qd, tau), Some(forces), qdd)
    }

    fn accelerate(
        &mut self,
        (q, qd, tau): (&[S], &[S], &[S]),
        forces: Option<Forces<'_, S>>,
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        check("tau", tau, n)?;
        self.check_forces(forces)?;
        check("qdd", qdd, n)?;
        let Self { mechanism, elimination, workspace, .. } = self;
        let state = (q, qd, tau);
        forward_dynamics(mechanism, elimination, state, forces, workspace, qdd);
        Ok(())
    }

    fn check_forces(&self, forces: Option<Forces<'_, S>>) -> Result<(), ShapeError> {
        forces
            .map_or(Ok(()), |forces| check("forces", forces.wrenches(), self.model.frames().len()))
    }

    /// The joint torques or forces `tau` (N m or N) of a motion: recursive Newton-Euler.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        self.required_torques((q, qd, Some(qdd)), None, tau)
    }

    /// The same under `forces` from outside, which take their share off the joints: one wrench for
    /// each link of the description, fixed ones too, in the order of [`Model::frames`](crate::model::Model::frames).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_external(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        forces: Forces<'_, S>,
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        self.required_torques((q, qd, Some(qdd)), Some(forces), tau)
    }

    fn required_torques(
        &mut self,
        (q, qd, qdd): (&[S], &[S], Option<&[S]>),
        forces: Option<Forces<'_, S>>,
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        qdd.map_or(Ok(()), |qdd| check("qdd", qdd, n))?;
        self.check_forces(forces)?;
        check("tau", tau, n)?;
        let (motion, workspace) = ((q, qd, qdd), &mut self.workspace);
        inverse_dynamics(&self.mechanism, motion, forces, workspace, tau);
        Ok(())
    }

    /// The bias forces h(q, qd) into `tau`: inverse dynamics without acceleration.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn bias_forces(&mut self, q: &[S], qd: &[S], tau: &mut [S]) -> Result<(), ShapeError> {
        self.required_torques((q, qd, None), None, tau)
    }

    /// The joint torques that hold the robot still, into `tau`.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn gravity_torques(&mut self, q: &[S], tau: &mut [S]) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("tau", tau, n)?;
        gravity_torques(&self.mechanism, q, &mut self.workspace, tau);
        Ok(())
    }

    /// The mass matrix by columns into `columns` (nv times nv), (7)-(10).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn mass_matrix(&mut self, q: &[S], columns: &mut [S]) -> Result<(), ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("columns", columns, n * n)?;
        mass_matrix(&self.mechanism, q, &mut self.workspace, columns);
        Ok(())
    }

    /// Kinetic energy of the moving links, J.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn kinetic_energy(&mut self, q: &[S], qd: &[S]) -> Result<S, ShapeError> {
        let n = self.model.nv();
        check("q", q, self.model.nq())?;
        check("qd", qd, n)?;
        Ok(kinetic_energy(&self.mechanism, q, qd, &mut self.workspace))
    }

    /// Potential energy of the moving links under gravity, J; zero at the world's origin.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn potential_energy(&mut self, q: &[S]) -> Result<S, ShapeError> {
        check("q", q, self.model.nq())?;
        Ok(potential_energy(&self.mechanism, q, &mut self.workspace))
    }
}
