# `cargo xtask pages` writes the parts between the marks.

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import TypedDict, Unpack

from ._arrays import Extras
from ._results import *
from ._types import (
    BaseParameters,
    ConstraintSettings,
    HeightField,
    Joint,
    JointLimits,
    Keyframe,
    QuadraticCost,
    RolloutCosts,
    RolloutGradients,
    RolloutResults,
    RolloutStates,
    StepSettings,
)

# `float64`, or `float32` with the option `scalar="f32"`.
Array: TypeAlias = NDArray[Any]

class Options(TypedDict, total=False):
    # <!-- data: python-options -->
    gravity: Sequence[float] | None
    """The acceleration of free fall in world axes, m/s^2; an MJCF or a model has its own. Default: `[0.0, 0.0,
    -9.81]`, or the MJCF's or the model's own. For example: `[0, 0, -1.62]`."""
    base: str | None
    """Whether the root link is fixed to the world or floats. With `auto`, a URDF's root link is fixed, and an
    SDF's floats unless a joint connects it to the world. In every format, `fixed` fixes what floats in the
    world by itself, where the file places it, and `floating` is an error if the robot floats already. Default:
    `auto`. For example: `"floating"`."""
    mimic: str | None
    """How joints that mimic another one are read: they follow it and have no coordinate of their own, have one, or
    are refused. Joints with a coordinate of their own are free; `<equality>` of an MJCF couples them in the
    function `step`, softly as in MuJoCo. Default: `follow`. For example: `"independent"`."""
    armature: Mapping[str, Any] | str | None
    """Armatures of joints: the inertia of the drive after the gear (kg m^2, or kg for a prismatic joint), in place
    of the description's. It acts in all dynamics. Default: the description's. For example: `{"elbow": 1}`."""
    rotors: Mapping[str, Any] | str | None
    """Armatures of joints by their rotors: the inertia of each before the gear (kg m^2) and the gear ratio. The
    armature is the inertia times the square of the ratio. Default: the description's. For example: `{"elbow":
    [0.0001, 100]}`."""
    loops: Mapping[str, Any] | str | None
    """Joints that close loops, besides the `<loop_joint>`s of the description: of type `spherical`, `fixed`,
    `revolute`, `continuous` or `prismatic`, the last three with an `axis` at the end. Roll, pitch and yaw, `[r,
    p, y]`, may follow each origin. Default: the description's. For example: `{"pin": ("revolute", "rod", [0.5,
    0, 0], "crank", [0.4, 0, 0], {"axis": [0, 1, 0]})}`."""
    contacts: Mapping[str, Any] | str | None
    """Frames of links that can touch the world, besides the `<contact_frame>`s of the description: of type
    `point`, which stops the motion of the frame's origin, or `surface`, which stops rotations too. The frame's
    origin may follow the link, and its roll, pitch and yaw may follow the origin. Default: the description's.
    For example: `{"fingertip": ("point", "hand", [0, 0, 0.2])}`."""
    ground: str | tuple[Any, ...] | None
    """The ground that collision shapes touch in the function `step`: a plane by a point (m) and the normal away
    from the ground, `plane` for z = 0. `friction = 0.8` at the end is the coefficient of all contacts, in place
    of the description's. If there are contacts, their points touch the plane, and shapes do not. Default: the
    planes in the world of an SDF or an MJCF. For example: `("plane", [0, 0, 0.1], [0, 0, 1])`."""
    actuators: Mapping[str, Any] | str | None
    """The actuators of joints, in the function `step_actuated`, by names in which `*` stands for any text:
    `position(kp, kd)` with the target position as its control, `velocity(kd)` with the target velocity, or
    `motor` with the force. `effort` (N m or N) at the end is the largest force; by default the effort limit of
    the description. `saturation` is the stall force of a torque-speed line, and `velocity` its no-load speed,
    by default the velocity limit. `delay` is the number of steps before a control acts. The option replaces the
    actuators of an MJCF. Default: the description's. For example: `{"elb*": ("position", 20, 0.5, {"effort":
    23.5, "saturation": 30, "velocity": 25, "delay": 2})}`."""
    joint_friction: str | tuple[str, float] | None
    """The damping and friction of the description that act on the joints. Default: `none`, with a warning if there
    are some. For example: `("smooth", 0.01)`."""
    unphysical_inertia: str | None
    """How inertias that no rigid body has are reported. A negative mass is always an error. Default: `error`. For
    example: `"warn"`."""
    unsupported_forces: str | None
    """How forces of fluids, such as air, and of tendons in an MJCF are reported, which are not read. With a
    warning the robot is without them; springs and dampers of fixed tendons then act in the function `step`
    only. Default: `error`. For example: `"warn"`."""
    packages: Mapping[str, Any] | str | None
    """The folders of ROS packages, which a description names in `$(find ...)` and `package://`. Packages in the
    folders above the description are found without this option, and so are packages in the folders of
    `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`. Default: found by their names. For example: `{"arm_description":
    "robots/arm"}`."""
    xacro_args: Mapping[str, Any] | str | None
    """The values of arguments of a xacro, `<xacro:arg>`, in place of their defaults. Default: the defaults of the
    xacro. For example: `{"prefix": "left_"}`."""
    fused: Mapping[str, Any] | str | None
    """Fused functions: each computes several functions in one call, with their common work done once. It has the
    arguments of all its functions; its result is a type with a field for each of them (`jacobian_hand`).
    Functions of one link are named with the link. In generated code, `name: batch(..)` makes the form for many
    states as well. Default: none. For example: `{"control": ["mass_matrix", "bias_forces", ("jacobian",
    "hand")]}`."""
    modules: str | Sequence[Sequence[str]] | None
    """The kinematic modules: maximal serial chains, links, or lists of link names, each from its parent outwards.
    Default: `chains`. For example: `[["upper_arm", "forearm"], ["hand"]]`."""
    scalar: str | None
    """The scalar of arguments and results: double or single precision. Default: `f64`. For example: `"f32"`."""
    runtime_gravity: bool | None
    """Makes gravity a run-time parameter, which can be changed; its value is then the default. Default: `False`.
    For example: `True`."""
    runtime_inertia: Sequence[str] | None
    """The links whose own inertia is a run-time parameter: each replaces the description's, which is the default.
    (Of each link alone, without the links that are fixed to it.) Default: none. For example: `["hand"]`."""
    payload: Sequence[str] | None
    """The links with a payload: an inertia that is a run-time parameter and is added to the link's. Its default is
    zero. Default: none. For example: `["hand"]`."""
    # <!-- end -->
    machine_code: bool
    """Whether functions are compiled to machine code; without, they are evaluated. Default: `True`."""

def load(path: str | os.PathLike[str], /, **options: Unpack[Options]) -> Robot:
    """Reads the robot of a file: URDF, xacro, SDF or MJCF.

    The keyword arguments are modyn's options about a robot: `gravity`, `base`, `mimic`, `armature`, `rotors`, `loops`,
    `contacts`, `ground`, `actuators`, `joint_friction`, `unphysical_inertia`, `unsupported_forces`, `packages`,
    `xacro_args`, `fused`, `modules`, `scalar`, `runtime_gravity`, `runtime_inertia` and `payload`; with
    `machine_code=False`, functions are evaluated instead of compiled.

    `OSError` if the file cannot be read, `DescriptionError` with file, line and column if the description is wrong.
    """

def loads(
    text: str, /, file: str = "robot", *, folder: str | os.PathLike[str] | None = None, **options: Unpack[Options]
) -> Robot:
    """Reads the robot of a text: URDF, xacro, SDF or MJCF; `file` is the name in diagnostics, and `folder` that of files which the
    text names: without it, no other file is read. The other keyword arguments are those of `load`."""

def functions() -> list[str]:
    """Returns the names of the functions of one state in modyn's table, which are methods of `Robot`."""

def options_table() -> list[tuple[str, str, str, str]]:
    """Returns the names of the options of `load`, each with an example, its default and its documentation."""

def xla_handler() -> int:
    """Returns the address of XLA's handler of all functions of arrays."""

def xla_cuda_handler(on_host: bool = False) -> int:
    """Returns the address of XLA's handler of all functions of arrays on CUDA; for tests the address of a handler that XLA calls on
    the host."""

def set_threads(threads: int | None) -> None:
    """Sets the number of threads that share a batch; `None` for all processors, the default."""

def mujoco_to_qpos(q: Array) -> Array: ...
def mujoco_from_qpos(qpos: Array) -> Array: ...
def mujoco_to_qvel(q: Array, qd: Array) -> Array: ...
def mujoco_from_qvel(q: Array, qvel: Array) -> Array: ...
def mujoco_to_qacc(q: Array, qd: Array, qdd: Array) -> Array: ...
def mujoco_from_qacc(q: Array, qd: Array, qacc: Array) -> Array: ...
def pinocchio_cos_sin(angles: Array) -> Array: ...
def pinocchio_angle(cos_sin: Array) -> Array: ...

@final
class Factorization:
    """The factorization U D U^T of a mass matrix by kinematic modules, of one state."""

    def u(self) -> Array:
        """Returns the block upper triangular U, (nv, nv)."""
    def d(self) -> Array:
        """Returns the block diagonal D, (nv, nv)."""
    def u_inverse(self) -> Array:
        """Returns the inverse of U, (nv, nv)."""
    def d_inverse(self) -> Array:
        """Returns the inverse of D, (nv, nv)."""
    def inverse(self) -> Array:
        """Returns the inverse of the mass matrix, (nv, nv)."""
    def log_determinant(self) -> float:
        """Returns the natural logarithm of the mass matrix's determinant."""
    def solve(self, rhs: ArrayLike) -> Array:
        """Returns the solution x, (nv,), of M x = `rhs` with the mass matrix M; `rhs` is (nv,)."""

@final
class GpuArray:
    """Numbers for n states on a graphics processor, in single precision: arguments and results of kernels."""

    def numpy(self) -> Any:
        """Waits until the numbers are computed, and returns a copy of them: an array of `float32`, or a named tuple of
        arrays as the robot's function returns. The first axis is that of the states."""
    def __len__(self) -> int:
        """The number of states."""

@final
class GpuRobot:
    """The kernels of a robot on a graphics processor, a thread for each state, in single precision. Each is compiled at
    its first use. `Robot.gpu` makes them."""

    @property
    def processor(self) -> str:
        """The name of the processor, as its driver gives it."""
    def upload(self, array: ArrayLike) -> GpuArray:
        """Copies an array of n states to the processor, which rounds the numbers to single precision. The first axis is
        that of the states."""
    def run(self, function: str, *arguments: ArrayLike | GpuArray, link: str | int | None = None) -> GpuArray:
        """Runs the kernel of a function, such as `"forward_dynamics"`, on all states of its arguments: arrays on the
        processor or of NumPy. A function of a link takes its name or index, too. The result stays on the processor; the
        call does not wait for it."""
    def rollout(
        self,
        functions: Sequence[str] | None = None,
        *,
        cost: str | None = None,
        forces: str | None = None,
        controls: int | None = None,
        active_contacts: str | None = None,
    ) -> GpuRollout:
        """Returns kernels that integrate motions over many time steps.

        The time steps among `functions` become kernels, by default `step_semi_implicit`. `cost` and `forces` are functions
        of yours in WGSL, which may call the functions of the robot (`robot_link_pose_hand`) and read the array `data`;
        docs/gpu.md has their signatures. `controls` is the number of controls of a step that `forces` takes.
        `active_contacts` proposes the active contacts of a step; then `functions` has `constrained_forward_dynamics` and `integrate`.
        """

@final
class GpuRollout:
    """Kernels that integrate motions over many time steps. `GpuRobot.rollout` makes them."""

    def run(
        self,
        q: ArrayLike | GpuArray,
        qd: ArrayLike | GpuArray,
        controls: ArrayLike | GpuArray,
        dt: float,
        *,
        step: str = "step_semi_implicit",
        settings: ConstraintSettings | ArrayLike | GpuArray | None = None,
        data: ArrayLike | GpuArray | None = None,
        trajectory: bool = False,
        act: ArrayLike | GpuArray | None = None,
    ) -> RolloutResults:
        """Runs n rollouts from the states `q`, (nq,) or (k, nq), and `qd`, (nv,) or (k, nv), under the `controls`,
        (n, steps, controls), with steps of `dt` s. Rollout i starts from state i modulo k. The arrays may be on the
        processor.

        `step` is a time step among the functions; `"constrained_forward_dynamics"` for steps that close loops and hold
        contacts, whose `settings` are those of the function. `data` are numbers for your functions. `act`, (activations,) or
        (k, activations), are the activations and the delayed controls with which `"step_actuated"` begins, by default zeros. Returns
        `RolloutResults`, whose arrays stay on the processor: `state` (n, nq + nv) after the last step, `cost` (n,) or
        `None`, and with `trajectory=True` `trajectory` (n, steps, nq + nv). The call does not wait for them.
        """

class CodeHandle:
    """Compiled code, which lives as long as a handle of it."""

    @property
    def key(self) -> int:
        """The key by which XLA finds the code."""
    @property
    def inputs(self) -> list[tuple[int, ...]]:
        """The shapes of the arrays of arguments, for one state."""
    @property
    def outputs(self) -> list[tuple[int, ...]]:
        """The shapes of the arrays of results, for one state."""
    def call(self, arrays: Sequence[Array]) -> list[Array]:
        """Calls the code on arrays in C order. Leading axes are axes of states, and are broadcast. Returns an array for each result,
        with the same leading axes."""
    def rollout(
        self,
        steps: int,
        trajectory: bool,
        roles: Mapping[str, Any],
        reverse: tuple[CodeHandle, Sequence[int]] | None = None,
    ) -> CodeHandle:
        """Returns the rollout of a time step, whose code this is: the results of all steps, or of the last one. Given the code of
        the step's products, the rollout returns the gradients with respect to the arguments `variables`. `roles` are the roles
        of the step's arguments: `state`, `start` and `sequences`."""

class CudaKernel:
    """A kernel on CUDA, for `modyn.torch` and `modyn.jax`."""

    def __init__(
        self, key: int, driver: Sequence[int], function: int, shapes: Sequence[Sequence[Sequence[int]]], is_double: bool
    ) -> None:
        """Keeps a kernel under the key of its function. `driver` are the addresses of the functions `cuLaunchKernel`,
        `cuCtxPushCurrent`, `cuCtxPopCurrent` and `cuGetErrorString`, `shapes` the shapes of the arguments and of the results."""
    def states(self, shapes: Sequence[Sequence[int]]) -> tuple[list[int], list[int]]:
        """Returns the axes of states that arguments of these shapes have in common, and the indices of the arguments that must be
        repeated along them before `launch`."""
    def launch(
        self, context: int, stream: int, shapes: Sequence[Sequence[int]], strides: Sequence[int], arrays: Sequence[int]
    ) -> None:
        """Starts the kernel on a stream of a context. `arrays` are the addresses of the arguments, whose shapes are `shapes` and
        whose rows are `strides` numbers apart, and of the results, in this order."""

@final
class Robot:
    """A robot: a description (URDF, xacro, SDF or MJCF) whose functions are compiled to machine code, each at its first use.

    `load` and `loads` make robots. Arguments and results are in SI units and radians, and joint vectors have the order of
    `coordinate_names` and `velocity_names`. Each argument has one state, or n states as n rows; the result then has n
    rows, too. `out` is an array (for several results: an earlier result) that the call writes and returns.
    """

    @property
    def name(self) -> str:
        """The robot's name in its description."""
    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of the numbers in arguments and results: `float64`, or `float32` with the option `scalar="f32"`."""
    @property
    def nq(self) -> int:
        """The length of the coordinate vector `q`."""
    @property
    def nv(self) -> int:
        """The length of the velocity vector `qd`: the number of degrees of freedom."""
    @property
    def joint_names(self) -> list[str]:
        """The names of the moving joints, depth first, including mimic joints."""
    @property
    def link_names(self) -> list[str]:
        """The names of all links of the description, in its order."""
    @property
    def coordinate_names(self) -> list[str]:
        """The name of each entry of `q`: the joint's name, and the component for joints with several coordinates."""
    @property
    def velocity_names(self) -> list[str]:
        """The name of each entry of `qd`."""
    @property
    def loop_constraint_names(self) -> list[str]:
        """The names of the joints that close loops, in the description's order."""
    @property
    def contact_names(self) -> list[str]:
        """The names of the contacts, in the order of the option."""
    @property
    def control_names(self) -> list[str]:
        """The names of the controls of `actuate`: of the actuators."""
    @property
    def activation_names(self) -> list[str]:
        """The names of the activations of `actuate`: of the actuators that have a state."""
    @property
    def control_ranges(self) -> NDArray[np.float64]:
        """The ranges of the controls, (controls, 2); -inf and inf for a control without a range."""
    @property
    def touching_shape_names(self) -> list[str]:
        """The names of the shapes that touch the ground in a `step`: the contacts if there are any, else the shapes of the
        description."""
    def step_settings(self) -> StepSettings:
        """Returns the settings of `step` by the description, to be changed: `StepSettings`, with the surface of each of
        `touching_shape_names`."""
    @property
    def fused_names(self) -> list[str]:
        """The names of the fused functions, each of which is a method."""
    @property
    def gravity(self) -> Array:
        """The acceleration of free fall at present, in world axes, (3,), m/s^2: that of the description, or of `set_gravity`."""
    @property
    def limits(self) -> JointLimits:
        """The joint limits, infinite without a limit."""
    @property
    def joints(self) -> list[Joint]:
        """The joints with coordinates of their own: the name, the type and the entries of `q` and `qd` of each."""
    def _followers(self) -> list[tuple[str, int, int, float, float]]: ...
    @property
    def parameters(self) -> Array:
        """The inertial parameters of the moving links at present, ten for each link, as in `regressor`: those of the description,
        with the changes of `set_inertia` and `set_payload`."""
    def base_parameters(self) -> BaseParameters:
        """Returns the base parameters: a smallest set of combinations of inertial parameters that determines all joint
        forces. `names` has each combination as text, `columns` the column of `regressor` of each, and `values` the
        present numbers. Finding them takes a while (Gautier 1991)."""
    def neutral(self) -> Array:
        """Returns the neutral coordinates, (nq,): zero for every joint, the identity for quaternions."""
    @property
    def keyframes(self) -> dict[str, Keyframe]:
        """The keyframes of the description: named states, in its order."""
    def keyframe(self, name: str) -> Keyframe:
        """Returns the keyframe of this name; `KeyError` names those that there are."""
    @property
    def time_step(self) -> float | None:
        """The time step of the description, s, such as `<option timestep>` of an MJCF; `None` without one."""
    def check_configuration(self, q: ArrayLike) -> None:
        """Checks that the quaternions of spherical and floating joints in `q`, (nq,), have length 1."""
    def animation(self, times: ArrayLike, trajectory: ArrayLike, ground: float | None = None) -> str:
        """Returns a page of HTML that shows the robot in motion, with its shapes. `times`, (n,), s, must ascend; `trajectory`,
        (n, nq), has the coordinates at each time. The ground is drawn at the height `ground`, m; by default at zero, or below the
        motion."""
    def set_gravity(self, gravity: ArrayLike) -> None:
        """Sets gravity, the acceleration of free fall in world axes, (3,), m/s^2. Needs the option `runtime_gravity`."""
    def set_inertia(
        self, link: str, mass: float, center_of_mass: ArrayLike, inertia: ArrayLike
    ) -> None:
        """Sets the inertia of a link, in its own frame, in place of the description's: the mass, kg; the centre of mass
        (3,), m; ixx, ixy, ixz, iyy, iyz, izz about the centre of mass, (6,), kg m^2. Needs the option `runtime_inertia`."""
    def set_payload(
        self,
        link: str,
        mass: float,
        center_of_mass: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
    ) -> None:
        """Sets the payload of a link, in the link's frame: an inertia that is added to the link's, with the units of
        `set_inertia`. The default is a point mass at the link's origin. Needs the option `payload`."""
    def gpu(self) -> GpuRobot:
        """Returns the robot's kernels on the machine's graphics processor, in single precision; on a software processor
        where there is no other. `RuntimeError` if there is none, or the package was built without the feature `gpu`."""
    def fused(self, name: str, *arguments: ArrayLike, out: Any = None, **named: ArrayLike) -> Any:
        """Calls a fused function by its name, with the arguments of all its functions by position or name."""
    def brge(self, q: ArrayLike) -> Factorization:
        """Returns the factorization U D U^T of the mass matrix at `q`, (nq,), by kinematic modules, by block reverse
        Gaussian elimination. The option `modules` selects the modules. The factors are in `float64` for every robot."""
    def __getattr__(self, name: str) -> Any:
        """Returns a fused function as a callable."""
    def _repr_html_(self) -> str | None: ...
    def _array_signature(
        self, name: str, link: str | int | None = None
    ) -> tuple[
        list[tuple[str, list[int], Array | None]], list[tuple[str, str | None, list[float]]], Any
    ]:
        """Returns the names of the arguments of a function or a fused function, each with its shape and its default; the run-time
        parameters that it depends on, each by option and link with its present numbers; and its result, whose arrays are their
        indices."""
    def _array_code(
        self, name: str, link: str | int | None, derivatives: Sequence[tuple[str, Sequence[int]]], extras: Extras
    ) -> CodeHandle:
        """Returns the code of a function or of a derivative. Each derivative is its mode (`forward`, `reverse` or `matrix`) and the
        indices of the arrays that vary."""
    def _array_text(
        self, name: str, link: str | int | None, derivatives: Sequence[tuple[str, Sequence[int]]], extras: Extras
    ) -> str:
        """Returns the text of a kernel on CUDA for the function or the derivative that `_array_code` has for these arguments, without
        a height field."""
    def _field_texts(self, field: tuple[int, int]) -> tuple[str, str, list[int]]:
        """Returns the texts of two kernels on CUDA: of the poses of the links that carry the touching shapes, (12 shapes,), from `q`;
        and of the settings with the planes of a height field of these rows and columns below the shapes, from the poses, `settings`,
        `heights` and `grid`. With them the places of the planes among the settings, each the first of twelve numbers."""
    @property
    def _kept(self) -> dict[Any, Any]:
        """What the package keeps of the robot: signatures and functions of arrays."""
    def simulate(
        self,
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
        steps; `settings`, `ground` and `parameters` as in `rollout`. Leading axes of `q` and `qd` are axes of motions, which `policy` gets,
        too.
        Result: `StepSolution`, with an axis of steps after the axes of motions.
        """
    def rollout(
        self,
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
        method, such as `semi_implicit` for the function `step_semi_implicit`, or `step` for the function `step`, with contacts and
        joint limits. This one has the arguments `settings`: `StepSettings`, by default the result of `step_settings()`; `warm_start`:
        the accelerations from which the first solver starts, by default zeros; and `ground`: a `HeightField` that sets the planes of
        the surfaces, by the place of each shape before each step; leading axes of its arrays count motions, too. With a feedback, the
        forces are `controls` + `gains` (x_ref - x), where the difference of states has the difference of coordinates in tangent space,
        then the difference of velocities: `gains`: (nv, 2 nv), or (2, nv) for a gain of each joint's own coordinate and of its
        velocity, and (steps, ...); `q_ref`: (nq,) or (steps, nq); `qd_ref`: (nv,) or (steps, nv); one step stands for all of them.
        With `step="actuated"`, the function `step_actuated`, `controls` has a control for each actuator, (steps, controls), and
        further arguments are `act`: the activations before the first step, by default zeros; and `applied`: (nv,), joint forces of all
        steps, by default zeros; there is no feedback. With `cost`, a `QuadraticCost`, each step adds the cost of its forces and of the
        state after it. `parameters`: the run-time parameters, by default those of the robot: `gravity` (3,), and by link `inertia` and
        `payload` (10,), as in `{"payload": {"hand": numbers}}`. Leading axes count motions, and are broadcast.
        Result: `RolloutStates`: `q` and `qd`; with a cost `RolloutCosts`; of `step` `StepSolution` and of `actuated`
        `ActuatedStep`, with the largest `residual` and `iterations` of all steps with `trajectory=False`.
        """
    def rollout_vjp(
        self,
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

    # <!-- data: python-functions -->
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint accelerations (rad/s^2 or m/s^2) at the coordinates `q` and velocities
        `qd` under the joint forces `tau` (N m or N), gravity included. The method is block reverse
        Gaussian elimination of the mass matrix by inter- and intra-modular recursion.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,).
        Result: (nv,). Several states have one more axis, the first.
        """
    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint forces (N m or N) of the accelerations `qdd` at the coordinates `q` and
        velocities `qd`, gravity included, by the recursive Newton-Euler algorithm.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
        Result: (nv,). Several states have one more axis, the first.
        """
    def bias_forces(
        self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the bias forces (N m or N): inverse dynamics at zero acceleration. They are the
        Coriolis, centrifugal and gravity forces and the forces of springs, with damping and
        friction if these are enabled.

        Arguments: `q`: (nq,); `qd`: (nv,).
        Result: (nv,). Several states have one more axis, the first.
        """
    def gravity_torques(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint forces (N m or N) that balance gravity and springs at `q` and zero
        velocity.

        Arguments: `q`: (nq,).
        Result: (nv,). Several states have one more axis, the first.
        """
    def mass_matrix(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the mass matrix at `q`, nv x nv.

        Arguments: `q`: (nq,).
        Result: (nv, nv). Several states have one more axis, the first.
        """
    def coriolis_matrix(
        self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the Coriolis matrix C, nv x nv. C `qd` are the Coriolis and centrifugal forces,
        without gravity, damping and friction, and dM/dt - 2 C is skew with the mass matrix M.

        Arguments: `q`: (nq,); `qd`: (nv,).
        Result: (nv, nv). Several states have one more axis, the first.
        """
    def kinetic_energy(
        self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None
    ) -> float | Array:
        """Returns the kinetic energy of the moving links and the armatures, J.

        Arguments: `q`: (nq,); `qd`: (nv,).
        Result: a number. Several states have one more axis, the first.
        """
    def potential_energy(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> float | Array:
        """Returns the potential energy of the moving links under gravity and of the springs, J; zero
        for mass at the world's origin and springs at rest.

        Arguments: `q`: (nq,).
        Result: a number. Several states have one more axis, the first.
        """
    def forward_dynamics_external_local(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, forces: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint accelerations under `tau` and a wrench on each link (in the order of
        `link_names`), at the link's origin in the link's own axes.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `forces`: (links, 6), forces before
        moments.
        Result: (nv,). Several states have one more axis, the first.
        """
    def forward_dynamics_external(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, forces: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint accelerations under `tau` and a wrench on each link (in the order of
        `link_names`), at the link's origin in world axes.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `forces`: (links, 6), forces before
        moments.
        Result: (nv,). Several states have one more axis, the first.
        """
    def inverse_dynamics_external_local(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, forces: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint forces of `qdd` under a wrench on each link (in the order of
        `link_names`), at the link's origin in the link's own axes.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `forces`: (links, 6), forces before
        moments.
        Result: (nv,). Several states have one more axis, the first.
        """
    def inverse_dynamics_external(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, forces: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the joint forces of `qdd` under a wrench on each link (in the order of
        `link_names`), at the link's origin in world axes.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `forces`: (links, 6), forces before
        moments.
        Result: (nv,). Several states have one more axis, the first.
        """
    def generalized_forces_local(
        self, q: ArrayLike, forces: ArrayLike, *, out: GeneralizedForces | None = None
    ) -> GeneralizedForces:
        """Returns the generalized forces J^T f of a wrench on each link (in the order of
        `link_names`), at the link's origin in the link's own axes, and their derivative with
        respect to `q` (in tangent space). The wrenches rotate with their links.

        Arguments: `q`: (nq,); `forces`: (links, 6), forces before moments.
        Result: `GeneralizedForces`: `tau` (nv,), `dtau_dq` (nv, nv). Several states have one more
        axis, the first.
        """
    def generalized_forces(
        self, q: ArrayLike, forces: ArrayLike, *, out: GeneralizedForces | None = None
    ) -> GeneralizedForces:
        """Returns the generalized forces J^T f of a wrench on each link (in the order of
        `link_names`), at the link's origin in world axes, and their derivative with respect to `q`
        (in tangent space). The wrenches keep their directions.

        Arguments: `q`: (nq,); `forces`: (links, 6), forces before moments.
        Result: `GeneralizedForces`: `tau` (nv,), `dtau_dq` (nv, nv). Several states have one more
        axis, the first.
        """
    def inverse_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: InverseDynamicsDerivatives | None = None
    ) -> InverseDynamicsDerivatives:
        """Returns the derivatives of inverse dynamics with respect to `q` (in tangent space) and `qd`.
        The derivative with respect to `qdd` is the mass matrix.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
        Result: `InverseDynamicsDerivatives`: `dtau_dq` (nv, nv), `dtau_dqd` (nv, nv). Several
        states have one more axis, the first.
        """
    def forward_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, *, out: ForwardDynamicsDerivatives | None = None
    ) -> ForwardDynamicsDerivatives:
        """Returns the joint accelerations, and the derivatives of forward dynamics with respect to `q`
        (in tangent space), `qd` and `tau`.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,).
        Result: `ForwardDynamicsDerivatives`: `qdd` (nv,), `dqdd_dq` (nv, nv), `dqdd_dqd` (nv, nv),
        `dqdd_dtau` (nv, nv). Several states have one more axis, the first.
        """
    def inverse_dynamics_vjp(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, cotangent: ArrayLike, *, out: InverseDynamicsVjp | None = None
    ) -> InverseDynamicsVjp:
        """Returns the joint forces tau of `qdd`, and the products of `cotangent` with their
        derivatives: the gradients of `cotangent`^T tau with respect to `q` (in tangent space), `qd`
        and `qdd`.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `cotangent`: (nv,).
        Result: `InverseDynamicsVjp`: `tau` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_qdd`
        (nv,). Several states have one more axis, the first.
        """
    def inverse_dynamics_jvp(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, tangent_q: ArrayLike, tangent_qd: ArrayLike, tangent_qdd: ArrayLike, *, out: InverseDynamicsJvp | None = None
    ) -> InverseDynamicsJvp:
        """Returns the joint forces tau of `qdd`, and their change under the changes `tangent_q` (in
        tangent space), `tangent_qd` and `tangent_qdd`.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,);
        `tangent_qdd`: (nv,).
        Result: `InverseDynamicsJvp`: `tau` (nv,), `tangent_tau` (nv,). Several states have one more
        axis, the first.
        """
    def forward_dynamics_vjp(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, cotangent: ArrayLike, *, out: ForwardDynamicsVjp | None = None
    ) -> ForwardDynamicsVjp:
        """Returns the accelerations qdd, and the products of `cotangent` with their derivatives: the
        gradients of `cotangent`^T qdd with respect to `q` (in tangent space), `qd` and `tau`.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `cotangent`: (nv,).
        Result: `ForwardDynamicsVjp`: `qdd` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_tau`
        (nv,). Several states have one more axis, the first.
        """
    def forward_dynamics_jvp(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, tangent_q: ArrayLike, tangent_qd: ArrayLike, tangent_tau: ArrayLike, *, out: ForwardDynamicsJvp | None = None
    ) -> ForwardDynamicsJvp:
        """Returns the accelerations qdd, and their change under the changes `tangent_q` (in tangent
        space), `tangent_qd` and `tangent_tau`.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,);
        `tangent_tau`: (nv,).
        Result: `ForwardDynamicsJvp`: `qdd` (nv,), `tangent_qdd` (nv,). Several states have one more
        axis, the first.
        """
    def inverse_dynamics_hessian(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, cotangent: ArrayLike, *, out: InverseDynamicsHessian | None = None
    ) -> InverseDynamicsHessian:
        """Returns the joint forces tau of `qdd`, and the gradients and the Hessian of `cotangent`^T
        tau with respect to `q` (in tangent space), `qd` and `qdd`. The blocks of `qd` and `qdd` and
        of `qdd` and `qdd` are zero.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `cotangent`: (nv,).
        Result: `InverseDynamicsHessian`: `tau` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_qdd`
        (nv,), `hess_q_q` (nv, nv), `hess_q_qd` (nv, nv), `hess_qd_qd` (nv, nv), `hess_q_qdd` (nv,
        nv). Several states have one more axis, the first.
        """
    def forward_dynamics_hessian(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, cotangent: ArrayLike, *, out: ForwardDynamicsHessian | None = None
    ) -> ForwardDynamicsHessian:
        """Returns the accelerations qdd, and the gradients and the Hessian of `cotangent`^T qdd with
        respect to `q` (in tangent space), `qd` and `tau`. The blocks of `qd` and `tau` and of `tau`
        and `tau` are zero.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `cotangent`: (nv,).
        Result: `ForwardDynamicsHessian`: `qdd` (nv,), `grad_q` (nv,), `grad_qd` (nv,), `grad_tau`
        (nv,), `hess_q_q` (nv, nv), `hess_q_qd` (nv, nv), `hess_qd_qd` (nv, nv), `hess_q_tau` (nv,
        nv). Several states have one more axis, the first.
        """
    def step_semi_implicit(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: Step | None = None
    ) -> Step:
        """Returns the state after the time `dt` (s) under the joint forces `tau`, by the semi-implicit
        Euler method: the new velocities are `qd` + `dt` qdd, and move the coordinates.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `Step`: `q` (nq,), `qd` (nv,). Several states have one more axis, the first.
        """
    def step_semi_implicit_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: StepDerivatives | None = None
    ) -> StepDerivatives:
        """Returns the state after the time `dt` (s) by the semi-implicit Euler method, and its
        derivatives: `a` with respect to the state before and `b` with respect to `tau`. A state has
        the entries of q (in tangent space), then the entries of qd.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `StepDerivatives`: `q` (nq,), `qd` (nv,), `a` (2 nv, 2 nv), `b` (2 nv, nv). Several
        states have one more axis, the first.
        """
    def knot(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: Knot | None = None
    ) -> Knot:
        """Returns a knot of optimal control: the velocities after a step of the time `dt` (s) by the
        semi-implicit Euler method, and the derivatives of the step in blocks, by rows. The
        derivatives of the velocities are with respect to `q` (in tangent space), `qd` and `tau`.
        The coordinates after the step are `integrate` of `q` and v, with v = `dt` times these
        velocities. Their derivatives with respect to `q` and v are 1, except for a 6 x 6 block at
        each quaternion, such as the quaternion of a floating base. A spherical joint has the
        angular part of its block.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `Knot`: `qd` (nv,), `dqd_dq` (nv, nv), `dqd_dqd` (nv, nv), `dqd_dtau` (nv, nv),
        `dq_dq` (quaternions, 6, 6), `dq_dv` (quaternions, 6, 6). Several states have one more axis,
        the first.
        """
    def step_semi_implicit_hessian(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, state_cotangent: ArrayLike, *, out: StepHessian | None = None
    ) -> StepHessian:
        """Returns the state after the time `dt` (s) by the semi-implicit Euler method, and the
        gradients and the Hessian of `state_cotangent`^T state: `grad_x` and `grad_tau` with respect
        to the state before and `tau`, and `hess_x_x`, `hess_x_tau` and `hess_tau_tau`. A state has
        the entries of q (in tangent space), then the entries of qd. Displacements of the state
        after the step are in tangent space, too.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `state_cotangent`: (2
        nv,).
        Result: `StepHessian`: `q` (nq,), `qd` (nv,), `grad_x` (2 nv,), `grad_tau` (nv,), `hess_x_x`
        (2 nv, 2 nv), `hess_x_tau` (2 nv, nv), `hess_tau_tau` (nv, nv). Several states have one more
        axis, the first.
        """
    def step_rk4(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: Step | None = None
    ) -> Step:
        """Returns the state after the time `dt` (s) under the constant joint forces `tau`, by a
        Runge-Kutta method of fourth order. Rotations follow exponential maps, so quaternions keep
        length 1.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `Step`: `q` (nq,), `qd` (nv,). Several states have one more axis, the first.
        """
    def step_rk4_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: StepDerivatives | None = None
    ) -> StepDerivatives:
        """Returns the state of `step_rk4`, and its derivatives: `a` with respect to the state before
        and `b` with respect to `tau`. A state has the entries of q (in tangent space), then the
        entries of qd.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `StepDerivatives`: `q` (nq,), `qd` (nv,), `a` (2 nv, 2 nv), `b` (2 nv, nv). Several
        states have one more axis, the first.
        """
    def step_implicit_midpoint(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: Step | None = None
    ) -> Step:
        """Returns the state after the time `dt` (s) under the constant joint forces `tau`, by the
        implicit midpoint rule: of second order, symmetric, and stable under stiff damping. Three
        iterations of simplified Newton solve its equations. Rotations follow exponential maps, so
        quaternions keep length 1.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `Step`: `q` (nq,), `qd` (nv,). Several states have one more axis, the first.
        """
    def step_implicit_midpoint_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, *, out: StepDerivatives | None = None
    ) -> StepDerivatives:
        """Returns the state of `step_implicit_midpoint`, and the derivatives of the implicit midpoint
        rule: `a` with respect to the state before and `b` with respect to `tau`. A state has the
        entries of q (in tangent space), then the entries of qd.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number.
        Result: `StepDerivatives`: `q` (nq,), `qd` (nv,), `a` (2 nv, 2 nv), `b` (2 nv, nv). Several
        states have one more axis, the first.
        """
    def constrained_forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstrainedForwardDynamics | None = None
    ) -> ConstrainedForwardDynamics:
        """Returns the joint accelerations under the joint forces `tau` with the loops closed and the
        active contacts held. Also returns the wrench on each constraint's link and the unmet part
        of the constraint's acceleration, and the number of independent constraint rows. Loop
        constraints come first, in the order of `loop_constraint_names`, at the second frame's
        origin in the first frame's axes. Contacts follow, in the order of `contact_names`, at the
        frame's origin in world axes. Redundant rows get the multipliers of smallest norm.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `active`: the names of the active
        contacts, or (contacts,), 1 for each active one, else 0; by default all are; `settings`:
        `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ConstrainedForwardDynamics`: `qdd` (nv,), `wrenches` (constraints, 6), `residuals`
        (constraints, 6), `rank` a number, linear before angular components. Several states have one
        more axis, the first.
        """
    def constraint_residual(
        self, q: ArrayLike, qd: ArrayLike, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstraintResidual | None = None
    ) -> ConstraintResidual:
        """Returns the displacement and the velocity of each loop constraint's second frame relative to
        its first, in the first frame's axes; then of each contact's frame, active or not, relative
        to its target, in world axes. Components along free directions are zero. A rotation is its
        axis times the sine of its angle.

        Arguments: `q`: (nq,); `qd`: (nv,); `settings`: `ConstraintSettings`, by default with the
        ground at z = 0 under all contacts.
        Result: `ConstraintResidual`: `displacements` (constraints, 6), `velocities` (constraints,
        6), linear before angular components. Several states have one more axis, the first.
        """
    def project_constraints(
        self, q: ArrayLike, qd: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstraintProjection | None = None
    ) -> ConstraintProjection:
        """Returns the smallest step (in the metric of the mass matrix) that closes the loops at `q`
        and moves the active contacts to their targets to first order, the smallest change of `qd`
        that keeps them there, and the number of independent constraint rows. The settings `alpha`
        and `beta` have no effect.

        Arguments: `q`: (nq,); `qd`: (nv,); `active`: the names of the active contacts, or
        (contacts,), 1 for each active one, else 0; by default all are; `settings`:
        `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ConstraintProjection`: `step_q` (nv,), `step_qd` (nv,), `rank` a number. Several
        states have one more axis, the first.
        """
    def constrained_forward_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstrainedForwardDynamicsDerivatives | None = None
    ) -> ConstrainedForwardDynamicsDerivatives:
        """Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and their
        derivatives with respect to `q` (in tangent space), `qd` and `tau`. The derivatives of
        wrenches are arrays for each constraint, in the axes of the wrenches. The rank is assumed
        constant; redundant rows get the derivatives of smallest norm.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `active`: the names of the active
        contacts, or (contacts,), 1 for each active one, else 0; by default all are; `settings`:
        `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ConstrainedForwardDynamicsDerivatives`: `qdd` (nv,), `wrenches` (constraints, 6),
        `dqdd_dq` (nv, nv), `dqdd_dqd` (nv, nv), `dqdd_dtau` (nv, nv), `dwrenches_dq` (constraints,
        6, nv), `dwrenches_dqd` (constraints, 6, nv), `dwrenches_dtau` (constraints, 6, nv), `rank`
        a number, forces before moments. Several states have one more axis, the first.
        """
    def constrained_knot(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstrainedKnot | None = None
    ) -> ConstrainedKnot:
        """Returns the results of `knot` under the accelerations of `constrained_forward_dynamics`, and
        the wrenches of the constraints with their derivatives, which
        `constrained_forward_dynamics_derivatives` describes.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `active`: the names of the
        active contacts, or (contacts,), 1 for each active one, else 0; by default all are;
        `settings`: `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ConstrainedKnot`: `qd` (nv,), `wrenches` (constraints, 6), `dqd_dq` (nv, nv),
        `dqd_dqd` (nv, nv), `dqd_dtau` (nv, nv), `dq_dq` (quaternions, 6, 6), `dq_dv` (quaternions,
        6, 6), `dwrenches_dq` (constraints, 6, nv), `dwrenches_dqd` (constraints, 6, nv),
        `dwrenches_dtau` (constraints, 6, nv), `rank` a number, forces before moments. Several
        states have one more axis, the first.
        """
    def constrained_forward_dynamics_hessian(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, cotangent: ArrayLike, wrench_cotangent: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstrainedForwardDynamicsHessian | None = None
    ) -> ConstrainedForwardDynamicsHessian:
        """Returns the accelerations and the wrenches of `constrained_forward_dynamics`, and the
        gradients and the Hessian of their sum with the weights `cotangent` and `wrench_cotangent`
        (of the components of the wrenches) with respect to `q` (in tangent space), `qd` and `tau`.
        The blocks of `qd` and `tau` and of `tau` and `tau` are zero. The rank is assumed constant.
        Weights of wrenches need independent rows, or compliance.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `cotangent`: (nv,); `wrench_cotangent`:
        (constraints, 6), forces before moments; `active`: the names of the active contacts, or
        (contacts,), 1 for each active one, else 0; by default all are; `settings`:
        `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ConstrainedForwardDynamicsHessian`: `qdd` (nv,), `wrenches` (constraints, 6),
        `grad_q` (nv,), `grad_qd` (nv,), `grad_tau` (nv,), `hess_q_q` (nv, nv), `hess_q_qd` (nv,
        nv), `hess_qd_qd` (nv, nv), `hess_q_tau` (nv, nv), `rank` a number, forces before moments.
        Several states have one more axis, the first.
        """
    def impact_dynamics(
        self, q: ArrayLike, qd: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ImpactDynamics | None = None
    ) -> ImpactDynamics:
        """Returns the velocities after an impact that closes the loops and stops the active contacts
        relative to their targets at the same instant, the impulse of each constraint, and the
        number of independent constraint rows. Along its normal, a contact leaves with `restitution`
        times the speed before the impact. The settings `alpha` and `beta` have no effect.

        Arguments: `q`: (nq,); `qd`: (nv,); `active`: the names of the active contacts, or
        (contacts,), 1 for each active one, else 0; by default all are; `settings`:
        `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ImpactDynamics`: `qd` (nv,), `impulses` (constraints, 6), `rank` a number, forces
        before moments. Several states have one more axis, the first.
        """
    def step(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: StepSolution | None = None
    ) -> StepSolution:
        """Returns the state after a step of the time `dt` (s) under the joint forces `tau`, with
        contacts, joint limits, dry joint friction and closed loops by MuJoCo's law: soft
        constraints whose forces minimize a convex function. The solver is Newton's method, to the
        tolerance of `settings`; `residual` says how far it came, relative to the largest force. It
        starts from the accelerations `warm_start`: `qdd` of the last step, or zeros. The integrator
        is semi-implicit Euler, implicit in joint damping, or MuJoCo's `implicitfast`, as the
        description says.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `warm_start`: (nv,), by
        default zeros; `settings`: `StepSettings`, by default the result of `step_settings()`.
        Result: `StepSolution`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
        `residual` a number, `iterations` a number. Several states have one more axis, the first.
        """
    def step_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: LinearizedStep | None = None
    ) -> LinearizedStep:
        """Returns the results of `step`, and the derivatives of the state after it: `a` with respect
        to the state before and `b` with respect to `tau`. A state has the entries of q (in tangent
        space), then the entries of qd. The derivatives follow from the implicit function theorem at
        the solution; where a contact opens or closes, or a point begins to slide, they are
        one-sided.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `warm_start`: (nv,), by
        default zeros; `settings`: `StepSettings`, by default the result of `step_settings()`.
        Result: `LinearizedStep`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
        `a` (2 nv, 2 nv), `b` (2 nv, nv), `residual` a number, `iterations` a number. Several states
        have one more axis, the first.
        """
    def step_vjp(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, dt: ArrayLike, state_cotangent: ArrayLike, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: StepVjp | None = None
    ) -> StepVjp:
        """Returns the results of `step`, and the gradients of `state_cotangent`^T state after it:
        `grad_x` with respect to the state before, and `grad_tau`. A state has the entries of q (in
        tangent space), then the entries of qd. At kinks they are as in `step_derivatives`.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `dt`: a number; `state_cotangent`: (2
        nv,); `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the
        result of `step_settings()`.
        Result: `StepVjp`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
        `grad_x` (2 nv,), `grad_tau` (nv,), `residual` a number, `iterations` a number. Several
        states have one more axis, the first.
        """
    def step_jvp(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, tangent_q: ArrayLike, tangent_qd: ArrayLike, tangent_tau: ArrayLike, dt: ArrayLike, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: StepJvp | None = None
    ) -> StepJvp:
        """Returns the results of `step`, and the change `tangent_x` of the state after it under the
        changes `tangent_q` (in tangent space), `tangent_qd` and `tangent_tau`. A state has the
        entries of q (in tangent space), then the entries of qd. At kinks it is as in
        `step_derivatives`.

        Arguments: `q`: (nq,); `qd`: (nv,); `tau`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,);
        `tangent_tau`: (nv,); `dt`: a number; `warm_start`: (nv,), by default zeros; `settings`:
        `StepSettings`, by default the result of `step_settings()`.
        Result: `StepJvp`: `q` (nq,), `qd` (nv,), `qdd` (nv,), `forces` (touching points, 3),
        `tangent_x` (2 nv,), `residual` a number, `iterations` a number. Several states have one
        more axis, the first.
        """
    def touching_points(
        self, q: ArrayLike, qd: ArrayLike, settings: StepSettings | ArrayLike | None = None, *, out: TouchingPoints | None = None
    ) -> TouchingPoints:
        """Returns the points of the shapes that can touch the ground, in the order of the `forces` of
        `step`: the heights `gaps` above the ground (m; negative in it), the `positions` in the
        middle between the shape and the ground (m, world axes), and the `velocities` of the link
        there, along the x and y axes of the plane, then along its normal (m/s).

        Arguments: `q`: (nq,); `qd`: (nv,); `settings`: `StepSettings`, by default the result of
        `step_settings()`.
        Result: `TouchingPoints`: `gaps` (touching points,), `positions` (touching points, 3),
        `velocities` (touching points, 3). Several states have one more axis, the first.
        """
    def actuate(
        self, q: ArrayLike, qd: ArrayLike, ctrl: ArrayLike, dt: ArrayLike, act: ArrayLike | None = None, *, out: ActuatorForces | None = None
    ) -> ActuatorForces:
        """Returns the joint forces `tau` of the actuators under the controls `ctrl`, in the order of
        `control_names`, and the activations after the time `dt` (s), in the order of
        `activation_names`. The laws are MuJoCo's: controls, forces, activations and joint forces
        are clamped to the ranges of the description.

        Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `act`:
        (activations,), which a robot without activations leaves out.
        Result: `ActuatorForces`: `tau` (nv,), `act` (activations,). Several states have one more
        axis, the first.
        """
    def step_actuated(
        self, q: ArrayLike, qd: ArrayLike, ctrl: ArrayLike, dt: ArrayLike, act: ArrayLike | None = None, applied: ArrayLike | None = None, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: ActuatedStep | None = None
    ) -> ActuatedStep:
        """Returns the state and the activations after a step of the time `dt` (s) under the controls
        `ctrl`: MuJoCo's `mj_step`. The joint forces are the result of `actuate` at the state before
        the step, and the forces `applied` beside it (MuJoCo's `qfrc_applied`). All else is as in
        `step`.

        Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `act`:
        (activations,), which a robot without activations leaves out; `applied`: (nv,), by default
        zeros; `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the
        result of `step_settings()`.
        Result: `ActuatedStep`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,), `forces`
        (touching points, 3), `residual` a number, `iterations` a number. Several states have one
        more axis, the first.
        """
    def step_actuated_derivatives(
        self, q: ArrayLike, qd: ArrayLike, ctrl: ArrayLike, dt: ArrayLike, act: ArrayLike | None = None, applied: ArrayLike | None = None, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: LinearizedActuatedStep | None = None
    ) -> LinearizedActuatedStep:
        """Returns the results of `step_actuated`, and the derivatives of the state after it: `a` with
        respect to the state before and `b` with respect to `ctrl`. A state has the entries of q (in
        tangent space), the entries of qd, then `act`. All else is as in `step_derivatives`.

        Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `act`:
        (activations,), which a robot without activations leaves out; `applied`: (nv,), by default
        zeros; `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the
        result of `step_settings()`.
        Result: `LinearizedActuatedStep`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,),
        `forces` (touching points, 3), `a` (2 nv + activations, 2 nv + activations), `b` (2 nv +
        activations, controls), `residual` a number, `iterations` a number. Several states have one
        more axis, the first.
        """
    def step_actuated_vjp(
        self, q: ArrayLike, qd: ArrayLike, ctrl: ArrayLike, dt: ArrayLike, state_cotangent: ArrayLike, act: ArrayLike | None = None, act_cotangent: ArrayLike | None = None, applied: ArrayLike | None = None, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: ActuatedStepVjp | None = None
    ) -> ActuatedStepVjp:
        """Returns the results of `step_actuated`, and the gradients of `state_cotangent`^T state +
        `act_cotangent`^T act after it: `grad_x` with respect to the state before, and `grad_ctrl`.
        The state of `grad_x` has the entries of q (in tangent space), the entries of qd, then
        `act`. At kinks they are as in `step_derivatives`.

        Arguments: `q`: (nq,); `qd`: (nv,); `ctrl`: (controls,); `dt`: a number; `state_cotangent`:
        (2 nv,); `act`: (activations,), which a robot without activations leaves out;
        `act_cotangent`: (activations,), by default zeros; `applied`: (nv,), by default zeros;
        `warm_start`: (nv,), by default zeros; `settings`: `StepSettings`, by default the result of
        `step_settings()`.
        Result: `ActuatedStepVjp`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,),
        `forces` (touching points, 3), `grad_x` (2 nv + activations,), `grad_ctrl` (controls,),
        `residual` a number, `iterations` a number. Several states have one more axis, the first.
        """
    def step_actuated_jvp(
        self, q: ArrayLike, qd: ArrayLike, tangent_q: ArrayLike, tangent_qd: ArrayLike, ctrl: ArrayLike, tangent_ctrl: ArrayLike, dt: ArrayLike, act: ArrayLike | None = None, tangent_act: ArrayLike | None = None, applied: ArrayLike | None = None, warm_start: ArrayLike | None = None, settings: StepSettings | ArrayLike | None = None, *, out: ActuatedStepJvp | None = None
    ) -> ActuatedStepJvp:
        """Returns the results of `step_actuated`, and the change `tangent_x` of the state after it
        under the changes `tangent_q` (in tangent space), `tangent_qd`, `tangent_ctrl` and
        `tangent_act`. The state of `tangent_x` has the entries of q (in tangent space), the entries
        of qd, then `act`. At kinks it is as in `step_derivatives`.

        Arguments: `q`: (nq,); `qd`: (nv,); `tangent_q`: (nv,); `tangent_qd`: (nv,); `ctrl`:
        (controls,); `tangent_ctrl`: (controls,); `dt`: a number; `act`: (activations,), which a
        robot without activations leaves out; `tangent_act`: (activations,), by default zeros;
        `applied`: (nv,), by default zeros; `warm_start`: (nv,), by default zeros; `settings`:
        `StepSettings`, by default the result of `step_settings()`.
        Result: `ActuatedStepJvp`: `q` (nq,), `qd` (nv,), `act` (activations,), `qdd` (nv,),
        `forces` (touching points, 3), `tangent_x` (2 nv + activations,), `residual` a number,
        `iterations` a number. Several states have one more axis, the first.
        """
    def constrained_inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: ConstrainedInverseDynamics | None = None
    ) -> ConstrainedInverseDynamics:
        """Returns the joint forces of the accelerations `qdd`, the wrenches of the active contacts
        that carry the floating bases, and the rank of the contacts' columns of the bases. The
        wrenches have the smallest sum of (force^2 + (moment / l)^2) / weight with the
        characteristic length l of each contact. The joint forces of a base are the wrench on it
        that no contact can carry. The wrenches of loop constraints are zero.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `active`: the names of the active
        contacts, or (contacts,), 1 for each active one, else 0; by default all are; `settings`:
        `ConstraintSettings`, by default with the ground at z = 0 under all contacts.
        Result: `ConstrainedInverseDynamics`: `tau` (nv,), `wrenches` (constraints, 6), `rank` a
        number, forces before moments. Several states have one more axis, the first.
        """
    def constraint_jacobian(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the Jacobian of each constraint. The product with `qd` is, for a loop constraint,
        the constrained part of the twist of its second frame relative to its first, in the first
        frame's axes; for a contact, active or not, the constrained part of its frame's twist in
        world axes.

        Arguments: `q`: (nq,).
        Result: (constraints, 6, nv), linear before angular components. Several states have one more
        axis, the first.
        """
    def constraint_jacobian_dot_qd(
        self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the bias acceleration of each constraint: the time derivative of
        `constraint_jacobian` times `qd`, in the same axes.

        Arguments: `q`: (nq,); `qd`: (nv,).
        Result: (constraints, 6), linear before angular components. Several states have one more
        axis, the first.
        """
    def operational_space_inertia(
        self, q: ArrayLike, active: ArrayLike | None = None, settings: ConstraintSettings | ArrayLike | None = None, *, out: OperationalSpaceInertia | None = None
    ) -> OperationalSpaceInertia:
        """Returns the Delassus matrix J M^-1 J^T of the constraints with the mass matrix M, its
        pseudo-inverse, the operational-space inertia, and the number of independent constraint
        rows. Each constraint has its constrained displacements, then its constrained rotations, of
        a contact in world axes. The entries of inactive contacts are zero. The Delassus matrix
        contains the compliance.

        Arguments: `q`: (nq,); `active`: the names of the active contacts, or (contacts,), 1 for
        each active one, else 0; by default all are; `settings`: `ConstraintSettings`, by default
        with the ground at z = 0 under all contacts.
        Result: `OperationalSpaceInertia`: `delassus` (constraint rows, constraint rows), `inertia`
        (constraint rows, constraint rows), `rank` a number. Several states have one more axis, the
        first.
        """
    def regressor(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the regressor Y of inverse dynamics: tau = Y pi, without armatures and friction. pi
        has ten entries for each moving link: mass, mass times centre of mass x, y, z, and Ixx, Ixy,
        Ixz, Iyy, Iyz, Izz about the link's origin in the link's own axes (`parameters`).

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
        Result: (nv, 10 moving links). Several states have one more axis, the first.
        """
    def center_of_mass(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the centre of mass of the moving links in world axes, m.

        Arguments: `q`: (nq,).
        Result: (3,). Several states have one more axis, the first.
        """
    def center_of_mass_jacobian(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the Jacobian of the centre of mass. Its product with `qd` is the velocity of the
        centre of mass in world axes.

        Arguments: `q`: (nq,).
        Result: (3, nv). Several states have one more axis, the first.
        """
    def centroidal_momentum_matrix(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the centroidal momentum matrix. Its product with `qd` is the momentum about the
        centre of mass, in world axes. Armatures have energy, but no momentum: their axes are not
        described.

        Arguments: `q`: (nq,).
        Result: (6, nv), linear before angular components. Several states have one more axis, the
        first.
        """
    def centroidal_composite_inertia(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the centroidal composite inertia. Its product with a twist is the momentum about the
        centre of mass, in world axes, of all moving links as one rigid body with this twist at the
        centre of mass.

        Arguments: `q`: (nq,).
        Result: (6, 6), linear before angular components. Several states have one more axis, the
        first.
        """
    def centroidal_momentum(
        self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the momentum of the moving links about their centre of mass, in world axes.
        Armatures have energy, but no momentum: their axes are not described.

        Arguments: `q`: (nq,); `qd`: (nv,).
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def centroidal_momentum_rate(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the time derivative of the centroidal momentum in world axes: the moment (N m) and
        the force (N) about the centre of mass of gravity and of all forces from outside. At `qdd` =
        0 it is the bias A' qd, with the centroidal momentum matrix A.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def centroidal_momentum_derivatives(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: CentroidalMomentumDerivatives | None = None
    ) -> CentroidalMomentumDerivatives:
        """Returns the momentum of the moving links about their centre of mass, its time derivative at
        `qdd` (the rate), and the derivatives of both with respect to `q` (in tangent space) and
        `qd`, in world axes. The derivatives of the momentum with respect to `qd`, and of the rate
        with respect to `qdd`, are the centroidal momentum matrix.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,).
        Result: `CentroidalMomentumDerivatives`: `momentum` (6,), `rate` (6,), `dmomentum_dq` (6,
        nv), `drate_dq` (6, nv), `drate_dqd` (6, nv), linear before angular components. Several
        states have one more axis, the first.
        """
    def link_poses(
        self, q: ArrayLike, *, out: Pose | None = None
    ) -> Pose:
        """Returns the poses in the world of all links of the description, fixed links included, in the
        order of `link_names`.

        Arguments: `q`: (nq,).
        Result: `Pose`: `rotation` (links, 3, 3), `translation` (links, 3). Several states have one
        more axis, the first.
        """
    def link_pose(
        self, q: ArrayLike, link: str | int, *, out: Pose | None = None
    ) -> Pose:
        """Returns the pose of a link in the world. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `link`: the name of a link, or its index in `link_names`.
        Result: `Pose`: `rotation` (3, 3), `translation` (3,). Several states have one more axis,
        the first.
        """
    def link_velocity(
        self, q: ArrayLike, qd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in world
        axes. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
        `link_names`.
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def link_velocity_local(
        self, q: ArrayLike, qd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the velocity of a link's origin (m/s) and its angular velocity (rad/s), in the
        link's own axes. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
        `link_names`.
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def link_acceleration(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
        (rad/s^2), in world axes. Gravity is not included. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `link`: the name of a link, or its index
        in `link_names`.
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def link_acceleration_local(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the classical acceleration of a link's origin (m/s^2) and its angular acceleration
        (rad/s^2), in the link's own axes. Gravity is not included. Computes the link's kinematic
        path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `qdd`: (nv,); `link`: the name of a link, or its index
        in `link_names`.
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def jacobian(
        self, q: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the Jacobian of a link. Its product with `qd` is the velocity of the link at its
        origin, in world axes. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `link`: the name of a link, or its index in `link_names`.
        Result: (6, nv), linear before angular components. Several states have one more axis, the
        first.
        """
    def jacobian_local(
        self, q: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the Jacobian of a link. Its product with `qd` is the velocity of the link at its
        origin, in the link's own axes. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `link`: the name of a link, or its index in `link_names`.
        Result: (6, nv), linear before angular components. Several states have one more axis, the
        first.
        """
    def jacobian_time_derivative(
        self, q: ArrayLike, qd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the time derivative of `jacobian`. Its product with `qd` is `jacobian_dot_qd`.
        Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
        `link_names`.
        Result: (6, nv), linear before angular components. Several states have one more axis, the
        first.
        """
    def jacobian_time_derivative_local(
        self, q: ArrayLike, qd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the time derivative of `jacobian_local`. Its product with `qd` is
        `jacobian_dot_qd_local`. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
        `link_names`.
        Result: (6, nv), linear before angular components. Several states have one more axis, the
        first.
        """
    def jacobian_dot_qd(
        self, q: ArrayLike, qd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the bias acceleration of a link in world axes: the time derivative of `jacobian`
        times `qd`, which is the link's acceleration at zero joint accelerations. Computes the
        link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
        `link_names`.
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def jacobian_dot_qd_local(
        self, q: ArrayLike, qd: ArrayLike, link: str | int, *, out: Array | None = None
    ) -> Array:
        """Returns the bias acceleration of a link in its own axes: the time derivative of
        `jacobian_local` times `qd`. Computes the link's kinematic path only.

        Arguments: `q`: (nq,); `qd`: (nv,); `link`: the name of a link, or its index in
        `link_names`.
        Result: (6,), linear before angular components. Several states have one more axis, the
        first.
        """
    def integrate(
        self, q: ArrayLike, v: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the coordinates after the displacement `v` (a velocity times a time) from `q`.

        Arguments: `q`: (nq,); `v`: (nv,).
        Result: (nq,). Several states have one more axis, the first.
        """
    def difference(
        self, from_: ArrayLike, to: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the displacement `v` with which `integrate` leads from `from_` to `to`. Rotations
        are the shortest ones; joint angles are not wrapped.

        Arguments: `from_`: (nq,); `to`: (nq,).
        Result: (nv,). Several states have one more axis, the first.
        """
    def integrate_derivatives(
        self, q: ArrayLike, v: ArrayLike, *, out: IntegrateDerivatives | None = None
    ) -> IntegrateDerivatives:
        """Returns the derivatives of `integrate` with respect to `q` and `v` in tangent space:
        displacements of `q` and of the result are in the axes at each of them.

        Arguments: `q`: (nq,); `v`: (nv,).
        Result: `IntegrateDerivatives`: `dq_dq` (nv, nv), `dq_dv` (nv, nv). Several states have one
        more axis, the first.
        """
    def difference_derivatives(
        self, from_: ArrayLike, to: ArrayLike, *, out: DifferenceDerivatives | None = None
    ) -> DifferenceDerivatives:
        """Returns the derivatives of `difference` with respect to `from_` and `to` in tangent space:
        displacements are in the axes at `from_` and at `to`.

        Arguments: `from_`: (nq,); `to`: (nq,).
        Result: `DifferenceDerivatives`: `dv_dfrom` (nv, nv), `dv_dto` (nv, nv). Several states have
        one more axis, the first.
        """
    def velocity_to_qdot(
        self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns dq/dt, the rates of the coordinates `q` at the velocities `qd`.

        Arguments: `q`: (nq,); `qd`: (nv,).
        Result: (nq,). Several states have one more axis, the first.
        """
    def normalize_configuration(
        self, q: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns the coordinates with quaternions scaled to length 1.

        Arguments: `q`: (nq,).
        Result: (nq,). Several states have one more axis, the first.
        """
    def random_configuration(
        self, uniforms: ArrayLike, *, out: Array | None = None
    ) -> Array:
        """Returns coordinates within the joint limits, from random numbers uniformly distributed in
        [0, 1). Angles without limits are in [-pi, pi), displacements without limits in [-1, 1) m,
        rotations uniform over SO(3).

        Arguments: `uniforms`: (nv,).
        Result: (nq,). Several states have one more axis, the first.
        """
    # <!-- end -->
