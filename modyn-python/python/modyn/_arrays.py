"""Functions of arrays and their derivatives: what `modyn.jax` and `modyn.torch` have in common."""

from __future__ import annotations

import functools
import hashlib
import inspect
import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ._modyn import CodeHandle, Robot, functions
from ._results import ActuatedStep, StepSolution
from ._types import HeightField, QuadraticCost, RolloutCosts, RolloutStates

Shape = tuple[int, ...]


NO_PARAMETERS = "the robot has no run-time parameters: load it with `runtime_gravity=True`, `runtime_inertia=[...]` or `payload=[...]`"

NO_HEIGHTS = "steps have no derivatives with respect to the fields of `ground`: do not differentiate by them"


class Code:
    """Code for arrays, compiled. Two of them are equal if they have the same code."""

    base: ArrayFunction | None = None
    """the function that a derivative is of"""
    start: int | None = None
    """the argument from which a solver starts; `None` for functions without a solver, and for their derivatives"""
    state: list[int] = []
    """the arguments of a time step that are its first results, in their order"""
    constant: int | None = None
    """the argument on which results do not depend: the one from which a solver, or the first solver of a rollout, starts"""
    heights: int | None = None
    """the argument with the heights of the ground, which the one with its grid follows; `None` without a height field"""

    def __init__(self, name: str, handle: CodeHandle, dtype: Any) -> None:
        self.name, self.handle, self.dtype = name, handle, dtype
        self.key: int = handle.key
        """the key by which XLA finds the code"""
        self.inputs: list[Shape] = handle.inputs
        """the shapes of the arguments for one state"""
        self.outputs: list[Shape] = handle.outputs
        """the shapes of the results for one state"""

    @property
    def variable(self) -> list[int]:
        """the arguments with respect to which there are derivatives"""
        ground = () if self.heights is None else (self.heights, self.heights + 1)
        return [k for k in range(len(self.inputs)) if k not in ground]

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

    gains: tuple[int, int] | None = None
    """the rows and columns of the gains of a feedback"""
    cost: bool = False
    field: tuple[int, int] | None = None
    """the rows and columns of the height field that sets the planes of the surfaces"""


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
        super().__init__(name, robot._array_code(name, link, list(derivatives), extras), robot.dtype)
        self.robot, self.link, self.derivatives, self.extras = robot, link, derivatives, extras
        names = Signature.of(robot, name, link).names
        self._solves = "warm_start" in names
        if self._solves and not derivatives:
            self.start = self.constant = names.index("warm_start")
        self.state = [k for k, argument in enumerate(names) if argument in STATE]
        if extras.field is not None and not derivatives:
            self.heights = len(self.inputs) - 2
        self._derived: dict[tuple[str, tuple[int, ...]], ArrayFunction] = {}
        self._fields: dict[tuple[int, int], ArrayFunction] = {}
        self._rollouts: dict[tuple[int, bool, tuple[int, ...]], Rollout] = {}

    def cuda_text(self) -> str:
        """Returns the text of the kernel on CUDA."""
        return self.robot._array_text(self.name, self.link, list(self.derivatives), self.extras)

    def on_planes(self, arrays: Sequence[Any], call: Callable[[Code, list[Any]], Any], library: Any) -> list[Any]:
        """Returns the results of a step on a height field, or of its derivative, on CUDA: of a kernel that sets the planes of the
        settings, and of the step's.

        `call` calls a function of arrays. `library` has `concatenate` and `zeros_like`.
        """
        heights, signature = (self.base or self).heights, Signature.of(self.robot, self.name, self.link)
        q, settings = signature.names.index("q"), signature.settings
        assert heights is not None and settings is not None and self.extras.field is not None
        field = FieldKernels.of(self.robot, self.extras.field)
        own, ground, others = list(arrays[:heights]), arrays[heights : heights + 2], list(arrays[heights + 2 :])
        [poses] = call(field.poses, [own[q]])
        [own[settings]] = call(field.planes, [poses, own[settings], *ground])
        step = ArrayFunction(self.robot, self.name, self.link, self.derivatives, self.extras._replace(field=None))
        if settings not in self.variables:
            return list(call(step, [*own, *others]))
        # Derivatives hold the planes where they are.
        hold = lambda numbers: field.without_planes(numbers, library)
        at, count = self.variables.index(settings), len(self.variables)
        if self.mode == "forward":
            others[at] = hold(others[at])
            return list(call(step, [*own, *others]))
        return [hold(x) if k % count == at else x for k, x in enumerate(call(step, [*own, *others]))]

    def on_field(self, field: tuple[int, int]) -> ArrayFunction:
        """Returns the function on a height field of these rows and columns."""
        found = self._fields.get(field)
        if found is None:
            extras = self.extras._replace(field=field)
            found = self._fields[field] = ArrayFunction(self.robot, self.name, self.link, self.derivatives, extras)
        return found

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
        if self.extras.field is not None and self.derivatives:
            raise NotImplementedError(
                f"`{self.name}` with a `ground` has first derivatives alone; for others, set the planes of the surfaces in the settings"
            )
        if not set(variables) <= set(self.variable):
            raise NotImplementedError(NO_HEIGHTS)
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


class KernelCode(Code):
    """A function of arrays on CUDA alone."""

    def __init__(self, name: str, text: str, inputs: list[Shape], outputs: list[Shape], dtype: Any) -> None:
        self.name, self.handle, self.dtype, self.inputs, self.outputs = name, None, dtype, inputs, outputs
        self.key = int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little") >> 1
        self._text = text

    def cuda_text(self) -> str:
        """Returns the text of the kernel on CUDA."""
        return self._text


class FieldKernels:
    """The kernels on CUDA that set the planes of settings to those of a height field below the shapes that touch it."""

    def __init__(self, robot: Robot, field: tuple[int, int]) -> None:
        poses, planes, self.places = robot._field_texts(field)
        shape, settings = (12 * len(self.places),), np.asarray(robot.step_settings(), robot.dtype).shape
        self.poses = KernelCode("poses of the shapes", poses, [(robot.nq,)], [shape], robot.dtype)
        self.planes = KernelCode("planes of the ground", planes, [shape, settings, field, (4,)], [settings], robot.dtype)

    @classmethod
    def of(cls, robot: Robot, field: tuple[int, int]) -> FieldKernels:
        """Returns the kernels, which the robot keeps."""
        found: FieldKernels | None = robot._kept.get((cls, field))
        if found is None:
            found = robot._kept[cls, field] = cls(robot, field)
        return found

    def without_planes(self, settings: Any, library: Any) -> Any:
        """Returns numbers of settings with zeros for the planes."""
        parts, end = [], 0
        for place in self.places:
            parts += [settings[..., end:place], library.zeros_like(settings[..., place : place + 12])]
            end = place + 12
        return library.concatenate([*parts, settings[..., end:]], -1)


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
        self.constant, self.heights = step.start, step.heights
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

SOLVING = '`step="step"` and `step="actuated"`'
"""the time steps with a solver"""

GROUND = ("ground.heights", "ground.origin and ground.spacing")
"""the last arguments of a step on a height field"""

FEEDBACK = ("gains", "q_ref", "qd_ref")
"""the arguments of a step with a feedback"""

COST = ("q_goal", "qd_goal", "state_weights", "control_weights")
"""the arguments of a step with a cost"""


class RolloutSignature:
    """The arguments of the rollouts of a time step."""

    def __init__(self, robot: Robot, step: str) -> None:
        if step not in time_steps():
            raise ValueError(f"there is no time step `{step}`; there are: {', '.join(time_steps())}")
        self.robot, self.step = robot, step if step == "step" else f"step_{step}"
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
    def of(cls, robot: Robot, step: str) -> RolloutSignature:
        """Returns the signature, which the robot keeps unless it has run-time parameters."""
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
                    steps = '`step="actuated"`' if name in ("act", "applied") else SOLVING
                    raise TypeError(f"`{name}` is an argument of rollouts with {steps}")
            elif given.get(name) is None:
                at = self.parameters.names.index(name)
                default = self.parameters.defaults[at]
                given[name] = asarray(np.zeros(self.parameters.shapes[at], self.robot.dtype) if default is None else default)

    def add_ground(
        self, given: dict[str, Any], ground: HeightField, asarray: Callable[[str, Any], Any], concatenate: Callable[[list[Any]], Any]
    ) -> None:
        """Adds the heights and the grid of a ground to the arguments of a rollout."""
        if not self.solves:
            raise TypeError(f"`ground` is an argument of rollouts with {SOLVING}")
        given["heights"], given["grid"] = ground_arrays("rollout", ground, asarray, concatenate)

    def add_parameters(
        self, given: dict[str, Any], parameters: Any, asarray: Callable[[Any], Any], concatenate: Callable[[list[Any]], Any]
    ) -> None:
        """Adds the run-time parameters, by default the present ones, to the arguments of a rollout."""
        if self.parameters.parameters:
            given["parameters"] = self.parameters.flat(parameters, asarray, concatenate)
        elif parameters is not None:
            raise TypeError(f"`rollout`: {NO_PARAMETERS}, or leave `parameters` out")

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

    def arrays(self, given: dict[str, Any]) -> tuple[list[Any], tuple[int, tuple[int, ...], Extras]]:
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
        one = self.shapes if missing else {**self.shapes, "gains": self.gains(given["gains"])}
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
        field, ground = self.ground(given)
        check("rollout", [*names, *GROUND[: len(ground)]], [*shapes, *((field, (4,)) if field else ())], [*arrays, *ground])
        if self.parameters.parameters:
            arrays.append(given["parameters"])
        at = tuple(names.index(name) for name in sequences)
        return [*arrays, *ground], (steps, at, Extras(None if missing else one["gains"], has_cost, field))

    def gains(self, given: Any) -> tuple[int, int]:
        """Returns the rows and columns of gains: those of a diagonal matrix are two rows."""
        nv, shape = self.robot.nv, tuple(given.shape)
        if shape[-2:] not in ((nv, 2 * nv), (2, nv)):
            diagonal = f"or {(2, nv)} of a diagonal matrix, after axes of motions and steps"
            raise ValueError(f"`gains` of `rollout` has the shape {shape}; expected {(nv, 2 * nv)}, {diagonal}")
        return (nv, 2 * nv) if shape[-2:] == (nv, 2 * nv) else (2, nv)

    def ground(self, given: dict[str, Any]) -> tuple[tuple[int, int] | None, list[Any]]:
        """Returns the rows and columns of the ground among the arguments, and its heights and grid."""
        if "heights" not in given:
            return None, []
        rows, columns = given["heights"].shape[-2:]
        return (rows, columns), [given["heights"], given["grid"]]

    def code(self, trajectory: bool, steps: int, sequences: tuple[int, ...], extras: Extras) -> Rollout:
        """Returns the rollout of this number of steps."""
        return self.one_step(extras).rollout(steps, trajectory, sequences)

    def one_step(self, extras: Extras) -> ArrayFunction:
        """Returns the function of one step, which the robot keeps."""
        kept, at = self.robot._kept, (ArrayFunction, self.step, extras)
        found: ArrayFunction | None = kept.get(at)
        if found is None:
            found = kept[at] = ArrayFunction(self.robot, self.step, extras=extras)
        return found


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
        names = [name for name, _, _ in arguments]
        self.settings = names.index("step_settings") if "step_settings" in names else None
        """the index of the settings of a step, whose planes a ground sets; `None` for functions without it"""
        self.names = ["settings" if name == "step_settings" and "settings" not in names else name for name in names]
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
        # A fused function may need an argument after those with a default; `bind` finds that it is missing.
        needed = next((k for k, default in enumerate(self.defaults) if default is not None), len(self.names))
        own = [inspect.Parameter(name, kind, default=empty if k < needed else None) for k, name in enumerate(self.names)]
        if self.parameters:
            own.append(inspect.Parameter("parameters", inspect.Parameter.KEYWORD_ONLY, default=None))
        if self.settings is not None:
            own.append(inspect.Parameter("ground", inspect.Parameter.KEYWORD_ONLY, default=None))
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
        arrays = [default if x is None else x for x, default in zip(all_given, defaults)]
        missing = next((name for name, x in zip(self.names, arrays) if x is None), None)
        if missing is not None:
            raise TypeError(f"`{self.name}`: missing a required argument: '{missing}'")
        return arrays, parameters

    def ground(self, named: dict[str, Any]) -> HeightField | None:
        """Takes the ground from the arguments by keyword, if the function can have one."""
        return None if self.settings is None else named.pop("ground", None)

    def check(self, arrays: Sequence[Any], ground: Sequence[Any] = ()) -> None:
        """Checks the shapes of arguments, whose leading axes are those of states and are broadcast."""
        of_ground = [tuple(ground[0].shape[-2:]), (4,)] if ground else []
        check(self.name, [*self.names, *GROUND[: len(ground)]], [*self.shapes, *of_ground], [*arrays, *ground])

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
        return self.by_link([asarray(own.numbers) for own in self.parameters])

    def by_link(self, arrays: Sequence[Any]) -> dict[str, Any]:
        """Returns the arrays of the run-time parameters by their options, and by their links."""
        found: dict[str, Any] = {}
        for (option, link, _), array in zip(self.parameters, arrays):
            if link is None:
                found[option] = array
            else:
                found.setdefault(option, {})[link] = array
        return found


def ground_arrays(
    function: str, ground: HeightField, asarray: Callable[[str, Any], Any], concatenate: Callable[[list[Any]], Any]
) -> list[Any]:
    """Returns the heights and the grid of a ground as arrays: the last arguments of a function on a height field."""
    if not isinstance(ground, HeightField):
        raise TypeError(f"`ground` must be a `modyn.HeightField`, not {type(ground).__name__}")
    for name in ("heights", "origin", "spacing"):
        if getattr(ground, name) is None:
            raise TypeError(f"`{name}` of `HeightField` is `None`; expected an array")
    heights = asarray("ground.heights", ground.heights)
    if heights.ndim < 2:
        raise ValueError(f"`heights` of `HeightField` has the shape {tuple(heights.shape)}; expected (rows, columns)")
    pairs = [asarray(f"ground.{name}", getattr(ground, name)) for name in ("origin", "spacing")]
    check(function, ["ground.origin", "ground.spacing"], [(2,), (2,)], pairs)
    return [heights, concatenate(pairs)]


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
    if signature.name in functions():
        docs = inspect.getdoc(getattr(Robot, signature.name))
    else:
        docs = f"Returns the results of `{'`, `'.join(signature.result._fields)}`, with their common work done once."
    call.__name__ = call.__qualname__ = signature.name
    call.__signature__ = signature.signature  # type: ignore[attr-defined]
    call.__doc__ = f"{docs}\n\nArguments and results are arrays of {library}; leading axes are those of states."
    return call
