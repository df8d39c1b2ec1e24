"""Writes what MuJoCo (PyPI `mujoco`) computes for the models of this folder, without damping and friction.

For each of three random states a line with q, qd, tau, accelerations, bias forces and mass matrix by columns. Springs and
gravity compensation are part of the bias forces. The numbers of free and ball joints are in modyn's coordinates.
"""

from pathlib import Path

import mujoco
import numpy

FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


def axes(model, data):
    """Returns the derivatives of MuJoCo's velocities by modyn's, which have the linear part of free joints in body axes."""
    matrix = numpy.eye(model.nv)
    for joint in range(model.njnt):
        if model.jnt_type[joint] == FREE:
            first, rotation = model.jnt_dofadr[joint], numpy.zeros(9)
            quaternion = model.jnt_qposadr[joint] + 3
            mujoco.mju_quat2Mat(rotation, data.qpos[quaternion : quaternion + 4])
            matrix[first : first + 3, first : first + 3] = rotation.reshape(3, 3)
    return matrix


def coordinates(model, data):
    """Returns the coordinates with the real part of quaternions last."""
    q = data.qpos.copy()
    for joint in range(model.njnt):
        kind, first = model.jnt_type[joint], model.jnt_qposadr[joint]
        if kind == FREE:
            first += 3
        if kind in (FREE, BALL):
            q[first : first + 4] = numpy.roll(q[first : first + 4], -1)
    return q


def rotating(model, qd):
    """Returns omega x v for the linear entries of free joints: classical accelerations minus modyn's."""
    drift = numpy.zeros(model.nv)
    for joint in range(model.njnt):
        if model.jnt_type[joint] == FREE:
            first = model.jnt_dofadr[joint]
            drift[first : first + 3] = numpy.cross(qd[first + 3 : first + 6], qd[first : first + 3])
    return drift


for path in sorted(Path(__file__).parent.glob("*.xml")):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    random = numpy.random.default_rng(1)
    lines = [f"# MuJoCo {mujoco.__version__}: q, qd, tau, accelerations, bias forces, mass matrix"]
    for _ in range(3):
        moved, qd, tau = random.uniform(-1, 1, (3, model.nv))
        if model.nq == model.nv:
            data.qpos[:] = moved
        else:
            data.qpos[:] = model.qpos0
            mujoco.mj_integratePos(model, data.qpos, moved, 1.0)
        own = axes(model, data)
        data.qvel[:] = own @ qd
        mujoco.mj_forward(model, data)
        matrix = numpy.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, matrix)
        matrix = own.T @ matrix @ own
        bias = own.T @ (data.qfrc_bias - data.qfrc_spring - data.qfrc_gravcomp) + matrix @ rotating(model, qd)
        accelerations = numpy.linalg.solve(matrix, tau - bias)
        q = coordinates(model, data)
        for numbers in (q, qd, tau, accelerations, bias, matrix.T.flatten()):
            lines.append(" ".join(repr(float(number)) for number in numbers))
    path.with_suffix(".txt").write_text("\n".join(lines) + "\n")
