"""Functions of arrays and their derivatives: what `modyn.jax` and `modyn.torch` have in common."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ._modyn import CodeHandle, Robot, functions
from ._results import ActuatedStep, StepSolution
from ._types import HeightField, QuadraticCost, RolloutCosts, RolloutStates

Shape = tuple[int, ...]


class Code:
    """Code for arrays, compiled. Two of them are equal if they have the same code."""

    base: ArrayFunction | None = None
    """the function that a derivative is of"""
    start: int | None = None
    """the argument from which a solver starts; `None` for functions without a solver, and for their derivatives"""
    state: list[int] = []
    """the arguments of a time step that are its first results, in their order"""
    constant: int | None = None
    """the argument that has no derivatives: the one from which a solver, or the first solver of a rollout, starts"""

    def __init__(self, name: str, handle: CodeHandle, dtype: Any) -> None:
        self.name, self.handle, self.dtype = name, handle, dtype
        self.key: int = handle.key
        """the key by which XLA finds the code"""
        self.inputs: list[Shape] = handle.inputs
        """the shapes of the arguments for one state"""
        self.outputs: list[Shape] = handle.outputs
        """the shapes of the results for one state"""

    def cuda_text(self) -> str:
        """Returns the text of the kernel on CUDA."""
        raise NotImplementedError(f"`{self.name}` has no kernel on CUDA")

    def at_solution(self, arguments: Sequence[Any], results: Sequence[Any]) -> list[Any]:
        """Returns the arguments at which derivatives are taken: a solver starts from the accelerations of its solution."""
        arguments = list(arguments)
        if self.start is not None:
            arguments[self.start] = results[self.state.index(self.start)]
        return arguments

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and isinstance(other, Code) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        # The text is part of the text of compiled programs, so it must be the same in each process.
        return f"{self.name}[{self.key:016x}]"


class Extras(NamedTuple):
    """What a time step of a rollout has beside the function of the table."""

    feedback: bool = False
    cost: bool = False
    ground: HeightField | None = None
    """the ground that sets the planes of the surfaces of `step`"""


class ArrayFunction(Code):
    """A function of arrays, or a derivative of one."""

    def __init__(
        self,
        robot: Robot,
        name: str,
        link: str | int | None = None,
        derivatives: tuple[Any, ...] = (),
        extras: Extras = Extras(),
    ) -> None:
        handle = robot._array_code(name, link, list(derivatives), extras.feedback, extras.cost)
        if extras.ground is not None:
            handle = robot._field_code(handle, derivatives[0] if derivatives else None, *extras.ground._numbers())
        super().__init__(name, handle, robot.dtype)
        self.robot, self.link, self.derivatives, self.extras = robot, link, derivatives, extras
        names = Signature.of(robot, name, link).names
        self._solves = "warm_start" in names
        if self._solves and not derivatives:
            self.start = self.constant = names.index("warm_start")
        self.state = [k for k, argument in enumerate(names) if argument in STATE]
        self._derived: dict[tuple[str, tuple[int, ...]], ArrayFunction] = {}
        self._rollouts: dict[tuple[int, bool, tuple[int, ...]], Rollout] = {}

    def cuda_text(self) -> str:
        """Returns the text of the kernel on CUDA."""
        if self.extras.ground is not None:
            raise NotImplementedError("steps on a `HeightField` run on the CPU; on CUDA, set the planes of the surfaces in `settings`")
        extras = self.extras.feedback, self.extras.cost
        return self.robot._array_text(self.name, self.link, list(self.derivatives), *extras)

    def rollout(self, steps: int, trajectory: bool, sequences: tuple[int, ...]) -> Rollout:
        """Returns the rollout of this number of steps; `sequences` are the arguments with numbers for each step."""
        at = (steps, trajectory, sequences)
        found = self._rollouts.get(at)
        if found is None:
            if len(self._rollouts) >= MOST_ROLLOUTS:
                self._rollouts.clear()
            found = self._rollouts[at] = Rollout(self, steps, trajectory, sequences)
        return found

    def derivative(self, mode: str, variables: Sequence[int]) -> ArrayFunction:
        """Returns the derivative with respect to these arguments.

        `forward`: the changes of the results; the changes of the variables are further arguments. `reverse`: the gradients of
        the weighted results with respect to the variables; the weights are further arguments. `matrix`: for each result and each
        variable the array of derivatives.

        Derivatives of a solver start from its solution, and do not depend on the argument from which the solver starts.
        """
        if self._solves and self.derivatives:
            raise NotImplementedError(f"`{self.name}` has first derivatives alone")
        at = (mode, tuple(variables))
        found = self._derived.get(at)
        if found is None:
            derivatives = (*self.derivatives, (mode, list(variables)))
            found = ArrayFunction(self.robot, self.name, self.link, derivatives, self.extras)
            found.base = self
            self._derived[at] = found
        return found

    @property
    def mode(self) -> str | None:
        """the mode of the last derivative; `None` for a function itself"""
        return self.derivatives[-1][0] if self.derivatives else None

    @property
    def variables(self) -> list[int]:
        """the arguments with respect to which the last derivative is"""
        return self.derivatives[-1][1] if self.derivatives else []


MOST_ROLLOUTS = 64
"""the rollouts that a step keeps, one for each number of steps"""


class Rollout(Code):
    """A time step that is repeated: the results of all steps, or of the last one."""

    def __init__(self, step: ArrayFunction, steps: int, trajectory: bool, sequences: tuple[int, ...]) -> None:
        # A cost is an argument after `q` and `qd`, and a result after them.
        self.state = [*step.state, 2] if step.extras.cost else step.state
        self.roles = {"state": self.state, "start": step.start, "sequences": list(sequences)}
        super().__init__(f"rollout of {step.name}", step.handle.rollout(steps, trajectory, self.roles), step.dtype)
        self.step, self.steps, self.trajectory, self.sequences = step, steps, trajectory, sequences
        self.constant = step.start
        self._gradients: dict[tuple[int, ...], RolloutGradient] = {}

    def gradient(self, variables: Sequence[int]) -> RolloutGradient:
        """Returns the gradients of the weighted states with respect to these arguments; the weights are further arguments."""
        found = self._gradients.get(tuple(variables))
        if found is None:
            found = self._gradients[tuple(variables)] = RolloutGradient(self, list(variables))
        return found

    def derivative(self, mode: str, variables: Sequence[int]) -> RolloutGradient:
        """Returns the derivative with respect to these arguments, of mode `reverse`."""
        if mode != "reverse":
            raise NotImplementedError(FIRST)
        return self.gradient(variables)


class RolloutGradient(Code):
    """The gradients of the weighted states of a rollout."""

    def __init__(self, rollout: Rollout, variables: list[int]) -> None:
        carried = {k for k in rollout.state if k != rollout.step.start}
        step = rollout.step.derivative("reverse", sorted(carried | {*variables}))
        forward, reverse = rollout.step.handle, (step.handle, variables)
        handle = forward.rollout(rollout.steps, rollout.trajectory, rollout.roles, reverse)
        super().__init__(rollout.name, handle, rollout.dtype)
        self.rollout, self.variables = rollout, variables

    def derivative(self, mode: str, variables: Sequence[int]) -> Any:
        """Raises: there are no second derivatives."""
        raise NotImplementedError(FIRST)


FIRST = "a rollout in one call has first derivatives in reverse mode; for others, differentiate a loop over the function of its step"

STATE = ("q", "qd", "act", "warm_start")
"""the arguments of a time step that are results of the step before, in the order of the results: `warm_start` is the result `qdd`"""

OWN = ("act", "applied", "warm_start", "settings")
"""the arguments of a time step with a solver beside the state, the forces or the controls, and the time"""

FEEDBACK = ("gains", "q_ref", "qd_ref")
"""the arguments of a step with a feedback"""

COST = ("q_goal", "qd_goal", "state_weights", "control_weights")
"""the arguments of a step with a cost"""


class RolloutSignature:
    """The arguments of the rollouts of a time step."""

    def __init__(self, robot: Robot, step: str, ground: HeightField | None = None) -> None:
        if step not in time_steps():
            raise ValueError(f"there is no time step `{step}`; there are: {', '.join(time_steps())}")
        if ground is not None and step != "step":
            raise TypeError('`ground` is an argument of rollouts with `step="step"`')
        if not isinstance(ground, HeightField | None):
            raise TypeError(f"`ground` must be a `modyn.HeightField`, not {type(ground).__name__}")
        self.robot, self.step, self.ground = robot, step if step == "step" else f"step_{step}", ground
        self.parameters = Signature.of(robot, self.step)
        self.solves = "warm_start" in self.parameters.names
        self.is_actuated = "ctrl" in self.parameters.names
        nq, nv = robot.nq, robot.nv
        self.shapes: dict[str, Shape] = {"q": (nq,), "qd": (nv,), "cost": (), "controls": (nv,), "dt": ()}
        """the shapes of the arguments for one state, in their order"""
        if self.is_actuated:
            self.shapes["controls"] = (len(robot.control_names),)
        self.shapes |= {name: shape for name, shape in zip(self.parameters.names, self.parameters.shapes) if name in OWN}
        self.shapes |= {"gains": (nv, 2 * nv), "q_ref": (nq,), "qd_ref": (nv,)}
        self.shapes |= {"q_goal": (nq,), "qd_goal": (nv,), "state_weights": (2 * nv,), "control_weights": (nv,)}

    @classmethod
    def of(cls, robot: Robot, step: str, ground: HeightField | None = None) -> RolloutSignature:
        """Returns the signature, which the robot keeps unless it has a ground or run-time parameters."""
        if ground is not None:
            return cls(robot, step, ground)
        at = (cls, step)
        found: RolloutSignature | None = robot._kept.get(at)
        if found is None:
            found = cls(robot, step)
            if not found.parameters.parameters:
                robot._kept[at] = found
        return found

    def start(self, given: dict[str, Any], asarray: Callable[[Any], Any]) -> None:
        """Adds the defaults of the arguments that only steps with a solver have. Activations are zero before the first step."""
        for name in OWN:
            if name not in self.parameters.names:
                if given.pop(name, None) is not None:
                    steps = '`step="actuated"`' if name in ("act", "applied") else '`step="step"` and `step="actuated"`'
                    raise TypeError(f"`{name}` is an argument of rollouts with {steps}")
            elif given.get(name) is None:
                at = self.parameters.names.index(name)
                default = self.parameters.defaults[at]
                given[name] = asarray(np.zeros(self.parameters.shapes[at], self.robot.dtype) if default is None else default)

    def add_cost(self, given: dict[str, Any], cost: QuadraticCost, asarray: Callable[[str, Any], Any], library: Any) -> None:
        """Adds the arguments of a cost to those of a rollout. `library` has `zeros`, `broadcast_to` and `concatenate`."""
        if not isinstance(cost, QuadraticCost):
            raise TypeError(f"`cost` of `rollout` must be a `modyn.QuadraticCost`, not {type(cost).__name__}")
        arrays = {name: None if x is None else asarray(name, x) for name, x in cost._asdict().items()}
        missing = [name for name in ("q_goal", "state_weights") if arrays[name] is None]
        if missing:
            raise TypeError(f"`cost` of `rollout` needs `{missing[0]}`")
        terminal, weights, nv = arrays.pop("terminal_weights"), arrays["state_weights"], self.robot.nv
        dtype = weights.dtype
        for name in ("qd_goal", "control_weights"):
            arrays[name] = library.zeros((nv,), dtype=dtype) if arrays[name] is None else arrays[name]
        if terminal is not None:
            check("rollout", ["terminal_weights"], [(2 * nv,)], [terminal])
            steps = given["controls"].shape[-2]
            if weights.ndim == 1:
                weights = weights[None]
            whole = lambda x, count: library.broadcast_to(x, (*lead, count, x.shape[-1]))
            lead = np.broadcast_shapes(weights.shape[:-2], terminal.shape[:-1])
            weights = whole(weights, steps)
            last = weights[..., steps - 1 :, :] + terminal[..., None, :]
            arrays["state_weights"] = library.concatenate([weights[..., : steps - 1, :], last], -2) if steps else weights
        given.update(arrays, cost=library.zeros((), dtype=dtype))

    def arrays(self, given: dict[str, Any]) -> tuple[list[Any], tuple[int, bool, bool, tuple[int, ...]]]:
        """Returns the arguments in the order of the step, without those that are `None`; and the arguments of `code`."""
        controls = given["controls"]
        if controls.ndim < 2:
            shape, (count,) = tuple(controls.shape), self.shapes["controls"]
            raise ValueError(f"`controls` of `rollout` has the shape {shape}; expected (steps, {count}), or (..., steps, {count})")
        missing = [name for name in FEEDBACK if given[name] is None]
        if len(missing) not in (0, 3):
            raise TypeError(f"`rollout` needs `gains`, `q_ref` and `qd_ref` together: `{missing[0]}` is missing")
        steps = int(controls.shape[-2])
        has_cost = "cost" in given
        if has_cost and self.solves:
            raise TypeError("`rollout` with contacts has no cost: compute it from the states, and leave `cost` out")
        if not missing and self.is_actuated:
            raise TypeError('`rollout` with `step="actuated"` has no feedback: leave `gains`, `q_ref` and `qd_ref` out')
        one = self.shapes
        left_out = (*missing, *(() if has_cost else ("cost", *COST)))
        names = [name for name in one if name not in left_out]
        sequences = ["controls"]
        for name in (*FEEDBACK, *COST):
            if name not in names:
                continue
            shape, at = tuple(given[name].shape), given[name].ndim - len(one[name]) - 1
            if at >= 0 and shape[at] == 1:
                # One step stands for all of them.
                given[name] = given[name].reshape(shape[:at] + shape[at + 1 :])
            elif at >= 0:
                sequences.append(name)
        shapes = [(steps, *one[name]) if name in sequences else one[name] for name in names]
        arrays = [given[name] for name in names]
        check("rollout", names, shapes, arrays)
        if self.parameters.parameters:
            arrays.append(given["parameters"])
        return arrays, (steps, not missing, has_cost, tuple(names.index(name) for name in sequences))

    def code(self, trajectory: bool, steps: int, feedback: bool, cost: bool, sequences: tuple[int, ...]) -> Rollout:
        """Returns the rollout of this number of steps."""
        return self.one_step(feedback, cost).rollout(steps, trajectory, sequences)

    def one_step(self, feedback: bool = False, cost: bool = False) -> ArrayFunction:
        """Returns the function of one step, which the robot keeps unless it has a ground."""
        if self.ground is not None:
            return ArrayFunction(self.robot, self.step, extras=Extras(feedback, cost, self.ground))
        kept, at = self.robot._kept, (ArrayFunction, self.step, feedback, cost)
        found: ArrayFunction | None = kept.get(at)
        if found is None:
            found = kept[at] = ArrayFunction(self.robot, self.step, extras=Extras(feedback, cost))
        return found


def unchanging(ground: HeightField | None) -> HeightField | None:
    """Returns the ground with heights of its own, so that a step and its derivatives have the same ones."""
    if not isinstance(ground, HeightField):
        return ground
    return dataclasses.replace(ground, heights=np.array(ground.heights, float))


def motions(results: Sequence[Any]) -> Any:
    """Returns the results of a rollout, with a type for those with a cost and for those of each step with a solver."""
    return {2: RolloutStates, 3: RolloutCosts, 6: StepSolution, 7: ActuatedStep}[len(results)](*results)


@functools.cache
def time_steps() -> list[str]:
    """Returns the names of time steps."""
    found = (re.fullmatch("step_(?!.*_(?:derivatives|hessian)$)(.*)", name) for name in functions())
    return [*(step[1] for step in found if step), "step"]


class Parameter(NamedTuple):
    """A run-time parameter."""

    option: str
    """`gravity`, `inertia` or `payload`"""
    link: str | None
    numbers: Any
    """the present numbers: (3,) of gravity, else (10,)"""


class Signature:
    """The arguments and the result of a function."""

    def __init__(self, robot: Robot, name: str, link: str | int | None) -> None:
        arguments, parameters, self.result = robot._array_signature(name, link)
        self.name = name
        self.names = [name for name, _, _ in arguments]
        self.shapes: list[Shape] = [tuple(shape) for _, shape, _ in arguments]
        self.defaults = [default for _, _, default in arguments]
        self.parameters = [Parameter(option, link, np.array(numbers, robot.dtype)) for option, link, numbers in parameters]

    @classmethod
    def of(cls, robot: Robot, name: str, link: str | int | None = None) -> Signature:
        """Returns the signature, which the robot keeps unless it has run-time parameters."""
        at = (cls, name, link)
        found: Signature | None = robot._kept.get(at)
        if found is None:
            found = cls(robot, name, link)
            if not found.parameters:
                robot._kept[at] = found
        return found

    @functools.cached_property
    def signature(self) -> inspect.Signature:
        """the arguments as those of a function of Python"""
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        empty = inspect.Parameter.empty
        own = [
            inspect.Parameter(name, kind, default=empty if default is None else None)
            for name, default in zip(self.names, self.defaults)
        ]
        if self.parameters:
            own.append(inspect.Parameter("parameters", inspect.Parameter.KEYWORD_ONLY, default=None))
        return inspect.Signature(own)

    def bind(self, given: tuple[Any, ...], named: dict[str, Any], defaults: Sequence[Any]) -> tuple[list[Any], Any]:
        """Returns the arguments in their order, with these defaults, and the run-time parameters or `None`."""
        if not named and len(given) == len(self.names):
            all_given, parameters = list(given), None
        else:
            try:
                bound = self.signature.bind(*given, **named)
            except TypeError as error:
                raise TypeError(f"`{self.name}`: {error}") from None
            bound.apply_defaults()
            all_given = [bound.arguments[name] for name in self.names]
            parameters = bound.arguments.get("parameters")
        return [default if x is None else x for x, default in zip(all_given, defaults)], parameters

    def check(self, arrays: Sequence[Any]) -> None:
        """Checks the shapes of arguments, whose leading axes are those of states and are broadcast."""
        check(self.name, self.names, self.shapes, arrays)

    def flat(self, parameters: Any, asarray: Callable[[Any], Any], concatenate: Callable[[list[Any]], Any]) -> Any:
        """Returns the numbers of run-time parameters, as `parameters` of the module returns them, in one array (..., n)."""
        if parameters is None:
            return asarray(np.concatenate([own.numbers for own in self.parameters]))
        arrays = []
        for option, link, numbers in self.parameters:
            where = f'["{option}"]' if link is None else f'["{option}"]["{link}"]'
            try:
                given = parameters[option] if link is None else parameters[option][link]
            except (KeyError, TypeError, IndexError):
                raise ValueError(f"`parameters` of `{self.name}` lacks {where}; `parameters(robot)` returns all of them") from None
            array = asarray(given)
            if tuple(array.shape[-1:]) != numbers.shape:
                message = f"`parameters{where}` of `{self.name}` has the shape {tuple(array.shape)}; expected {numbers.shape}"
                raise ValueError(message)
            arrays.append(array)
        return concatenate(arrays)

    def described(self, asarray: Callable[[Any], Any]) -> dict[str, Any]:
        """Returns the present run-time parameters: `gravity` (3,), and by link `inertia` and `payload` (10,)."""
        found: dict[str, Any] = {}
        for option, link, numbers in self.parameters:
            if link is None:
                found[option] = asarray(numbers)
            else:
                found.setdefault(option, {})[link] = asarray(numbers)
        return found


def check(function: str, names: Sequence[str], shapes: Sequence[Shape], arrays: Sequence[Any]) -> None:
    """Checks the shapes of arguments, whose leading axes are those of states and are broadcast."""
    if all(array.shape == own for own, array in zip(shapes, arrays)):
        return
    leads = []
    for name, own, array in zip(names, shapes, arrays):
        shape = tuple(array.shape)
        split = len(shape) - len(own)
        if split < 0 or shape[split:] != own:
            many = "(..., " + str(own).strip("(),") + ")" if own else "(...)"
            raise ValueError(f"`{name}` of `{function}` has the shape {shape}; expected {own}, or {many} for many states")
        leads.append(shape[:split])
    try:
        np.broadcast_shapes(*leads)
    except ValueError:
        listed = ", ".join(f"`{name}` {lead}" for name, lead in zip(names, leads) if lead)
        raise ValueError(f"the axes of states of the arguments of `{function}` do not fit: {listed}") from None


def documented(call: Callable[..., Any], signature: Signature, library: str) -> Callable[..., Any]:
    """Returns the function with the name, the arguments and the documentation of the method of `Robot`."""
    method = getattr(Robot, signature.name)
    call.__name__ = call.__qualname__ = signature.name
    call.__signature__ = signature.signature  # type: ignore[attr-defined]
    call.__doc__ = f"{inspect.getdoc(method)}\n\nArguments and results are arrays of {library}; leading axes are those of states."
    return call
