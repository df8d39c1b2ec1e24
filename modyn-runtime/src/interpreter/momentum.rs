//! The centre of mass, and the momentum about it.

use super::Interpreter;
use super::errors::{ShapeError, check};
use crate::Scalar;
use crate::equations::derivatives::{CentroidalOutputs, centroidal_momentum_derivatives};
use crate::equations::dynamics::{
    centroidal_composite_inertia, centroidal_momentum, centroidal_momentum_matrix,
    centroidal_momentum_rate,
};
use crate::equations::kinematics::{center_of_mass, center_of_mass_jacobian};
use crate::equations::{Motion, State};
use crate::spatial::{Momentum, Vector3};

/// Functions of all moving links together, in world axes.
impl<S: Scalar> Interpreter<S> {
    /// Returns the centre of mass of the moving links in world axes, m; NaN if their mass is zero.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// assert!((pendulum.center_of_mass(&[0.0])?[2] + 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn center_of_mass(&mut self, q: &[S]) -> Result<[S; 3], ShapeError> {
        self.check_coordinates(q)?;
        Ok(center_of_mass(&self.mechanism, q, &mut self.workspace).0)
    }

    /// Computes the Jacobian of the centre of mass into `columns` (nv), world axes. Its product
    /// with qd is the velocity of the centre of mass.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn center_of_mass_jacobian(
        &mut self,
        q: &[S],
        columns: &mut [Vector3<S>],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        check("columns", columns, self.model.nv())?;
        center_of_mass_jacobian(&self.mechanism, q, &mut self.workspace, columns);
        Ok(())
    }

    /// Computes the centroidal momentum matrix A into `columns` (nv), world axes: A qd is the
    /// momentum about the centre of mass (Orin, Goswami and Lee 2013). Rotors have energy, but no
    /// momentum: their axes are not described.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_momentum_matrix(
        &mut self,
        q: &[S],
        columns: &mut [Momentum<S>],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        check("columns", columns, self.model.nv())?;
        centroidal_momentum_matrix(&self.mechanism, q, &mut self.workspace, columns);
        Ok(())
    }

    /// Computes the centroidal composite inertia I into `columns`, world axes: I t is the momentum
    /// about the centre of mass of all moving links as one rigid body with the twist t at the
    /// centre of mass (Orin, Goswami and Lee 2013; Pinocchio's `Ig`).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_composite_inertia(
        &mut self,
        q: &[S],
        columns: &mut [Momentum<S>; 6],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        centroidal_composite_inertia(&self.mechanism, q, &mut self.workspace, columns);
        Ok(())
    }

    /// Returns the momentum about the centre of mass in world axes, kg m^2/s and kg m/s. Rotors
    /// have energy, but no momentum: their axes are not described.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_momentum(&mut self, q: &[S], qd: &[S]) -> Result<Momentum<S>, ShapeError> {
        self.check_state(State { q, qd })?;
        Ok(centroidal_momentum(&self.mechanism, State { q, qd }, &mut self.workspace))
    }

    /// Returns the time derivative A qdd + A' qd of
    /// [`centroidal_momentum`](Self::centroidal_momentum) in world axes, N and N m: the wrench
    /// about the centre of mass of gravity and of all forces from outside. At qdd = 0 it is the
    /// bias A' qd.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_momentum_rate(
        &mut self,
        motion: Motion<'_, S>,
    ) -> Result<Momentum<S>, ShapeError> {
        self.check_motion(motion)?;
        Ok(centroidal_momentum_rate(&self.mechanism, motion, &mut self.workspace))
    }

    /// Computes [`centroidal_momentum`](Self::centroidal_momentum), its time derivative, and the
    /// derivatives of both, nv columns each. The derivatives of the momentum by qd and of the rate
    /// by qdd are the [`centroidal_momentum_matrix`](Self::centroidal_momentum_matrix).
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn centroidal_momentum_derivatives(
        &mut self,
        motion: Motion<'_, S>,
        outputs: CentroidalOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        let nv = self.model.nv();
        self.check_motion(motion)?;
        check("dmomentum_dq", outputs.dmomentum_dq, nv)?;
        check("drate_dq", outputs.drate_dq, nv)?;
        check("drate_dqd", outputs.drate_dqd, nv)?;
        centroidal_momentum_derivatives(&self.mechanism, motion, &mut self.workspace, outputs);
        Ok(())
    }
}
