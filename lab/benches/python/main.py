"""Forward dynamics from Python: from import to the first result, a single call, a batch of 10,000 states.

Each library runs in a process of its own, one after the other; its accelerations must be those of Pinocchio. Times are the
least of several runs.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

STATES = 10_000
# The longest time that a library may take, s.
MAX_SECONDS = 1200


def inputs(path):
    """Returns random states and the accelerations by Pinocchio."""
    import numpy as np
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(path))
    rng = np.random.default_rng(0)
    q = rng.uniform(-1, 1, (STATES, model.nq))
    qd, tau = rng.normal(size=(2, STATES, model.nv))
    return q, qd, tau


class Pinocchio:
    """Pinocchio, a loop over `aba`"""

    def __init__(self, path):
        import numpy as np
        import pinocchio as pin

        model = pin.buildModelFromUrdf(str(path))
        data = model.createData()
        self.one = lambda q, qd, tau: pin.aba(model, data, q, qd, tau)
        self.batch = lambda q, qd, tau: np.array([pin.aba(model, data, *state) for state in zip(q, qd, tau)])


class Modyn:
    """modyn"""

    def __init__(self, path):
        import modyn

        self.robot = modyn.load(path, joint_friction="none")
        self.one = self.robot.forward_dynamics
        self.batch = self.robot.forward_dynamics


class ModynSingle:
    """modyn in single precision (`scalar="f32"`)"""

    dtype = "float32"
    # The rounding errors of single precision, times the condition number of the mass matrix.
    tolerance = 1e-2

    def __init__(self, path):
        import modyn

        self.robot = modyn.load(path, joint_friction="none", scalar="f32")
        self.one = self.robot.forward_dynamics
        self.batch = self.robot.forward_dynamics


class MuJoCo:
    """MuJoCo, `mj_forward` with a loop"""

    def __init__(self, path):
        import mujoco
        import numpy as np

        model = mujoco_model(path)
        data = mujoco.MjData(model)

        def one(q, qd, tau):
            data.qpos, data.qvel, data.qfrc_applied = q, qd, tau
            mujoco.mj_forward(model, data)
            return data.qacc

        self.one = one
        self.batch = lambda q, qd, tau: np.array([one(*state).copy() for state in zip(q, qd, tau)])


def mujoco_model(path):
    """Returns the robot of a URDF without contacts, damping and friction."""
    import mujoco

    spec = mujoco.MjSpec.from_string(Path(path).read_text())
    for joint in spec.joints:
        joint.damping, joint.frictionloss = 0 * joint.damping, 0.0
    model = spec.compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


class MuJoCoRollout:
    """MuJoCo, `rollout` of one step with a thread for each core"""

    def __init__(self, path):
        import mujoco
        import numpy as np
        from mujoco.rollout import Rollout

        model, threads = mujoco_model(path), os.cpu_count()
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        dt, data = model.opt.timestep, [mujoco.MjData(model) for _ in range(threads)]
        pool, spec = Rollout(nthread=threads), mujoco.mjtState.mjSTATE_QFRC_APPLIED.value
        first = 1 + model.nq  # The state is the time, the coordinates, the velocities.

        # The accelerations are differences of velocities, divided by the time step.
        def batch(q, qd, tau):
            states = np.hstack([np.zeros((len(q), 1)), q, qd])
            after, _ = pool.rollout(model, data, states, tau[:, None], control_spec=spec)
            return (after[:, 0, first : first + model.nv] - qd) / dt

        self.one = lambda q, qd, tau: batch(q[None], qd[None], tau[None])[0]
        self.batch = batch


class CasADi:
    """CasADi, compiled C of adam's expressions (with the C compiler's time)"""

    def __init__(self, path):
        import tempfile

        import casadi
        import numpy as np
        import pinocchio as pin
        from adam.casadi import KinDynComputations

        names = list(pin.buildModelFromUrdf(str(path)).names)[1:]
        robot, n = KinDynComputations(str(path), names, gravity=np.array([0, 0, -9.81, 0, 0, 0])), len(names)
        q, qd, tau = (casadi.SX.sym(name, n) for name in ("q", "qd", "tau"))
        base, rest = casadi.SX.eye(4), casadi.SX.zeros(6)
        # The base is fixed: its six rows are left out.
        mass, bias = robot.mass_matrix(base, q)[6:, 6:], robot.bias_force(base, q, rest, qd)[6:]
        function = casadi.Function("forward_dynamics", [q, qd, tau], [casadi.solve(mass, tau - bias)])
        folder = tempfile.mkdtemp()
        generator = casadi.CodeGenerator("dynamics.c")
        generator.add(function)
        generator.generate(folder + "/")
        library = f"{folder}/dynamics.so"
        command = ["cc", "-O3", "-march=native", "-fPIC", "-shared", f"{folder}/dynamics.c", "-o", library, "-lm"]
        subprocess.run(command, check=True)
        compiled = casadi.external("forward_dynamics", library)
        mapped = compiled.map(STATES, "thread", os.cpu_count())
        self.one = lambda q, qd, tau: np.asarray(compiled(q, qd, tau)).ravel()
        self.batch = lambda q, qd, tau: np.asarray(mapped(q.T, qd.T, tau.T)).T


class Mjx:
    """MuJoCo XLA (JAX on the CPU, f64, with `jit` and `vmap`)"""

    def __init__(self, path):
        import jax

        jax.config.update("jax_enable_x64", True)
        from mujoco import mjx

        model = mjx.put_model(mujoco_model(path))
        data = mjx.make_data(model)

        def forward(q, qd, tau):
            return mjx.forward(model, data.replace(qpos=q, qvel=qd, qfrc_applied=tau)).qacc

        self.one, self.batch = compiled(forward)


class Frax:
    """frax (JAX on the CPU, f64, with `jit`, `vmap` and the flags that its README recommends)"""

    def __init__(self, path):
        recommended = ["--xla_cpu_multi_thread_eigen=false", "--xla_cpu_scheduler_type=CPU_SCHEDULER_TYPE_MEMORY_OPTIMIZED"]
        os.environ.update(JAX_ENABLE_X64="1", OPENBLAS_NUM_THREADS="1", XLA_FLAGS=" ".join(recommended))
        from frax.core.robot import Robot

        robot = Robot(str(path))
        self.one, self.batch = compiled(lambda q, qd, tau: robot.forward_dynamics(q, qd, tau, None))


def compiled(function):
    """Returns a function of one state, and of many, that JAX compiles in double precision."""
    import jax
    import numpy as np

    jax.config.update("jax_enable_x64", True)
    one, many = jax.jit(function), jax.jit(jax.vmap(function))
    return (lambda *state: np.asarray(one(*state))), (lambda *states: np.asarray(many(*states)))


LIBRARIES = {name: library for name, library in list(globals().items()) if isinstance(library, type)}


def least(call, seconds=1.0):
    """Returns the least time of a call, s; calls are repeated for this many seconds, short ones in groups."""
    call()
    begin = time.perf_counter()
    call()
    once = time.perf_counter() - begin
    if once > seconds:
        return once
    group = max(1, int(1e-3 / once))
    best, end = float("inf"), time.perf_counter() + seconds
    while time.perf_counter() < end:
        begin = time.perf_counter()
        for _ in range(group):
            call()
        best = min(best, (time.perf_counter() - begin) / group)
    return best


def measure(name, path, states):
    """Measures a library; prints its times and its accelerations of some states."""
    import numpy as np

    dtype = getattr(LIBRARIES[name], "dtype", "float64")
    with np.load(states) as saved:
        q, qd, tau = (saved[key].astype(dtype) for key in ("q", "qd", "tau"))
    begin = time.perf_counter()
    library = LIBRARIES[name](path)
    library.one(q[0], qd[0], tau[0])
    first = time.perf_counter() - begin
    one = least(lambda: library.one(q[0], qd[0], tau[0]))
    batch = least(lambda: library.batch(q, qd, tau), 3.0)
    found = np.asarray(library.batch(q, qd, tau))[:: STATES // 10]
    single = np.asarray(library.one(q[0], qd[0], tau[0]))
    print(json.dumps({"times": [first, one, batch], "qdd": found.tolist(), "one": single.tolist()}))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot", type=Path)
    parser.add_argument("--library", choices=LIBRARIES, help="measure one in this process")
    parser.add_argument("--states")
    arguments = parser.parse_args()
    if arguments.library:
        measure(arguments.library, arguments.robot, arguments.states)
        return
    import tempfile

    import numpy as np

    q, qd, tau = inputs(arguments.robot)
    with tempfile.NamedTemporaryFile(suffix=".npz") as file:
        np.savez(file, q=q, qd=qd, tau=tau)
        file.flush()
        print("| library | import to first result, ms | single call, us | batch of 10,000, ms |")
        print("|---|---|---|---|")
        expected = None
        for name in LIBRARIES:
            command = [sys.executable, __file__, str(arguments.robot), "--library", name, "--states", file.name]
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=MAX_SECONDS)
            except subprocess.TimeoutExpired:
                print(f"{name} is left out: it takes more than {MAX_SECONDS} s", file=sys.stderr)
                continue
            if done.returncode:
                print(f"{name} is left out: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
                continue
            result = json.loads(done.stdout.splitlines()[-1])
            found = np.array(result["qdd"])
            expected = found if expected is None else expected
            scale = np.abs(expected).max()
            limit = getattr(LIBRARIES[name], "tolerance", 1e-6) * scale
            if np.abs(found - expected).max() > limit or np.abs(result["one"] - found[0]).max() > limit:
                sys.exit(f"the accelerations of {name} are not those of Pinocchio")
            first, one, batch = result["times"]
            print(f"| {LIBRARIES[name].__doc__} | {first * 1e3:.0f} | {one * 1e6:.2f} | {batch * 1e3:.2f} |", flush=True)


if __name__ == "__main__":
    main()
