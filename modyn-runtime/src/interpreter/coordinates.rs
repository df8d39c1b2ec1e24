//! The configuration space: integration, differences, rates, checks and random coordinates.

use alloc::string::String;

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::equations::State;
use crate::equations::kinematics::coordinates;
use crate::{ConfigurationError, Scalar, configuration};

impl<S: Scalar> Interpreter<S> {
    /// Computes the coordinates after unit time at the constant velocities `v` from `q`: q (+) v,
    /// nq entries. For a time step dt use `v` = qd dt.
    ///
    /// Coordinates of revolute and prismatic joints are added. Rotations and poses follow the
    /// exponential map in their own axes, which are the axes of qd; quaternions keep length 1.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let pendulum = Interpreter::<f64>::new(model);
    /// let (qd, dt) = (2.0, 0.01);
    /// let mut q = [0.0];
    /// pendulum.integrate(&[1.0], &[qd * dt], &mut q)?;
    /// assert!((q[0] - 1.02).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn integrate(&self, q: &[S], v: &[S], moved: &mut [S]) -> Result<(), ShapeError> {
        let nq = self.model.nq();
        self.check_coordinates(q)?;
        self.check_vectors(&[("v", v)])?;
        check("moved", moved, nq)?;
        coordinates::integrate(&self.mechanism, q, v, moved);
        Ok(())
    }

    /// Computes the velocities `v` that lead from `from` to `to` in unit time, nv entries: the
    /// inverse of [`integrate`](Self::integrate). Rotations are the shortest ones; joint angles are
    /// not wrapped.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn difference(&self, from: &[S], to: &[S], v: &mut [S]) -> Result<(), ShapeError> {
        let nq = self.model.nq();
        check("from", from, nq)?;
        check("to", to, nq)?;
        self.check_vectors(&[("v", v)])?;
        coordinates::difference(&self.mechanism, from, to, v);
        Ok(())
    }

    /// Computes the derivatives of [`integrate`](Self::integrate) with respect to `q` and `v`, nv x
    /// nv matrices by columns.
    ///
    /// Both are in the tangent space: displacements of `q` are in the axes at `q`, and
    /// displacements of the moved coordinates in the axes there. Nothing depends on `q` but its
    /// length.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn integrate_derivatives(
        &self,
        q: &[S],
        v: &[S],
        dq_dq: &mut [S],
        dq_dv: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        self.check_vectors(&[("v", v)])?;
        self.check_matrices(&[("dq_dq", dq_dq), ("dq_dv", dq_dv)])?;
        coordinates::integrate_derivatives(&self.mechanism, v, dq_dq, dq_dv);
        Ok(())
    }

    /// Computes the derivatives of [`difference`](Self::difference) with respect to `from` and
    /// `to`, nv x nv matrices by columns, in the tangent space: displacements are in the axes at
    /// `from` and at `to`.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn difference_derivatives(
        &self,
        from: &[S],
        to: &[S],
        dv_dfrom: &mut [S],
        dv_dto: &mut [S],
    ) -> Result<(), ShapeError> {
        let nq = self.model.nq();
        check("from", from, nq)?;
        check("to", to, nq)?;
        self.check_matrices(&[("dv_dfrom", dv_dfrom), ("dv_dto", dv_dto)])?;
        coordinates::difference_derivatives(&self.mechanism, from, to, dv_dfrom, dv_dto);
        Ok(())
    }

    /// Computes dq/dt, the rates of the coordinates `q` at the velocities `qd`, nq entries.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn velocity_to_qdot(&self, q: &[S], qd: &[S], rates: &mut [S]) -> Result<(), ShapeError> {
        let nq = self.model.nq();
        self.check_state(State { q, qd })?;
        check("rates", rates, nq)?;
        coordinates::velocity_to_qdot(&self.mechanism, q, qd, rates);
        Ok(())
    }

    /// Checks that the quaternions of spherical and floating joints in `q` have length 1.
    ///
    /// The tolerance is half of the scalar's digits: 1.5e-8 in `f64`, 3.5e-4 in `f32`. No other
    /// function checks quaternions. With a quaternion of length 1.1, accelerations are wrong by a
    /// part in a thousand or more.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length. Otherwise names the first joint whose quaternion
    /// does not have length 1.
    pub fn check_configuration(&self, q: &[S]) -> Result<(), ConfigurationError<S, String>>
    where
        S: PartialOrd,
    {
        check("q", q, self.model.nq()).map_err(|error| ConfigurationError::Shape {
            expected: error.expected,
            found: error.found,
        })?;
        let quaternions = self.model.quaternions();
        configuration::check(quaternions.map(|(joint, at)| (joint.into(), at)), q)
    }

    /// Scales the quaternions in `q` to length 1. A quaternion of length 0 becomes the identity.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn normalize_configuration(&self, q: &mut [S]) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        coordinates::normalize_configuration(&self.mechanism, q);
        Ok(())
    }

    /// Sets all coordinates in `q` to zero, and quaternions to the identity.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let pendulum = Interpreter::<f64>::new(model);
    /// let mut q = [1.0];
    /// pendulum.neutral(&mut q)?;
    /// assert_eq!(q, [0.0]);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn neutral(&self, q: &mut [S]) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        coordinates::neutral(&self.mechanism, q);
        Ok(())
    }

    /// Computes random coordinates, uniformly distributed within the joint limits. Without limits,
    /// angles are within -pi..pi, displacements within -1 m..1 m, and rotations uniformly
    /// distributed over SO(3).
    ///
    /// `uniform` returns independent numbers, uniformly distributed in 0..1. It is called nv times.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn random_configuration(
        &self,
        mut uniform: impl FnMut() -> S,
        q: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        coordinates::random(&self.mechanism, &mut uniform, q);
        Ok(())
    }
}
