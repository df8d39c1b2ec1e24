//! A method for each function of modyn's table.
//!
//! `cargo xtask pages` writes them.
#![allow(clippy::too_many_arguments)]

use pyo3::prelude::*;

use crate::robot::Robot;

type Argument<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

#[rustfmt::skip]
#[pymethods]
impl Robot {
    // <!-- data: python-methods -->
    /// Returns the joint accelerations (rad/s^2 or m/s^2) at the coordinates `q` and velocities
    /// `qd` under the joint forces `tau` (N m or N), gravity included. The method is block reverse
    /// Gaussian elimination of the mass matrix by inter- and intra-modular recursion.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,).
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, *, out=None))]
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 0, &[Some(q), Some(qd), Some(tau)], None, out)
    }

    /// Returns the joint forces (N m or N) of the accelerations `qdd` at the coordinates `q` and
    /// velocities `qd`, gravity included, by the recursive Newton-Euler algorithm.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, *, out=None))]
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 1, &[Some(q), Some(qd), Some(qdd)], None, out)
    }

    /// Returns the bias forces (N m or N): inverse dynamics at zero acceleration. They are the
    /// Coriolis, centrifugal and gravity forces and the forces of springs, with damping and
    /// friction if these are enabled.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,).
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, *, out=None))]
    fn bias_forces<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 2, &[Some(q), Some(qd)], None, out)
    }

    /// Returns the joint forces (N m or N) that balance gravity and springs at `q` and zero
    /// velocity.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn gravity_torques<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 3, &[Some(q)], None, out)
    }

    /// Returns the mass matrix at `q`, nv x nv.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (nv, nv). Several states have one more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn mass_matrix<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 4, &[Some(q)], None, out)
    }

    /// Returns the Coriolis matrix C, nv x nv. C `qd` are the Coriolis and centrifugal forces,
    /// without gravity, damping and friction, and dM/dt - 2 C is skew with the mass matrix M.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,).
    /// Result: (nv, nv). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, *, out=None))]
    fn coriolis_matrix<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 5, &[Some(q), Some(qd)], None, out)
    }

    /// Returns the kinetic energy of the moving links and the armatures, J.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,).
    /// Result: a number. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, *, out=None))]
    fn kinetic_energy<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 7, &[Some(q), Some(qd)], None, out)
    }

    /// Returns the potential energy of the moving links under gravity and of the springs, J; zero
    /// for mass at the world's origin and springs at rest.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: a number. Several states have one more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn potential_energy<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 8, &[Some(q)], None, out)
    }

    /// Returns the joint accelerations under `tau` and a wrench on each link (in the order of
    /// `link_names`), at the link's origin in the link's own axes.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `forces`: (links, 6), forces before
    /// moments.
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, forces, *, out=None))]
    fn forward_dynamics_external_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        forces: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 9, &[Some(q), Some(qd), Some(tau), Some(forces)], None, out)
    }

    /// Returns the joint accelerations under `tau` and a wrench on each link (in the order of
    /// `link_names`), at the link's origin in world axes.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `forces`: (links, 6), forces before
    /// moments.
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, forces, *, out=None))]
    fn forward_dynamics_external<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        forces: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 10, &[Some(q), Some(qd), Some(tau), Some(forces)], None, out)
    }

    /// Returns the joint forces of `qdd` under a wrench on each link (in the order of
    /// `link_names`), at the link's origin in the link's own axes.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `forces`: (links, 6), forces before
    /// moments.
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, forces, *, out=None))]
    fn inverse_dynamics_external_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        forces: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 11, &[Some(q), Some(qd), Some(qdd), Some(forces)], None, out)
    }

    /// Returns the joint forces of `qdd` under a wrench on each link (in the order of
    /// `link_names`), at the link's origin in world axes.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `forces`: (links, 6), forces before
    /// moments.
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, forces, *, out=None))]
    fn inverse_dynamics_external<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        forces: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 12, &[Some(q), Some(qd), Some(qdd), Some(forces)], None, out)
    }

    /// Returns the generalized forces J^T f of a wrench on each link (in the order of
    /// `link_names`), at the link's origin in the link's own axes, and their derivative with
    /// respect to `q` (in tangent space). The wrenches rotate with their links.
    ///
    /// Arguments: `q`: (nq,); `forces`: (links, 6), forces before moments.
    /// Result: `GeneralizedForces`: `tau` (nv,), `dtau_dq` (nv, nv). Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, forces, *, out=None))]
    fn generalized_forces_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        forces: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 13, &[Some(q), Some(forces)], None, out)
    }

    /// Returns the generalized forces J^T f of a wrench on each link (in the order of
    /// `link_names`), at the link's origin in world axes, and their derivative with respect to `q`
    /// (in tangent space). The wrenches keep their directions.
    ///
    /// Arguments: `q`: (nq,); `forces`: (links, 6), forces before moments.
    /// Result: `GeneralizedForces`: `tau` (nv,), `dtau_dq` (nv, nv). Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, forces, *, out=None))]
    fn generalized_forces<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        forces: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 14, &[Some(q), Some(forces)], None, out)
    }

    /// Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`.
    /// The derivative with respect to `qdd` is the mass matrix.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
    /// Result: `InverseDynamicsDerivatives`: `dtau_dq` (nv, nv), `dtau_dqd` (nv, nv). Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, *, out=None))]
    fn inverse_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 15, &[Some(q), Some(qd), Some(qdd)], None, out)
    }

    /// Returns the joint accelerations, and the derivatives of forward dynamics with respect to `q`
    /// (in tangent space), `qd` and `tau`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,).
    /// Result: `ForwardDynamicsDerivatives`: `qdd` (nv,), `dqdd_dq` (nv, nv), `dqdd_dqd` (nv, nv),
    /// `dqdd_dtau` (nv, nv). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, *, out=None))]
    fn forward_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 16, &[Some(q), Some(qd), Some(tau)], None, out)
    }

    /// Returns the joint forces tau of `qdd`, and the products of `cotangent` with their
    /// derivatives: the gradients of `cotangent`^T tau with respect to `q` (in tangent space), `qd`
    /// and `qdd`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `cotangent`: (nv,).
    /// Result: `InverseDynamicsVjp`: `tau` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_qdd`
    /// (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, cotangent, *, out=None))]
    fn inverse_dynamics_vjp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        cotangent: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 17, &[Some(q), Some(qd), Some(qdd), Some(cotangent)], None, out)
    }

    /// Returns the joint forces tau of `qdd`, and their change under the changes `tangent_q` (in
    /// tangent space), `tangent_qd` and `tangent_qdd`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,);
    /// `tangent_qdd`: (nv,).
    /// Result: `InverseDynamicsJvp`: `tau` (nv,), `tangent_tau` (nv,). Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, qd, qdd, tangent_q, tangent_qd, tangent_qdd, *, out=None))]
    fn inverse_dynamics_jvp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        tangent_q: &Bound<'py, PyAny>,
        tangent_qd: &Bound<'py, PyAny>,
        tangent_qdd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 18, &[Some(q), Some(qd), Some(qdd), Some(tangent_q), Some(tangent_qd), Some(tangent_qdd)], None, out)
    }

    /// Returns the accelerations qdd, and the products of `cotangent` with their derivatives: the
    /// gradients of `cotangent`^T qdd with respect to `q` (in tangent space), `qd` and `tau`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `cotangent`: (nv,).
    /// Result: `ForwardDynamicsVjp`: `qdd` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_tau`
    /// (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, cotangent, *, out=None))]
    fn forward_dynamics_vjp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        cotangent: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 19, &[Some(q), Some(qd), Some(tau), Some(cotangent)], None, out)
    }

    /// Returns the accelerations qdd, and their change under the changes `tangent_q` (in tangent
    /// space), `tangent_qd` and `tangent_tau`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,);
    /// `tangent_tau`: (nv,).
    /// Result: `ForwardDynamicsJvp`: `qdd` (nv,), `tangent_qdd` (nv,). Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, qd, tau, tangent_q, tangent_qd, tangent_tau, *, out=None))]
    fn forward_dynamics_jvp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        tangent_q: &Bound<'py, PyAny>,
        tangent_qd: &Bound<'py, PyAny>,
        tangent_tau: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 20, &[Some(q), Some(qd), Some(tau), Some(tangent_q), Some(tangent_qd), Some(tangent_tau)], None, out)
    }

    /// Returns the joint forces tau of `qdd`, and the gradients and the Hessian of `cotangent`^T
    /// tau with respect to `q` (in tangent space), `qd` and `qdd`. The blocks of `qd` and `qdd` and
    /// of `qdd` and `qdd` are zero.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `cotangent`: (nv,).
    /// Result: `InverseDynamicsHessian`: `tau` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_qdd`
    /// (nv,), `hess_q_q` (nv, nv), `hess_q_qd` (nv, nv), `hess_qd_qd` (nv, nv), `hess_q_qdd` (nv,
    /// nv). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, cotangent, *, out=None))]
    fn inverse_dynamics_hessian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        cotangent: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 21, &[Some(q), Some(qd), Some(qdd), Some(cotangent)], None, out)
    }

    /// Returns the accelerations qdd, and the gradients and the Hessian of `cotangent`^T qdd with
    /// respect to `q` (in tangent space), `qd` and `tau`. The blocks of `qd` and `tau` and of `tau`
    /// and `tau` are zero.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `cotangent`: (nv,).
    /// Result: `ForwardDynamicsHessian`: `qdd` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_tau`
    /// (nv,), `hess_q_q` (nv, nv), `hess_q_qd` (nv, nv), `hess_qd_qd` (nv, nv), `hess_q_tau` (nv,
    /// nv). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, cotangent, *, out=None))]
    fn forward_dynamics_hessian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        cotangent: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 22, &[Some(q), Some(qd), Some(tau), Some(cotangent)], None, out)
    }

    /// Returns the state after the time `dt` (s) under the joint forces `tau`, by the semi-implicit
    /// Euler method: the new velocities are `qd` + `dt` qdd, and move the coordinates.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `Step`: `q` (nq,), `qd` (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn step_semi_implicit<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 23, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns the state after the time `dt` (s) by the semi-implicit Euler method, and its
    /// derivatives: `a` with respect to the state before and `b` with respect to `tau`. A state has
    /// the entries of q (in tangent space), then the entries of qd.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `StepDerivatives`: `q` (nq,), `qd` (nv,), `a` (2 nv, 2 nv), `b` (2 nv, nv). Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn step_semi_implicit_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 24, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns a knot of optimal control: the velocities after a step of the time `dt` (s) by the
    /// semi-implicit Euler method, and the derivatives of the step in blocks, by rows. The
    /// derivatives of the velocities are with respect to `q` (in tangent space), `qd` and `tau`.
    /// The coordinates after the step are `integrate` of `q` and v, with v = `dt` times these
    /// velocities. Their derivatives with respect to `q` and v are 1, except for a 6 x 6 block at
    /// each quaternion, such as the quaternion of a floating base. A spherical joint has the
    /// angular part of its block.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `Knot`: `qd` (nv,), `dqd_dq` (nv, nv), `dqd_dqd` (nv, nv), `dqd_dtau` (nv, nv),
    /// `dq_dq` (quaternions, 6, 6), `dq_dv` (quaternions, 6, 6). Several states have one more axis,
    /// the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn knot<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 25, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns the state after the time `dt` (s) by the semi-implicit Euler method, and the
    /// gradients and the Hessian of `state_cotangent`^T state: `grad_x` and `grad_tau` with respect
    /// to the state before and `tau`, and `hess_x_x`, `hess_x_tau` and `hess_tau_tau`. A state has
    /// the entries of q (in tangent space), then the entries of qd. Displacements of the state
    /// after the step are in tangent space, too.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `state_cotangent`: (2
    /// nv,).
    /// Result: `StepHessian`: `q` (nq,), `qd` (nv,), `grad_x` (2 nv,), `grad_tau` (nv,), `hess_x_x`
    /// (2 nv, 2 nv), `hess_x_tau` (2 nv, nv), `hess_tau_tau` (nv, nv). Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, state_cotangent, *, out=None))]
    fn step_semi_implicit_hessian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        state_cotangent: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 26, &[Some(q), Some(qd), Some(tau), Some(dt), Some(state_cotangent)], None, out)
    }

    /// Returns the state after the time `dt` (s) under the constant joint forces `tau`, by a
    /// Runge-Kutta method of fourth order. Rotations follow exponential maps, so quaternions keep
    /// length 1.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `Step`: `q` (nq,), `qd` (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn step_rk4<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 27, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns the state of `step_rk4`, and its derivatives: `a` with respect to the state before
    /// and `b` with respect to `tau`. A state has the entries of q (in tangent space), then the
    /// entries of qd.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `StepDerivatives`: `q` (nq,), `qd` (nv,), `a` (2 nv, 2 nv), `b` (2 nv, nv). Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn step_rk4_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 28, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns the state after the time `dt` (s) under the constant joint forces `tau`, by the
    /// implicit midpoint rule: of second order, symmetric, and stable under stiff damping. Three
    /// iterations of simplified Newton solve its equations. Rotations follow exponential maps, so
    /// quaternions keep length 1.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `Step`: `q` (nq,), `qd` (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn step_implicit_midpoint<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 29, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns the state of `step_implicit_midpoint`, and the derivatives of the implicit midpoint
    /// rule: `a` with respect to the state before and `b` with respect to `tau`. A state has the
    /// entries of q (in tangent space), then the entries of qd.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
    /// Result: `StepDerivatives`: `q` (nq,), `qd` (nv,), `a` (2 nv, 2 nv), `b` (2 nv, nv). Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, *, out=None))]
    fn step_implicit_midpoint_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 30, &[Some(q), Some(qd), Some(tau), Some(dt)], None, out)
    }

    /// Returns the joint accelerations under the joint forces `tau` with the loops closed and the
    /// active contacts held. Also returns the wrench on each constraint's link and the unmet part
    /// of the constraint's acceleration, and the number of independent constraint rows. Loop
    /// constraints come first, in the order of `loop_constraint_names`, at the second frame's
    /// origin in the first frame's axes. Contacts follow, in the order of `contact_names`, at the
    /// frame's origin in world axes. Redundant rows get the multipliers of smallest norm.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `active`: the names of the active
    /// contacts, or (contacts,), 1 for each active one, else 0; by default all are; `settings`:
    /// `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ConstrainedForwardDynamics`: `qdd` (nv,), `wrenches` (constraints, 6), `residuals`
    /// (constraints, 6), `rank` a number, linear before angular components. Several states have one
    /// more axis, the first.
    #[pyo3(signature = (q, qd, tau, active=None, settings=None, *, out=None))]
    fn constrained_forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 31, &[Some(q), Some(qd), Some(tau), active, settings], None, out)
    }

    /// Returns the displacement and the velocity of each loop constraint's second frame relative to
    /// its first, in the first frame's axes; then of each contact's frame, active or not, relative
    /// to its target, in world axes. Components along free directions are zero. A rotation is its
    /// axis times the sine of its angle.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `settings`: `ConstraintSettings`, by default with the
    /// ground at z = 0 under all contacts.
    /// Result: `ConstraintResidual`: `displacements` (constraints, 6), `velocities` (constraints,
    /// 6), linear before angular components. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, settings=None, *, out=None))]
    fn constraint_residual<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 32, &[Some(q), Some(qd), settings], None, out)
    }

    /// Returns the smallest step (in the metric of the mass matrix) that closes the loops at `q`
    /// and moves the active contacts to their targets to first order, the smallest change of `qd`
    /// that keeps them there, and the number of independent constraint rows. The settings `alpha`
    /// and `beta` have no effect.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `active`: the names of the active contacts, or
    /// (contacts,), 1 for each active one, else 0; by default all are; `settings`:
    /// `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ConstraintProjection`: `step_q` (nv,), `step_qd` (nv,), `rank` a number. Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, active=None, settings=None, *, out=None))]
    fn project_constraints<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 33, &[Some(q), Some(qd), active, settings], None, out)
    }

    /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and their
    /// derivatives with respect to `q` (in tangent space), `qd` and `tau`. The derivatives of
    /// wrenches are arrays for each constraint, in the axes of the wrenches. The rank is assumed
    /// constant; redundant rows get the derivatives of smallest norm.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `active`: the names of the active
    /// contacts, or (contacts,), 1 for each active one, else 0; by default all are; `settings`:
    /// `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ConstrainedForwardDynamicsDerivatives`: `qdd` (nv,), `wrenches` (constraints, 6),
    /// `dqdd_dq` (nv, nv), `dqdd_dqd` (nv, nv), `dqdd_dtau` (nv, nv), `dwrenches_dq` (constraints,
    /// 6, nv), `dwrenches_dqd` (constraints, 6, nv), `dwrenches_dtau` (constraints, 6, nv), `rank`
    /// a number, forces before moments. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, active=None, settings=None, *, out=None))]
    fn constrained_forward_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 34, &[Some(q), Some(qd), Some(tau), active, settings], None, out)
    }

    /// Returns the results of `knot` under the accelerations of `constrained_forward_dynamics`, and
    /// the wrenches of the constraints with their derivatives, which
    /// `constrained_forward_dynamics_derivatives` describes.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `active`: the names of the
    /// active contacts, or (contacts,), 1 for each active one, else 0; by default all are;
    /// `settings`: `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ConstrainedKnot`: `qd` (nv,), `wrenches` (constraints, 6), `dqd_dq` (nv, nv),
    /// `dqd_dqd` (nv, nv), `dqd_dtau` (nv, nv), `dq_dq` (quaternions, 6, 6), `dq_dv` (quaternions,
    /// 6, 6), `dwrenches_dq` (constraints, 6, nv), `dwrenches_dqd` (constraints, 6, nv),
    /// `dwrenches_dtau` (constraints, 6, nv), `rank` a number, forces before moments. Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, active=None, settings=None, *, out=None))]
    fn constrained_knot<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 35, &[Some(q), Some(qd), Some(tau), Some(dt), active, settings], None, out)
    }

    /// Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and the
    /// gradients and the Hessian of their sum with the weights `cotangent` and `wrench_cotangent`
    /// (of the components of the wrenches) with respect to `q` (in tangent space), `qd` and `tau`.
    /// The blocks of `qd` and `tau` and of `tau` and `tau` are zero. The rank is assumed constant.
    /// Weights of wrenches need independent rows, or compliance.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `cotangent`: (nv,); `wrench_cotangent`:
    /// (constraints, 6), forces before moments; `active`: the names of the active contacts, or
    /// (contacts,), 1 for each active one, else 0; by default all are; `settings`:
    /// `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ConstrainedForwardDynamicsHessian`: `qdd` (nv,), `wrenches` (constraints, 6),
    /// `grad_q` (nv,), `grad_qd` (nv,), `grad_tau` (nv,), `hess_q_q` (nv, nv), `hess_q_qd` (nv,
    /// nv), `hess_qd_qd` (nv, nv), `hess_q_tau` (nv, nv), `rank` a number, forces before moments.
    /// Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, cotangent, wrench_cotangent, active=None, settings=None, *, out=None))]
    fn constrained_forward_dynamics_hessian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        cotangent: &Bound<'py, PyAny>,
        wrench_cotangent: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 36, &[Some(q), Some(qd), Some(tau), Some(cotangent), Some(wrench_cotangent), active, settings], None, out)
    }

    /// Returns the velocities after an impact that closes the loops and stops the active contacts
    /// relative to their targets at the same instant, the impulse of each constraint, and the
    /// number of independent constraint rows. Along its normal, a contact leaves with `restitution`
    /// times the speed before the impact. The settings `alpha` and `beta` have no effect.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `active`: the names of the active contacts, or
    /// (contacts,), 1 for each active one, else 0; by default all are; `settings`:
    /// `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ImpactDynamics`: `qd` (nv,), `impulses` (constraints, 6), `rank` a number, forces
    /// before moments. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, active=None, settings=None, *, out=None))]
    fn impact_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 37, &[Some(q), Some(qd), active, settings], None, out)
    }

    /// Returns the state after a step of the time `dt` (s) under the joint forces `tau`, with
    /// contacts, joint limits, dry joint friction and closed loops by MuJoCo's law: soft
    /// constraints whose forces minimize a convex function. The solver is Newton's method, to the
    /// tolerance of `settings`; `residual` says how far it came, relative to the largest force. It
    /// starts from the accelerations `warm_start`: `qdd` of the last step, or zeros. The integrator
    /// is semi-implicit Euler, implicit in joint damping, or MuJoCo's `implicitfast`, as the
    /// description says.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `warm_start`: (nv,), by
    /// default zeros; `settings`: `StepSettings`, by default the result of `step_settings()`.
    /// Result: `StepSolution`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
    /// `residual` a number, `iterations` a number. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, warm_start=None, settings=None, *, out=None))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 38, &[Some(q), Some(qd), Some(tau), Some(dt), warm_start, settings], None, out)
    }

    /// Returns the results of `step`, and the derivatives of the state after it: `a` with respect
    /// to the state before and `b` with respect to `tau`. A state has the entries of q (in tangent
    /// space), then the entries of qd. The derivatives follow from the implicit function theorem at
    /// the solution; where a contact opens or closes, or a point begins to slide, they are
    /// one-sided.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `warm_start`: (nv,), by
    /// default zeros; `settings`: `StepSettings`, by default the result of `step_settings()`.
    /// Result: `LinearizedStep`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
    /// `a` (2 nv, 2 nv), `b` (2 nv, nv), `residual` a number, `iterations` a number. Several states
    /// have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, warm_start=None, settings=None, *, out=None))]
    fn step_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 39, &[Some(q), Some(qd), Some(tau), Some(dt), warm_start, settings], None, out)
    }

    /// Returns the results of `step`, and the gradients of `state_cotangent`^T state after it:
    /// `grad_x` with respect to the state before, and `grad_tau`. A state has the entries of q (in
    /// tangent space), then the entries of qd. At kinks they are as in `step_derivatives`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `state_cotangent`: (2
    /// nv,); `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the
    /// result of `step_settings()`.
    /// Result: `StepVjp`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
    /// `grad_x` (2 nv,), `grad_tau` (nv,), `residual` a number, `iterations` a number. Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, tau, dt, state_cotangent, warm_start=None, settings=None, *, out=None))]
    fn step_vjp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        state_cotangent: &Bound<'py, PyAny>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 40, &[Some(q), Some(qd), Some(tau), Some(dt), Some(state_cotangent), warm_start, settings], None, out)
    }

    /// Returns the results of `step`, and the change `tangent_x` of the state after it under the
    /// changes `tangent_q` (in tangent space), `tangent_qd` and `tangent_tau`. A state has the
    /// entries of q (in tangent space), then the entries of qd. At kinks it is as in
    /// `step_derivatives`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,);
    /// `tangent_tau`: (nv,); `dt`: a number; `warm_start`: (nv,), by default zeros; `settings`:
    /// `StepSettings`, by default the result of `step_settings()`.
    /// Result: `StepJvp`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
    /// `tangent_x` (2 nv,), `residual` a number, `iterations` a number. Several states have one
    /// more axis, the first.
    #[pyo3(signature = (q, qd, tau, tangent_q, tangent_qd, tangent_tau, dt, warm_start=None, settings=None, *, out=None))]
    fn step_jvp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
        tangent_q: &Bound<'py, PyAny>,
        tangent_qd: &Bound<'py, PyAny>,
        tangent_tau: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 41, &[Some(q), Some(qd), Some(tau), Some(tangent_q), Some(tangent_qd), Some(tangent_tau), Some(dt), warm_start, settings], None, out)
    }

    /// Returns the points of the shapes that can touch the ground, in the order of the `forces` of
    /// `step`: the heights `gaps` above the ground (m; negative in it), the `positions` in the
    /// middle between the shape and the ground (m, world axes), and the `velocities` of the link
    /// there, along the x and y axes of the plane, then along its normal (m/s).
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `settings`: `StepSettings`, by default the result of
    /// `step_settings()`.
    /// Result: `TouchingPoints`: `gaps` (touching points,), `positions` (touching points, 3),
    /// `velocities` (touching points, 3). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, settings=None, *, out=None))]
    fn touching_points<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 42, &[Some(q), Some(qd), settings], None, out)
    }

    /// Returns the joint forces `tau` of the actuators under the controls `ctrl`, in the order of
    /// `control_names`, and the activations after the time `dt` (s), in the order of
    /// `activation_names`. The laws are MuJoCo's: controls, forces, activations and joint forces
    /// are clamped to the ranges of the description.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `act`:
    /// (activations,), which a robot without activations leaves out.
    /// Result: `ActuatorForces`: `tau` (nv,), `act` (activations,). Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, qd, ctrl, dt, act=None, *, out=None))]
    fn actuate<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        ctrl: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        act: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 43, &[Some(q), Some(qd), Some(ctrl), Some(dt), act], None, out)
    }

    /// Returns the state and the activations after a step of the time `dt` (s) under the controls
    /// `ctrl`: MuJoCo's `mj_step`. The joint forces are the result of `actuate` at the state before
    /// the step, and the forces `applied` beside it (MuJoCo's `qfrc_applied`). All else is as in
    /// `step`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `act`:
    /// (activations,), which a robot without activations leaves out; `applied`: (nv,), by default
    /// zeros; `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the
    /// result of `step_settings()`.
    /// Result: `ActuatedStep`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,), `forces`
    /// (touching points, 3), `residual` a number, `iterations` a number. Several states have one
    /// more axis, the first.
    #[pyo3(signature = (q, qd, ctrl, dt, act=None, applied=None, warm_start=None, settings=None, *, out=None))]
    fn step_actuated<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        ctrl: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        act: Argument<'_, 'py>,
        applied: Argument<'_, 'py>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 44, &[Some(q), Some(qd), Some(ctrl), Some(dt), act, applied, warm_start, settings], None, out)
    }

    /// Returns the results of `step_actuated`, and the derivatives of the state after it: `a` with
    /// respect to the state before and `b` with respect to `ctrl`. A state has the entries of q (in
    /// tangent space), the entries of qd, then `act`. All else is as in `step_derivatives`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `act`:
    /// (activations,), which a robot without activations leaves out; `applied`: (nv,), by default
    /// zeros; `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the
    /// result of `step_settings()`.
    /// Result: `LinearizedActuatedStep`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,),
    /// `forces` (touching points, 3), `a` (2 nv + activations, 2 nv + activations), `b` (2 nv +
    /// activations, controls), `residual` a number, `iterations` a number. Several states have one
    /// more axis, the first.
    #[pyo3(signature = (q, qd, ctrl, dt, act=None, applied=None, warm_start=None, settings=None, *, out=None))]
    fn step_actuated_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        ctrl: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        act: Argument<'_, 'py>,
        applied: Argument<'_, 'py>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 45, &[Some(q), Some(qd), Some(ctrl), Some(dt), act, applied, warm_start, settings], None, out)
    }

    /// Returns the results of `step_actuated`, and the gradients of `state_cotangent`^T state +
    /// `act_cotangent`^T act after it: `grad_x` with respect to the state before, and `grad_ctrl`.
    /// The state of `grad_x` has the entries of q (in tangent space), the entries of qd, then
    /// `act`. At kinks they are as in `step_derivatives`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `state_cotangent`:
    /// (2 nv,); `act`: (activations,), which a robot without activations leaves out;
    /// `act_cotangent`: (activations,), by default zeros; `applied`: (nv,), by default zeros;
    /// `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the result of
    /// `step_settings()`.
    /// Result: `ActuatedStepVjp`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,),
    /// `forces` (touching points, 3), `grad_x` (2 nv + activations,), `grad_ctrl` (controls,),
    /// `residual` a number, `iterations` a number. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, ctrl, dt, state_cotangent, act=None, act_cotangent=None, applied=None, warm_start=None, settings=None, *, out=None))]
    fn step_actuated_vjp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        ctrl: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        state_cotangent: &Bound<'py, PyAny>,
        act: Argument<'_, 'py>,
        act_cotangent: Argument<'_, 'py>,
        applied: Argument<'_, 'py>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 46, &[Some(q), Some(qd), Some(ctrl), Some(dt), Some(state_cotangent), act, act_cotangent, applied, warm_start, settings], None, out)
    }

    /// Returns the results of `step_actuated`, and the change `tangent_x` of the state after it
    /// under the changes `tangent_q` (in tangent space), `tangent_qd`, `tangent_ctrl` and
    /// `tangent_act`. The state of `tangent_x` has the entries of q (in tangent space), the entries
    /// of qd, then `act`. At kinks it is as in `step_derivatives`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,); `ctrl`:
    /// (controls,); `tangent_ctrl`: (controls,); `dt`: a number; `act`: (activations,), which a
    /// robot without activations leaves out; `tangent_act`: (activations,), by default zeros;
    /// `applied`: (nv,), by default zeros; `warm_start`: (nv,), by default zeros; `settings`:
    /// `StepSettings`, by default the result of `step_settings()`.
    /// Result: `ActuatedStepJvp`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,),
    /// `forces` (touching points, 3), `tangent_x` (2 nv + activations,), `residual` a number,
    /// `iterations` a number. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, tangent_q, tangent_qd, ctrl, tangent_ctrl, dt, act=None, tangent_act=None, applied=None, warm_start=None, settings=None, *, out=None))]
    fn step_actuated_jvp<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        tangent_q: &Bound<'py, PyAny>,
        tangent_qd: &Bound<'py, PyAny>,
        ctrl: &Bound<'py, PyAny>,
        tangent_ctrl: &Bound<'py, PyAny>,
        dt: &Bound<'py, PyAny>,
        act: Argument<'_, 'py>,
        tangent_act: Argument<'_, 'py>,
        applied: Argument<'_, 'py>,
        warm_start: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 47, &[Some(q), Some(qd), Some(tangent_q), Some(tangent_qd), Some(ctrl), Some(tangent_ctrl), Some(dt), act, tangent_act, applied, warm_start, settings], None, out)
    }

    /// Returns the joint forces of the accelerations `qdd`, the wrenches of the active contacts
    /// that carry the floating bases, and the rank of the contacts' columns of the bases. The
    /// wrenches have the smallest sum of (force^2 + (moment / l)^2) / weight with the
    /// characteristic length l of each contact. The joint forces of a base are the wrench on it
    /// that no contact can carry. The wrenches of loop constraints are zero.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `active`: the names of the active
    /// contacts, or (contacts,), 1 for each active one, else 0; by default all are; `settings`:
    /// `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
    /// Result: `ConstrainedInverseDynamics`: `tau` (nv,), `wrenches` (constraints, 6), `rank` a
    /// number, forces before moments. Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, active=None, settings=None, *, out=None))]
    fn constrained_inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 48, &[Some(q), Some(qd), Some(qdd), active, settings], None, out)
    }

    /// Returns the Jacobian of each constraint. The product with `qd` is, for a loop constraint,
    /// the constrained part of the twist of its second frame relative to its first, in the first
    /// frame's axes; for a contact, active or not, the constrained part of its frame's twist in
    /// world axes.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (constraints, 6, nv), linear before angular components. Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn constraint_jacobian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 49, &[Some(q)], None, out)
    }

    /// Returns the bias acceleration of each constraint: the time derivative of
    /// `constraint_jacobian` times `qd`, in the same axes.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,).
    /// Result: (constraints, 6), linear before angular components. Several states have one more
    /// axis, the first.
    #[pyo3(signature = (q, qd, *, out=None))]
    fn constraint_jacobian_dot_qd<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 50, &[Some(q), Some(qd)], None, out)
    }

    /// Returns the Delassus matrix J M^-1 J^T of the constraints with the mass matrix M, its
    /// pseudo-inverse, the operational-space inertia, and the number of independent constraint
    /// rows. Each constraint has its constrained displacements, then its constrained rotations, of
    /// a contact in world axes. The entries of inactive contacts are zero. The Delassus matrix
    /// contains the compliance.
    ///
    /// Arguments: `q`: (nq,); `active`: the names of the active contacts, or (contacts,), 1 for
    /// each active one, else 0; by default all are; `settings`: `ConstraintSettings`, by default
    /// with the ground at z = 0 under all contacts.
    /// Result: `OperationalSpaceInertia`: `delassus` (constraint rows, constraint rows), `inertia`
    /// (constraint rows, constraint rows), `rank` a number. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, active=None, settings=None, *, out=None))]
    fn operational_space_inertia<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        active: Argument<'_, 'py>,
        settings: Argument<'_, 'py>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 51, &[Some(q), active, settings], None, out)
    }

    /// Returns the regressor Y of inverse dynamics: tau = Y pi, without armatures and friction. pi
    /// has ten entries for each moving link: mass, mass times centre of mass x, y, z, and Ixx, Ixy,
    /// Ixz, Iyy, Iyz, Izz about the link's origin in the link's own axes (`parameters`).
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
    /// Result: (nv, 10 moving links). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, *, out=None))]
    fn regressor<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 52, &[Some(q), Some(qd), Some(qdd)], None, out)
    }

    /// Returns the centre of mass of the moving links in world axes, m.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (3,). Several states have one more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn center_of_mass<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 53, &[Some(q)], None, out)
    }

    /// Returns the Jacobian of the centre of mass. Its product with `qd` is the velocity of the
    /// centre of mass in world axes.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (3, nv). Several states have one more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn center_of_mass_jacobian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 54, &[Some(q)], None, out)
    }

    /// Returns the centroidal momentum matrix. Its product with `qd` is the momentum about the
    /// centre of mass, in world axes. Armatures have energy, but no momentum: their axes are not
    /// described.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (6, nv), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, *, out=None))]
    fn centroidal_momentum_matrix<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 55, &[Some(q)], None, out)
    }

    /// Returns the centroidal composite inertia. Its product with a twist is the momentum about the
    /// centre of mass, in world axes, of all moving links as one rigid body with this twist at the
    /// centre of mass.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (6, 6), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, *, out=None))]
    fn centroidal_composite_inertia<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 56, &[Some(q)], None, out)
    }

    /// Returns the momentum of the moving links about their centre of mass, in world axes.
    /// Armatures have energy, but no momentum: their axes are not described.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,).
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, *, out=None))]
    fn centroidal_momentum<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 57, &[Some(q), Some(qd)], None, out)
    }

    /// Returns the time derivative of the centroidal momentum in world axes: the moment (N m) and
    /// the force (N) about the centre of mass of gravity and of all forces from outside. At `qdd` =
    /// 0 it is the bias A' qd, with the centroidal momentum matrix A.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, qdd, *, out=None))]
    fn centroidal_momentum_rate<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 58, &[Some(q), Some(qd), Some(qdd)], None, out)
    }

    /// Returns the momentum of the moving links about their centre of mass, its time derivative at
    /// `qdd` (the rate), and the derivatives of both with respect to `q` (in tangent space) and
    /// `qd`, in world axes. The derivatives of the momentum with respect to `qd`, and of the rate
    /// with respect to `qdd`, are the centroidal momentum matrix.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
    /// Result: `CentroidalMomentumDerivatives`: `momentum` (6,), `rate` (6,), `dmomentum_dq` (6,
    /// nv), `drate_dq` (6, nv), `drate_dqd` (6, nv), linear before angular components. Several
    /// states have one more axis, the first.
    #[pyo3(signature = (q, qd, qdd, *, out=None))]
    fn centroidal_momentum_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 59, &[Some(q), Some(qd), Some(qdd)], None, out)
    }

    /// Returns the poses in the world of all links of the description, fixed links included, in the
    /// order of `link_names`.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: `Pose`: `rotation` (links, 3, 3), `translation` (links, 3). Several states have one
    /// more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn link_poses<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 60, &[Some(q)], None, out)
    }

    /// Returns the pose of a link in the world. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `link`: the name of a link, or its index in `link_names`.
    /// Result: `Pose`: `rotation` (3, 3), `translation` (3,). Several states have one more axis,
    /// the first.
    #[pyo3(signature = (q, link, *, out=None))]
    fn link_pose<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 61, &[Some(q)], Some(link), out)
    }

    /// Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in world
    /// axes. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
    /// `link_names`.
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, link, *, out=None))]
    fn link_velocity<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 62, &[Some(q), Some(qd)], Some(link), out)
    }

    /// Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in the
    /// link's own axes. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
    /// `link_names`.
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, link, *, out=None))]
    fn link_velocity_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 63, &[Some(q), Some(qd)], Some(link), out)
    }

    /// Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
    /// (rad/s^2), in world axes. Gravity is not included. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `link`: the name of a link, or its index
    /// in `link_names`.
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, qdd, link, *, out=None))]
    fn link_acceleration<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 64, &[Some(q), Some(qd), Some(qdd)], Some(link), out)
    }

    /// Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
    /// (rad/s^2), in the link's own axes. Gravity is not included. Computes the link's kinematic
    /// path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `link`: the name of a link, or its index
    /// in `link_names`.
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, qdd, link, *, out=None))]
    fn link_acceleration_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 65, &[Some(q), Some(qd), Some(qdd)], Some(link), out)
    }

    /// Returns the Jacobian of a link. Its product with `qd` is the velocity of the link at its
    /// origin, in world axes. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `link`: the name of a link, or its index in `link_names`.
    /// Result: (6, nv), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, link, *, out=None))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 66, &[Some(q)], Some(link), out)
    }

    /// Returns the Jacobian of a link. Its product with `qd` is the velocity of the link at its
    /// origin, in the link's own axes. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `link`: the name of a link, or its index in `link_names`.
    /// Result: (6, nv), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, link, *, out=None))]
    fn jacobian_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 67, &[Some(q)], Some(link), out)
    }

    /// Returns the time derivative of `jacobian`. Its product with `qd` is `jacobian_dot_qd`.
    /// Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
    /// `link_names`.
    /// Result: (6, nv), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, link, *, out=None))]
    fn jacobian_time_derivative<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 68, &[Some(q), Some(qd)], Some(link), out)
    }

    /// Returns the time derivative of `jacobian_local`. Its product with `qd` is
    /// `jacobian_dot_qd_local`. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
    /// `link_names`.
    /// Result: (6, nv), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, link, *, out=None))]
    fn jacobian_time_derivative_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 69, &[Some(q), Some(qd)], Some(link), out)
    }

    /// Returns the bias acceleration of a link in world axes: the time derivative of `jacobian`
    /// times `qd`, which is the link's acceleration at zero joint accelerations. Computes the
    /// link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
    /// `link_names`.
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, link, *, out=None))]
    fn jacobian_dot_qd<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 70, &[Some(q), Some(qd)], Some(link), out)
    }

    /// Returns the bias acceleration of a link in its own axes: the time derivative of
    /// `jacobian_local` times `qd`. Computes the link's kinematic path only.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
    /// `link_names`.
    /// Result: (6,), linear before angular components. Several states have one more axis, the
    /// first.
    #[pyo3(signature = (q, qd, link, *, out=None))]
    fn jacobian_dot_qd_local<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        link: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 71, &[Some(q), Some(qd)], Some(link), out)
    }

    /// Returns the coordinates after the displacement `v` (a velocity times a time) from `q`.
    ///
    /// Arguments: `q`: (nq,); `v`: (nv,).
    /// Result: (nq,). Several states have one more axis, the first.
    #[pyo3(signature = (q, v, *, out=None))]
    fn integrate<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 72, &[Some(q), Some(v)], None, out)
    }

    /// Returns the displacement `v` with which `integrate` leads from `from_` to `to`. Rotations
    /// are the shortest ones; joint angles are not wrapped.
    ///
    /// Arguments: `from_`: (nq,); `to`: (nq,).
    /// Result: (nv,). Several states have one more axis, the first.
    #[pyo3(signature = (from_, to, *, out=None))]
    fn difference<'py>(
        &self,
        py: Python<'py>,
        from_: &Bound<'py, PyAny>,
        to: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 73, &[Some(from_), Some(to)], None, out)
    }

    /// Returns the derivatives of `integrate` with respect to `q` and `v` in tangent space:
    /// displacements of `q` and of the result are in the axes at each of them.
    ///
    /// Arguments: `q`: (nq,); `v`: (nv,).
    /// Result: `IntegrateDerivatives`: `dq_dq` (nv, nv), `dq_dv` (nv, nv). Several states have one
    /// more axis, the first.
    #[pyo3(signature = (q, v, *, out=None))]
    fn integrate_derivatives<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 74, &[Some(q), Some(v)], None, out)
    }

    /// Returns the derivatives of `difference` with respect to `from_` and `to` in tangent space:
    /// displacements are in the axes at `from_` and at `to`.
    ///
    /// Arguments: `from_`: (nq,); `to`: (nq,).
    /// Result: `DifferenceDerivatives`: `dv_dfrom` (nv, nv), `dv_dto` (nv, nv). Several states have
    /// one more axis, the first.
    #[pyo3(signature = (from_, to, *, out=None))]
    fn difference_derivatives<'py>(
        &self,
        py: Python<'py>,
        from_: &Bound<'py, PyAny>,
        to: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 75, &[Some(from_), Some(to)], None, out)
    }

    /// Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.
    ///
    /// Arguments: `q`: (nq,); `qd`: (nv,).
    /// Result: (nq,). Several states have one more axis, the first.
    #[pyo3(signature = (q, qd, *, out=None))]
    fn velocity_to_qdot<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 76, &[Some(q), Some(qd)], None, out)
    }

    /// Returns the coordinates with quaternions scaled to length 1.
    ///
    /// Arguments: `q`: (nq,).
    /// Result: (nq,). Several states have one more axis, the first.
    #[pyo3(signature = (q, *, out=None))]
    fn normalize_configuration<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 77, &[Some(q)], None, out)
    }

    /// Returns coordinates within the joint limits, from random numbers uniformly distributed in
    /// [0, 1). Angles without limits are in [-pi, pi), displacements without limits in [-1, 1) m,
    /// rotations uniform over SO(3).
    ///
    /// Arguments: `uniforms`: (nv,).
    /// Result: (nq,). Several states have one more axis, the first.
    #[pyo3(signature = (uniforms, *, out=None))]
    fn random_configuration<'py>(
        &self,
        py: Python<'py>,
        uniforms: &Bound<'py, PyAny>,
        out: Argument<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.call(py, 78, &[Some(uniforms)], None, out)
    }
    // <!-- end -->
}
