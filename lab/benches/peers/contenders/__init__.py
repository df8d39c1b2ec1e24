"""The contenders, each in a file: a function that builds it and returns its programs.

To add one, write such a file and a line here.
"""

from . import casadi, crates, modyn, modyn_c, mujoco, native, pinocchio

CONTENDERS = {
    "modyn": modyn.build,
    "native": native.build,
    "modyn_c": modyn_c.build,
    "pinocchio": pinocchio.build,
    "casadi": casadi.build,
    "mujoco": mujoco.build,
    "crates": crates.build,
}
