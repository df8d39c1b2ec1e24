"""The results of functions with several results: named tuples of arrays.

`UPDATE_SNAPSHOTS=1 cargo test -p modyn-codegen --test python_package` writes this file.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ConstrainedForwardDynamics",
    "ConstrainedForwardDynamicsDerivatives",
    "ConstrainedForwardDynamicsHessian",
    "ConstrainedInverseDynamics",
    "ConstraintProjection",
    "ConstraintResidual",
    "ContactImpulse",
    "DifferenceDerivatives",
    "ForwardDynamicsDerivatives",
    "ForwardDynamicsHessian",
    "ForwardDynamicsJvp",
    "ForwardDynamicsVjp",
    "GeneralizedForces",
    "IntegrateDerivatives",
    "InverseDynamicsDerivatives",
    "InverseDynamicsHessian",
    "InverseDynamicsJvp",
    "InverseDynamicsVjp",
    "OperationalInertia",
    "Pose",
    "Step",
    "StepDerivatives",
    "StepHessian",
]


class ConstrainedForwardDynamics(NamedTuple):
    """The result of `constrained_forward_dynamics`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    wrenches: NDArray[np.float64]
    """(constraints, 6)"""
    residuals: NDArray[np.float64]
    """(constraints, 6)"""
    rank: NDArray[np.float64]
    """a number"""


class ConstrainedForwardDynamicsDerivatives(NamedTuple):
    """The result of `constrained_forward_dynamics_derivatives`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    wrenches: NDArray[np.float64]
    """(constraints, 6)"""
    dq: NDArray[np.float64]
    """(nv, nv)"""
    dqd: NDArray[np.float64]
    """(nv, nv)"""
    dtau: NDArray[np.float64]
    """(nv, nv)"""
    wrenches_dq: NDArray[np.float64]
    """(constraints, 6, nv)"""
    wrenches_dqd: NDArray[np.float64]
    """(constraints, 6, nv)"""
    wrenches_dtau: NDArray[np.float64]
    """(constraints, 6, nv)"""
    rank: NDArray[np.float64]
    """a number"""


class ConstrainedForwardDynamicsHessian(NamedTuple):
    """The result of `constrained_forward_dynamics_hessian`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    wrenches: NDArray[np.float64]
    """(constraints, 6)"""
    dq: NDArray[np.float64]
    """(nv,)"""
    dqd: NDArray[np.float64]
    """(nv,)"""
    dtau: NDArray[np.float64]
    """(nv,)"""
    dq_dq: NDArray[np.float64]
    """(nv, nv)"""
    dq_dqd: NDArray[np.float64]
    """(nv, nv)"""
    dqd_dqd: NDArray[np.float64]
    """(nv, nv)"""
    dq_dtau: NDArray[np.float64]
    """(nv, nv)"""
    rank: NDArray[np.float64]
    """a number"""


class ConstrainedInverseDynamics(NamedTuple):
    """The result of `constrained_inverse_dynamics`."""

    tau: NDArray[np.float64]
    """(nv,)"""
    wrenches: NDArray[np.float64]
    """(constraints, 6)"""
    rank: NDArray[np.float64]
    """a number"""


class ConstraintProjection(NamedTuple):
    """The result of `project_constraints`."""

    dq: NDArray[np.float64]
    """(nv,)"""
    dqd: NDArray[np.float64]
    """(nv,)"""
    rank: NDArray[np.float64]
    """a number"""


class ConstraintResidual(NamedTuple):
    """The result of `constraint_residual`."""

    displacements: NDArray[np.float64]
    """(constraints, 6)"""
    velocities: NDArray[np.float64]
    """(constraints, 6)"""


class ContactImpulse(NamedTuple):
    """The result of `contact_impulse`."""

    qd: NDArray[np.float64]
    """(nv,)"""
    impulses: NDArray[np.float64]
    """(constraints, 6)"""
    rank: NDArray[np.float64]
    """a number"""


class DifferenceDerivatives(NamedTuple):
    """The result of `difference_derivatives`."""

    dfrom: NDArray[np.float64]
    """(nv, nv)"""
    dto: NDArray[np.float64]
    """(nv, nv)"""


class ForwardDynamicsDerivatives(NamedTuple):
    """The result of `forward_dynamics_derivatives`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    dq: NDArray[np.float64]
    """(nv, nv)"""
    dqd: NDArray[np.float64]
    """(nv, nv)"""
    dtau: NDArray[np.float64]
    """(nv, nv)"""


class ForwardDynamicsHessian(NamedTuple):
    """The result of `forward_dynamics_hessian`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    dq: NDArray[np.float64]
    """(nv,)"""
    dqd: NDArray[np.float64]
    """(nv,)"""
    dtau: NDArray[np.float64]
    """(nv,)"""
    dq_dq: NDArray[np.float64]
    """(nv, nv)"""
    dq_dqd: NDArray[np.float64]
    """(nv, nv)"""
    dqd_dqd: NDArray[np.float64]
    """(nv, nv)"""
    dq_dtau: NDArray[np.float64]
    """(nv, nv)"""


class ForwardDynamicsJvp(NamedTuple):
    """The result of `forward_dynamics_jvp`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    dqdd: NDArray[np.float64]
    """(nv,)"""


class ForwardDynamicsVjp(NamedTuple):
    """The result of `forward_dynamics_vjp`."""

    qdd: NDArray[np.float64]
    """(nv,)"""
    dq: NDArray[np.float64]
    """(nv,)"""
    dqd: NDArray[np.float64]
    """(nv,)"""
    dtau: NDArray[np.float64]
    """(nv,)"""


class GeneralizedForces(NamedTuple):
    """The result of `generalized_forces`, `generalized_forces_world`."""

    tau: NDArray[np.float64]
    """(nv,)"""
    dq: NDArray[np.float64]
    """(nv, nv)"""


class IntegrateDerivatives(NamedTuple):
    """The result of `integrate_derivatives`."""

    dq: NDArray[np.float64]
    """(nv, nv)"""
    dv: NDArray[np.float64]
    """(nv, nv)"""


class InverseDynamicsDerivatives(NamedTuple):
    """The result of `inverse_dynamics_derivatives`."""

    dq: NDArray[np.float64]
    """(nv, nv)"""
    dqd: NDArray[np.float64]
    """(nv, nv)"""


class InverseDynamicsHessian(NamedTuple):
    """The result of `inverse_dynamics_hessian`."""

    tau: NDArray[np.float64]
    """(nv,)"""
    dq: NDArray[np.float64]
    """(nv,)"""
    dqd: NDArray[np.float64]
    """(nv,)"""
    dqdd: NDArray[np.float64]
    """(nv,)"""
    dq_dq: NDArray[np.float64]
    """(nv, nv)"""
    dq_dqd: NDArray[np.float64]
    """(nv, nv)"""
    dqd_dqd: NDArray[np.float64]
    """(nv, nv)"""
    dq_dqdd: NDArray[np.float64]
    """(nv, nv)"""


class InverseDynamicsJvp(NamedTuple):
    """The result of `inverse_dynamics_jvp`."""

    tau: NDArray[np.float64]
    """(nv,)"""
    dtau: NDArray[np.float64]
    """(nv,)"""


class InverseDynamicsVjp(NamedTuple):
    """The result of `inverse_dynamics_vjp`."""

    tau: NDArray[np.float64]
    """(nv,)"""
    dq: NDArray[np.float64]
    """(nv,)"""
    dqd: NDArray[np.float64]
    """(nv,)"""
    dqdd: NDArray[np.float64]
    """(nv,)"""


class OperationalInertia(NamedTuple):
    """The result of `operational_inertia`."""

    inverse: NDArray[np.float64]
    """(constraint rows, constraint rows)"""
    inertia: NDArray[np.float64]
    """(constraint rows, constraint rows)"""
    rank: NDArray[np.float64]
    """a number"""


class Pose(NamedTuple):
    """The result of `link_poses`, `link_pose`."""

    rotation: NDArray[np.float64]
    """(links, 3, 3)"""
    translation: NDArray[np.float64]
    """(links, 3)"""


class Step(NamedTuple):
    """The result of `step_semi_implicit`, `step_rk4`, `step_implicit_midpoint`."""

    q: NDArray[np.float64]
    """(nq,)"""
    qd: NDArray[np.float64]
    """(nv,)"""


class StepDerivatives(NamedTuple):
    """The result of `step_semi_implicit_derivatives`, `step_implicit_midpoint_derivatives`."""

    q: NDArray[np.float64]
    """(nq,)"""
    qd: NDArray[np.float64]
    """(nv,)"""
    a: NDArray[np.float64]
    """(2 nv, 2 nv)"""
    b: NDArray[np.float64]
    """(2 nv, nv)"""


class StepHessian(NamedTuple):
    """The result of `step_semi_implicit_hessian`."""

    q: NDArray[np.float64]
    """(nq,)"""
    qd: NDArray[np.float64]
    """(nv,)"""
    dx: NDArray[np.float64]
    """(2 nv,)"""
    dtau: NDArray[np.float64]
    """(nv,)"""
    dx_dx: NDArray[np.float64]
    """(2 nv, 2 nv)"""
    dx_dtau: NDArray[np.float64]
    """(2 nv, nv)"""
    dtau_dtau: NDArray[np.float64]
    """(nv, nv)"""
