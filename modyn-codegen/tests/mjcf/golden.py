"""Writes what MuJoCo (PyPI `mujoco`) computes for the models of this folder, without damping and friction.

For each of three random states a line with q, qd, tau, accelerations, bias forces and mass matrix by columns.
"""

from pathlib import Path

import mujoco
import numpy

for path in sorted(Path(__file__).parent.glob("*.xml")):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    random = numpy.random.default_rng(1)
    lines = [f"# MuJoCo {mujoco.__version__}: q, qd, tau, accelerations, bias forces, mass matrix"]
    for _ in range(3):
        data.qpos[:], data.qvel[:], tau = random.uniform(-1, 1, (3, model.nv))
        mujoco.mj_forward(model, data)
        matrix = numpy.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, matrix)
        accelerations = numpy.linalg.solve(matrix, tau - data.qfrc_bias)
        for numbers in (data.qpos, data.qvel, tau, accelerations, data.qfrc_bias, matrix.T.flatten()):
            lines.append(" ".join(repr(float(number)) for number in numbers))
    path.with_suffix(".txt").write_text("\n".join(lines) + "\n")
