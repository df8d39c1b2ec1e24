//! Inverse and forward dynamics, the mass matrix, gravity and energy.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::dynamics::{
    forward_dynamics, gravity_torques, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy,
};
use crate::equations::{Forces, ForwardInput, State};

impl<S: Scalar> Interpreter<S> {
    /// Computes the joint accelerations `qdd` (rad/s^2 or m/s^2) under the joint forces `tau`, by
    /// the inter- and intra-modular recursion (60) of the paper.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut qdd = [0.0];
    /// pendulum.forward_dynamics(&[1.0], &[0.0], &[0.0], &mut qdd)?;
    /// assert!((qdd[0] + 9.81 / 0.5 * 1.0_f64.sin()).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
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
        self.accelerate(ForwardInput { q, qd, tau }, None, qdd)
    }

    /// Computes the joint accelerations `qdd` under the joint forces `tau` and external wrenches
    /// `forces`: one wrench for each link of the description, fixed links included, in the order of
    /// [`Model::links`](crate::model::Model::links).
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
        self.accelerate(ForwardInput { q, qd, tau }, Some(forces), qdd)
    }

    fn accelerate(
        &mut self,
        input: ForwardInput<'_, S>,
        forces: Option<Forces<'_, S>>,
        qdd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_forward_input(input)?;
        self.check_forces(forces)?;
        self.check_vectors(&[("qdd", qdd)])?;
        let Self { mechanism, elimination, workspace, .. } = self;
        forward_dynamics(mechanism, elimination, input, forces, workspace, qdd);
        Ok(())
    }

    pub(super) fn check_forces(&self, forces: Option<Forces<'_, S>>) -> Result<(), ShapeError> {
        forces.map_or(Ok(()), |forces| {
            check("forces", forces.wrenches(), self.mechanism.frames.len())
        })
    }

    /// Computes the joint forces `tau` (N m or N) of the accelerations `qdd`, by the recursive
    /// Newton-Euler algorithm (Featherstone 2008, chapter 5).
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut tau = [0.0];
    /// pendulum.inverse_dynamics(&[0.0], &[0.0], &[1.0], &mut tau)?;
    /// assert!((tau[0] - 2.0 * 0.5 * 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
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
        self.required_torques(State { q, qd }, Some(qdd), None, tau)
    }

    /// Computes the joint forces `tau` of the accelerations `qdd` under external wrenches `forces`:
    /// one wrench for each link of the description, fixed links included, in the order of
    /// [`Model::links`](crate::model::Model::links).
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
        self.required_torques(State { q, qd }, Some(qdd), Some(forces), tau)
    }

    fn required_torques(
        &mut self,
        state: State<'_, S>,
        qdd: Option<&[S]>,
        forces: Option<Forces<'_, S>>,
        tau: &mut [S],
    ) -> Result<(), ShapeError> {
        let n = self.model.nv();
        self.check_state(state)?;
        qdd.map_or(Ok(()), |qdd| check("qdd", qdd, n))?;
        self.check_forces(forces)?;
        self.check_vectors(&[("tau", tau)])?;
        inverse_dynamics(&self.mechanism, state, qdd, forces, &mut self.workspace, tau);
        Ok(())
    }

    /// Computes the bias forces h(q, qd): the joint forces at zero acceleration.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut tau = [0.0];
    /// pendulum.bias_forces(&[1.0], &[3.0], &mut tau)?;
    /// assert!((tau[0] - 2.0 * 9.81 * 0.5 * 1.0_f64.sin()).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn bias_forces(&mut self, q: &[S], qd: &[S], tau: &mut [S]) -> Result<(), ShapeError> {
        self.required_torques(State { q, qd }, None, None, tau)
    }

    /// Computes the joint forces that balance gravity and springs at zero velocity: the gradient of
    /// the [`potential_energy`](Self::potential_energy).
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut tau = [0.0];
    /// pendulum.gravity_torques(&[1.0], &mut tau)?;
    /// assert!((tau[0] - 2.0 * 9.81 * 0.5 * 1.0_f64.sin()).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn gravity_torques(&mut self, q: &[S], tau: &mut [S]) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        self.check_vectors(&[("tau", tau)])?;
        gravity_torques(&self.mechanism, q, &mut self.workspace, tau);
        Ok(())
    }

    /// Computes the mass matrix, nv x nv, into `columns`, column by column: (7)-(10) of the paper.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut columns = [0.0];
    /// pendulum.mass_matrix(&[1.0], &mut columns)?;
    /// assert!((columns[0] - 2.0 * 0.5 * 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn mass_matrix(&mut self, q: &[S], columns: &mut [S]) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        self.check_matrices(&[("columns", columns)])?;
        mass_matrix(&self.mechanism, q, &mut self.workspace, columns);
        Ok(())
    }

    /// Returns the kinetic energy of the moving links and the rotors, J.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// assert!((pendulum.kinetic_energy(&[1.0], &[2.0])? - 1.0).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn kinetic_energy(&mut self, q: &[S], qd: &[S]) -> Result<S, ShapeError> {
        self.check_state(State { q, qd })?;
        Ok(kinetic_energy(&self.mechanism, q, qd, &mut self.workspace))
    }

    /// Returns the potential energy of the moving links under gravity and of the springs, J; zero
    /// for mass at the world's origin and springs at rest.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// assert!((pendulum.potential_energy(&[0.0])? + 2.0 * 9.81 * 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn potential_energy(&mut self, q: &[S]) -> Result<S, ShapeError> {
        self.check_coordinates(q)?;
        Ok(potential_energy(&self.mechanism, q, &mut self.workspace))
    }
}
