"""Dynamics inside JAX and PyTorch on the CPU, f64: one state, 4,096 states, gradients of motions, the first gradient.

    lab/benches/python/run learn | lab/record "lab/benches/python/run learn" "$(lab/benches/python/run versions)" > docs/data/learning.tsv

Each library runs in a process of its own, one after the other, and its gradients must be those of modyn. Times are the least of
several runs. The motions have 50 time steps by `semi_implicit`, or by the library's own time step of this kind; the cost is the
sum of squares of the last coordinates and velocities of the joints, and its gradient is that by the controls.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from xml.etree import ElementTree

BEGIN = time.perf_counter()
ROOT = Path(__file__).resolve().parents[3]
ROBOTS = {"Panda": "panda.urdf", "quadruped": "solo12.urdf"}
STATES, MOTIONS, STEPS, DT = 4096, 64, 50, 0.002
# The longest time that a library may take, s.
MAX_SECONDS = 180
# The calls inside of a compiled program that are measured together.
INSIDE = 1000


def inputs(robot):
    """Returns random states, in which a floating base rests, and the controls of motions."""
    import numpy as np

    rng = np.random.default_rng(0)
    joints, floating = {"Panda": (7, False), "quadruped": (12, True), "tree": (6, False)}[robot]
    q, qd = rng.uniform(-1, 1, (STATES, joints)), 0.3 * rng.normal(size=(STATES, joints))
    tau, controls = rng.normal(size=(STATES, joints)), 0.1 * rng.normal(size=(MOTIONS, STEPS, joints))
    if not floating:
        return q, qd, tau, controls
    # The place, then the quaternion x, y, z, w.
    base = rng.normal(size=(STATES, 7))
    base[:, 3:] /= np.linalg.norm(base[:, 3:], axis=1, keepdims=True)
    still = lambda x: np.concatenate([np.zeros((*x.shape[:-1], 6)), x], -1)
    return np.hstack([base, q]), still(qd), still(tau), still(controls)


def path_of(robot):
    if robot != "tree":
        return ROOT / "tests" / "golden" / ROBOTS[robot]
    # A tree in general position, of the tests of the Python package.
    sys.path.insert(0, str(ROOT / "modyn-python" / "tests"))
    from conftest import chain

    path = Path(tempfile.gettempdir()) / "modyn-learn-tree.urdf"
    path.write_text(chain(3))
    return path


class Modyn:
    """modyn"""

    def __init__(self, path, floating):
        import modyn
        import modyn.jax

        self.robot = modyn.load(path, joint_friction="none", **({"base": "floating"} if floating else {}))
        self.forward_dynamics = modyn.jax.function(self.robot, "forward_dynamics")
        step = modyn.jax.function(self.robot, "step_semi_implicit")
        self.step = lambda q, qd, tau: tuple(step(q, qd, tau, DT))

    def of_modyn(self, q):
        return q


class Rollout(Modyn):
    """modyn, `rollout` in one call"""

    def __init__(self, path, floating):
        import modyn.jax

        super().__init__(path, floating)
        rollout = modyn.jax.rollout(self.robot, trajectory=False)
        self.motion = lambda q, qd, controls: tuple(rollout(q, qd, controls, DT))


class Frax:
    """frax"""

    def __init__(self, path, floating):
        from frax.core.robot import Robot

        # Joints have the order of the file, in place of that by their depth.
        names = [joint.get("name") for joint in ElementTree.parse(path).iterfind("joint") if joint.get("type") != "fixed"]
        robot = Robot(str(path), joint_ordering=names, floating_base="quaternion" if floating else None)
        self.floating = floating
        self.forward_dynamics = lambda q, qd, tau: robot.forward_dynamics(q, qd, tau, None)

        def step(q, qd, tau):
            qd = qd + DT * self.forward_dynamics(q, qd, tau)
            return robot.integrate(q, qd, DT), qd

        self.step = step

    def of_modyn(self, q):
        """Returns coordinates, whose quaternions are w, x, y, z."""
        import numpy as np

        return np.concatenate([q[..., :3], q[..., 6:7], q[..., 3:6], q[..., 7:]], -1) if self.floating else q


class Mjx:
    """MuJoCo XLA"""

    def __init__(self, path, floating):
        from main import mujoco_model
        from mujoco import mjx

        assert not floating
        compiled = mujoco_model(path)
        compiled.opt.timestep = DT
        model = mjx.put_model(compiled)
        data = mjx.make_data(model)
        self.forward_dynamics = lambda q, qd, tau: mjx.forward(model, data.replace(qpos=q, qvel=qd, qfrc_applied=tau)).qacc

        def step(q, qd, tau):
            qd = qd + DT * self.forward_dynamics(q, qd, tau)
            return q + DT * qd, qd

        self.step = step

    def of_modyn(self, q):
        return q


class Jax:
    """JAX alone"""

    def __init__(self, path, floating):
        self.forward_dynamics = lambda q, qd, tau: tau - q
        self.step = lambda q, qd, tau: (q + DT * qd, qd + DT * (tau - q))

    def of_modyn(self, q):
        return q


LIBRARIES = [Modyn, Rollout, Frax, Mjx, Jax]


def measure_jax(library, robot, first):
    """Returns the times of a library in JAX by measurement, s, and the gradient of a motion; or the time to the first gradient, and the gradient."""
    os.environ.update(JAX_ENABLE_X64="1", JAX_PLATFORMS="cpu")
    if library is Frax:
        # The flags that its README recommends.
        flags = ["--xla_cpu_multi_thread_eigen=false", "--xla_cpu_scheduler_type=CPU_SCHEDULER_TYPE_MEMORY_OPTIMIZED"]
        os.environ.update(OPENBLAS_NUM_THREADS="1", XLA_FLAGS=" ".join(flags))
    import jax
    import jax.numpy as jnp
    from main import least

    floating = robot == "quadruped"
    own = library(path_of(robot), floating)
    q, qd, tau, controls = inputs(robot)
    q, qd, tau, controls = map(jnp.asarray, (own.of_modyn(q), qd, tau, controls))
    joints = (7, 6) if floating else (0, 0)

    def motion(q, qd, controls):
        if hasattr(own, "motion"):
            return own.motion(q, qd, controls)
        advance = lambda state, tau: (own.step(*state, tau), None)
        return jax.lax.scan(advance, (q, qd), controls)[0]

    def cost(q, qd, controls):
        return sum((x[first:] ** 2).sum() for x, first in zip(motion(q, qd, controls), joints))

    times = {}
    gradient = jax.jit(jax.grad(cost, 2))
    one = q[0], qd[0], controls[0]
    found = gradient(*one).block_until_ready()
    times["first"] = time.perf_counter() - BEGIN
    if first or library is Jax:
        return times, None if library is Jax else found[:, joints[1] :].tolist()
    times["gradient of one motion"] = least(lambda: gradient(*one).block_until_ready())
    if library is not Mjx:
        gradients = jax.jit(jax.vmap(jax.grad(cost, 2)))
        many = q[:MOTIONS], qd[:MOTIONS], controls
        times["gradient of many motions"] = least(lambda: gradients(*many).block_until_ready())
    if library is not Rollout:
        times["one state"] = inside(own.forward_dynamics, q[0], qd[0], tau[0], INSIDE // 100 if library is Mjx else INSIDE)
        batch = jax.jit(jax.vmap(own.forward_dynamics))
        times["states"] = least(lambda: batch(q, qd, tau).block_until_ready())
    return times, found[:, joints[1] :].tolist()


def inside(function, q, qd, tau, count):
    """Returns the time of a call within a compiled program, s: of calls that depend on each other, less that of the loop."""
    import jax
    from main import least

    def loop(f):
        # All arguments change, so that nothing can be computed before the loop.
        call = lambda q, qd, tau, x: f(q + 1e-9 * x[0], qd + 1e-9 * x, tau + 1e-9 * x)
        return jax.jit(lambda q, qd, tau: jax.lax.fori_loop(0, count, lambda _, x: call(q, qd, tau, x), tau))

    times = []
    for f in (function, lambda q, qd, tau: tau + q[0] + qd[0]):
        compiled = loop(f)
        times.append(least(lambda: compiled(q, qd, tau).block_until_ready()))
    return (times[0] - times[1]) / count


def measure_pinocchio(robot):
    """Returns the time of forward dynamics of all states on all cores, s."""
    import pinocchio as pin
    from main import least

    path = str(ROOT / "tests" / "golden" / ROBOTS[robot])
    floating = [pin.JointModelFreeFlyer()] if robot == "quadruped" else []
    model = pin.buildModelFromUrdf(path, *floating)
    cores = os.cpu_count()
    pool = pin.ModelPool(model, cores)
    q, qd, tau, _ = inputs(robot)
    q, qd, tau = (x.T.copy(order="F") for x in (q, qd, tau))
    return {"states": least(lambda: pin.abaInParallel(cores, pool, q, qd, tau))}, None


def measure_torch(library):
    """Returns the time of forward dynamics of the Panda's states with the gradients of a weighted sum, s, and gradients."""
    import numpy as np
    import torch
    from main import least

    path = ROOT / "tests" / "golden" / ROBOTS["Panda"]
    q, qd, tau, _ = inputs("Panda")
    if library == "modyn":
        import modyn
        import modyn.torch

        forward_dynamics = modyn.torch.function(modyn.load(path, joint_friction="none"), "forward_dynamics")
    else:
        forward_dynamics = pinocchio_in_torch(path)
    given = [torch.from_numpy(x).requires_grad_() for x in (q, qd, tau)]

    def backward():
        return torch.autograd.grad(forward_dynamics(*given).sum(), given)

    return {"torch": least(backward)}, np.hstack([x[:10] for x in backward()]).tolist()


def pinocchio_in_torch(path):
    """Returns forward dynamics as a function of PyTorch, by a loop over Pinocchio's derivatives."""
    import numpy as np
    import pinocchio as pin
    import torch

    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()

    class ForwardDynamics(torch.autograd.Function):
        @staticmethod
        def forward(ctx, *given):
            ctx.save_for_backward(*given)
            states = zip(*(x.detach().numpy() for x in given))
            return torch.from_numpy(np.array([pin.aba(model, data, *state) for state in states]))

        @staticmethod
        def backward(ctx, weights):
            gradients = [], [], []
            states = zip(*(x.detach().numpy() for x in (*ctx.saved_tensors, weights)))
            for *state, weight in states:
                for own, matrix in zip(gradients, pin.computeABADerivatives(model, data, *state)):
                    own.append(weight @ matrix)
            return tuple(torch.from_numpy(np.array(own)) for own in gradients)

    return ForwardDynamics.apply


# The rows of the table: the title, the unit in s, the robot, the measurement.
ROWS = [
    *(
        row
        for robot in ROBOTS
        for row in [
            (f"{robot}: forward dynamics inside `jit`, us", 1e-6, robot, "one state"),
            (f"{robot}: forward dynamics of 4,096 states, us", 1e-6, robot, "states"),
            (f"{robot}: gradient of a motion of 50 steps, us", 1e-6, robot, "gradient of one motion"),
            (f"{robot}: gradient of 64 motions of 50 steps, us", 1e-6, robot, "gradient of many motions"),
        ]
    ),
    ("Panda: from import to the first gradient of a motion, s", 1.0, "Panda", "first"),
    ("Panda: PyTorch, 4,096 states with backward, us", 1e-6, "Panda", "torch"),
]

# The columns: the title, and the processes whose times it has.
COLUMNS = {
    "modyn": ["Modyn", "torch-modyn"],
    "modyn, `rollout` in one call": ["Rollout"],
    "frax": ["Frax"],
    "MuJoCo XLA": ["Mjx"],
    "Pinocchio": ["pinocchio", "torch-pinocchio"],
    "JAX alone": ["Jax"],
}


def measured(process, robot, *more):
    """Returns what a process of its own measures; nothing if the library cannot be measured here."""
    command = [sys.executable, __file__, "--process", process, "--robot", robot, *more]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=MAX_SECONDS)
    except subprocess.TimeoutExpired:
        print(f"{process} of the {robot} is left out: it takes more than {MAX_SECONDS} s", file=sys.stderr)
        return {}, None
    if done.returncode:
        print(f"{process} of the {robot} is left out: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return {}, None
    return json.loads(done.stdout.splitlines()[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--versions", action="store_true", help="print the processor and the versions alone")
    parser.add_argument("--without", nargs="*", default=[], help="processes to leave out, such as Mjx")
    parser.add_argument("--process", help="measure in this process")
    parser.add_argument("--first", action="store_true", help="measure the time to the first gradient alone")
    parser.add_argument("--robot", choices=[*ROBOTS, "tree"], default="Panda")
    arguments = parser.parse_args()
    if arguments.process:
        classes = {library.__name__: library for library in LIBRARIES}
        if arguments.process in classes:
            result = measure_jax(classes[arguments.process], arguments.robot, arguments.first)
        elif arguments.process == "pinocchio":
            result = measure_pinocchio(arguments.robot)
        else:
            result = measure_torch(arguments.process.removeprefix("torch-"))
        print(json.dumps(result))
        return
    if arguments.versions:
        model = next(line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name"))
        versions = []
        for name in ("jax", "frax", "mujoco-mjx", "pin", "torch", "numpy"):
            try:
                versions.append(f"{name} {version(name)}")
            except PackageNotFoundError:
                versions.append(f"without {name}")
        print(f"{model.split(':', 1)[1].strip()}, {os.cpu_count()} cores, {', '.join(versions)}")
        return
    import numpy as np

    times, gradients = {}, {}
    for robot in [*ROBOTS, "tree"]:
        for process in [own for column in COLUMNS.values() for own in column]:
            # The gradients of a robot in general position are compared alone.
            if robot == "tree" and process not in ("Modyn", "Rollout", "Frax"):
                continue
            only_panda = process in ("Mjx", "Jax") or process.startswith("torch")
            if process in arguments.without or (only_panda and robot != "Panda"):
                continue
            found, gradient = measured(process, robot, *(["--first"] if robot == "tree" else []))
            if robot == "Panda" and process in ("Modyn", "Rollout", "Frax", "Jax"):
                again = [measured(process, robot, "--first")[0].get("first", float("inf")) for _ in range(2)]
                found["first"] = min([found.get("first", float("inf")), *again])
            for name, seconds in found.items():
                times[process, robot, name] = seconds
            if gradient is None:
                continue
            kind = robot, process.startswith("torch")
            expected = gradients.setdefault(kind, np.array(gradient))
            error = np.abs(np.array(gradient) - expected).max() / np.abs(expected).max()
            if error > 1e-6:
                sys.exit(f"the gradient of {process} of the {robot} is not that of modyn: {error:.2g} relative")
    print("| measurement | " + " | ".join(COLUMNS) + " |")
    print("|---" * (len(COLUMNS) + 1) + "|")
    for title, unit, robot, name in ROWS:
        cells = []
        for processes in COLUMNS.values():
            own = [times[process, robot, name] / unit for process in processes if (process, robot, name) in times]
            cells.append(f"{own[0]:.3g}" if own and own[0] < 100 else f"{own[0]:,.0f}" if own else "")
        print(f"| {title} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
