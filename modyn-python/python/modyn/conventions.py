"""States of Pinocchio and MuJoCo, to and from modyn's.

    theirs = modyn.conventions.Pinocchio(robot, pinocchio_model)
    pinocchio.aba(pinocchio_model, data, theirs.to_q(q), theirs.to_v(qd), theirs.to_v(tau))

Joints are found by their names; the floating base of a robot is the free joint of the other model. All functions take one
state, or n states as rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

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


class _Follower(NamedTuple):
    """A mimic joint that has a coordinate of its own in the other model."""

    q: int
    """the entry of its leader in modyn's coordinates"""
    v: int
    """the entry of its leader in modyn's velocities"""
    multiplier: float
    offset: float
    their_q: slice
    their_v: slice

    def coordinates(self, rows: Array) -> Array:
        """Returns its coordinates, (n, 1), from modyn's."""
        return self.multiplier * rows[:, self.q : self.q + 1] + self.offset

    def velocities(self, rows: Array) -> Array:
        """Returns its velocities, (n, 1), from modyn's."""
        return self.multiplier * rows[:, self.v : self.v + 1]


class Pinocchio:
    """The states of a `pinocchio.Model` of the same robot.

    Velocities, accelerations and joint forces differ from modyn's in their order alone. So do coordinates, except that a
    continuous joint has a cosine and a sine there. Planar joints have no conversion. A mimic joint follows its leader: the other
    model may have a joint for it (`mimic=False`) or not. `from_q` and `from_v` leave its numbers out; its force acts on the leader,
    so the functions of forces are `to_tau` and `from_tau`.
    """

    def __init__(self, robot: Robot, model: Any) -> None:
        self._nq, self._nv = robot.nq, robot.nv
        self._model_nq, self._model_nv = model.nq, model.nv
        names = list(model.names)[1:]
        floating = [name for name, joint in zip(names, list(model.joints)[1:]) if joint.nq == 7]
        self._joints = []
        self._followers: list[_Follower] = []
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
        for name, *own in robot._followers():
            if name in names:
                names.remove(name)
                their = model.joints[model.getJointId(name)]
                # A mimic joint of Pinocchio has no coordinate of its own.
                if their.nq:
                    _check_follower("Pinocchio", name, their.nq)
                    places = slice(their.idx_q, their.idx_q + 1), slice(their.idx_v, their.idx_v + 1)
                    self._followers.append(_Follower(*own, *places))
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
        for follower in self._followers:
            theirs[:, follower.their_q] = follower.coordinates(rows)
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
        """Returns Pinocchio's velocities or accelerations, from modyn's, (nv,); without mimic joints also joint forces."""
        theirs = self.to_tau(v)
        rows = np.atleast_2d(theirs)
        for follower in self._followers:
            rows[:, follower.their_v] = follower.velocities(_rows("v", v, self._nv))
        return theirs

    def to_tau(self, tau: ArrayLike) -> Array:
        """Returns Pinocchio's joint forces, from modyn's, (nv,). Those of mimic joints are zero."""
        rows = _rows("tau", tau, self._nv)
        theirs = np.zeros((len(rows), self._model_nv))
        for _, _, own, their in self._joints:
            theirs[:, their] = rows[:, own]
        return _like(theirs, tau)

    def from_v(self, v: ArrayLike) -> Array:
        """Returns modyn's velocities or accelerations, (nv,), from Pinocchio's; without mimic joints also joint forces."""
        rows = _rows("v", v, self._model_nv)
        own = np.zeros((len(rows), self._nv))
        for _, _, places, their in self._joints:
            own[:, places] = rows[:, their]
        return _like(own, v)

    def from_tau(self, tau: ArrayLike) -> Array:
        """Returns modyn's joint forces, (nv,), from Pinocchio's. Forces of mimic joints act on their leaders."""
        own = self.from_v(tau)
        _add_forces(own, _rows("tau", tau, self._model_nv), self._followers)
        return own


def _check_follower(library: str, name: str, coordinates: int) -> None:
    """Checks that a mimic joint has one coordinate in the other model."""
    if coordinates != 1:
        raise ValueError(
            f"the mimic joint `{name}` has {coordinates} coordinates in {library}'s model; load the robot with "
            '`mimic="independent"`, so that it has a coordinate of its own'
        )


def _add_forces(own: Array, theirs: Array, followers: list[_Follower]) -> None:
    """Adds the forces of mimic joints to those of their leaders."""
    rows = np.atleast_2d(own)
    for follower in followers:
        rows[:, follower.v] += follower.multiplier * theirs[:, follower.their_v][:, 0]


class MuJoCo:
    """The states of a `mujoco.MjModel` of the same robot.

    A free joint has its quaternion as w, x, y, z there, its linear velocity in world axes and its acceleration as the
    derivative of that. A ball joint has its quaternion as w, x, y, z. Joints without a name are matched in the order of the file. A
    mimic joint follows its leader: `from_qpos`, `from_qvel` and `from_qacc` leave its numbers out, and its force acts on the leader.
    """

    def __init__(self, robot: Robot, model: Any) -> None:
        self._nq, self._nv = robot.nq, robot.nv
        self._model_nq, self._model_nv = model.nq, model.nv
        joints = [model.joint(i) for i in range(model.njnt)]
        names = {their.name for their in joints if their.name}
        self._joints = []
        self._followers: list[_Follower] = []
        for joint in robot.joints:
            found = [i for i, their in enumerate(joints) if their.name == joint.name]
            free = [i for i, their in enumerate(joints) if int(their.type[0]) == 0]
            if joint.type == "floating" and not found and len(free) == 1:
                found = free
            if joint.name not in names and not found:
                # Both programs have the joints in the order of the file.
                found = [i for i, their in enumerate(joints) if not their.name][:1]
            if not found or joint.type in ("planar", "universal"):
                raise ValueError(f"MuJoCo's model has no {joint.type} joint `{joint.name}`")
            their = joints.pop(found[0])
            kind = ("floating", "spherical", "prismatic", "revolute")[int(their.type[0])]
            if kind != joint.type.replace("continuous", "revolute"):
                shown = f"joint `{their.name}`" if their.name else "next joint without a name"
                raise ValueError(
                    f"the {joint.type} joint `{joint.name}` of the robot and the {shown} of MuJoCo's model, which is {kind}, have other "
                    "types: give the joints of both files the same names"
                )
            self._joints.append((joint.type, joint.q, *self._places(their, joint.q, joint.v)))
        for name, q, v, multiplier, offset in robot._followers():
            for their in [their for their in joints if their.name == name]:
                joints.remove(their)
                _check_follower("MuJoCo", name, 1 if int(their.type[0]) in (2, 3) else 6)
                places = self._places(their, slice(0, 1), slice(0, 1))
                self._followers.append(_Follower(q, v, multiplier, offset, places[0], places[2]))
        if joints:
            raise ValueError(f"the robot has no coordinates of MuJoCo's joint `{joints[0].name}`")

    @staticmethod
    def _places(their: Any, q: slice, v: slice) -> tuple[slice, slice, slice]:
        """Returns the entries of a joint in `qpos`, in modyn's velocities and in `qvel`."""
        first_q, first_v = int(their.qposadr[0]), int(their.dofadr[0])
        return slice(first_q, first_q + q.stop - q.start), v, slice(first_v, first_v + v.stop - v.start)

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
        for follower in self._followers:
            theirs[:, follower.their_q] = follower.coordinates(rows)
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
        return self._with_followers(self.to_qfrc(q, qd), "qd", qd)

    def from_qvel(self, q: ArrayLike, qvel: ArrayLike) -> Array:
        """Returns modyn's velocities, (nv,), from modyn's coordinates and MuJoCo's `qvel`."""
        return self._from_theirs(_modyn.mujoco_from_qvel, [self._coordinates(q)], "qvel", qvel)

    def to_qacc(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Returns MuJoCo's `qacc`, from modyn's coordinates, velocities and accelerations, (nv,)."""
        state = [self._coordinates(q), self._velocities(qd)]
        return self._with_followers(self._to_theirs(_modyn.mujoco_to_qacc, state, "qdd", qdd), "qdd", qdd)

    def from_qacc(self, q: ArrayLike, qd: ArrayLike, qacc: ArrayLike) -> Array:
        """Returns modyn's accelerations, (nv,), from modyn's coordinates and velocities and MuJoCo's `qacc`."""
        state = [self._coordinates(q), self._velocities(qd)]
        return self._from_theirs(_modyn.mujoco_from_qacc, state, "qacc", qacc)

    def to_qfrc(self, q: ArrayLike, tau: ArrayLike) -> Array:
        """Returns MuJoCo's `qfrc_...`, from modyn's coordinates and joint forces, (nv,). Those of mimic joints are zero."""
        return self._to_theirs(_modyn.mujoco_to_qvel, [self._coordinates(q)], "tau", tau)

    def from_qfrc(self, q: ArrayLike, qfrc: ArrayLike) -> Array:
        """Returns modyn's joint forces, (nv,), from modyn's coordinates and MuJoCo's `qfrc_...`."""
        own = self.from_qvel(q, qfrc)
        _add_forces(own, _rows("qfrc", qfrc, self._model_nv), self._followers)
        return own

    def _with_followers(self, theirs: Array, name: str, numbers: ArrayLike) -> Array:
        """Sets the velocities or the accelerations of mimic joints, from modyn's."""
        rows = np.atleast_2d(theirs)
        for follower in self._followers:
            rows[:, follower.their_v] = follower.velocities(_rows(name, numbers, self._nv))
        return theirs

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
