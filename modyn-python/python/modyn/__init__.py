"""Rigid-body dynamics of a robot description (URDF, xacro, SDF, MJCF) as machine code, on NumPy arrays.

    import modyn

    robot = modyn.load("panda.urdf", base="fixed")
    qdd = robot.forward_dynamics(q, qd, tau)    # one state: (nq,), (nv,), (nv,)
    qdd = robot.forward_dynamics(Q, QD, TAU)    # n states: (n, nq), (n, nv), (n, nv)

Units are SI units and radians. A function is compiled at its first use, within milliseconds.
"""

from __future__ import annotations

from typing import Any

from . import _results, _rollout, conventions
from ._errors import DescriptionError, DescriptionWarning, Diagnostic, MachineCodeWarning
from ._modyn import Factorization, Robot, functions, load, loads, set_threads
from ._results import *  # noqa: F403
from ._show import Animation, show
from ._types import (
    BaseParameters,
    ConstraintSettings,
    ContactSurface,
    ContactTarget,
    HeightField,
    Joint,
    JointLimits,
    Keyframe,
    QuadraticCost,
    RolloutCosts,
    RolloutGradients,
    RolloutResults,
    RolloutStates,
    StepSettings,
)

__version__ = "0.2.0"

for _method in _rollout.METHODS:
    setattr(Robot, _method.__name__, _method)

__all__ = [
    "Animation",
    "BaseParameters",
    "ConstraintSettings",
    "ContactSurface",
    "ContactTarget",
    "DescriptionError",
    "DescriptionWarning",
    "Diagnostic",
    "Factorization",
    "HeightField",
    "Joint",
    "JointLimits",
    "Keyframe",
    "MachineCodeWarning",
    "Robot",
    "QuadraticCost",
    "RolloutCosts",
    "RolloutGradients",
    "RolloutResults",
    "RolloutStates",
    "StepSettings",
    "conventions",
    "functions",
    "load",
    "loads",
    "set_threads",
    "show",
    *_results.__all__,
]


def _restore(
    text: str, file: str, folder: Any, options: dict[str, Any], changes: list[Any]
) -> Robot:
    """Returns a robot from its pickle."""
    import warnings

    with warnings.catch_warnings():
        # The first reading has issued them.
        warnings.simplefilter("ignore", DescriptionWarning)
        robot = loads(text, file=file, folder=folder, **options)
    for method, arguments in changes:
        getattr(robot, method)(*arguments)
    return robot
