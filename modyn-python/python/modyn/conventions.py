"""States of Pinocchio and MuJoCo, to and from modyn's.

    theirs = modyn.conventions.Pinocchio(robot, pinocchio_model)
    pinocchio.aba(pinocchio_model, data, theirs.to_q(q), theirs.to_v(qd), theirs.to_v(tau))

Joints are found by their names; the floating base of a robot is the free joint of the other model. All functions take one
state, or n states as rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _modyn
from ._modyn import Robot

Array = NDArray[np.float64]
# Numbers of states as rows, and the columns of each joint.
_Part = tuple[Array, list[slice]]
_Convert = Callable[..., Array]


def _rows(name: str, numbers: ArrayLike, length: int) -> Array:
    """Returns the numbers of states as rows."""
    rows = np.atleast_2d(np.asarray(numbers, float))
    if rows.ndim != 2 or rows.shape[1] != length:
        shape = np.shape(numbers)
        raise ValueError(f"`{name}` has the shape {shape}; expected ({length},), or (n, {length}) for n states")
    return rows


def _like(rows: Array, numbers: ArrayLike) -> Array:
    """Returns the rows, or the only row if the numbers are those of one state."""
    return rows if np.ndim(numbers) == 2 else rows[0]


def _block(rows: Array, places: slice) -> Array:
    """Returns some columns as an array of their own."""
    return np.ascontiguousarray(rows[:, places])


class Pinocchio:
    """The states of a `pinocchio.Model` of the same robot.

    Velocities, accelerations and joint forces differ from modyn's in their order alone. So do coordinates, except that a
    continuous joint has a cosine and a sine there. Planar joints have no conversion.
    """

    def __init__(self, robot: Robot, model: Any) -> None:
        self._nq, self._nv = robot.nq, robot.nv
        self._model_nq, self._model_nv = model.nq, model.nv
        names = list(model.names)[1:]
        floating = [name for name, joint in zip(names, list(model.joints)[1:]) if joint.nq == 7]
        self._joints = []
        for joint in robot.joints:
            if joint.type == "planar":
                raise ValueError(f"joint `{joint.name}`: there is no conversion of planar joints")
            name = joint.name
            if joint.type == "floating" and name not in names and len(floating) == 1:
                name = floating[0]
            if name not in names:
                raise ValueError(f"Pinocchio's model has no joint `{joint.name}`")
            names.remove(name)
            their = model.joints[model.getJointId(name)]
            q = slice(their.idx_q, their.idx_q + their.nq)
            v = slice(their.idx_v, their.idx_v + their.nv)
            self._joints.append((joint.q, q, joint.v, v))
        if names:
            raise ValueError(f"the robot has no coordinates of Pinocchio's joint `{names[0]}`")

    def to_q(self, q: ArrayLike) -> Array:
        """Returns Pinocchio's coordinates, from modyn's, (nq,)."""
        rows = _rows("q", q, self._nq)
        theirs = np.zeros((len(rows), self._model_nq))
        for own, their, _, _ in self._joints:
            block = _block(rows, own)
            is_unbounded = their.stop - their.start == 2 and block.shape[1] == 1
            theirs[:, their] = _modyn.pinocchio_cos_sin(block) if is_unbounded else block
        return _like(theirs, q)

    def from_q(self, q: ArrayLike) -> Array:
        """Returns modyn's coordinates, (nq,), from Pinocchio's."""
        rows = _rows("q", q, self._model_nq)
        own = np.zeros((len(rows), self._nq))
        for places, their, _, _ in self._joints:
            block = _block(rows, their)
            is_unbounded = block.shape[1] == 2 and places.stop - places.start == 1
            own[:, places] = _modyn.pinocchio_angle(block) if is_unbounded else block
        return _like(own, q)

    def to_v(self, v: ArrayLike) -> Array:
        """Returns Pinocchio's velocities, accelerations or joint forces, from modyn's, (nv,)."""
        rows = _rows("v", v, self._nv)
        theirs = np.zeros((len(rows), self._model_nv))
        for _, _, own, their in self._joints:
            theirs[:, their] = rows[:, own]
        return _like(theirs, v)

    def from_v(self, v: ArrayLike) -> Array:
        """Returns modyn's velocities, accelerations or joint forces, (nv,), from Pinocchio's."""
        rows = _rows("v", v, self._model_nv)
        own = np.zeros((len(rows), self._nv))
        for _, _, places, their in self._joints:
            own[:, places] = rows[:, their]
        return _like(own, v)


class MuJoCo:
    """The states of a `mujoco.MjModel` of the same robot.

    A free joint has its quaternion as w, x, y, z there, its linear velocity in world axes and its acceleration as the
    derivative of that. A ball joint has its quaternion as w, x, y, z.
    """

    def __init__(self, robot: Robot, model: Any) -> None:
        self._nq, self._nv = robot.nq, robot.nv
        self._model_nq, self._model_nv = model.nq, model.nv
        joints = [model.joint(i) for i in range(model.njnt)]
        self._joints = []
        for joint in robot.joints:
            found = [i for i, their in enumerate(joints) if their.name == joint.name]
            free = [i for i, their in enumerate(joints) if int(their.type[0]) == 0]
            if joint.type == "floating" and not found and len(free) == 1:
                found = free
            lengths = (joint.q.stop - joint.q.start, joint.v.stop - joint.v.start)
            if not found or joint.type in ("planar", "universal"):
                raise ValueError(f"MuJoCo's model has no {joint.type} joint `{joint.name}`")
            their = joints.pop(found[0])
            q, v = int(their.qposadr[0]), int(their.dofadr[0])
            places = slice(q, q + lengths[0]), slice(v, v + lengths[1])
            self._joints.append((joint.type, joint.q, places[0], joint.v, places[1]))
        if joints:
            raise ValueError(f"the robot has no coordinates of MuJoCo's joint `{joints[0].name}`")

    def to_qpos(self, q: ArrayLike) -> Array:
        """Returns MuJoCo's `qpos`, from modyn's coordinates, (nq,)."""
        rows = _rows("q", q, self._nq)
        theirs = np.zeros((len(rows), self._model_nq))
        for kind, own, their, _, _ in self._joints:
            block = _block(rows, own)
            if kind == "floating":
                block = _modyn.mujoco_to_qpos(block)
            elif kind == "spherical":
                block = block[:, [3, 0, 1, 2]]
            theirs[:, their] = block
        return _like(theirs, q)

    def from_qpos(self, qpos: ArrayLike) -> Array:
        """Returns modyn's coordinates, (nq,), from MuJoCo's `qpos`."""
        rows = _rows("qpos", qpos, self._model_nq)
        own = np.zeros((len(rows), self._nq))
        for kind, places, their, _, _ in self._joints:
            block = _block(rows, their)
            if kind == "floating":
                block = _modyn.mujoco_from_qpos(block)
            elif kind == "spherical":
                block = block[:, [1, 2, 3, 0]]
            own[:, places] = block
        return _like(own, qpos)

    def to_qvel(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """Returns MuJoCo's `qvel`, from modyn's coordinates and velocities, (nv,)."""
        return self._to_theirs(_modyn.mujoco_to_qvel, [self._coordinates(q)], "qd", qd)

    def from_qvel(self, q: ArrayLike, qvel: ArrayLike) -> Array:
        """Returns modyn's velocities, (nv,), from modyn's coordinates and MuJoCo's `qvel`."""
        return self._from_theirs(_modyn.mujoco_from_qvel, [self._coordinates(q)], "qvel", qvel)

    def to_qacc(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Returns MuJoCo's `qacc`, from modyn's coordinates, velocities and accelerations, (nv,)."""
        state = [self._coordinates(q), self._velocities(qd)]
        return self._to_theirs(_modyn.mujoco_to_qacc, state, "qdd", qdd)

    def from_qacc(self, q: ArrayLike, qd: ArrayLike, qacc: ArrayLike) -> Array:
        """Returns modyn's accelerations, (nv,), from modyn's coordinates and velocities and MuJoCo's `qacc`."""
        state = [self._coordinates(q), self._velocities(qd)]
        return self._from_theirs(_modyn.mujoco_from_qacc, state, "qacc", qacc)

    def to_qfrc(self, q: ArrayLike, tau: ArrayLike) -> Array:
        """Returns MuJoCo's `qfrc_...`, from modyn's coordinates and joint forces, (nv,)."""
        return self.to_qvel(q, tau)

    def from_qfrc(self, q: ArrayLike, qfrc: ArrayLike) -> Array:
        """Returns modyn's joint forces, (nv,), from modyn's coordinates and MuJoCo's `qfrc_...`."""
        return self.from_qvel(q, qfrc)

    def _coordinates(self, q: ArrayLike) -> _Part:
        """Returns the coordinates of states, and where each joint has its own."""
        return _rows("q", q, self._nq), [joint[1] for joint in self._joints]

    def _velocities(self, qd: ArrayLike) -> _Part:
        """Returns the velocities of states, and where each joint has its own."""
        return _rows("qd", qd, self._nv), [joint[3] for joint in self._joints]

    def _to_theirs(self, convert: _Convert, state: list[_Part], name: str, numbers: ArrayLike) -> Array:
        """Returns MuJoCo's velocities or accelerations; `convert` does those of a floating base, at the state."""
        rows = _rows(name, numbers, self._nv)
        places = [(joint[3], joint[4]) for joint in self._joints]
        return _like(self._converted(convert, state, rows, places, self._model_nv), numbers)

    def _from_theirs(self, convert: _Convert, state: list[_Part], name: str, numbers: ArrayLike) -> Array:
        """Returns modyn's velocities or accelerations; `convert` does those of a floating base, at the state."""
        rows = _rows(name, numbers, self._model_nv)
        places = [(joint[4], joint[3]) for joint in self._joints]
        return _like(self._converted(convert, state, rows, places, self._nv), numbers)

    def _converted(
        self, convert: _Convert, state: list[_Part], rows: Array, places: list[tuple[slice, slice]], length: int
    ) -> Array:
        """Returns rows of `length` numbers: each joint's block moves from its first place to its second one."""
        moved = np.zeros((len(rows), length))
        for i, (source, target) in enumerate(places):
            block = _block(rows, source)
            if self._joints[i][0] == "floating":
                block = convert(*(_block(part, own[i]) for part, own in state), block)
            moved[:, target] = block
        return moved
