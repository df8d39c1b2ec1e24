//! Moving in the space of the coordinates.

use alloc::string::String;

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::equations::kinematics::coordinates;
use crate::{ConfigurationError, Scalar, configuration};

impl<S: Scalar> Interpreter<S> {
    /// Where the constant velocities `v` lead from `q` in a unit of time, q (+) v, into `moved`: so
    /// one step of time dt is with `v` = qd dt.
    ///
    /// Plain coordinates add; rotations and poses follow the exponential map in their own axes
    /// (those of qd), and their quaternions stay of length 1.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn integrate(&self, q: &[S], v: &[S], moved: &mut [S]) -> Result<(), ShapeError> {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        check("q", q, nq)?;
        check("v", v, nv)?;
        check("moved", moved, nq)?;
        coordinates::integrate(&self.mechanism, (q, v), moved);
        Ok(())
    }

    /// The velocities that lead from one place to another in a unit of time, into `v`: the inverse
    /// of [`integrate`](Self::integrate), by the shortest rotations. Angles are not wrapped.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn difference(&self, from: &[S], to: &[S], v: &mut [S]) -> Result<(), ShapeError> {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        check("from", from, nq)?;
        check("to", to, nq)?;
        check("v", v, nv)?;
        coordinates::difference(&self.mechanism, (from, to), v);
        Ok(())
    }

    /// The rates dq/dt of the coordinates at velocities `qd`, into `rates` (as many as q has).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn velocity_to_qdot(&self, q: &[S], qd: &[S], rates: &mut [S]) -> Result<(), ShapeError> {
        let (nq, nv) = (self.model.nq(), self.model.nv());
        check("q", q, nq)?;
        check("qd", qd, nv)?;
        check("rates", rates, nq)?;
        coordinates::velocity_to_qdot(&self.mechanism, (q, qd), rates);
        Ok(())
    }

    /// Checks that the quaternions of spherical and floating joints in `q` have length 1, to half of the scalar's digits:
    /// to 1.5e-8 in `f64`, to 3.5e-4 in `f32`. No other function checks it: with a quaternion of length 1.1, accelerations
    /// are wrong by a part in a thousand or more.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length, or the first joint whose quaternion has another length than 1.
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

    /// Brings the quaternions in `q` to length 1; one of length 0 becomes the identity.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn normalize(&self, q: &mut [S]) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        coordinates::normalize(&self.mechanism, q);
        Ok(())
    }

    /// The coordinates zero, with identity quaternions, into `q`.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn neutral(&self, q: &mut [S]) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        coordinates::neutral(&self.mechanism, q);
        Ok(())
    }

    /// Random coordinates into `q`, evenly spread within the joints' limits; without limits, angles
    /// in half a turn both ways, displacements in 1 m both ways, and rotations everywhere.
    ///
    /// `uniform` gives independent numbers evenly spread in 0..1; it is called nv times.
    ///
    /// # Errors
    ///
    /// If `q` does not have the model's length.
    pub fn random(&self, mut uniform: impl FnMut() -> S, q: &mut [S]) -> Result<(), ShapeError> {
        check("q", q, self.model.nq())?;
        coordinates::random(&self.mechanism, &mut uniform, q);
        Ok(())
    }
}
