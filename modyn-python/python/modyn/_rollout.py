"""Rollouts on NumPy's arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import COST, FEEDBACK, ArrayFunction, GroundStep, Rollout, RolloutSignature, check, motions
from ._modyn import Robot, call_arrays
from ._results import StepDerivatives
from ._types import ConstraintSettings, Ground, GroundStates, QuadraticCost, RolloutCosts, RolloutGradients, RolloutStates

Step = tuple[str, Ground | None]
"""the name of a time step, and the options of a step on the ground"""


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
    robot: Robot, name: str, arguments: dict[str, Any], step: Step, trajectory: bool, cost: QuadraticCost | None
) -> tuple[list[Any], Rollout]:
    """Returns the arguments as arrays in the order of the step, and the rollout."""
    array = lambda argument, x: _array(robot, name, argument, x)
    signature = RolloutSignature(robot, *step)
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
) -> RolloutStates | RolloutCosts | GroundStates:
    """Returns the result of `Robot.rollout`."""
    arrays, code = _given(robot, "rollout", arguments, step, trajectory, cost)
    return motions(call_arrays(code.key, arrays))


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
    on_ground = isinstance(code.step, GroundStep)
    own = ("contact_impulses", "stop_impulses", "residual") if on_ground else ("cost",) if cost is not None else ()
    names = ["q", "qd", *own, "controls", "dt", *(["settings"] if on_ground else [])]
    names += [name for name in FEEDBACK if arguments[name] is not None]
    names += COST if cost is not None else ()
    wanted = [k for k, name in enumerate(names) if name not in own]
    gradient = code.gradient(wanted)
    weights = (*weights[:2], None, None, None) if on_ground else weights
    for name, shape, given in zip(("q_weights", "qd_weights", "cost_weights", "", ""), code.outputs, weights):
        weight = np.ascontiguousarray(np.zeros(shape) if given is None else given, robot.dtype).reshape(np.shape(given) or shape)
        if weight.shape[weight.ndim - len(shape) :] != shape:
            raise ValueError(f"`{name}` of `rollout_vjp` has the shape {weight.shape}; expected {shape}, after axes of motions")
        arrays.append(weight)
    found = dict(zip((names[k] for k in wanted), call_arrays(gradient.key, arrays)))
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


def _ground(
    robot: Robot, name: str, arguments: dict[str, Any], last: GroundStates | None, ground: Ground | None
) -> tuple[GroundStep, list[Any]]:
    """Returns the step on the ground, and its arguments as arrays."""
    signature = RolloutSignature(robot, "ground", ground)
    arrays = {argument: _array(robot, name, argument, given) for argument, given in arguments.items()}
    signature.start(arrays, lambda x: _array(robot, name, "last", x), last)
    code = signature.one_step()
    assert isinstance(code, GroundStep)
    names = ["q", "qd", "contact_impulses", "stop_impulses", "residual", "tau", "dt", "settings"]
    given = [arrays[own] for own in names]
    check(name, names, code.inputs, given)
    if signature.parameters.parameters:
        given.append(signature.parameters.flat(None, np.asarray, np.concatenate))
    return code, given


def step_on_ground(robot: Robot, arguments: dict[str, Any], last: GroundStates | None, ground: Ground | None) -> GroundStates:
    """Returns the result of `Robot.step_on_ground`."""
    code, given = _ground(robot, "step_on_ground", arguments, last, ground)
    return GroundStates(*call_arrays(code.key, given))


def step_on_ground_derivatives(
    robot: Robot, arguments: dict[str, Any], last: GroundStates | None, ground: Ground | None
) -> StepDerivatives:
    """Returns the result of `Robot.step_on_ground_derivatives`."""
    code, given = _ground(robot, "step_on_ground_derivatives", arguments, last, ground)
    unit = np.eye(robot.nv, dtype=robot.dtype)
    to_rates = ArrayFunction(robot, "velocity_to_qdot").key
    # The rates of the coordinates under each unit velocity: rows, which are orthogonal.
    rates = lambda q: call_arrays(to_rates, [np.ascontiguousarray(q[..., None, :]), unit])[0]
    before = np.swapaxes(rates(given[0]), -1, -2)
    q, qd, *_ = call_arrays(code.key, given)
    after = rates(q)
    by = call_arrays(code.derivative("matrix", [0, 1, 5]).key, given)
    columns = [np.concatenate([of_q @ before, *others], -1) for of_q, *others in (by[:3], by[3:6])]
    moved = after @ columns[0] / np.sum(after * after, -1)[..., None]
    matrices = np.concatenate([moved, columns[1]], -2)
    return StepDerivatives(q, qd, matrices[..., : 2 * robot.nv], matrices[..., 2 * robot.nv :])


def simulate(
    robot: Robot, policy: Callable[[float, Any, Any], Any], arguments: dict[str, Any], steps: int, ground: Ground | None
) -> GroundStates:
    """Returns the result of `Robot.simulate`."""
    if steps < 1:
        raise ValueError(f"`steps` of `simulate` is {steps}; expected at least 1")
    q, qd, dt = (np.asarray(arguments[name], robot.dtype) for name in ("q", "qd", "dt"))
    if dt.ndim:
        raise ValueError(f"`dt` of `simulate` has the shape {dt.shape}; expected a number")
    found: list[GroundStates] = []
    for k in range(steps):
        tau = policy(k * float(dt), q, qd)
        of_step = {"q": q, "qd": qd, "tau": tau, "dt": dt, "settings": arguments["settings"]}
        found.append(step_on_ground(robot, of_step, found[-1] if found else None, ground))
        q, qd = found[-1].q, found[-1].qd
    return GroundStates(*(np.stack(parts, q.ndim - 1) for parts in zip(*found)))
