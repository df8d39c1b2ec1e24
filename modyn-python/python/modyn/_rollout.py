"""Motions of many time steps on NumPy's arrays: methods of `Robot`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import COST, FEEDBACK, OWN, Extras, Rollout, RolloutSignature, Signature, motions
from ._modyn import Robot
from ._results import ActuatedStep, StepSolution
from ._types import HeightField, QuadraticCost, RolloutCosts, RolloutGradients, RolloutStates, StepSettings


def _array(robot: Robot, function: str, argument: str, given: Any) -> Any:
    """Returns an argument as an array in C order; `None` if it is not given."""
    if given is None or (type(given) is np.ndarray and given.dtype == robot.dtype and given.flags.c_contiguous):
        return given
    try:
        if isinstance(given, StepSettings):
            return np.asarray(given, robot.dtype)
        found = np.asarray(given)
        # Numbers that are too large become infinite, and checks of ranges find them.
        with np.errstate(over="ignore"):
            return np.ascontiguousarray(found.astype(robot.dtype, casting="same_kind")).reshape(found.shape)
    except (TypeError, ValueError) as error:
        raise TypeError(f"`{argument}` of `{function}` must be an array of real numbers: {error}") from None


def _concatenate(arrays: list[Any]) -> Any:
    lead = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
    return np.concatenate([np.broadcast_to(array, (*lead, array.shape[-1])) for array in arrays], -1)


class StructuredArguments(NamedTuple):
    """The arguments of a rollout that are more than one array."""

    cost: QuadraticCost | None
    ground: HeightField | None
    parameters: Mapping[str, Any] | None


def _given(
    robot: Robot,
    name: str,
    arguments: dict[str, Any],
    step: str,
    trajectory: bool,
    structured: StructuredArguments,
) -> tuple[list[Any], Rollout]:
    """Returns the arguments as arrays in the order of the step, and the rollout."""
    array = lambda argument, x: _array(robot, name, argument, x)
    signature = RolloutSignature.of(robot, step)
    arrays = {argument: array(argument, given) for argument, given in arguments.items()}
    signature.start(arrays, np.asarray)
    if structured.cost is not None:
        signature.add_cost(arrays, structured.cost, array, np)
        arrays["state_weights"] = np.ascontiguousarray(arrays["state_weights"])
    if structured.ground is not None:
        signature.add_ground(arrays, structured.ground, array, _concatenate)
    signature.add_parameters(arrays, structured.parameters, lambda x: array("parameters", x), _concatenate)
    found, own = signature.arrays(arrays)
    return found, signature.code(trajectory, *own)


def rollout(
    self: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    controls: ArrayLike,
    dt: ArrayLike,
    *,
    step: str = "semi_implicit",
    gains: ArrayLike | None = None,
    q_ref: ArrayLike | None = None,
    qd_ref: ArrayLike | None = None,
    cost: QuadraticCost | None = None,
    settings: StepSettings | ArrayLike | None = None,
    warm_start: ArrayLike | None = None,
    act: ArrayLike | None = None,
    applied: ArrayLike | None = None,
    ground: HeightField | None = None,
    parameters: Mapping[str, Any] | None = None,
    trajectory: bool = True,
) -> RolloutStates | RolloutCosts | StepSolution | ActuatedStep:
    """Returns the states of motions of many time steps in one call: after each step, (..., steps, n), or after the last
    one with `trajectory=False`. Many motions use the vector units and all cores.

    Arguments: `q`: (nq,); `qd`: (nv,); `controls`: (steps, nv), the joint forces of each step; `dt`: the time step, s; `step`: the
    method, such as `semi_implicit` for the function `step_semi_implicit`, or `step` for the function `step`, with contacts and joint
    limits. This one has the arguments `settings`: `StepSettings`, by default the result of `step_settings()`; `warm_start`: the
    accelerations from which the first solver starts, by default zeros; and `ground`: a `HeightField` that sets the planes of the
    surfaces, by the place of each shape before each step; leading axes of its arrays count motions, too. With a feedback, the forces
    are `controls` + `gains` (x_ref - x), where the difference of states has the difference of coordinates in tangent space, then the
    difference of velocities: `gains`: (nv, 2 nv), or (2, nv) for a gain of each joint's own coordinate and of its velocity, and
    (steps, ...); `q_ref`: (nq,) or (steps, nq); `qd_ref`: (nv,) or (steps, nv); one step stands for all of them. With
    `step="actuated"`, the function `step_actuated`, `controls` has a control for each actuator, (steps, controls), and further
    arguments are `act`: the activations before the first step, by default zeros; and `applied`: (nv,), joint forces of all steps, by
    default zeros; there is no feedback. With `cost`, a `QuadraticCost`, each step adds the cost of its forces and of the state after
    it. `parameters`: the run-time parameters, by default those of the robot: `gravity` (3,), and by link `inertia` and `payload`
    (10,), as in `{"payload": {"hand": numbers}}`. Leading axes count motions, and are broadcast.
    Result: `RolloutStates`: `q` and `qd`; with a cost `RolloutCosts`; of `step` `StepSolution` and of `actuated`
    `ActuatedStep`, with the largest `residual` and `iterations` of all steps with `trajectory=False`.
    """
    state = {"q": q, "qd": qd, "controls": controls, "dt": dt, "act": act, "applied": applied}
    arguments = {**state, "settings": settings, "warm_start": warm_start, "gains": gains, "q_ref": q_ref, "qd_ref": qd_ref}
    arrays, code = _given(self, "rollout", arguments, step, trajectory, StructuredArguments(cost, ground, parameters))
    return motions(code.handle.call(arrays))


def rollout_vjp(
    self: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    controls: ArrayLike,
    dt: ArrayLike,
    q_cotangent: ArrayLike | None,
    qd_cotangent: ArrayLike | None,
    *,
    step: str = "semi_implicit",
    gains: ArrayLike | None = None,
    q_ref: ArrayLike | None = None,
    qd_ref: ArrayLike | None = None,
    cost: QuadraticCost | None = None,
    cost_cotangent: ArrayLike | None = None,
    settings: StepSettings | ArrayLike | None = None,
    warm_start: ArrayLike | None = None,
    act: ArrayLike | None = None,
    applied: ArrayLike | None = None,
    ground: HeightField | None = None,
    parameters: Mapping[str, Any] | None = None,
    trajectory: bool = True,
) -> RolloutGradients:
    """Returns the gradients of the weighted states of motions, which `rollout` returns, with respect to its arguments, for
    each motion: one call, which stores few states. Coordinates have an entry for each of their numbers; lengths of
    quaternions have no effect.

    Arguments: the arguments of `rollout`; `q_cotangent`: (steps, nq) and `qd_cotangent`: (steps, nv), or (nq,) and (nv,) with
    `trajectory=False`; `None` for zeros; `cost_cotangent`: (steps,), or () with `trajectory=False`, the weights of the cost.
    Result: `RolloutGradients`, with the names and the shapes of the arguments.
    """
    state = {"q": q, "qd": qd, "controls": controls, "dt": dt, "act": act, "applied": applied}
    arguments = {**state, "settings": settings, "warm_start": warm_start, "gains": gains, "q_ref": q_ref, "qd_ref": qd_ref}
    weights: tuple[Any, ...] = (q_cotangent, qd_cotangent, cost_cotangent)
    arrays, code = _given(self, "rollout_vjp", arguments, step, trajectory, StructuredArguments(cost, ground, parameters))
    if cost is None and weights[2] is not None:
        raise TypeError("`cost_cotangent` of `rollout_vjp` needs a `cost`")
    solves = code.step.start is not None
    own = ("cost",) if cost is not None else ()
    names = ["q", "qd", *own, "controls", "dt", *(name for name in OWN if name in RolloutSignature.of(self, step).shapes)]
    names += [name for name in FEEDBACK if arguments[name] is not None]
    names += COST if cost is not None else ()
    names += ["parameters"] if parameters is not None else ()
    wanted = [k for k, name in enumerate(names) if name not in own and k != code.step.start]
    gradient = code.gradient(wanted)
    weights = (*weights[:2], *[None] * (len(code.outputs) - 2)) if solves else weights
    for name, shape, given in zip(("q_cotangent", "qd_cotangent", "cost_cotangent", *[""] * len(weights)), code.outputs, weights):
        weight = np.ascontiguousarray(np.zeros(shape) if given is None else given, self.dtype).reshape(np.shape(given) or shape)
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
    if parameters is not None:
        of_robot = RolloutSignature.of(self, step).parameters
        ends = np.cumsum([own.numbers.size for own in of_robot.parameters])
        found["parameters"] = of_robot.by_link(np.split(found["parameters"], ends[:-1], -1))
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
    self: Robot,
    policy: Callable[[float, NDArray[Any], NDArray[Any]], ArrayLike],
    q: ArrayLike,
    qd: ArrayLike,
    dt: ArrayLike,
    steps: int,
    settings: StepSettings | ArrayLike | None = None,
    *,
    ground: HeightField | None = None,
    parameters: Mapping[str, Any] | None = None,
) -> StepSolution:
    """Returns the results of each of `steps` calls of `step` under the joint forces `policy(time, q, qd)`, which gets the
    time (s) and the state before each step. `modyn.show` shows the motion. A rollout without a call of Python in each
    step is `rollout`.

    Arguments: `policy`: a function that returns tau: (nv,); `q`: (nq,); `qd`: (nv,); `dt`: (); `steps`: the number of
    steps; `settings`, `ground` and `parameters` as in `rollout`. Leading axes are axes of motions, which `q` and `qd` of `policy` have,
    too.
    Result: `StepSolution`, with an axis of steps after the axes of motions.
    """
    if steps < 1:
        raise ValueError(f"`steps` of `simulate` is {steps}; expected at least 1")
    signature = RolloutSignature.of(self, "step")
    arguments = {"q": q, "qd": qd, "dt": dt, "settings": settings}
    given = {name: _array(self, "simulate", name, x) for name, x in arguments.items()}
    if given["dt"].ndim:
        raise ValueError(f"`dt` of `simulate` has the shape {given['dt'].shape}; expected a number")
    given["warm_start"] = None
    signature.start(given, np.asarray)
    if ground is not None:
        signature.add_ground(given, ground, lambda name, x: _array(self, "simulate", name, x), _concatenate)
    field, of_ground = signature.ground(given)
    signature.add_parameters(given, parameters, lambda x: _array(self, "simulate", "parameters", x), _concatenate)
    step, of_robot = signature.one_step(Extras(field=field)), signature.parameters
    own = [given["parameters"]] if of_robot.parameters else []
    q, qd, qdd = given["q"], given["qd"], given["warm_start"]
    of_robot.check([q, qd, np.zeros(self.nv), given["dt"], qdd, given["settings"]], of_ground)
    leads = [x.shape[:-1] for x in (q, qd, given["settings"], *own, *of_ground[1:])]
    lead = np.broadcast_shapes(*leads, *(x.shape[:-2] for x in of_ground[:1]))
    q, qd = (np.ascontiguousarray(np.broadcast_to(x, (*lead, x.shape[-1]))) for x in (q, qd))
    results: list[StepSolution] = []
    for k in range(steps):
        tau = _array(self, "simulate", "policy(time, q, qd)", policy(k * float(given["dt"]), q, qd))
        of_step = [q, qd, tau, given["dt"], qdd, given["settings"]]
        of_robot.check(of_step, of_ground)
        results.append(StepSolution(*step.handle.call([*of_step, *own, *of_ground])))
        q, qd, qdd = results[-1][:3]
    return StepSolution(*(np.stack(parts, q.ndim - 1) for parts in zip(*results)))


METHODS = (rollout, rollout_vjp, simulate)
