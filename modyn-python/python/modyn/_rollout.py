"""Rollouts on NumPy's arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import COST, FEEDBACK, OWN, ArrayFunction, Rollout, RolloutSignature, Signature, motions
from ._modyn import Robot
from ._results import ActuatedStep, StepSolution
from ._types import HeightField, QuadraticCost, RolloutCosts, RolloutGradients, RolloutStates, StepSettings

Step = tuple[str, HeightField | None]
"""the name of a time step, and the ground of `step`"""


def _array(robot: Robot, function: str, argument: str, given: Any) -> Any:
    """Returns an argument as an array in C order; `None` if it is not given."""
    if given is None or (type(given) is np.ndarray and given.dtype == robot.dtype and given.flags.c_contiguous):
        return given
    try:
        if isinstance(given, StepSettings):
            return np.asarray(given, robot.dtype)
        found = np.asarray(given)
        return np.ascontiguousarray(found.astype(robot.dtype, casting="same_kind")).reshape(found.shape)
    except (TypeError, ValueError) as error:
        raise TypeError(f"`{argument}` of `{function}` must be an array of real numbers: {error}") from None


def _given(
    robot: Robot, name: str, arguments: dict[str, Any], step: Step, trajectory: bool, cost: QuadraticCost | None
) -> tuple[list[Any], Rollout]:
    """Returns the arguments as arrays in the order of the step, and the rollout."""
    array = lambda argument, x: _array(robot, name, argument, x)
    signature = RolloutSignature.of(robot, *step)
    arrays = {argument: array(argument, given) for argument, given in arguments.items()}
    signature.start(arrays, np.asarray)
    if cost is not None:
        signature.add_cost(arrays, cost, array, np)
        arrays["state_weights"] = np.ascontiguousarray(arrays["state_weights"])
    if signature.parameters.parameters:
        arrays["parameters"] = signature.parameters.flat(None, np.asarray, np.concatenate)
    found, own = signature.arrays(arrays)
    return found, signature.code(trajectory, *own)


def rollout(
    robot: Robot, arguments: dict[str, Any], step: Step, trajectory: bool, cost: QuadraticCost | None
) -> RolloutStates | RolloutCosts | StepSolution | ActuatedStep:
    """Returns the result of `Robot.rollout`."""
    arrays, code = _given(robot, "rollout", arguments, step, trajectory, cost)
    return motions(code.handle.call(arrays))


def rollout_vjp(
    robot: Robot,
    arguments: dict[str, Any],
    weights: tuple[Any, ...],
    step: Step,
    trajectory: bool,
    cost: QuadraticCost | None,
) -> RolloutGradients:
    """Returns the result of `Robot.rollout_vjp`."""
    arrays, code = _given(robot, "rollout_vjp", arguments, step, trajectory, cost)
    if cost is None and weights[2] is not None:
        raise TypeError("`cost_weights` of `rollout_vjp` are those of a `cost`")
    solves = code.step.start is not None
    own = ("cost",) if cost is not None else ()
    names = ["q", "qd", *own, "controls", "dt", *(name for name in OWN if name in RolloutSignature.of(robot, *step).shapes)]
    names += [name for name in FEEDBACK if arguments[name] is not None]
    names += COST if cost is not None else ()
    wanted = [k for k, name in enumerate(names) if name not in own and k != code.step.start]
    gradient = code.gradient(wanted)
    weights = (*weights[:2], *[None] * (len(code.outputs) - 2)) if solves else weights
    for name, shape, given in zip(("q_weights", "qd_weights", "cost_weights", *[""] * len(weights)), code.outputs, weights):
        weight = np.ascontiguousarray(np.zeros(shape) if given is None else given, robot.dtype).reshape(np.shape(given) or shape)
        if weight.shape[weight.ndim - len(shape) :] != shape:
            raise ValueError(f"`{name}` of `rollout_vjp` has the shape {weight.shape}; expected {shape}, after axes of motions")
        arrays.append(weight)
    found = dict(zip((names[k] for k in wanted), gradient.handle.call(arrays)))
    if cost is not None and cost.terminal_weights is not None:
        # Those of the weights of each step, of which the last has the terminal weights added.
        by_step = found["state_weights"]
        found["terminal_weights"] = by_step[..., -1:, :].sum(-2)
        if _steps(cost.state_weights, "state_weights") in (None, 1):
            found["state_weights"] = by_step.sum(-2)
    given = {**arguments, **(cost._asdict() if cost is not None else {})}
    for name in (*FEEDBACK, *COST):
        if name in found and _steps(given[name], name) == 1:
            found[name] = np.expand_dims(found[name], -1 - _rank(name))
    if cost is not None:
        of_cost = {name: found.pop(name, None) for name in QuadraticCost._fields}
        found["cost"] = QuadraticCost(**{name: None if given[name] is None else x for name, x in of_cost.items()})
    return RolloutGradients(**found)


def _rank(name: str) -> int:
    return 2 if name == "gains" else 1


def _steps(given: Any, name: str) -> int | None:
    """Returns the length of the axis of steps of an argument; `None` if it has none."""
    shape = np.shape(given)
    return shape[-1 - _rank(name)] if len(shape) > _rank(name) else None


def simulate(
    robot: Robot, policy: Callable[[float, Any, Any], Any], arguments: dict[str, Any], steps: int, ground: HeightField | None
) -> StepSolution:
    """Returns the result of `Robot.simulate`."""
    if steps < 1:
        raise ValueError(f"`steps` of `simulate` is {steps}; expected at least 1")
    signature = RolloutSignature(robot, "step", ground)
    given = {name: _array(robot, "simulate", name, x) for name, x in arguments.items()}
    if given["dt"].ndim:
        raise ValueError(f"`dt` of `simulate` has the shape {given['dt'].shape}; expected a number")
    given["warm_start"] = None
    signature.start(given, np.asarray)
    step, of_robot = signature.one_step(), signature.parameters
    parameters = [of_robot.flat(None, np.asarray, np.concatenate)] if of_robot.parameters else []
    q, qd, qdd = given["q"], given["qd"], given["warm_start"]
    results: list[StepSolution] = []
    for k in range(steps):
        tau = _array(robot, "simulate", "policy(time, q, qd)", policy(k * float(given["dt"]), q, qd))
        of_step = [q, qd, tau, given["dt"], qdd, given["settings"]]
        of_robot.check(of_step)
        results.append(StepSolution(*step.handle.call(of_step + parameters)))
        q, qd, qdd = results[-1][:3]
    return StepSolution(*(np.stack(parts, q.ndim - 1) for parts in zip(*results)))
