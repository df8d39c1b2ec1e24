//! Derivatives of inverse and forward dynamics.

use super::Interpreter;
use super::errors::ShapeError;
use crate::Scalar;
use crate::equations::brge::UduLayout;
pub use crate::equations::derivatives::ForwardDerivatives;
use crate::equations::dynamics::Forces;
use crate::equations::{ForwardInput, Motion, State, derivatives};
use crate::model::ModuleTree;

impl<S: Scalar> Interpreter<S> {
    /// Computes the derivatives d tau / d q and d tau / d qd of inverse dynamics, nv x nv matrices
    /// by columns.
    ///
    /// The derivative with respect to q is in the tangent space: for spherical and floating joints,
    /// with respect to displacements in the link's own axes. d tau / d qdd is the
    /// [`mass_matrix`](Self::mass_matrix). The derivative of Coulomb friction is taken as 0, also
    /// at its jump.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_derivatives(
        &mut self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        dtau_dq: &mut [S],
        dtau_dqd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_motion(Motion { q, qd, qdd })?;
        self.check_matrices(&[("dtau_dq", dtau_dq), ("dtau_dqd", dtau_dqd)])?;
        let Self { mechanism, workspace, .. } = self;
        let motion = Motion { q, qd, qdd };
        derivatives::inverse_dynamics_derivatives(mechanism, motion, workspace, dtau_dq, dtau_dqd);
        Ok(())
    }

    /// Computes the Coriolis matrix C, nv x nv, by columns. C qd are the Coriolis and centrifugal
    /// forces, and dM/dt - 2 C is skew with the [`mass_matrix`](Self::mass_matrix) M. Gravity,
    /// damping and friction are not included. The first call allocates memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn coriolis_matrix(
        &mut self,
        q: &[S],
        qd: &[S],
        columns: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_state(State { q, qd })?;
        self.check_matrices(&[("columns", columns)])?;
        derivatives::coriolis_matrix(
            &self.mechanism,
            State { q, qd },
            &mut self.workspace,
            columns,
        );
        Ok(())
    }

    /// Computes the generalized forces `tau` = J^T f of external wrenches f (N m or N), one for
    /// each link of the description, and their derivatives with respect to q (in the tangent
    /// space), an nv x nv matrix by columns.
    ///
    /// The wrenches are constant while q changes: those in link axes rotate with their links, those
    /// in world axes do not. Both act at the links' origins, which move.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn generalized_forces(
        &mut self,
        q: &[S],
        forces: Forces<'_, S>,
        tau: &mut [S],
        dtau_dq: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_coordinates(q)?;
        self.check_forces(Some(forces))?;
        self.check_vectors(&[("tau", tau)])?;
        self.check_matrices(&[("dtau_dq", dtau_dq)])?;
        let Self { mechanism, workspace, .. } = self;
        derivatives::generalized_forces(mechanism, q, forces, workspace, tau, dtau_dq);
        Ok(())
    }

    /// Computes the derivatives d tau / d q and d tau / d qd of
    /// [`inverse_dynamics_external`](Self::inverse_dynamics_external), nv x nv matrices by columns.
    ///
    /// The wrenches are constant while q changes: those in link axes rotate with their links, those
    /// in world axes do not. Both act at the links' origins, which move. The first call allocates
    /// memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn inverse_dynamics_external_derivatives(
        &mut self,
        motion: Motion<'_, S>,
        forces: Forces<'_, S>,
        dtau_dq: &mut [S],
        dtau_dqd: &mut [S],
    ) -> Result<(), ShapeError> {
        self.check_motion(motion)?;
        self.check_forces(Some(forces))?;
        self.check_matrices(&[("dtau_dq", dtau_dq), ("dtau_dqd", dtau_dqd)])?;
        let Self { mechanism, workspace, .. } = self;
        let derive = derivatives::inverse_dynamics_external_derivatives;
        derive(mechanism, motion, forces, workspace, dtau_dq, dtau_dqd);
        Ok(())
    }

    /// Computes the joint accelerations under the joint forces `tau`, and their derivatives with
    /// respect to q (in the tangent space), qd and tau, nv x nv matrices by columns.
    ///
    /// The derivative with respect to tau is the inverse of the mass matrix, exactly symmetric. The
    /// first call allocates memory.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let [mut qdd, mut dqdd_dq, mut dqdd_dqd, mut dqdd_dtau] = [[0.0]; 4];
    /// let outputs = modyn_runtime::ForwardDerivatives {
    ///     qdd: &mut qdd,
    ///     dqdd_dq: &mut dqdd_dq,
    ///     dqdd_dqd: &mut dqdd_dqd,
    ///     dqdd_dtau: &mut dqdd_dtau,
    /// };
    /// pendulum.forward_dynamics_derivatives(&[0.0], &[0.0], &[0.0], outputs)?;
    /// assert!((dqdd_dq[0] + 9.81 / 0.5).abs() < 1e-12 && (dqdd_dtau[0] - 2.0).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_derivatives(
        &mut self,
        q: &[S],
        qd: &[S],
        tau: &[S],
        outputs: ForwardDerivatives<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_derivatives(ForwardInput { q, qd, tau }, &outputs)?;
        let Self { mechanism, workspace, model, links, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let input = ForwardInput { q, qd, tau };
        derivatives::forward_dynamics_derivatives(mechanism, layout, input, workspace, outputs);
        Ok(())
    }

    /// Computes the joint accelerations under the joint forces `tau` and external wrenches, and
    /// their derivatives with respect to q (in the tangent space), qd and tau, nv x nv matrices by
    /// columns.
    ///
    /// The wrenches are constant while q changes: those in link axes rotate with their links, those
    /// in world axes do not. Both act at the links' origins, which move. The first call allocates
    /// memory.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn forward_dynamics_external_derivatives(
        &mut self,
        input: ForwardInput<'_, S>,
        forces: Forces<'_, S>,
        outputs: ForwardDerivatives<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_forces(Some(forces))?;
        self.check_derivatives(input, &outputs)?;
        let Self { mechanism, workspace, model, links, .. } = self;
        let layout =
            links.get_or_insert_with(|| UduLayout::new(mechanism, &ModuleTree::links(model)));
        let derive = derivatives::forward_dynamics_external_derivatives;
        derive(mechanism, layout, input, forces, workspace, outputs);
        Ok(())
    }

    fn check_derivatives(
        &self,
        input: ForwardInput<'_, S>,
        outputs: &ForwardDerivatives<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_forward_input(input)?;
        self.check_vectors(&[("qdd", outputs.qdd)])?;
        self.check_matrices(&[
            ("dqdd_dq", outputs.dqdd_dq),
            ("dqdd_dqd", outputs.dqdd_dqd),
            ("dqdd_dtau", outputs.dqdd_dtau),
        ])
    }
}
