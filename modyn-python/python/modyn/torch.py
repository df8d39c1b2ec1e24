"""Functions of a robot as functions of PyTorch, on the CPU and on CUDA.

    import torch, modyn, modyn.torch

    robot = modyn.load("panda.urdf")
    forward_dynamics = modyn.torch.function(robot, "forward_dynamics")
    qdd = forward_dynamics(q, qd, tau)
    (qdd**2).sum().backward()

Gradients of any order, forward mode, `torch.func` and `torch.compile` work. Derivatives are machine code, which modyn compiles at their
first use; on CUDA they are kernels, which start on the current stream and copy nothing. A function scales quaternions to length 1, and
derivatives with respect to `q` are those of this function by the entries of `q`. `to_tangent` turns a gradient into one by displacements.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from typing import Any

try:
    import torch
except ImportError as error:
    raise ImportError("`modyn.torch` needs PyTorch: pip install modyn[torch]") from error
import numpy as np

from . import _cuda
from ._arrays import (
    NO_HEIGHTS,
    NO_PARAMETERS,
    ArrayFunction,
    Rollout,
    RolloutGradient,
    RolloutSignature,
    Signature,
    documented,
    ground_arrays,
    motions,
)
from ._modyn import Robot
from ._results import ActuatedStep, StepSolution
from ._types import HeightField, QuadraticCost, RolloutCosts, RolloutStates, StepSettings

__all__ = ["function", "parameters", "rollout", "to_tangent"]


def function(robot: Robot, name: str, link: str | int | None = None) -> Callable[..., Any]:
    """Returns the function or fused function `name` of a robot as a function of PyTorch's tensors.

    Its arguments and results are those of the method of `Robot`; the link of a function of one link is given here. Leading axes
    are those of states, and are broadcast. Functions that depend on run-time parameters (the options `runtime_gravity`,
    `runtime_inertia` and `payload`) have the keyword argument `parameters`, which can be differentiated: what the function
    `parameters` of this module returns, by default with the numbers that the robot has now. Functions with the settings of a step have
    the keyword argument `ground`, a `HeightField` that sets the planes of the surfaces.
    """
    signature = Signature(robot, name, link)
    code = ArrayFunction(robot, name, link)
    number = _numbered(code)
    dtype = _dtype(robot)
    constants = _Constants(signature)

    @torch.compiler.assume_constant_result
    def numbered_on(field: tuple[int, int]) -> int:
        return _numbered(code.on_field(field))

    def call(*given: Any, **named: Any) -> Any:
        ground = signature.ground(named)
        device = _device((*given, *named.values(), getattr(ground, "heights", None)))
        own, of_robot = signature.bind(given, named, constants.defaults(device))
        tensors = [_tensor(x, dtype, argument, name, device) for argument, x in zip(signature.names, own)]
        of_ground = []
        if ground is not None:
            of_ground = ground_arrays(name, ground, lambda argument, x: _tensor(x, dtype, argument, name, device), _concatenate)
        signature.check(tensors, of_ground)
        if _is_cuda(device):
            _check_rows(signature, tensors)
        if signature.parameters:
            flat = lambda: signature.flat(of_robot, lambda x: _tensor(x, dtype, "parameters", name, device), _concatenate)
            tensors.append(constants.present(device) if of_robot is None else flat())
        called = numbered_on(tuple(of_ground[0].shape[-2:])) if of_ground else number
        return _rebuilt(signature.result, _called(called, [*tensors, *of_ground]))

    return documented(call, signature, "PyTorch")


def rollout(
    robot: Robot, step: str = "semi_implicit", trajectory: bool = True
) -> Callable[..., RolloutStates | RolloutCosts | StepSolution | ActuatedStep]:
    """Returns the function `Robot.rollout` of a robot as a function of PyTorch's tensors.

    It is one call from the first step to the last, and so is its gradient, which stores few states. (On CUDA each step is a kernel, and
    the gradient stores all states.) Its arguments are `q`, `qd`,
    `controls`, `dt`, and by keyword `gains`, `q_ref`, `qd_ref`, `cost` and `parameters`. It has first derivatives in reverse mode.
    With `step="step"`, `settings`, `warm_start` and `ground`, a `HeightField`, are arguments. With `step="actuated"` the controls
    are those of the actuators, `act` and `applied` are further arguments, and there is no feedback.
    """
    signature = RolloutSignature(robot, step)
    dtype = _dtype(robot)

    kept: dict[Any, torch.Tensor] = {}

    @torch.compiler.assume_constant_result
    def numbered(own: Any) -> int:
        return _numbered(signature.code(trajectory, *own))

    def constant(x: np.ndarray[Any, Any], device: torch.device) -> torch.Tensor:
        """Returns an array on the device of a call; copied to CUDA once."""
        if not _is_cuda(device):
            return _tensor(x, dtype, "settings", "rollout")
        at = (device, x.tobytes())
        if at not in kept:
            kept[at] = torch.from_numpy(x).to(device)
        return kept[at]

    def on_device(name: str, x: Any, device: torch.device) -> torch.Tensor:
        """Returns a tensor, or an array that is copied to CUDA once."""
        if isinstance(x, torch.Tensor) or not _is_cuda(device):
            return _tensor(x, dtype, name, "rollout", device)
        return constant(_tensor(x, dtype, name, "rollout").numpy(), device)

    def call(
        q: Any,
        qd: Any,
        controls: Any,
        dt: Any,
        *,
        gains: Any = None,
        q_ref: Any = None,
        qd_ref: Any = None,
        cost: QuadraticCost | None = None,
        settings: Any = None,
        warm_start: Any = None,
        act: Any = None,
        applied: Any = None,
        ground: HeightField | None = None,
        parameters: Any = None,
    ) -> Any:
        """Returns the states after each step, (..., steps, n), or after the last one."""
        arguments = {"q": q, "qd": qd, "controls": controls, "dt": dt, "gains": gains, "q_ref": q_ref, "qd_ref": qd_ref}
        device = _device((*arguments.values(), settings, warm_start, act, applied))
        if isinstance(settings, StepSettings):
            settings = constant(np.asarray(settings, robot.dtype), device)
        arguments |= {"settings": settings, "warm_start": warm_start, "act": act, "applied": applied}
        given = {name: None if x is None else _tensor(x, dtype, name, "rollout", device) for name, x in arguments.items()}
        signature.start(given, lambda x: constant(x, device))
        if cost is not None:
            with device if _is_cuda(device) else contextlib.nullcontext():
                signature.add_cost(given, cost, lambda name, x: _tensor(x, dtype, name, "rollout", device), torch)
        if ground is not None:
            signature.add_ground(given, ground, lambda name, x: on_device(name, x, device), _concatenate)
        signature.add_parameters(given, parameters, lambda x: on_device("parameters", x, device), _concatenate)
        tensors, own = signature.arrays(given)
        return motions(_called(numbered(own), tensors))

    return call


def parameters(robot: Robot) -> dict[str, Any]:
    """Returns the present run-time parameters of a robot, for the argument `parameters` of its functions.

    `gravity`: (3,), m/s^2. `inertia` and `payload`: for each link (10,), the mass (kg), the centre of mass (m) and ixx, ixy, ixz,
    iyy, iyz, izz about the centre of mass (kg m^2), in the link's frame.
    """
    signature = Signature(robot, "inverse_dynamics", None)
    if not signature.parameters:
        raise ValueError(NO_PARAMETERS)
    return signature.described(torch.from_numpy)


def to_tangent(robot: Robot, q: Any, gradient: Any) -> Any:
    """Returns the gradient with respect to displacements at `q`, (..., nv), from that with respect to the entries of `q`, (..., nq).

    Displacements are those of `Robot.integrate`; the quaternions of `q` have length 1.
    """
    rates = ArrayFunction(robot, "velocity_to_qdot").derivative("reverse", [1])
    device = _device((q, gradient))
    q, gradient = (_tensor(x, _dtype(robot), name, "to_tangent", device) for x, name in ((q, "q"), (gradient, "gradient")))
    zero = q.new_zeros((*q.shape[:-1], robot.nv))
    return _called(_numbered(rates), [q, zero, gradient])[0]


def _dtype(robot: Robot) -> torch.dtype:
    return torch.float64 if robot.dtype == np.float64 else torch.float32


class _Constants:
    """The tensors that a function adds to its arguments, on each device."""

    def __init__(self, signature: Signature) -> None:
        numbers = [own.numbers for own in signature.parameters]
        arrays = [*signature.defaults, np.concatenate(numbers) if numbers else None]
        self.on: dict[torch.device, list[Any]] = {_CPU: [None if x is None else torch.from_numpy(x) for x in arrays]}

    def all(self, device: torch.device) -> list[Any]:
        if device not in self.on:
            self.on[device] = [None if x is None else x.to(device) for x in self.on[_CPU]]
        return self.on[device]

    def defaults(self, device: torch.device) -> list[Any]:
        """Returns the defaults of the arguments."""
        return self.all(device)[:-1]

    def present(self, device: torch.device) -> Any:
        """Returns the run-time parameters that the robot had."""
        return self.all(device)[-1]


_CPU = torch.device("cpu")


def _is_cuda(device: torch.device) -> bool:
    """Returns whether kernels compute on a device. Tests replace it."""
    return device.type == "cuda"


def _stream(device: torch.device) -> int:
    """Returns the address of the current stream of a device. Tests replace it."""
    return int(torch.cuda.current_stream(device).cuda_stream)


def _device(given: Sequence[Any]) -> torch.device:
    """Returns the device of a call: the device of its first tensor on CUDA, else the CPU."""
    return next((x.device for x in given if isinstance(x, torch.Tensor) and _is_cuda(x.device)), _CPU)


def _tensor(given: Any, dtype: torch.dtype, argument: str, name: str, device: torch.device = _CPU) -> torch.Tensor:
    """Returns an argument as a tensor of the robot's scalar on the device of a call."""
    if isinstance(given, int | float):
        return torch.full((), given, dtype=dtype, device=device)
    try:
        # PyTorch makes single precision of lists of numbers.
        tensor = given if isinstance(given, torch.Tensor) else torch.as_tensor(np.asarray(given))
    except (TypeError, ValueError, RuntimeError) as error:
        raise TypeError(f"`{argument}` of `{name}` must be a tensor of real numbers: {error}") from None
    if tensor.device != device:
        of_others = f"other arguments are on {device}" if _is_cuda(device) else "`modyn.torch` computes on the CPU and on CUDA"
        raise ValueError(f"`{argument}` of `{name}` is on the device {tensor.device}; {of_others}")
    if tensor.dtype == dtype:
        return tensor
    if _is_cuda(device):
        raise TypeError(f"`{argument}` of `{name}` has numbers of {tensor.dtype}, and calls on CUDA copy nothing: pass `.to({dtype})` of it")
    if tensor.is_complex() or tensor.dtype == torch.bool:
        raise TypeError(f"`{argument}` of `{name}` must be a tensor of real numbers, not of {tensor.dtype}")
    return tensor.to(dtype)


def _check_rows(signature: Signature, tensors: Sequence[torch.Tensor]) -> None:
    """Checks that a call on CUDA copies no argument."""
    for name, own, tensor in zip(signature.names, signature.shapes, tensors):
        if _cuda.stride(tensor, own) is None:
            raise ValueError(
                f"the numbers of a state in `{name}` of `{signature.name}` are not contiguous, or the states have no common stride, and "
                "calls on CUDA copy nothing: pass `.contiguous()` of it"
            )


def _concatenate(tensors: list[torch.Tensor]) -> torch.Tensor:
    lead = torch.broadcast_shapes(*(tensor.shape[:-1] for tensor in tensors))
    return torch.cat([tensor.expand(*lead, tensor.shape[-1]) for tensor in tensors], -1)


def _rebuilt(result: Any, tensors: Sequence[torch.Tensor]) -> Any:
    """Returns a result with its tensors in place of their indices."""
    if isinstance(result, int):
        return tensors[result]
    return type(result)(*(_rebuilt(field, tensors) for field in result))


# The functions, which operators and graphs name by their indices; equal functions have one index.
_codes: list[Any] = []
_numbers: dict[Any, int] = {}


def _numbered(code: Any) -> int:
    number = _numbers.get(code)
    if number is None:
        number = _numbers[code] = len(_codes)
        _codes.append(code)
    return number


def _called(number: int, tensors: Sequence[torch.Tensor]) -> Sequence[torch.Tensor]:
    if torch.compiler.is_compiling():
        return torch.ops.modyn.call(number, False, list(tensors))
    # PyTorch takes longer for a call that it can differentiate than a kernel for its start.
    if not (torch.is_grad_enabled() and any(tensor.requires_grad for tensor in tensors) or _is_transformed()):
        return _computed(_codes[number], tensors)
    return _Call.apply(_codes[number], *tensors)


def _is_transformed() -> bool:
    """Returns whether a transformation of `torch.func` or forward mode is active."""
    return torch._C._are_functorch_transforms_active() or torch.autograd.forward_ad._current_level >= 0


def _computed(code: Any, tensors: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    device = tensors[0].device
    if _is_cuda(device):
        if isinstance(code, Rollout):
            return _rolled_out(code, _by_step(code, tensors), tensors)
        if isinstance(code, RolloutGradient):
            return _rollout_gradient(code, tensors)
        if isinstance(code, ArrayFunction) and code.extras.field is not None:
            return code.on_planes(tensors, _computed, torch)
        return _cuda.call(code, device.index or 0, _stream(device), list(tensors), tensors[0].new_empty)
    arrays = [tensor.detach().contiguous().numpy() for tensor in tensors]
    return [torch.from_numpy(array) for array in code.handle.call(arrays)]


def _lead(tensors: Sequence[torch.Tensor], shapes: Any) -> torch.Size:
    """Returns the axes of states that tensors have in common."""
    return torch.broadcast_shapes(*(tensor.shape[: tensor.dim() - len(own)] for tensor, own in zip(tensors, shapes)))


# Rollouts on CUDA: a kernel for each step.


def _by_step(code: Rollout, tensors: Sequence[torch.Tensor]) -> list[tuple[list[torch.Tensor], list[torch.Tensor]]]:
    """Returns the arguments and the results of each step."""
    given, steps = list(tensors), []
    sequences = {k: tensors[k].movedim(tensors[k].dim() - len(code.inputs[k]), 0) for k in code.sequences}
    for i in range(code.steps):
        for k, sequence in sequences.items():
            given[k] = sequence[i]
        results = _computed(code.step, given)
        steps.append((list(given), results))
        for k, result in zip(code.state, results):
            given[k] = result
    return steps


def _rolled_out(code: Rollout, steps: Any, tensors: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    """Returns the results of a rollout: of all steps, or of the last one."""
    lead = _lead(tensors, code.inputs)
    if not steps:
        empty = [tensors[0].new_zeros((*lead, *shape)) for shape in code.outputs]
        first = [] if code.trajectory else [tensors[k].expand_as(x).contiguous() for k, x in zip(code.state, empty)]
        return [*first, *empty[len(first) :]]
    # A step whose arguments have fewer axes of states than others has fewer results.
    whole = [[x.expand(*lead, *own) for x, own in zip(results, code.step.outputs)] for _, results in steps]
    if code.trajectory:
        return [torch.stack(of_steps, len(lead)) for of_steps in zip(*whole)]
    # The largest residual and number of iterations of all steps.
    states, most = len(code.state), lambda of_steps: torch.stack(of_steps).amax(0)
    of_result = list(zip(*whole))
    others = [most(x) if own == () else x[-1] for x, own in zip(of_result[states:], code.outputs[states:])]
    return [x.contiguous() for x in (*(x[-1] for x in of_result[:states]), *others)]


def _rollout_gradient(code: RolloutGradient, tensors: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    """Returns the gradients of the weighted results of a rollout."""
    rollout, count = code.rollout, len(code.rollout.inputs)
    given, weights, lead = tensors[:count], tensors[count:], _lead(tensors, code.inputs)
    state = [k for k in rollout.state if k != rollout.step.start]
    step = rollout.step.derivative("reverse", sorted({*state, *code.variables}))
    results = rollout.step.outputs
    # The gradients with respect to the state after a step, and of each step with respect to other arguments.
    by_state = {k: weights[rollout.state.index(k)] for k in state} if not rollout.trajectory else {}
    by_step: dict[int, list[torch.Tensor]] = {k: [] for k in code.variables if k not in state}
    for i, (arguments, found) in reversed(list(enumerate(_by_step(rollout, given)))):
        own: list[torch.Tensor] = []
        for r, shape in enumerate(results):
            k = rollout.state[r] if r < len(rollout.state) else None
            weight = tensors[0].new_zeros(shape)
            if rollout.trajectory:
                weight = weights[r].select(weights[r].dim() - len(shape) - 1, i)
            elif i == rollout.steps - 1 and k not in by_state and shape != ():
                weight = weights[r]
            own.append(weight + by_state[k] if k in by_state else weight)
        gradients = _computed(step, [*rollout.step.at_solution(arguments, found), *own])
        by = dict(zip(step.variables, gradients))
        by_state = {k: by[k] for k in state}
        for k, of_steps in by_step.items():
            of_steps.append(by[k])
    gradients = []
    for k, shape in zip(code.variables, code.outputs):
        zero = tensors[0].new_zeros((*lead, *shape))
        of_steps = by_step.get(k, [])[::-1]
        if k in by_state:
            zero = zero + by_state[k]
        elif of_steps and k in rollout.sequences:
            zero = torch.stack([x.expand(*lead, *shape[1:]) for x in of_steps], len(lead))
        elif of_steps:
            zero = zero + sum(of_steps)
        gradients.append(zero)
    return gradients


def _sum_to(gradient: torch.Tensor, tensor: torch.Tensor) -> torch.Tensor:
    return gradient if gradient.shape == tensor.shape else gradient.sum_to_size(tensor.shape)


def _moved(dims: Sequence[int | None], tensors: Sequence[torch.Tensor], shapes: Any) -> list[torch.Tensor]:
    """Returns tensors whose axis of `vmap` is the first of those that all of them have."""
    ranks = [tensor.dim() - (dim is not None) - len(own) for tensor, dim, own in zip(tensors, dims, shapes)]
    most = max(ranks)
    moved = []
    for tensor, dim, rank in zip(tensors, dims, ranks):
        if dim is not None:
            tensor = tensor.movedim(dim, 0)
            tensor = tensor.reshape((tensor.shape[0], *(1,) * (most - rank), *tensor.shape[1:]))
        moved.append(tensor)
    return moved


class _Call(torch.autograd.Function):
    """A call of a function of arrays, whose derivatives are calls of its derivatives."""

    @staticmethod
    def forward(code: Any, *tensors: torch.Tensor) -> Any:
        return tuple(_computed(code, tensors))

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.code, *tensors = inputs
        tensors = ctx.code.at_solution(tensors, output)
        ctx.save_for_backward(*tensors)
        ctx.save_for_forward(*tensors)
        # `jvp` gets no changes of arguments that do not change, such as the heights of a ground.
        ctx.set_materialize_grads(False)

    @staticmethod
    def backward(ctx: Any, *weights: torch.Tensor) -> Any:
        tensors = ctx.saved_tensors
        weights = tuple(tensors[0].new_zeros(own) if x is None else x for x, own in zip(weights, ctx.code.outputs))
        variables = [k for k in range(len(tensors)) if ctx.needs_input_grad[k + 1] and k != ctx.code.constant]
        found = _Call.apply(ctx.code.derivative("reverse", variables), *tensors, *weights)
        gradients: list[Any] = [None] * len(tensors)
        for k, gradient in zip(variables, found):
            gradients[k] = _sum_to(gradient, tensors[k])
        return None, *gradients

    @staticmethod
    def jvp(ctx: Any, _: Any, *changes: Any) -> Any:
        tensors = ctx.saved_tensors
        variables = [k for k, change in enumerate(changes) if change is not None and k != ctx.code.constant]
        if not variables:
            lead = _lead(tensors, ctx.code.inputs)
            return tuple(tensors[0].new_zeros((*lead, *own)) for own in ctx.code.outputs)
        changes = [changes[k] for k in variables]  # type: ignore[assignment]
        return _Call.apply(ctx.code.derivative("forward", variables), *tensors, *changes)

    @staticmethod
    def vmap(info: Any, dims: Any, code: Any, *tensors: torch.Tensor) -> Any:
        return _Call.apply(code, *_moved(dims[1:], tensors, code.inputs)), (0,) * len(code.outputs)


# The operator that `torch.compile` keeps in its graphs: a function, or the gradients with respect to all of its arguments.


def _resolved(number: int, reverse: bool) -> Any:
    code = _codes[number]
    return code.derivative("reverse", code.variable) if reverse else code


@torch.library.custom_op("modyn::call", mutates_args=(), device_types=("cpu", "cuda"))
def _operator(function: int, reverse: bool, tensors: list[torch.Tensor]) -> list[torch.Tensor]:
    code = _codes[function]
    if reverse and code.start is not None:
        count = len(code.inputs)
        tensors = [*code.at_solution(tensors[:count], _computed(code, tensors[:count])), *tensors[count:]]
    return _computed(_resolved(function, reverse), tensors)


@_operator.register_fake
def _fake(function: int, reverse: bool, tensors: list[torch.Tensor]) -> list[torch.Tensor]:
    code = _resolved(function, reverse)
    leads = [tensor.shape[: tensor.dim() - len(own)] for tensor, own in zip(tensors, code.inputs)]
    lead = torch.broadcast_shapes(*leads)
    return [tensors[0].new_empty((*lead, *own)) for own in code.outputs]


def _saved(ctx: Any, inputs: Any, output: Any) -> None:
    ctx.function, ctx.reverse, tensors = inputs
    ctx.save_for_backward(*tensors)


def _backward(ctx: Any, weights: list[torch.Tensor]) -> Any:
    if ctx.reverse:
        raise NotImplementedError("compiled functions have first derivatives; second ones need `modyn.torch` without `torch.compile`")
    tensors, variables = ctx.saved_tensors, _codes[ctx.function].variable
    if any(needed and k not in variables for k, needed in enumerate(ctx.needs_input_grad[2])):
        raise NotImplementedError(NO_HEIGHTS)
    found = torch.ops.modyn.call(ctx.function, True, [*tensors, *weights])
    gradients = dict(zip(variables, found))
    return None, None, [_sum_to(gradients[k], x) if k in gradients else None for k, x in enumerate(tensors)]


_operator.register_autograd(_backward, setup_context=_saved)


@_operator.register_vmap
def _vmapped(info: Any, dims: Any, function: int, reverse: bool, tensors: list[torch.Tensor]) -> Any:
    code = _resolved(function, reverse)
    moved = _moved(dims[2], tensors, code.inputs)
    return torch.ops.modyn.call(function, reverse, moved), [0] * len(code.outputs)
