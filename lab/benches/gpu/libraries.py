"""Time of a state on the machine's graphics processor: modyn's CUDA kernels, GRiD, frax and MuJoCo XLA; and modyn on the host.

    measure="python lab/benches/gpu/libraries.py --grid FOLDER"
    $measure | lab/record "$measure" "NOTE" > docs/data/gpu-libraries.tsv

Needs nvcc, CuPy, JAX, frax, MuJoCo XLA, the package `modyn`, and the command `modyn` (MODYN); a library that is missing is left
out. FOLDER has `grid.cuh`, which GRiD's `generateGRiD.py` writes for tests/golden/panda.urdf.

Each library runs in a process of its own. A time is the median of 11 passes; a pass starts the function so often that it takes
some 20 ms, and waits once. Numbers stay on the graphics processor. A library whose first 200 accelerations are not those of modyn
on the host in `f64` is left out. Rollouts have 50 steps of 2 ms, and their time is that of a step.
"""

import argparse
import ctypes
import functools
import json
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "lab/benches/python"))
import learn  # noqa: E402

SIZES = [256, 4096, 65_536, 1_048_576]
STEPS, DT, COMPARED, MAX_SECONDS = 50, 0.002, 200, 120
# The name, the file, whether the base floats.
ROBOTS = {
    "Panda": ("tests/golden/panda.urdf", False),
    "Solo12, floating base": ("tests/golden/solo12.urdf", True),
    "G1, floating base": ("tests/golden/g1.urdf", True),
}
GROUND = "quadruped on four feet"
FEET = ["front_left", "front_right", "hind_left", "hind_right"]
FUNCTIONS = ["forward_dynamics", "forward_dynamics_derivatives", "rollout_semi_implicit"]


@functools.cache
def states(robot):
    """Returns q, qd and tau of random states, as modyn orders them. Floating bases rest, since libraries differ in their velocities."""
    own, rng, n = on_host(robot), np.random.default_rng(0), SIZES[-1]
    base = 7 if ROBOTS[robot][1] else 0
    q, qd, tau = rng.uniform(-1, 1, (n, own.nq)), 0.3 * rng.normal(size=(n, own.nv)), rng.normal(size=(n, own.nv))
    if base:
        q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
        qd[:, :6] = tau[:, :6] = 0
    return q, qd, tau


def on_host(robot):
    import modyn

    path, floating = ROBOTS[robot]
    return modyn.load(ROOT / path, friction="none", **({"base": "floating"} if floating else {}))


def agrees(name, robot, found):
    """Compares the first accelerations with those of modyn in `f64`."""
    # Libraries give the linear acceleration of a floating base in different frames.
    first = 3 if ROBOTS[robot][1] else 0
    expected = on_host(robot).forward_dynamics(*(x[:COMPARED] for x in states(robot)))[:, first:]
    errors = np.abs(found[:COMPARED, first:] - expected).max(-1) / np.maximum(1, np.abs(expected).max(-1))
    # A few states are badly conditioned.
    usual = np.quantile(errors, 0.9)
    print(f"{name}, {robot}: nine tenths of the errors are below {usual:.1e}", file=sys.stderr)
    return usual < 1e-3


def median(call, wait):
    """Returns the time of a call, s."""
    call()
    wait()
    start = time.perf_counter()
    call()
    wait()
    times = min(max(math.ceil(0.02 / (time.perf_counter() - start)), 1), 10_000)
    passes = []
    for _ in range(11):
        start = time.perf_counter()
        for _ in range(times):
            call()
        wait()
        passes.append((time.perf_counter() - start) / times)
    return statistics.median(passes)


def kernel(options, scalar, name):
    """Returns a kernel of modyn, and prints how long NVRTC takes."""
    import cupy

    command = [os.environ.get("MODYN", "modyn"), "generate", *options, "--target", "cuda", "--scalar", scalar]
    text = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    start = time.perf_counter()
    compiled = cupy.RawModule(code=text).get_function(name)
    print(f"{name}, {scalar}: NVRTC {time.perf_counter() - start:.1f} s", file=sys.stderr)
    block = min(compiled.max_threads_per_block, 128)

    def run(n, *arguments):
        compiled(((n + block - 1) // block,), (block,), (*arguments, np.uint32(n)))

    return run


def measure_modyn(scalar):
    import cupy

    dtype = np.float32 if scalar == "f32" else np.float64
    wait = cupy.cuda.get_current_stream().synchronize
    columns = lambda x: cupy.asarray(np.ascontiguousarray(x.T, dtype))
    rows = {}
    for robot, (path, floating) in ROBOTS.items():
        prefix, base = Path(path).stem, ["--base", "floating"] if floating else []
        every = states(robot)
        nq, nv = every[0].shape[1], every[1].shape[1]
        for function in FUNCTIONS[:1] if robot.startswith("G1") else FUNCTIONS:
            rollout = function.startswith("rollout")
            own = ["--functions", "step_semi_implicit", "--rollout"] if rollout else ["--functions", function]
            run = kernel([path, "--friction", "none", *base, *own], scalar, f"{prefix}_{function}")
            for n in SIZES:
                given = [columns(x[:n]) for x in every]
                results = {"forward_dynamics": nv, "forward_dynamics_derivatives": nv * (1 + 3 * nv)}.get(function, nq + nv)
                out = cupy.full((results, n), np.nan, dtype)
                if rollout:
                    controls = cupy.tile(0.01 * given[2], (STEPS, 1))
                    call = lambda: run(n, *given[:2], controls, out, np.uint64(0), dtype(DT), np.uint32(STEPS), np.uint32(n))
                else:
                    call = lambda: run(n, *given, out)
                seconds = median(call, wait) / (STEPS if rollout else 1)
                rows.setdefault((robot, function), []).append(1e9 * seconds / n)
                if function == "forward_dynamics" and n == SIZES[0]:
                    assert agrees(f"modyn, {scalar}", robot, out.T.get())
                assert bool(cupy.isfinite(out[:nv]).all()), f"{robot}, {function}: numbers are not finite"
                del out, given
    rows[GROUND, "rollout_on_ground"] = measure_ground(dtype, scalar, wait)
    return rows


def measure_ground(dtype, scalar, wait):
    """Returns the times of steps of quadrupeds that stand, whose last heights must be those of the host."""
    import cupy
    import modyn

    path = "robots/quadruped.urdf"
    contacts = {foot: ("point", f"{foot}_foot", [0.0, 0.0, 0.0]) for foot in FEET}
    robot = modyn.load(ROOT / path, base="floating", contacts=contacts, friction="none")
    q = np.concatenate([np.zeros(6), [1.0], [[0.0, 0.6, -1.2][k % 3] * (1 if k < 6 else -1) for k in range(12)]])
    q[2] = -min(robot.link_pose(q, link=f"{foot}_foot").translation[2] for foot in FEET)
    tau = robot.constrained_inverse_dynamics(q, np.zeros(robot.nv), np.zeros(robot.nv)).tau
    tau[:6] = 0
    settings = cupy.asarray(np.asarray(modyn.ConstraintSettings([modyn.ContactTarget()] * 4), dtype))
    rng = np.random.default_rng(0)
    q = np.tile(q, (SIZES[-1], 1))
    q[:, 7:] += 0.02 * rng.normal(size=(len(q), 12))
    few = q[:COMPARED]
    host = robot.rollout(few, 0 * few[:, 1:], np.tile(tau, (COMPARED, STEPS, 1)), DT, step="ground", trajectory=False)
    own = [x for foot in FEET for x in ("--contacts", f"{foot}: point({foot}_foot)")]
    options = [path, "--base", "floating", "--friction", "none", *own, "--functions", "contact_step", "--rollout"]
    run = kernel(options, scalar, "quadruped_rollout_on_ground")
    times = []
    for n in SIZES:
        start = cupy.asarray(np.ascontiguousarray(q[:n].T, dtype))
        still, controls = cupy.zeros((18, n), dtype), cupy.repeat(cupy.asarray(np.tile(tau, STEPS), dtype)[:, None], n, 1)
        out = cupy.full((37, n), np.nan, dtype)
        scalars = dtype(DT), np.uint32(STEPS), np.uint32(n)
        call = lambda: run(n, start, still, controls, settings, out, np.uint64(0), *scalars)
        times.append(1e9 * median(call, wait) / n / STEPS)
        heights = out[2].get()
        apart = np.abs(heights[:COMPARED] - host.q[: len(heights), 2]).max()
        assert apart < 1e-3, f"on the ground the heights are {apart} m apart"
    print(f"{GROUND}, {scalar}: the heights are {apart:.1e} m apart", file=sys.stderr)
    return times


def measure_grid(folder):
    import cupy

    here, library = Path(__file__).parent, Path(folder) / "libgrid.so"
    # The flags of GRiD's own programs.
    flags = ["-std=c++17", "-O3", "-arch=native", "-ftz=true", "-prec-div=false", "-prec-sqrt=false", "-w"]
    command = ["nvcc", *flags, "--shared", "-Xcompiler", "-fPIC", "-I", folder, here / "grid.cu", "-o", library]
    subprocess.run(command, check=True)
    grid = ctypes.CDLL(str(library))
    grid.grid_model.restype = ctypes.c_void_p
    model = ctypes.c_void_p(grid.grid_model())
    # All on the default stream.
    wait = cupy.cuda.Device().synchronize
    every, rows = states("Panda"), {}
    for function, count in (("forward_dynamics", 7), ("forward_dynamics_derivatives", 98)):
        run = getattr(grid, f"grid_{function}")
        for n in SIZES:
            given = cupy.asarray(np.hstack([x[:n] for x in every]).astype(np.float32))
            out = cupy.full((n, count), np.nan, np.float32)
            pointers = ctypes.c_void_p(given.data.ptr), ctypes.c_void_p(out.data.ptr)
            rows.setdefault(("Panda", function), []).append(1e9 * median(lambda: run(*pointers, model, n), wait) / n)
            finite = 100 * float(cupy.isfinite(out).all(1).mean())
            print(f"GRiD, {function}, {n} states: {finite:.2f} % have finite results", file=sys.stderr)
            if function == "forward_dynamics" and n == SIZES[0]:
                assert agrees("GRiD", "Panda", out.get())
    return rows


def measure_jax(library, scalar):
    os.environ.update(JAX_ENABLE_X64=str(int(scalar == "f64")), XLA_PYTHON_CLIENT_PREALLOCATE="false")
    import jax

    # Without it products have 10 bits, and accelerations errors of some percent.
    jax.config.update("jax_default_matmul_precision", "highest")
    assert jax.devices()[0].platform == "gpu", "JAX has no graphics processor"
    rows = {}
    for robot, (path, floating) in ROBOTS.items():
        # MuJoCo's models of floating robots are built otherwise.
        if floating and library is learn.Mjx or robot.startswith("G1"):
            continue
        own = library(ROOT / path, floating)
        q, qd, tau = states(robot)
        batch = jax.jit(jax.vmap(own.forward_dynamics))
        for n in SIZES:
            given = [jax.numpy.asarray(x[:n], scalar.replace("f", "float")) for x in (own.of_modyn(q), qd, tau)]
            last = [None]

            def call():
                last[0] = batch(*given)

            start = time.perf_counter()
            call()
            last[0].block_until_ready()
            print(f"{library.__name__}, {scalar}, {robot}, {n}: first call {time.perf_counter() - start:.1f} s", file=sys.stderr)
            if n == SIZES[0] and not agrees(f"{library.__name__}, {scalar}", robot, np.asarray(last[0])):
                break
            rows.setdefault((robot, "forward_dynamics"), []).append(1e9 * median(call, lambda: last[0].block_until_ready()) / n)
            report(rows)
    return rows


def measure_host(_):
    rows = {}
    for robot in ROBOTS:
        own, every = on_host(robot), states(robot)
        for function in FUNCTIONS[: 1 if robot.startswith("G1") else 2]:
            for n in SIZES if function == "forward_dynamics" else SIZES[:3]:
                given = [np.ascontiguousarray(x[:n]) for x in every]
                seconds = median(lambda: getattr(own, function)(*given), lambda: None)
                rows.setdefault((robot, function), []).append(1e9 * seconds / n)
    return rows


def report(rows):
    """Prints what has been measured so far; the last line counts."""
    print(json.dumps([[*key, times] for key, times in rows.items()]), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grid", help="the folder of GRiD's grid.cuh")
    parser.add_argument("--process", nargs=2, help="measure a library in this process")
    arguments = parser.parse_args()
    libraries = {
        "modyn, CUDA": (measure_modyn, ["f32", "f64"]),
        "GRiD": (lambda _: measure_grid(arguments.grid), ["f32"]),
        "frax": (lambda scalar: measure_jax(learn.Frax, scalar), ["f32", "f64"]),
        "MuJoCo XLA, `mjx.forward`": (lambda scalar: measure_jax(learn.Mjx, scalar), ["f32"]),
        f"modyn, {os.cpu_count()} cores of the host": (measure_host, ["f64"]),
    }
    if arguments.process:
        name, scalar = arguments.process
        report(libraries[name][0](scalar))
        return
    table = []
    for name, (_, scalars) in libraries.items():
        for scalar in scalars:
            command = [sys.executable, __file__, "--process", name, scalar, *(["--grid", arguments.grid] if arguments.grid else [])]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
                try:
                    output, _ = process.communicate(timeout=MAX_SECONDS)
                except subprocess.TimeoutExpired:
                    process.kill()
                    output, _ = process.communicate()
            if process.returncode:
                print(f"{name}, {scalar}: not all could be measured", file=sys.stderr)
            for robot, function, times in json.loads(output.splitlines()[-1]) if output.strip() else []:
                table.append((robot, function, name, scalar, times))
    print("| robot | function | library | scalar | " + " | ".join(f"{n:,} states" for n in SIZES) + " |")
    print("|---" * (4 + len(SIZES)) + "|")
    order = [*((robot, function) for robot in ROBOTS for function in FUNCTIONS), (GROUND, "rollout_on_ground")]
    for robot, function, name, scalar, times in sorted(table, key=lambda row: order.index(row[:2])):
        cells = [f"{times[i]:.3g}" if i < len(times) and times[i] < 100 else f"{times[i]:,.0f}" if i < len(times) else "" for i in range(len(SIZES))]
        print(f"| {robot} | `{function}` | {name} | {scalar} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
