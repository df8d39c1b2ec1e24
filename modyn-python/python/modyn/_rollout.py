"""Rollouts on NumPy's arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import Rollout, RolloutSignature, check
from ._modyn import Robot, call_arrays
from ._types import ConstraintSettings, Ground, GroundStates, RolloutGradients, RolloutStates


def _array(robot: Robot, function: str, argument: str, given: Any) -> Any:
    """Returns an argument as an array in C order; `None` if it is not given."""
    if given is None:
        return None
    try:
        if isinstance(given, ConstraintSettings):
            return np.asarray(given, robot.dtype)
        found = np.asarray(given)
        return np.ascontiguousarray(found.astype(robot.dtype, casting="same_kind")).reshape(found.shape)
    except (TypeError, ValueError) as error:
        raise TypeError(f"`{argument}` of `{function}` must be an array of real numbers: {error}") from None


def _given(
    robot: Robot, name: str, arguments: dict[str, Any], step: tuple[str, Ground | None], trajectory: bool
) -> tuple[list[Any], Rollout, RolloutSignature]:
    """Returns the arguments as arrays in the order of the step, and the rollout."""
    signature = RolloutSignature(robot, *step)
    arrays = {argument: _array(robot, name, argument, given) for argument, given in arguments.items()}
    signature.start(arrays, np.asarray)
    if signature.parameters.parameters:
        arrays["parameters"] = signature.parameters.flat(None, np.asarray, np.concatenate)
    found, own = signature.arrays(arrays)
    return found, signature.code(trajectory, *own), signature


def step_on_ground(robot: Robot, arguments: dict[str, Any], last: GroundStates | None, ground: Ground | None) -> GroundStates:
    """Returns the result of `Robot.step_on_ground`."""
    name = "step_on_ground"
    signature = RolloutSignature(robot, "ground", ground)
    arrays = {argument: _array(robot, name, argument, given) for argument, given in arguments.items()}
    signature.start(arrays, lambda x: _array(robot, name, "last", x), last)
    code = signature.one_step(False)
    names = ["q", "qd", "contact_impulses", "stop_impulses", "residual", "tau", "dt", "settings"]
    given = [arrays[own] for own in names]
    check(name, names, code.inputs, given)
    if signature.parameters.parameters:
        given.append(signature.parameters.flat(None, np.asarray, np.concatenate))
    return signature.states(call_arrays(code.key, given))


def rollout(
    robot: Robot, arguments: dict[str, Any], step: tuple[str, Ground | None], trajectory: bool
) -> RolloutStates | GroundStates:
    """Returns the result of `Robot.rollout`."""
    arrays, code, signature = _given(robot, "rollout", arguments, step, trajectory)
    return signature.states(call_arrays(code.key, arrays))


def rollout_vjp(
    robot: Robot, arguments: dict[str, Any], weights: tuple[Any, Any], step: tuple[str, Ground | None], trajectory: bool
) -> RolloutGradients:
    """Returns the result of `Robot.rollout_vjp`."""
    arrays, code, _ = _given(robot, "rollout_vjp", arguments, step, trajectory)
    own = ["q", "qd", *(["contact_impulses", "stop_impulses", "residual"] if step[0] == "ground" else [])]
    names = [*own, *(name for name, given in arguments.items() if name not in own and given is not None)]
    if step[0] == "ground" and "settings" not in names:
        names.append("settings")
    names.sort(key=ORDER.index)
    wanted = [k for k, name in enumerate(names) if name in RolloutGradients._fields]
    gradient = code.gradient(wanted)
    for k, shape in enumerate(code.outputs):
        weight = np.ascontiguousarray(weights[k], robot.dtype) if k < 2 else np.zeros(shape, robot.dtype)
        if weight.shape[weight.ndim - len(shape) :] != shape:
            name = ("q_weights", "qd_weights")[k]
            raise ValueError(f"`{name}` of `rollout_vjp` has the shape {weight.shape}; expected {shape}, after axes of motions")
        arrays.append(weight)
    found = call_arrays(gradient.key, arrays)
    return RolloutGradients(**dict(zip((names[k] for k in wanted), found)))


ORDER = [
    *("q", "qd", "contact_impulses", "stop_impulses", "residual", "controls", "dt"),
    *("settings", "gains", "q_ref", "qd_ref"),
]
"""the arguments of a step in their order"""
