"""Functions of a robot as functions of JAX, on the CPU and on CUDA.

    import jax, modyn, modyn.jax

    jax.config.update("jax_enable_x64", True)
    robot = modyn.load("panda.urdf")
    forward_dynamics = modyn.jax.function(robot, "forward_dynamics")
    qdd = forward_dynamics(q, qd, tau)
    gradient = jax.grad(lambda tau: (forward_dynamics(q, qd, tau) ** 2).sum())(tau)

All transformations of JAX apply: `jit`, `vmap`, `grad`, `jvp`, `vjp`, `jacfwd`, `jacrev`, `hessian`, `lax.scan`, `checkpoint`, to any
order. XLA calls machine code, whose derivatives modyn compiles at their first use; on CUDA, kernels on its own stream.

A function scales quaternions to length 1, and derivatives with respect to `q` are those of this function by the entries of `q`, as
JAX defines them. `to_tangent` turns a gradient into one by displacements.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

try:
    import jax
except ImportError as error:
    raise ImportError("`modyn.jax` needs JAX: pip install modyn[jax]") from error
if jax.__version_info__ < (0, 7):
    raise ImportError(f"`modyn.jax` needs JAX 0.7 or later; this is JAX {jax.__version__}: pip install --upgrade modyn[jax]")
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from . import _cuda, _modyn
from ._arrays import NO_PARAMETERS, ArrayFunction, Rollout, RolloutGradient, RolloutSignature, Signature, documented, ground_arrays, motions
from ._modyn import Robot
from ._results import ActuatedStep, StepSolution
from ._types import ConstraintSettings, HeightField, QuadraticCost, RolloutCosts, RolloutStates, StepSettings, of_fields

__all__ = ["function", "parameters", "rollout", "to_tangent"]


def function(robot: Robot, name: str, link: str | int | None = None) -> Callable[..., Any]:
    """Returns the function or fused function `name` of a robot as a function of JAX's arrays.

    Its arguments and results are those of the method of `Robot`; the link of a function of one link is given here. Leading axes
    are those of states, and are broadcast. Functions that depend on run-time parameters (the options `runtime_gravity`,
    `runtime_inertia` and `payload`) have the keyword argument `parameters`, which can be differentiated: what the function
    `parameters` of this module returns, by default with the numbers that the robot has now. Functions with the settings of a step have
    the keyword argument `ground`, a `HeightField` that sets the planes of the surfaces.
    """
    signature = Signature(robot, name, link)
    code = ArrayFunction(robot, name, link)
    structure = jax.tree.structure(signature.result)
    dtype = np.dtype(robot.dtype)

    def call(*given: Any, **named: Any) -> Any:
        ground = signature.ground(named)
        arrays, own = signature.bind(given, named, signature.defaults)
        arrays = [_array(array, dtype, argument, name) for argument, array in zip(signature.names, arrays)]
        of_ground = []
        if ground is not None:
            of_ground = ground_arrays(name, ground, lambda argument, x: _array(x, dtype, argument, name), _concatenate)
        signature.check(arrays, of_ground)
        if signature.parameters:
            arrays.append(signature.flat(own, lambda x: _array(x, dtype, "parameters", name), _concatenate))
        called = code.on_field(of_ground[0].shape[-2:]) if of_ground else code
        return jax.tree.unflatten(structure, _call.bind(*arrays, *of_ground, code=called))

    return documented(call, signature, "JAX")


def rollout(
    robot: Robot, step: str = "semi_implicit", trajectory: bool = True
) -> Callable[..., RolloutStates | RolloutCosts | StepSolution | ActuatedStep]:
    """Returns the function `Robot.rollout` of a robot as a function of JAX's arrays.

    It is one call from the first step to the last, and so is its gradient, which stores few states. Other derivatives go through
    `lax.scan`. Its arguments are `q`, `qd`, `controls`, `dt`, and by keyword `gains`, `q_ref`, `qd_ref`, `cost` and `parameters`.
    With `step="step"`, `settings`, `warm_start` and `ground`, a `HeightField`, are arguments, and there are only first derivatives. With
    `step="actuated"` the controls are those of the actuators, `act` and `applied` are further arguments, and there is no feedback.
    """
    signature = RolloutSignature(robot, step)
    dtype = np.dtype(robot.dtype)

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
        arguments |= {"settings": settings, "warm_start": warm_start, "act": act, "applied": applied}
        given = {name: None if x is None else _array(x, dtype, name, "rollout") for name, x in arguments.items()}
        signature.start(given, jnp.asarray)
        if cost is not None:
            signature.add_cost(given, cost, lambda name, x: _array(x, dtype, name, "rollout"), jnp)
        if ground is not None:
            signature.add_ground(given, ground, lambda name, x: _array(x, dtype, name, "rollout"), _concatenate)
        signature.add_parameters(given, parameters, lambda x: _array(x, dtype, "parameters", "rollout"), _concatenate)
        arrays, own = signature.arrays(given)
        return motions(_rollout.bind(*arrays, code=signature.code(trajectory, *own)))

    return call


def parameters(robot: Robot) -> dict[str, Any]:
    """Returns the present run-time parameters of a robot, for the argument `parameters` of its functions.

    `gravity`: (3,), m/s^2. `inertia` and `payload`: for each link (10,), the mass (kg), the centre of mass (m) and ixx, ixy, ixz,
    iyy, iyz, izz about the centre of mass (kg m^2), in the link's frame.
    """
    signature = Signature(robot, "inverse_dynamics", None)
    if not signature.parameters:
        raise ValueError(NO_PARAMETERS)
    return signature.described(lambda x: _array(x, np.dtype(robot.dtype), "parameters", "parameters"))


def to_tangent(robot: Robot, q: Any, gradient: Any) -> Any:
    """Returns the gradient with respect to displacements at `q`, (..., nv), from that with respect to the entries of `q`, (..., nq).

    Displacements are those of `Robot.integrate`; the quaternions of `q` have length 1.
    """
    rates = function(robot, "velocity_to_qdot")
    q = _array(q, np.dtype(robot.dtype), "q", "to_tangent")
    zero = jnp.zeros((*q.shape[:-1], robot.nv), q.dtype)
    return jax.vjp(lambda v: rates(q, v), zero)[1](_array(gradient, q.dtype, "gradient", "to_tangent"))[0]


def _array(given: Any, dtype: np.dtype[Any], argument: str, name: str) -> Any:
    """Returns an argument as an array of the robot's scalar."""
    if dtype == np.float64 and not jax.config.jax_enable_x64:  # type: ignore[attr-defined]
        raise TypeError(
            f"`{name}` computes in float64, which JAX has only after `jax.config.update(\"jax_enable_x64\", True)`; or load "
            'the robot with `scalar="f32"`'
        )
    try:
        array = _of_settings(given, dtype) if isinstance(given, ConstraintSettings | StepSettings) else jnp.asarray(given)
    except (TypeError, ValueError) as error:
        raise TypeError(f"`{argument}` of `{name}` must be an array of real numbers: {error}") from None
    if array.dtype == dtype:
        return array
    if not jnp.issubdtype(array.dtype, jnp.number) or jnp.issubdtype(array.dtype, jnp.complexfloating):
        raise TypeError(f"`{argument}` of `{name}` must be an array of real numbers, not of {array.dtype}")
    return array.astype(dtype)


def _of_settings(settings: ConstraintSettings | StepSettings, dtype: np.dtype[Any]) -> Any:
    """Returns settings as an array. Their fields can be arrays of a program that is being compiled or differentiated."""
    try:
        return jnp.asarray(np.asarray(settings, dtype))
    except jax.errors.TracerArrayConversionError:
        return of_fields(settings._named(dtype), dtype, jnp)


def _concatenate(arrays: list[Any]) -> Any:
    lead = jnp.broadcast_shapes(*(array.shape[:-1] for array in arrays))
    return jnp.concatenate([jnp.broadcast_to(array, (*lead, array.shape[-1])) for array in arrays], -1)


# JAX refuses a type twice, as when this module is loaded again.
if jax.tree_util.all_leaves([HeightField(())]):
    jax.tree_util.register_dataclass(HeightField, ["heights", "origin", "spacing"], [])

# XLA's handler. The attribute `function` is the key of the code.
_HANDLER = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(_modyn.xla_handler())
jax.ffi.register_ffi_target("modyn", jax.ffi.pycapsule(_HANDLER), platform="cpu")
_CUDA_HANDLER = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(_modyn.xla_cuda_handler())
jax.ffi.register_ffi_target("modyn_cuda", jax.ffi.pycapsule(_CUDA_HANDLER), platform="CUDA")
if hasattr(jax.ffi, "register_ffi_target_as_batch_partitionable"):
    jax.ffi.register_ffi_target_as_batch_partitionable("modyn")
    jax.ffi.register_ffi_target_as_batch_partitionable("modyn_cuda")

# The code that programs call, by its keys. XLA runs programs later than Python calls them, and says of none that it has ended.
_kept: dict[int, Any] = {}

# A call of an `ArrayFunction`, the parameter `code`. Derivatives of a call are calls of its derivatives: a change is one of mode
# `forward`, which is linear in the changes of its variables, and whose transpose is one of mode `reverse`.
_call = Primitive("modyn")
_call.multiple_results = True


def _lead(arrays: Any, shapes: Any) -> tuple[int, ...]:
    """Returns the axes of states that arrays have in common."""
    return jnp.broadcast_shapes(*(array.shape[: len(array.shape) - len(own)] for array, own in zip(arrays, shapes)))


def _abstract(*arrays: Any, code: Any) -> list[Any]:
    lead = _lead(arrays, code.inputs)
    return [jax.core.ShapedArray(lead + own, arrays[0].dtype) for own in code.outputs]


def _eager(primitive: Primitive) -> Callable[..., Any]:
    """Returns the primitive on numbers: compiled once for each code."""
    compiled: dict[Any, Any] = {}

    def call(*arrays: Any, code: Any, **more: Any) -> Any:
        at = (code, *more.values())
        if at not in compiled:
            compiled[at] = jax.jit(lambda *arrays: primitive.bind(*arrays, code=code, **more))
        return compiled[at](*arrays)

    return call


def _lowered(context: Any, *operands: Any, code: Any) -> Any:
    _kept[code.key] = code.handle
    return jax.ffi.ffi_lowering("modyn")(context, *operands, function=np.int64(code.key))


def _devices() -> list[int]:
    """Returns the devices of CUDA, by their indices. Tests replace it."""
    return [device.local_hardware_id for device in jax.local_devices(backend="cuda")]


def _on_cuda(*arrays: Any, code: Any) -> list[Any]:
    """Returns a call as a kernel that XLA starts on its stream."""
    if isinstance(code, ArrayFunction) and code.extras.field is not None:
        return code.on_planes(arrays, lambda code, arrays: _call.bind(*arrays, code=code), jnp)
    _kept[code.key] = code.handle
    devices = _devices()
    architectures = sorted({_cuda.driver().device(device)[0] for device in devices})
    if len(architectures) > 1:
        raise RuntimeError(f"`{code.name}`: XLA's devices have several architectures, {', '.join(architectures)}: show it one of them")
    lead, repeated = _cuda.kernel(code, devices[0]).states([array.shape for array in arrays])
    whole = lambda k, array: jnp.broadcast_to(array, (*lead, *code.inputs[k])) if k in repeated else array
    results = [jax.ShapeDtypeStruct((*lead, *shape), arrays[0].dtype) for shape in code.outputs]
    given = [whole(k, array) for k, array in enumerate(arrays)]
    return list(jax.ffi.ffi_call("modyn_cuda", results)(*given, function=np.int64(code.key)))


def _jvp(primals: Any, tangents: Any, *, code: ArrayFunction) -> Any:
    values = _call.bind(*primals, code=code)
    variables = [i for i, tangent in enumerate(tangents) if type(tangent) is not ad.Zero and i != code.constant]
    if not variables:
        return values, [ad.Zero.from_primal_value(value) for value in values]
    changes = [tangents[i] for i in variables]
    own = code.at_solution(primals, values)
    return values, _call.bind(*own, *changes, code=code.derivative("forward", variables))


def _transpose(cotangents: Any, *arrays: Any, code: ArrayFunction) -> Any:
    base = code.base
    if base is None:
        raise TypeError(f"`{code.name}` is no linear function: use `jax.vjp` in place of `jax.linear_transpose`")
    own, linear = arrays[: len(base.inputs)], arrays[len(base.inputs) :]
    unknown = [k for k, array in enumerate(linear) if ad.is_undefined_primal(array)]
    given = [ad.instantiate_zeros(cotangent) for cotangent in cotangents]
    if code.mode == "forward":
        found = _call.bind(*own, *given, code=base.derivative("reverse", [code.variables[k] for k in unknown]))
        by_linear = dict(zip(unknown, found))
    else:
        found = _call.bind(*own, *given, code=base.derivative("forward", code.variables))
        by_linear = {k: found[k] for k in unknown}
    sums = [_sum_to(by_linear[k], array.aval) if k in by_linear else None for k, array in enumerate(linear)]
    return [None] * len(own) + sums


def _sum_to(cotangent: Any, aval: Any) -> Any:
    """Sums a cotangent over the axes along which its array was repeated."""
    extra = cotangent.ndim - len(aval.shape)
    cotangent = cotangent.sum(tuple(range(extra))) if extra else cotangent
    axes = tuple(i for i, (a, b) in enumerate(zip(cotangent.shape, aval.shape)) if a != b)
    return cotangent.sum(axes, keepdims=True) if axes else cotangent


def _moved(arrays: Any, dims: Any, shapes: Any) -> list[Any]:
    """Returns arrays whose axis of `vmap` is the first of those that all of them have."""
    # A number of a program is no array.
    arrays = [jnp.asarray(array) for array in arrays]
    ranks = [array.ndim - (dim is not None) - len(own) for array, dim, own in zip(arrays, dims, shapes)]
    most = max(ranks)
    moved = []
    for array, dim, rank in zip(arrays, dims, ranks):
        if dim is not None:
            array = jnp.moveaxis(array, dim, 0)
            array = array.reshape((array.shape[0], *(1,) * (most - rank), *array.shape[1:]))
        moved.append(array)
    return moved


def _batched(arrays: Any, dims: Any, *, code: ArrayFunction) -> Any:
    moved = _moved(arrays, dims, code.inputs)
    count = next(array.shape[0] for array, dim in zip(moved, dims) if dim is not None)
    base = code.base
    if base is not None and all(dim is None for dim in dims[: len(base.inputs)]):
        # One point and many changes or weights, as in `jacfwd` and `jacrev`: products with the matrices of derivatives.
        sizes = [sum(map(_size, shapes)) for shapes in (base.outputs, [base.inputs[i] for i in code.variables])]
        if count * 4 >= min(sizes):
            return _products(moved, base, code), [0] * len(code.outputs)
    return _call.bind(*moved, code=code), [0] * len(code.outputs)


def _products(arrays: list[Any], base: ArrayFunction, code: ArrayFunction) -> list[Any]:
    """Returns a `forward` or `reverse` derivative by the matrices of derivatives."""
    own, linear = arrays[: len(base.inputs)], arrays[len(base.inputs) :]
    matrices = _call.bind(*own, code=base.derivative("matrix", code.variables))
    inputs = [base.inputs[i] for i in code.variables]
    from_shapes, to_shapes = (inputs, base.outputs) if code.mode == "forward" else (base.outputs, inputs)
    flat = [x.reshape((*x.shape[: x.ndim - len(shape)], _size(shape))) for x, shape in zip(linear, from_shapes)]
    results = []
    for at, shape in enumerate(to_shapes):
        total: Any = 0
        for k, x in enumerate(flat):
            row, column = (at, k) if code.mode == "forward" else (k, at)
            matrix = matrices[row * len(inputs) + column]
            lead = matrix.shape[: matrix.ndim - len(base.outputs[row]) - len(inputs[column])]
            matrix = matrix.reshape((*lead, _size(base.outputs[row]), _size(inputs[column])))
            total += jnp.einsum("...ij,...j->...i" if code.mode == "forward" else "...ij,...i->...j", matrix, x)
        results.append(total.reshape((*total.shape[:-1], *shape)))
    lead = jnp.broadcast_shapes(*(x.shape[: x.ndim - len(shape)] for x, shape in zip(results, to_shapes)), _lead(arrays, code.inputs))
    return [jnp.broadcast_to(x, (*lead, *shape)) for x, shape in zip(results, to_shapes)]


def _size(shape: tuple[int, ...]) -> int:
    return int(np.prod(shape))


_call.def_impl(_eager(_call))
_call.def_abstract_eval(_abstract)
mlir.register_lowering(_call, _lowered, platform="cpu")
_lowered_on_cuda = mlir.lower_fun(_on_cuda, multiple_results=True)
mlir.register_lowering(_call, _lowered_on_cuda, platform="cuda")
ad.primitive_jvps[_call] = _jvp
ad.primitive_transposes[_call] = _transpose
batching.primitive_batchers[_call] = _batched


# Rollouts: the states, `_rollout`; their changes by `lax.scan`, `_rollout_changes`, whose transpose is `_rollout_gradient`. Further
# derivatives are those of `lax.scan`.
_rollout = Primitive("modyn_rollout")
_rollout_changes = Primitive("modyn_rollout_changes")
_rollout_gradient = Primitive("modyn_rollout_gradient")


def _scanned(*arrays: Any, code: Rollout) -> list[Any]:
    """Returns the states of a rollout, by calls of the step in a `scan`."""
    lead = _lead(arrays, code.inputs)
    state = [jnp.broadcast_to(arrays[k], (*lead, *code.inputs[k])) for k in code.state]
    by_step = [jnp.moveaxis(arrays[k], arrays[k].ndim - len(code.inputs[k]), 0) for k in code.sequences]

    def advance(state: Any, of_step: Any) -> Any:
        given = list(arrays)
        for k, array in zip([*code.state, *code.sequences], [*state, *of_step]):
            given[k] = array
        results = _call.bind(*given, code=code.step)
        return results[: len(code.state)], results

    end, results = jax.lax.scan(advance, state, by_step, length=code.steps)
    if code.trajectory:
        return [jnp.moveaxis(x, 0, len(lead)) for x in results]
    # The accelerations and forces of the last step, the largest residual and number of iterations of all steps.
    last = lambda x: x[-1] if code.steps else x.sum(0)
    others = [x.max(0, initial=0) if x.ndim == 1 + len(lead) else last(x) for x in results[len(code.state) :]]
    return [*end, *others]


def _changes_shapes(code: Rollout, variables: tuple[int, ...]) -> list[tuple[int, ...]]:
    return [*code.inputs, *(code.inputs[k] for k in variables)]


def _by_scan(*arrays: Any, code: Rollout, variables: tuple[int, ...]) -> list[Any]:
    """Returns the changes of the states of a rollout under those of the variables."""
    lead = _lead(arrays, _changes_shapes(code, variables))
    own, changes = list(arrays[: len(code.inputs)]), arrays[len(code.inputs) :]
    whole = lambda x, k: jnp.broadcast_to(x, (*lead, *code.inputs[k]))

    def states(*varying: Any) -> list[Any]:
        given = list(own)
        for k, array in zip(variables, varying):
            given[k] = array
        return _scanned(*given, code=code)

    changes = tuple(whole(x, k) for x, k in zip(changes, variables))
    return jax.jvp(states, tuple(whole(own[k], k) for k in variables), changes)[1]


def _gradient_by_scan(*arrays: Any, code: RolloutGradient) -> list[Any]:
    """Returns the gradients of the weighted states of a rollout."""
    lead = _lead(arrays, code.inputs)
    whole = lambda k: jnp.broadcast_to(arrays[k], (*lead, *code.inputs[k]))
    own = arrays[: len(code.rollout.inputs)]
    weights = [whole(k) for k in range(len(own), len(arrays))]

    def states(*varying: Any) -> list[Any]:
        given = list(own)
        for k, array in zip(code.variables, varying):
            given[k] = array
        return _scanned(*given, code=code.rollout)

    return list(jax.vjp(states, *map(whole, code.variables))[1](weights))


def _rollout_jvp(primals: Any, tangents: Any, *, code: Rollout) -> Any:
    values = _rollout.bind(*primals, code=code)
    variables = tuple(i for i, tangent in enumerate(tangents) if type(tangent) is not ad.Zero and i != code.constant)
    if not variables:
        return values, [ad.Zero.from_primal_value(value) for value in values]
    changes = [tangents[i] for i in variables]
    return values, _rollout_changes.bind(*primals, *changes, code=code, variables=variables)


def _changes_abstract(*arrays: Any, code: Rollout, variables: tuple[int, ...]) -> list[Any]:
    lead = _lead(arrays, _changes_shapes(code, variables))
    return [jax.core.ShapedArray(lead + own, arrays[0].dtype) for own in code.outputs]


def _check_second(step: ArrayFunction) -> None:
    """Raises if a step has no second derivatives."""
    if step.start is not None:
        raise NotImplementedError(f"`{step.name}` has first derivatives alone")


def _changes_jvp(primals: Any, tangents: Any, *, code: Rollout, variables: tuple[int, ...]) -> Any:
    _check_second(code.step)
    call = lambda *arrays: _by_scan(*arrays, code=code, variables=variables)
    return jax.jvp(call, primals, tuple(map(ad.instantiate_zeros, tangents)))


def _changes_transpose(cotangents: Any, *arrays: Any, code: Rollout, variables: tuple[int, ...]) -> Any:
    own, linear = arrays[: len(code.inputs)], arrays[len(code.inputs) :]
    unknown = [k for k, array in enumerate(linear) if ad.is_undefined_primal(array)]
    weights = [ad.instantiate_zeros(cotangent) for cotangent in cotangents]
    found = _rollout_gradient.bind(*own, *weights, code=code.gradient([variables[k] for k in unknown]))
    by_linear = dict(zip(unknown, found))
    sums = [_sum_to(by_linear[k], array.aval) if k in by_linear else None for k, array in enumerate(linear)]
    return [None] * len(own) + sums


def _changes_batched(arrays: Any, dims: Any, *, code: Rollout, variables: tuple[int, ...]) -> Any:
    moved = _moved(arrays, dims, _changes_shapes(code, variables))
    return _rollout_changes.bind(*moved, code=code, variables=variables), [0] * len(code.outputs)


def _gradient_jvp(primals: Any, tangents: Any, *, code: RolloutGradient) -> Any:
    _check_second(code.rollout.step)
    values = _rollout_gradient.bind(*primals, code=code)
    call = lambda *arrays: _gradient_by_scan(*arrays, code=code)
    return values, jax.jvp(call, primals, tuple(map(ad.instantiate_zeros, tangents)))[1]


def _batched_call(primitive: Primitive) -> Callable[..., Any]:
    def rule(arrays: Any, dims: Any, *, code: Any) -> Any:
        return primitive.bind(*_moved(arrays, dims, code.inputs), code=code), [0] * len(code.outputs)

    return rule


for _primitive in (_rollout, _rollout_changes, _rollout_gradient):
    _primitive.multiple_results = True
    _primitive.def_impl(_eager(_primitive))
for _primitive in (_rollout, _rollout_gradient):
    _primitive.def_abstract_eval(_abstract)
    mlir.register_lowering(_primitive, _lowered, platform="cpu")
    batching.primitive_batchers[_primitive] = _batched_call(_primitive)
# On CUDA each step is a kernel.
mlir.register_lowering(_rollout, mlir.lower_fun(_scanned, multiple_results=True), platform="cuda")
mlir.register_lowering(_rollout_gradient, mlir.lower_fun(_gradient_by_scan, multiple_results=True), platform="cuda")
_rollout_changes.def_abstract_eval(_changes_abstract)
mlir.register_lowering(_rollout_changes, mlir.lower_fun(_by_scan, multiple_results=True))
batching.primitive_batchers[_rollout_changes] = _changes_batched
ad.primitive_jvps[_rollout] = _rollout_jvp
ad.primitive_jvps[_rollout_changes] = _changes_jvp
ad.primitive_transposes[_rollout_changes] = _changes_transpose
ad.primitive_jvps[_rollout_gradient] = _gradient_jvp
