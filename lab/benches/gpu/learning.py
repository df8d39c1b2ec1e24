"""Time of a state in calls of `modyn.torch` and `modyn.jax` on a CUDA device, in `f32`, and how far values and gradients are from the CPU's.

    measure="python lab/benches/gpu/learning.py"
    $measure | lab/record "$measure" "NOTE" > docs/data/gpu-learning.tsv
    python lab/benches/gpu/learning.py --check

Needs PyTorch for CUDA, JAX for CUDA, or both, and the package `modyn`. A time is the median of 11 passes, in ns; a pass calls the function so
often that it takes some 20 ms, and waits once. Rollouts have 10 steps of 2 ms with a feedback, on the ground where the robot has feet;
their time is for a step. `--check` computes few states only. NVRTC takes some minutes for all kernels the first time: `--robot Panda` is
quick. `--device cpu` tests this program.
"""

import argparse
import functools
import importlib.util
import os
import sys
import time
from pathlib import Path

import numpy as np

import modyn

sys.path.insert(0, str(Path(__file__).parent))
from libraries import FEET, ROOT, median  # noqa: E402

SIZES, CHECKED, STEPS, DT = [1024, 16_384, 262_144, 1_048_576], 64, 10, 0.002
SOLES = ["left_ankle_roll_link", "right_ankle_roll_link"]
# The name, the file, the links that touch the ground.
ROBOTS = {
    "Panda": ("tests/golden/panda.urdf", []),
    "quadruped on four feet": ("robots/quadruped.urdf", [f"{foot}_foot" for foot in FEET]),
    "humanoid on two feet": ("robots/humanoid.urdf", SOLES),
}
FUNCTIONS = ["forward_dynamics", "step", "rollout", "gradient of a rollout"]


def load(robot, scalar):
    path, feet = ROBOTS[robot]
    own = {"base": "floating", "contacts": {foot: ("point", foot, [0.0, 0.0, 0.0]) for foot in feet}} if feet else {}
    return modyn.load(ROOT / path, joint_friction="none", scalar=scalar, **own)


def states(robot, n):
    """Returns q, qd and the joint forces of n states near the robot's posture, with the lowest foot 1 mm in the ground."""
    own, rng = load(robot, "f64"), np.random.default_rng(0)
    feet, base = ROBOTS[robot][1], 7 if ROBOTS[robot][1] else 0
    q = np.tile(own.neutral(), (n, 1))
    q[:, base:] += 0.1 * rng.normal(size=(n, own.nq - base))
    if feet:
        q[:, 2] -= np.min([own.link_pose(q, link=foot).translation[:, 2] for foot in feet], axis=0) + 1e-3
    qd, tau = 0.1 * rng.normal(size=(n, own.nv)), rng.normal(size=(n, own.nv))
    if feet:
        tau[:, :6] = 0
    return q, qd, tau


class Torch:
    def __init__(self, device):
        import modyn.torch
        import torch

        self.library, self.functions, self.device = torch, modyn.torch, torch.device(device)
        self.wait = (lambda _: torch.cuda.synchronize()) if device == "cuda" else lambda _: None

    def array(self, x):
        return self.library.from_numpy(np.asarray(x, np.float32)).to(self.device)

    def gradient(self, total, x):
        x = x.detach().requires_grad_()
        return self.library.autograd.grad(total(x), x)[0]

    def compiled(self, function):
        return function


class Jax:
    def __init__(self, device):
        os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
        import jax
        import modyn.jax

        self.library, self.functions, self.device = jax, modyn.jax, jax.devices(device)[0]
        self.wait = jax.block_until_ready

    def array(self, x):
        return self.library.device_put(np.asarray(x, np.float32), self.device)

    def gradient(self, total, x):
        return self.library.grad(total)(x)

    def compiled(self, function):
        return self.library.jit(function)


def calls(functions, robot, gradient=None):
    """Returns what is measured, functions of arrays. Given NumPy's arrays in place of a library's functions, the same on the CPU."""
    step = "step" if robot_has_feet(robot) else "semi_implicit"
    rollout = functions["rollout"](step)
    motion = lambda q, qd, controls, gains: rollout(q, qd, controls, DT, gains=gains, q_ref=q[:, None], qd_ref=0 * qd[:, None])
    return {
        "forward_dynamics": lambda q, qd, tau, *_: functions["function"]("forward_dynamics")(q, qd, tau),
        "step": lambda q, qd, tau, *_: functions["function"]("step" if step == "step" else "step_semi_implicit")(q, qd, tau, DT).q,
        "rollout": lambda q, qd, tau, controls, gains: motion(q, qd, controls, gains).q,
        "gradient of a rollout": lambda q, qd, tau, controls, gains: gradient(q, qd, controls, gains, motion),
    }


def robot_has_feet(robot):
    return bool(ROBOTS[robot][1])


def feedback(nv):
    return np.concatenate([np.eye(nv), 0.01 * np.eye(nv)], 1)


def expected(robot, q, qd, tau, controls, gains):
    """Returns the results of the CPU in `f64`."""
    own = load(robot, "f64")
    rollout = lambda step: functools.partial(own.rollout, step=step, trajectory=False)

    def gradient(q, qd, controls, gains, motion):
        step, end = "step" if robot_has_feet(robot) else "semi_implicit", motion(q, qd, controls, gains).q
        named = {"gains": gains, "q_ref": q[:, None], "qd_ref": 0 * qd[:, None], "step": step, "trajectory": False}
        return own.rollout_vjp(q, qd, controls, DT, 2 * end, np.zeros_like(qd), **named).controls

    of_cpu = calls({"function": lambda name: getattr(own, name), "rollout": rollout}, robot, gradient)
    return {name: call(q, qd, tau, controls, gains) for name, call in of_cpu.items()}


def measure(title, library, robot, sizes):
    own = load(robot, "f32")
    kept = functools.cache(functools.partial(library.functions.function, own))
    rollout = lambda step: library.functions.rollout(own, step=step, trajectory=False)
    gradient = lambda q, qd, controls, gains, motion: library.gradient(lambda x: (motion(q, qd, x, gains).q ** 2).sum(), controls)
    measured = {name: library.compiled(call) for name, call in calls({"function": kept, "rollout": rollout}, robot, gradient).items()}
    few = states(robot, CHECKED)
    controls = lambda tau: np.repeat(tau[:, None], STEPS, 1)
    on_cpu = expected(robot, *few, controls(few[2]), feedback(own.nv))
    for name, call in measured.items():
        times, result = [], None
        for n in sizes:
            q, qd, tau = (np.tile(x, (n // CHECKED, 1)) for x in few)
            given = [*map(library.array, (q, qd, tau, controls(tau))), library.array(feedback(own.nv))]

            def run():
                nonlocal result
                result = call(*given)

            start = time.perf_counter()
            run()
            library.wait(result)
            if n == sizes[0]:
                found = np.asarray(result.detach().cpu() if isinstance(library, Torch) else result)[-CHECKED:]
                axes = tuple(range(1, found.ndim))
                errors = np.abs(found - on_cpu[name]).max(axes) / np.maximum(np.abs(on_cpu[name]).max(axes), 1e-3)
                # Where a contact opens or begins to slip, a gradient in `f32` can be that of the other side.
                usual = np.quantile(errors, 0.9)
                first = f"first call {time.perf_counter() - start:.2f} s"
                print(f"{title}, {robot}, {name}: {first}; nine tenths of the errors are below {usual:.1e}", file=sys.stderr)
                assert usual < 1e-2, f"{title}, {robot}, {name}: the results are not those of the CPU"
            if sizes != [CHECKED]:
                per = n * (STEPS if "rollout" in name else 1)
                times.append(f"{1e9 * median(run, lambda: library.wait(result)) / per:.2f}")
            del given
        if times:
            print("|" + "|".join([title, robot, name, *times]) + "|", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--device", default="cuda", choices=["cuda", "cpu"])
    parser.add_argument("--robot", choices=ROBOTS, action="append")
    given = parser.parse_args()
    sizes = [CHECKED] if given.check else SIZES
    if not given.check:
        print("|" + "|".join(["library", "robot", "function", *(f"{n:,} states" for n in SIZES)]) + "|", flush=True)
    for title, name, library in (("PyTorch", "torch", Torch), ("JAX", "jax", Jax)):
        if importlib.util.find_spec(name) is None:
            print(f"left out: {title} is not installed", file=sys.stderr)
            continue
        opened = library(given.device)
        for robot in given.robot or ROBOTS:
            measure(title, opened, robot, sizes)


main()
