"""Types that several parts of the package share."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

if TYPE_CHECKING:
    from ._modyn import GpuArray


class JointLimits(NamedTuple):
    """The limits of the joints; infinite without a limit."""

    lower: NDArray[np.float64]
    """(nq,), rad or m"""
    upper: NDArray[np.float64]
    """(nq,), rad or m"""
    velocity: NDArray[np.float64]
    """(nv,), rad/s or m/s"""
    effort: NDArray[np.float64]
    """(nv,), N m or N"""


class Keyframe(NamedTuple):
    """A named state of a robot, with its controls; zeros where the description has none."""

    q: NDArray[Any]
    """(nq,): the coordinates"""
    qd: NDArray[Any]
    """(nv,): the velocities"""
    ctrl: NDArray[Any]
    """(controls,): the controls of the actuators"""
    act: NDArray[Any]
    """(activations,): the states of the actuators"""


class BaseParameters(NamedTuple):
    """A smallest set of combinations of inertial parameters that determines all joint forces."""

    names: list[str]
    """each combination as text"""
    columns: NDArray[np.int64]
    """(parameters,): the column of `regressor` of each"""
    values: NDArray[np.float64]
    """(parameters,): the numbers of the description"""


SHAPES = {"rotation": (3, 3), "translation": (3,), "velocity": (6,), "solref": (2,), "solimp": (4,)}
"""the shapes of the fields of settings that are no numbers"""


def _named(settings: ContactTarget | ContactSurface) -> list[tuple[str, Any]]:
    return [(name, getattr(settings, name)) for name in settings.__dataclass_fields__]


def _numbers(named: Sequence[tuple[str, Any]]) -> list[float] | None:
    """Returns the numbers of fields, one field after another; `None` if one has axes of states."""
    numbers = []
    for name, value in named:
        if isinstance(value, float):
            numbers.append(value)
            continue
        array = np.asarray(value)
        if array.shape != SHAPES.get(name, ()):
            return None
        numbers += array.ravel().tolist()
    return numbers


def of_fields(named: Sequence[tuple[str, Any]], dtype: DTypeLike, library: Any = np) -> Any:
    """Returns the numbers of fields as an array (..., n), with the axes of states of all fields. `library` is `numpy` or `jax.numpy`."""
    numbers = _numbers(named) if library is np else None
    if numbers is not None:
        return np.array(numbers, dtype)
    parts = []
    for name, value in named:
        array, shape = library.asarray(value), SHAPES.get(name, ())
        lead = array.ndim - len(shape)
        if lead < 0 or array.shape[lead:] != shape:
            raise ValueError(f"`{name}` of the settings has the shape {array.shape}; expected {shape}, after axes of states")
        parts.append(array.reshape(*array.shape[:lead], math.prod(shape)))
    lead = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return library.concatenate([library.broadcast_to(part, (*lead, part.shape[-1])) for part in parts], -1).astype(dtype)


@dataclass
class ContactTarget:
    """The frame in the world that a contact holds its link's frame to; by default the plane z = 0, at rest and rigid. As in all
    settings, a field can have leading axes, which count states: `alpha` of the shape (n,) has a number for each of n states."""

    rotation: ArrayLike = field(default_factory=lambda: np.eye(3))
    """(3, 3): the columns are the target's axes in the world; z is the normal"""
    translation: ArrayLike = (0.0, 0.0, 0.0)
    """(3,), m"""
    velocity: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """(6,): the velocity of the ground in world axes, linear, then angular, m/s and rad/s"""
    tangential: ArrayLike = 0.0
    """the factor of the tangential displacement: 0 for a plane, 1 for a frame"""
    alpha: ArrayLike = 20.0
    """the damping of the displacement, 1/s"""
    beta: ArrayLike = 20.0
    """the stiffness of the displacement, 1/s"""
    compliance: ArrayLike = 0.0
    """the relative acceleration that the contact allows per force, 1/kg"""
    restitution: ArrayLike = 0.0
    """the coefficient of restitution along the normal"""
    weight: ArrayLike = 1.0
    """the weight of the contact in the distribution of the load by inverse dynamics"""

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(of_fields(_named(self), np.dtype(dtype)))


@dataclass
class ConstraintSettings:
    """The stabilization of constraints, the limits below which rows count as dependent, and the targets of contacts."""

    targets: list[ContactTarget] = field(default_factory=list)
    """the target of each contact, active or not, in the order of `contact_names`"""
    alpha: ArrayLike = 20.0
    """the damping of the displacements of loop constraints, 1/s"""
    beta: ArrayLike = 20.0
    """the stiffness of the displacements of loop constraints, 1/s"""
    tolerance: ArrayLike | None = None
    """the mobility of a dependent row relative to its constraint's mobility in all six directions; by default 1e-10, and
    1e-8 in single precision"""
    rounding: ArrayLike | None = None
    """the part of a row's own mobility that rounding may leave; by default 1e-10, and 1e-5 in single precision"""

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(of_fields(self._named(np.dtype(dtype)), np.dtype(dtype)))

    def _named(self, dtype: np.dtype[Any]) -> list[tuple[str, Any]]:
        tolerance, rounding = (1e-8, 1e-5) if dtype == np.float32 else (1e-10, 1e-10)
        tolerance = tolerance if self.tolerance is None else self.tolerance
        rounding = rounding if self.rounding is None else self.rounding
        own = [("alpha", self.alpha), ("beta", self.beta), ("tolerance", tolerance), ("rounding", rounding)]
        return [*own, *(pair for target in self.targets for pair in _named(target))]


@dataclass
class ContactSurface:
    """The surfaces of a contact of `step`: a plane, and the rounding of the shape that touches it. Defaults are MuJoCo's. A
    field can have leading axes, which count states: `friction` of the shape (n,) has a coefficient for each of n states."""

    rotation: ArrayLike = field(default_factory=lambda: np.eye(3))
    """(3, 3): the columns are the plane's axes in the world; z is the normal"""
    translation: ArrayLike = (0.0, 0.0, 0.0)
    """(3,): a point of the plane, m"""
    radius: ArrayLike = 0.0
    """the radius of a sphere or a capsule, or of a shape's round edges, m; 0 for a point"""
    friction: ArrayLike = 1.0
    """the coefficient of sliding friction"""
    torsional_friction: ArrayLike = 0.005
    """the moment about the normal divided by the normal force, m: for contacts of at least four components"""
    rolling_friction: ArrayLike = 0.0001
    """the moment about a tangent divided by the normal force, m: for contacts of six components"""
    margin: ArrayLike = 0.0
    """the distance from which on the contact acts, m"""
    solref: ArrayLike = (0.02, 1.0)
    """(2,): how a violation decays: the time constant (s) and the damping ratio; if the first number is negative, minus the
    stiffness and minus the damping"""
    solimp: ArrayLike = (0.9, 0.95, 0.001, 0.5)
    """(4,): the impedance at the surface and at the depth `width`; the width, m; the share of the width at which the curve between
    them, of two parabolas, changes its direction"""

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(of_fields(_named(self), np.dtype(dtype)))


@dataclass
class StepSettings:
    """The settings of `step`: its solver, and the surfaces that shapes touch. Names and defaults are MuJoCo's."""

    surfaces: list[ContactSurface] = field(default_factory=list)
    """the surface of each shape that touches the ground, in the order of `touching_shape_names`"""
    tolerance: ArrayLike | None = None
    """the largest mismatch between the forces and their laws at which the solver ends, divided by the sum of the robot's weight and
    the largest force; by default 1e-8, and 1e-4 in single precision"""
    impratio: ArrayLike = 1.0
    """how many times stiffer friction is than the normal direction"""
    coulomb: ArrayLike = 0.0
    """the share of Coulomb's law in sliding, from 0 (MuJoCo's law) to 1: by MuJoCo's law a sliding contact separates at the speed of
    its slip times the friction; this share of that speed, by the slip before the step, is subtracted"""

    def rigid(self, impedance: float = 0.999) -> StepSettings:
        """Returns the settings with nearly rigid contacts for all time steps: a contact's motion into the plane, or along it if it
        sticks, ends within a step, and sliding follows Coulomb's law. A violation decays by a sixteenth per step. Use an `impedance` of
        at most 0.99 in single precision."""
        surfaces = [replace(surface, solref=(1e-6, 2.0), solimp=(impedance, impedance, 0.001, 0.5)) for surface in self.surfaces]
        return replace(self, surfaces=surfaces, coulomb=1.0)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(of_fields(self._named(np.dtype(dtype)), np.dtype(dtype)))

    def _named(self, dtype: np.dtype[Any]) -> list[tuple[str, Any]]:
        tolerance = 1e-4 if dtype == np.float32 else 1e-8
        tolerance = tolerance if self.tolerance is None else self.tolerance
        own = [("tolerance", tolerance), ("impratio", self.impratio), ("coulomb", self.coulomb)]
        return [*own, *(pair for surface in self.surfaces for pair in _named(surface))]


class Joint(NamedTuple):
    """A joint with coordinates of its own."""

    name: str
    type: str
    """`revolute`, `continuous`, `prismatic`, `universal`, `planar`, `spherical` or `floating`"""
    q: slice
    """the joint's entries of `q`"""
    v: slice
    """the joint's entries of `qd`"""


class RolloutResults(NamedTuple):
    """The results of n rollouts of `GpuRollout`: arrays on the graphics processor, whose `numpy` copies them."""

    state: GpuArray
    """the states after the last step, (n, nq + nv): the coordinates, then the velocities"""
    cost: GpuArray | None
    """the sum of your function `cost` over the steps, (n,)"""
    trajectory: GpuArray | None
    """the states after each step, (n, steps, nq + nv)"""


class RolloutStates(NamedTuple):
    """The states of motions: after each step, (..., steps, n), or after the last one, (..., n)."""

    q: NDArray[Any]
    """the coordinates"""
    qd: NDArray[Any]
    """the velocities"""


class RolloutCosts(NamedTuple):
    """The states of motions with their costs: after each step, (..., steps, n), or after the last one, (..., n)."""

    q: NDArray[Any]
    """the coordinates"""
    qd: NDArray[Any]
    """the velocities"""
    cost: NDArray[Any]
    """the sum of the costs of the steps so far: (..., steps), or (...) after the last step"""


class QuadraticCost(NamedTuple):
    """The cost of a rollout: each step adds the sum of `state_weights` (x_goal - x)^2 over the state after it, and of `control_weights`
    f^2 over its joint forces (those of a feedback included). The difference of states has that of coordinates in tangent space, then that
    of velocities.

    Arrays of NumPy, JAX or PyTorch, with the same numbers for all steps, or with an axis of steps; leading axes are those of motions.
    """

    q_goal: Any
    """(nq,) or (steps, nq)"""
    state_weights: Any
    """(2 nv,) or (steps, 2 nv)"""
    qd_goal: Any = None
    """(nv,) or (steps, nv), by default zero"""
    control_weights: Any = None
    """(nv,) or (steps, nv), by default zero"""
    terminal_weights: Any = None
    """(2 nv,), by default zero: further weights of the last state"""


@dataclass(frozen=True, eq=False)
class HeightField:
    """Ground whose height is given on a grid in the xy plane of the world, and interpolated bilinearly. Beyond the grid the ground goes
    on level at the height of the border. Leading axes are axes of motions, each of which can have its own ground; in functions of JAX and
    of PyTorch the fields can be their arrays. Arrays in C order, of the numbers that the robot has, are read where they are.
    """

    heights: ArrayLike
    """(rows, columns), m: columns along x, rows along y; two or more of each"""
    origin: ArrayLike = (0.0, 0.0)
    """(2,): the x and y of the first height, m"""
    spacing: ArrayLike = (1.0, 1.0)
    """(2,): the distances of neighbours along x and y, m"""


class RolloutGradients(NamedTuple):
    """The gradients of the weighted states of motions, for each motion, with the shapes of the arguments."""

    q: NDArray[Any]
    """by the entries of the first coordinates, (..., nq)"""
    qd: NDArray[Any]
    controls: NDArray[Any]
    dt: NDArray[Any]
    gains: NDArray[Any] | None = None
    """`None` without a feedback"""
    q_ref: NDArray[Any] | None = None
    qd_ref: NDArray[Any] | None = None
    settings: NDArray[Any] | None = None
    """with respect to the numbers of `settings`; `None` for steps without contacts"""
    cost: QuadraticCost | None = None
    """`None` without a cost"""
    act: NDArray[Any] | None = None
    """with respect to the first activations; `None` unless the step is `actuated`, as of `applied`"""
    applied: NDArray[Any] | None = None
    parameters: dict[str, Any] | None = None
    """with the entries of the argument; `None` without it"""


@cache
def fused(name: str, fields: tuple[str, ...]) -> type[tuple[Any, ...]]:
    """Returns the type of a fused function's results: a named tuple with a field for each of its functions."""
    return namedtuple(name, fields)
