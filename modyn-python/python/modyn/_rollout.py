"""Rollouts on NumPy's arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import Rollout, RolloutSignature
from ._modyn import Robot, call_arrays
from ._types import RolloutGradients, RolloutStates


def _given(robot: Robot, name: str, arguments: dict[str, Any], step: str, trajectory: bool) -> tuple[list[Any], Rollout]:
    """Returns the arguments as arrays in the order of the step, and the rollout."""

    def array(argument: str, given: Any) -> Any:
        if given is None:
            return None
        try:
            found = np.asarray(given)
            return np.ascontiguousarray(found.astype(robot.dtype, casting="same_kind")).reshape(found.shape)
        except (TypeError, ValueError) as error:
            raise TypeError(f"`{argument}` of `{name}` must be an array of real numbers: {error}") from None

    signature = RolloutSignature(robot, step)
    arrays = {argument: array(argument, given) for argument, given in arguments.items()}
    if signature.parameters.parameters:
        arrays["parameters"] = signature.parameters.flat(None, np.asarray, np.concatenate)
    found, own = signature.arrays(arrays)
    return found, signature.code(trajectory, *own)


def rollout(robot: Robot, arguments: dict[str, Any], step: str, trajectory: bool) -> RolloutStates:
    """Returns the result of `Robot.rollout`."""
    arrays, code = _given(robot, "rollout", arguments, step, trajectory)
    return RolloutStates(*call_arrays(code.key, arrays))


def rollout_vjp(
    robot: Robot, arguments: dict[str, Any], weights: tuple[Any, Any], step: str, trajectory: bool
) -> RolloutGradients:
    """Returns the result of `Robot.rollout_vjp`."""
    arrays, code = _given(robot, "rollout_vjp", arguments, step, trajectory)
    names = [name for name, given in arguments.items() if given is not None]
    gradient = code.gradient(range(len(names)))
    for name, own, given in zip(("q_weights", "qd_weights"), code.outputs, weights):
        weight = np.ascontiguousarray(given, robot.dtype)
        if weight.shape[weight.ndim - len(own) :] != own:
            raise ValueError(f"`{name}` of `rollout_vjp` has the shape {weight.shape}; expected {own}, after axes of motions")
        arrays.append(weight)
    return RolloutGradients(**dict(zip(names, call_arrays(gradient.key, arrays))))
