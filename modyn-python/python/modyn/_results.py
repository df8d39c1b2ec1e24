"""The results of functions with several results: named tuples of arrays.

`cargo xtask pages` writes them.
"""

from typing import Any, NamedTuple

from numpy.typing import NDArray

# <!-- data: python-results -->
__all__ = [
    "ActuatedStep",
    "ActuatedStepJvp",
    "ActuatedStepVjp",
    "ActuatorForces",
    "CentroidalMomentumDerivatives",
    "ConstrainedForwardDynamics",
    "ConstrainedForwardDynamicsDerivatives",
    "ConstrainedForwardDynamicsHessian",
    "ConstrainedInverseDynamics",
    "ConstrainedKnot",
    "ConstraintProjection",
    "ConstraintResidual",
    "DifferenceDerivatives",
    "ForwardDynamicsDerivatives",
    "ForwardDynamicsHessian",
    "ForwardDynamicsJvp",
    "ForwardDynamicsVjp",
    "GeneralizedForces",
    "ImpactDynamics",
    "IntegrateDerivatives",
    "InverseDynamicsDerivatives",
    "InverseDynamicsHessian",
    "InverseDynamicsJvp",
    "InverseDynamicsVjp",
    "Knot",
    "LinearizedActuatedStep",
    "LinearizedStep",
    "OperationalSpaceInertia",
    "Pose",
    "Step",
    "StepDerivatives",
    "StepHessian",
    "StepJvp",
    "StepSolution",
    "StepVjp",
    "TouchingPoints",
]


class ActuatedStep(NamedTuple):
    """The result of `step_actuated`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    act: NDArray[Any]
    """(activations,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class ActuatedStepJvp(NamedTuple):
    """The result of `step_actuated_jvp`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    act: NDArray[Any]
    """(activations,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    tangent_x: NDArray[Any]
    """(2 nv + activations,)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class ActuatedStepVjp(NamedTuple):
    """The result of `step_actuated_vjp`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    act: NDArray[Any]
    """(activations,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    grad_x: NDArray[Any]
    """(2 nv + activations,)"""
    grad_ctrl: NDArray[Any]
    """(controls,)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class ActuatorForces(NamedTuple):
    """The result of `actuate`."""

    tau: NDArray[Any]
    """(nv,)"""
    act: NDArray[Any]
    """(activations,)"""


class CentroidalMomentumDerivatives(NamedTuple):
    """The result of `centroidal_momentum_derivatives`."""

    momentum: NDArray[Any]
    """(6,)"""
    rate: NDArray[Any]
    """(6,)"""
    dmomentum_dq: NDArray[Any]
    """(6, nv)"""
    drate_dq: NDArray[Any]
    """(6, nv)"""
    drate_dqd: NDArray[Any]
    """(6, nv)"""


class ConstrainedForwardDynamics(NamedTuple):
    """The result of `constrained_forward_dynamics`."""

    qdd: NDArray[Any]
    """(nv,)"""
    wrenches: NDArray[Any]
    """(constraints, 6)"""
    residuals: NDArray[Any]
    """(constraints, 6)"""
    rank: NDArray[Any]
    """a number"""


class ConstrainedForwardDynamicsDerivatives(NamedTuple):
    """The result of `constrained_forward_dynamics_derivatives`."""

    qdd: NDArray[Any]
    """(nv,)"""
    wrenches: NDArray[Any]
    """(constraints, 6)"""
    dqdd_dq: NDArray[Any]
    """(nv, nv)"""
    dqdd_dqd: NDArray[Any]
    """(nv, nv)"""
    dqdd_dtau: NDArray[Any]
    """(nv, nv)"""
    dwrenches_dq: NDArray[Any]
    """(constraints, 6, nv)"""
    dwrenches_dqd: NDArray[Any]
    """(constraints, 6, nv)"""
    dwrenches_dtau: NDArray[Any]
    """(constraints, 6, nv)"""
    rank: NDArray[Any]
    """a number"""


class ConstrainedForwardDynamicsHessian(NamedTuple):
    """The result of `constrained_forward_dynamics_hessian`."""

    qdd: NDArray[Any]
    """(nv,)"""
    wrenches: NDArray[Any]
    """(constraints, 6)"""
    grad_q: NDArray[Any]
    """(nv,)"""
    grad_qd: NDArray[Any]
    """(nv,)"""
    grad_tau: NDArray[Any]
    """(nv,)"""
    hess_q_q: NDArray[Any]
    """(nv, nv)"""
    hess_q_qd: NDArray[Any]
    """(nv, nv)"""
    hess_qd_qd: NDArray[Any]
    """(nv, nv)"""
    hess_q_tau: NDArray[Any]
    """(nv, nv)"""
    rank: NDArray[Any]
    """a number"""


class ConstrainedInverseDynamics(NamedTuple):
    """The result of `constrained_inverse_dynamics`."""

    tau: NDArray[Any]
    """(nv,)"""
    wrenches: NDArray[Any]
    """(constraints, 6)"""
    rank: NDArray[Any]
    """a number"""


class ConstrainedKnot(NamedTuple):
    """The result of `constrained_knot`."""

    qd: NDArray[Any]
    """(nv,)"""
    wrenches: NDArray[Any]
    """(constraints, 6)"""
    dqd_dq: NDArray[Any]
    """(nv, nv)"""
    dqd_dqd: NDArray[Any]
    """(nv, nv)"""
    dqd_dtau: NDArray[Any]
    """(nv, nv)"""
    dq_dq: NDArray[Any]
    """(quaternions, 6, 6)"""
    dq_dv: NDArray[Any]
    """(quaternions, 6, 6)"""
    dwrenches_dq: NDArray[Any]
    """(constraints, 6, nv)"""
    dwrenches_dqd: NDArray[Any]
    """(constraints, 6, nv)"""
    dwrenches_dtau: NDArray[Any]
    """(constraints, 6, nv)"""
    rank: NDArray[Any]
    """a number"""


class ConstraintProjection(NamedTuple):
    """The result of `project_constraints`."""

    step_q: NDArray[Any]
    """(nv,)"""
    step_qd: NDArray[Any]
    """(nv,)"""
    rank: NDArray[Any]
    """a number"""


class ConstraintResidual(NamedTuple):
    """The result of `constraint_residual`."""

    displacements: NDArray[Any]
    """(constraints, 6)"""
    velocities: NDArray[Any]
    """(constraints, 6)"""


class DifferenceDerivatives(NamedTuple):
    """The result of `difference_derivatives`."""

    dv_dfrom: NDArray[Any]
    """(nv, nv)"""
    dv_dto: NDArray[Any]
    """(nv, nv)"""


class ForwardDynamicsDerivatives(NamedTuple):
    """The result of `forward_dynamics_derivatives`."""

    qdd: NDArray[Any]
    """(nv,)"""
    dqdd_dq: NDArray[Any]
    """(nv, nv)"""
    dqdd_dqd: NDArray[Any]
    """(nv, nv)"""
    dqdd_dtau: NDArray[Any]
    """(nv, nv)"""


class ForwardDynamicsHessian(NamedTuple):
    """The result of `forward_dynamics_hessian`."""

    qdd: NDArray[Any]
    """(nv,)"""
    grad_q: NDArray[Any]
    """(nv,)"""
    grad_qd: NDArray[Any]
    """(nv,)"""
    grad_tau: NDArray[Any]
    """(nv,)"""
    hess_q_q: NDArray[Any]
    """(nv, nv)"""
    hess_q_qd: NDArray[Any]
    """(nv, nv)"""
    hess_qd_qd: NDArray[Any]
    """(nv, nv)"""
    hess_q_tau: NDArray[Any]
    """(nv, nv)"""


class ForwardDynamicsJvp(NamedTuple):
    """The result of `forward_dynamics_jvp`."""

    qdd: NDArray[Any]
    """(nv,)"""
    tangent_qdd: NDArray[Any]
    """(nv,)"""


class ForwardDynamicsVjp(NamedTuple):
    """The result of `forward_dynamics_vjp`."""

    qdd: NDArray[Any]
    """(nv,)"""
    grad_q: NDArray[Any]
    """(nv,)"""
    grad_qd: NDArray[Any]
    """(nv,)"""
    grad_tau: NDArray[Any]
    """(nv,)"""


class GeneralizedForces(NamedTuple):
    """The result of `generalized_forces_local`, `generalized_forces`."""

    tau: NDArray[Any]
    """(nv,)"""
    dtau_dq: NDArray[Any]
    """(nv, nv)"""


class ImpactDynamics(NamedTuple):
    """The result of `impact_dynamics`."""

    qd: NDArray[Any]
    """(nv,)"""
    impulses: NDArray[Any]
    """(constraints, 6)"""
    rank: NDArray[Any]
    """a number"""


class IntegrateDerivatives(NamedTuple):
    """The result of `integrate_derivatives`."""

    dq_dq: NDArray[Any]
    """(nv, nv)"""
    dq_dv: NDArray[Any]
    """(nv, nv)"""


class InverseDynamicsDerivatives(NamedTuple):
    """The result of `inverse_dynamics_derivatives`."""

    dtau_dq: NDArray[Any]
    """(nv, nv)"""
    dtau_dqd: NDArray[Any]
    """(nv, nv)"""


class InverseDynamicsHessian(NamedTuple):
    """The result of `inverse_dynamics_hessian`."""

    tau: NDArray[Any]
    """(nv,)"""
    grad_q: NDArray[Any]
    """(nv,)"""
    grad_qd: NDArray[Any]
    """(nv,)"""
    grad_qdd: NDArray[Any]
    """(nv,)"""
    hess_q_q: NDArray[Any]
    """(nv, nv)"""
    hess_q_qd: NDArray[Any]
    """(nv, nv)"""
    hess_qd_qd: NDArray[Any]
    """(nv, nv)"""
    hess_q_qdd: NDArray[Any]
    """(nv, nv)"""


class InverseDynamicsJvp(NamedTuple):
    """The result of `inverse_dynamics_jvp`."""

    tau: NDArray[Any]
    """(nv,)"""
    tangent_tau: NDArray[Any]
    """(nv,)"""


class InverseDynamicsVjp(NamedTuple):
    """The result of `inverse_dynamics_vjp`."""

    tau: NDArray[Any]
    """(nv,)"""
    grad_q: NDArray[Any]
    """(nv,)"""
    grad_qd: NDArray[Any]
    """(nv,)"""
    grad_qdd: NDArray[Any]
    """(nv,)"""


class Knot(NamedTuple):
    """The result of `knot`."""

    qd: NDArray[Any]
    """(nv,)"""
    dqd_dq: NDArray[Any]
    """(nv, nv)"""
    dqd_dqd: NDArray[Any]
    """(nv, nv)"""
    dqd_dtau: NDArray[Any]
    """(nv, nv)"""
    dq_dq: NDArray[Any]
    """(quaternions, 6, 6)"""
    dq_dv: NDArray[Any]
    """(quaternions, 6, 6)"""


class LinearizedActuatedStep(NamedTuple):
    """The result of `step_actuated_derivatives`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    act: NDArray[Any]
    """(activations,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    a: NDArray[Any]
    """(2 nv + activations, 2 nv + activations)"""
    b: NDArray[Any]
    """(2 nv + activations, controls)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class LinearizedStep(NamedTuple):
    """The result of `step_derivatives`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    a: NDArray[Any]
    """(2 nv, 2 nv)"""
    b: NDArray[Any]
    """(2 nv, nv)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class OperationalSpaceInertia(NamedTuple):
    """The result of `operational_space_inertia`."""

    delassus: NDArray[Any]
    """(constraint rows, constraint rows)"""
    inertia: NDArray[Any]
    """(constraint rows, constraint rows)"""
    rank: NDArray[Any]
    """a number"""


class Pose(NamedTuple):
    """The result of `link_poses`, `link_pose`."""

    rotation: NDArray[Any]
    """(links, 3, 3)"""
    translation: NDArray[Any]
    """(links, 3)"""


class Step(NamedTuple):
    """The result of `step_semi_implicit`, `step_rk4`, `step_implicit_midpoint`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""


class StepDerivatives(NamedTuple):
    """The result of `step_semi_implicit_derivatives`, `step_rk4_derivatives`, `step_implicit_midpoint_derivatives`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    a: NDArray[Any]
    """(2 nv, 2 nv)"""
    b: NDArray[Any]
    """(2 nv, nv)"""


class StepHessian(NamedTuple):
    """The result of `step_semi_implicit_hessian`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    grad_x: NDArray[Any]
    """(2 nv,)"""
    grad_tau: NDArray[Any]
    """(nv,)"""
    hess_x_x: NDArray[Any]
    """(2 nv, 2 nv)"""
    hess_x_tau: NDArray[Any]
    """(2 nv, nv)"""
    hess_tau_tau: NDArray[Any]
    """(nv, nv)"""


class StepJvp(NamedTuple):
    """The result of `step_jvp`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    tangent_x: NDArray[Any]
    """(2 nv,)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class StepSolution(NamedTuple):
    """The result of `step`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class StepVjp(NamedTuple):
    """The result of `step_vjp`."""

    q: NDArray[Any]
    """(nq,)"""
    qd: NDArray[Any]
    """(nv,)"""
    qdd: NDArray[Any]
    """(nv,)"""
    forces: NDArray[Any]
    """(touching points, 3)"""
    grad_x: NDArray[Any]
    """(2 nv,)"""
    grad_tau: NDArray[Any]
    """(nv,)"""
    residual: NDArray[Any]
    """a number"""
    iterations: NDArray[Any]
    """a number"""


class TouchingPoints(NamedTuple):
    """The result of `touching_points`."""

    gaps: NDArray[Any]
    """(touching points,)"""
    positions: NDArray[Any]
    """(touching points, 3)"""
    velocities: NDArray[Any]
    """(touching points, 3)"""
# <!-- end -->
