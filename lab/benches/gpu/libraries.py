"""Time of a state on the machine's graphics processor: modyn's CUDA kernels, GRiD, frax and MuJoCo XLA; and modyn on the host.

    measure="python lab/benches/gpu/libraries.py --grid FOLDER"
    $measure | lab/record "$measure" "NOTE" > docs/data/gpu-libraries.tsv

Needs nvcc, CuPy, JAX, frax, MuJoCo XLA, GRiD (`pip install grid-rbd==0.6.0`), the package `modyn`, and the command `modyn`
(MODYN); a library that is missing is left out. FOLDER keeps what GRiD generates and nvcc compiles, some minutes for G1.

Each library runs in a process of its own. A time is the median of 11 passes; a pass starts the function so often that it takes
some 20 ms, and waits once. Numbers stay on the graphics processor. A library whose first 200 accelerations are not those of modyn
on the host in `f64` is left out, and so are derivatives. Rollouts have 50 steps of 2 ms, and their time is that of a step.

GRiD's forward dynamics is the faster of its `forward_dynamics` and `aba`. Its `forward_dynamics_gradient` stores the derivatives
by q and by qd; modyn stores the accelerations and the derivatives by tau besides. GRiD's kernels run with the number of threads,
of blocks, and the share of shared memory that is fastest for so many states, of a choice.
"""

import argparse
import ctypes
import functools
import json
import math
import os
import re
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
STEPS, DT, COMPARED, MAX_SECONDS = 50, 0.002, 200, 300
# The most bytes of the results of a call.
MAX_BYTES = 16e9
# The name, the file, whether the base floats.
ROBOTS = {
    "Panda": ("tests/golden/panda.urdf", False),
    "Solo12, floating base": ("tests/golden/solo12.urdf", True),
    "G1, floating base": ("tests/golden/g1.urdf", True),
}
GROUND = "quadruped on four feet"
FEET = ["front_left", "front_right", "hind_left", "hind_right"]
FUNCTIONS = ["forward_dynamics", "forward_dynamics_derivatives", "rollout_semi_implicit"]
ORDER = [*((robot, function) for robot in ROBOTS for function in FUNCTIONS), (GROUND, "rollout")]
# The numbers of GRiD's kernels in grid.cu, and numbers of threads.
GRID = {"forward_dynamics": {0: "forward_dynamics", 1: "aba"}, "forward_dynamics_derivatives": {2: "forward_dynamics_gradient"}}
THREADS, TIERS = [32, 64, 96, 128, 192, 256, 384, 512, 768], [0, 1, 2]
# The most states that choices are compared for.
CHOSEN = 16_384


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
    return modyn.load(ROOT / path, joint_friction="none", **({"base": "floating"} if floating else {}))


def agrees(name, robot, found, function="forward_dynamics"):
    """Compares the first accelerations, or their derivatives by q and by qd as columns of one row, with those of modyn in `f64`."""
    # Libraries give the linear acceleration of a floating base in different frames. Without it gravity has no effect: only robots with
    # a fixed base show a wrong sign of gravity.
    first = 3 if ROBOTS[robot][1] else 0
    expected = getattr(on_host(robot), function)(*(x[:COMPARED] for x in states(robot)))
    if function == "forward_dynamics_derivatives":
        expected = np.concatenate([expected.dqdd_dq, expected.dqdd_dqd], -1)
        found = found[:COMPARED].reshape(COMPARED, expected.shape[2], -1).swapaxes(1, 2)
    largest = lambda x: np.abs(x[:COMPARED, first:]).reshape(COMPARED, -1).max(-1)
    errors = largest(found[:COMPARED] - expected) / np.maximum(1, largest(expected))
    # A few states are badly conditioned.
    usual = np.quantile(errors, 0.9)
    print(f"{name}, {robot}, {function}: nine tenths of the errors are below {usual:.1e}", file=sys.stderr)
    return usual < 1e-3


def once(call, wait, times=1):
    """Returns the time of a call, s, of one pass."""
    start = time.perf_counter()
    for _ in range(times):
        call()
    wait()
    return (time.perf_counter() - start) / times


def median(call, wait):
    """Returns the time of a call, s."""
    once(call, wait)
    times = min(max(math.ceil(0.02 / once(call, wait)), 1), 10_000)
    return statistics.median(once(call, wait, times) for _ in range(11))


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


def measure_modyn(scalar, selected):
    import cupy

    dtype = np.float32 if scalar == "f32" else np.float64
    wait = cupy.cuda.get_current_stream().synchronize
    columns = lambda x: cupy.asarray(np.ascontiguousarray(x.T, dtype))
    rows = {}
    if selected(GROUND, "rollout"):
        rows[GROUND, "rollout"] = measure_ground(dtype, scalar, wait)
    for robot, (path, floating) in ROBOTS.items():
        prefix, base = Path(path).stem, ["--base", "floating"] if floating else []
        for function in filter(functools.partial(selected, robot), FUNCTIONS):
            # NVRTC takes minutes for derivatives of G1 in `f64`.
            if robot.startswith("G1") and (function == FUNCTIONS[2] or function == FUNCTIONS[1] and scalar == "f64"):
                continue
            every = states(robot)
            nq, nv = every[0].shape[1], every[1].shape[1]
            rollout = function.startswith("rollout")
            own = ["--functions", "step_semi_implicit", "--rollout"] if rollout else ["--functions", function]
            run = kernel([path, "--joint-friction", "none", *base, *own], scalar, f"{prefix}_{function}")
            results = {"forward_dynamics": nv, "forward_dynamics_derivatives": nv * (1 + 3 * nv)}.get(function, nq + nv)
            for n in SIZES:
                if results * n * dtype().itemsize > MAX_BYTES:
                    break
                given = [columns(x[:n]) for x in every]
                out = cupy.full((results, n), np.nan, dtype)
                if rollout:
                    controls = cupy.tile(0.01 * given[2], (STEPS, 1))
                    call = lambda: run(n, *given[:2], controls, out, np.uint64(0), dtype(DT), np.uint32(STEPS), np.uint32(n))
                else:
                    call = lambda: run(n, *given, out)
                seconds = median(call, wait) / (STEPS if rollout else 1)
                rows.setdefault((robot, function), []).append(1e9 * seconds / n)
                if n == SIZES[0] and not rollout:
                    found = out.T.get()
                    found = found[:, nv : nv + 2 * nv * nv] if function == "forward_dynamics_derivatives" else found
                    assert agrees(f"modyn, {scalar}", robot, found, function)
                assert bool(cupy.isfinite(out[:nv]).all()), f"{robot}, {function}: numbers are not finite"
                del out, given
            report(rows)
    return rows


def measure_ground(dtype, scalar, wait):
    """Returns the times of steps of quadrupeds that stand, whose last heights must be those of the host."""
    import cupy
    import modyn

    path = "robots/quadruped.urdf"
    contacts = {foot: ("point", f"{foot}_foot", [0.0, 0.0, 0.0]) for foot in FEET}
    robot = modyn.load(ROOT / path, base="floating", contacts=contacts, joint_friction="none")
    q = np.concatenate([np.zeros(6), [1.0], [[0.0, 0.6, -1.2][k % 3] * (1 if k < 6 else -1) for k in range(12)]])
    q[2] = -min(robot.link_pose(q, link=f"{foot}_foot").translation[2] for foot in FEET)
    tau = robot.constrained_inverse_dynamics(q, np.zeros(robot.nv), np.zeros(robot.nv)).tau
    tau[:6] = 0
    settings = cupy.asarray(np.asarray(robot.step_settings(), dtype))
    rng = np.random.default_rng(0)
    q = np.tile(q, (SIZES[-1], 1))
    q[:, 7:] += 0.02 * rng.normal(size=(len(q), 12))
    few = q[:COMPARED]
    host = robot.rollout(few, 0 * few[:, 1:], np.tile(tau, (COMPARED, STEPS, 1)), DT, step="step", trajectory=False)
    own = [x for foot in FEET for x in ("--contacts", f"{foot}: point({foot}_foot)")]
    options = [path, "--base", "floating", "--joint-friction", "none", *own, "--functions", "step", "--rollout"]
    run = kernel(options, scalar, "quadruped_rollout")
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


def load_grid(folder, path, floating):
    """Returns GRiD's kernels of a robot, which are generated and compiled unless the folder has them."""
    folder, here, name = Path(folder).resolve(), Path(__file__).parent, Path(path).stem
    header, library = folder / f"{name}.cuh", folder / f"lib{name}.so"
    if not library.exists():
        own = ["--algorithm-list", "aba,forward_dynamics,forward_dynamics_gradient", "--no-mujoco-kernels", "-o", header]
        subprocess.run(["grid-generate", ROOT / path, *(["-f"] if floating else []), *own], check=True, stdout=sys.stderr)
        # The flags of GRiD's own package.
        flags = ["-std=c++17", "-O3", "-arch=native", "-ftz=true", "-prec-div=false", "-prec-sqrt=false", "-w"]
        command = ["nvcc", *flags, f'-DGRID="{header}"', "--shared", "-Xcompiler", "-fPIC", here / "grid.cu", "-o", library]
        subprocess.run(command, check=True)
    grid = ctypes.CDLL(str(library))
    grid.grid_model.restype, grid.grid_workspace.restype = ctypes.c_void_p, ctypes.c_size_t
    return grid


def fastest(grid, kernels, start, wait, n, most_blocks):
    """Returns the fastest choice of a kernel, a tier, threads and a limit of blocks."""
    found = {}
    for kernel in kernels:
        for tier in TIERS:
            limit = grid.grid_threads(kernel, tier)
            for threads in sorted({x for x in THREADS if x < limit} | {limit} - {0}):
                for blocks in most_blocks[: 1 if n <= most_blocks[-1] else 2]:
                    choice = kernel, tier, threads, blocks
                    call = functools.partial(start, *choice)
                    once(call, wait)
                    found[choice] = once(call, wait, max(4096 // n, 1))
    for choice in sorted(found, key=found.get)[:5]:
        call = functools.partial(start, *choice)
        found[choice] = statistics.median(once(call, wait, max(CHOSEN // n, 1)) for _ in range(3))
    return min(found, key=found.get)


def measure_grid(folder, selected):
    import cupy

    # All on the default stream.
    wait, rows = cupy.cuda.Device().synchronize, {}
    resident = 32 * cupy.cuda.Device().attributes["MultiProcessorCount"]
    workspace = cupy.empty(8 << 30, np.uint8)
    address = lambda x: ctypes.c_void_p(x.data.ptr)
    for robot, function in ((robot, function) for robot in ROBOTS for function in GRID if selected(robot, function)):
        grid = load_grid(folder, *ROBOTS[robot])
        model, most = ctypes.c_void_p(grid.grid_model()), workspace.size // grid.grid_workspace()
        every, derivatives = states(robot), function == "forward_dynamics_derivatives"
        nq, nv = every[0].shape[1], every[1].shape[1]
        count = 2 * nv * nv if derivatives else nq
        grid.grid_keep(address(workspace), ctypes.c_size_t(workspace.size if derivatives else 0))
        for n in SIZES:
            # GRiD numbers results by an `int`.
            if n * count >= 2**31:
                break
            given, out = np.zeros((n, 3, nq), np.float32), cupy.full((n, count), np.nan, np.float32)
            for k, x in enumerate(every):
                given[:, k, : x.shape[1]] = x[:n]
            pointers = *map(address, (given := cupy.asarray(given), out, workspace)), model

            def start(states, kernel, tier, threads, most_blocks):
                error = grid.grid_run(kernel, tier, threads, min(states, most_blocks), *pointers, states)
                assert not error, f"GRiD, {robot}, {function}: error {error} of the start"

            if n < SIZES[-1]:
                few = min(n, CHOSEN)
                choice = fastest(grid, GRID[function], functools.partial(start, few), wait, few, [most, min(most, resident)])
            seconds = median(functools.partial(start, n, *choice), wait)
            finite = 100 * float(cupy.isfinite(out[:, :nv]).all(1).mean())
            own = f"{GRID[function][choice[0]]}, tier {choice[1]}, {choice[2]} threads, at most {choice[3]} blocks"
            print(f"GRiD, {robot}, {function}, {n} states: {own}; {finite:.2f} % have finite results", file=sys.stderr)
            found = out[:COMPARED].get()
            if not agrees("GRiD", robot, found if derivatives else found[:, :nv], function):
                break
            rows.setdefault((robot, function), []).append(1e9 * seconds / n)
            report(rows)
            del given, out, pointers
    return rows


def measure_jax(library, scalar, selected):
    os.environ.update(JAX_ENABLE_X64=str(int(scalar == "f64")), XLA_PYTHON_CLIENT_PREALLOCATE="false")
    import jax

    # Without it products have 10 bits, and accelerations errors of some percent.
    jax.config.update("jax_default_matmul_precision", "highest")
    assert jax.devices()[0].platform == "gpu", "JAX has no graphics processor"
    rows = {}
    for robot, (path, floating) in ROBOTS.items():
        # MuJoCo's models of floating robots are built otherwise.
        if floating and library is learn.Mjx or robot.startswith("G1") or not selected(robot, "forward_dynamics"):
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


def measure_host(_, selected):
    rows = {}
    for robot in ROBOTS:
        for function in filter(functools.partial(selected, robot), FUNCTIONS[:2]):
            own, every = on_host(robot), states(robot)
            for n in SIZES if function == "forward_dynamics" else SIZES[:3]:
                given = [np.ascontiguousarray(x[:n]) for x in every]
                seconds = median(lambda: getattr(own, function)(*given), lambda: None)
                rows.setdefault((robot, function), []).append(1e9 * seconds / n)
    return rows


def report(rows):
    """Prints what has been measured so far; the last line counts."""
    print(json.dumps([[*key, times] for key, times in rows.items()]), flush=True)


def show(table):
    """Prints rows of a robot, a function, a library, a scalar and times."""
    print("| robot | function | library | scalar | " + " | ".join(f"{n:,} states" for n in SIZES) + " |")
    print("|---" * (4 + len(SIZES)) + "|")
    for robot, function, name, scalar, times in sorted(table, key=lambda row: ORDER.index(row[:2])):
        cells = [f"{times[i]:.3g}" if i < len(times) and times[i] < 100 else f"{times[i]:,.0f}" if i < len(times) else "" for i in range(len(SIZES))]
        print(f"| {robot} | `{function}` | {name} | {scalar} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grid", help="the folder of GRiD's kernels")
    parser.add_argument("--only", default="", help="measure rows alone whose robot, function, library and scalar have this pattern")
    parser.add_argument("--process", nargs=2, help="measure a library in this process")
    arguments = parser.parse_args()
    libraries = {
        "modyn, CUDA": (measure_modyn, ["f32", "f64"]),
        "GRiD": (lambda _, selected: measure_grid(arguments.grid, selected), ["f32"]),
        "frax": (functools.partial(measure_jax, learn.Frax), ["f32", "f64"]),
        "MuJoCo XLA, `mjx.forward`": (functools.partial(measure_jax, learn.Mjx), ["f32"]),
        f"modyn, {os.cpu_count()} cores of the host": (measure_host, ["f64"]),
    }

    def selected(name, scalar, robot, function):
        return re.search(arguments.only, f"{robot}, {function}, {name}, {scalar}")

    if arguments.process:
        name, scalar = arguments.process
        report(libraries[name][0](scalar, functools.partial(selected, name, scalar)))
        return
    table = []
    for name, (_, scalars) in libraries.items():
        for scalar in scalars:
            if not any(selected(name, scalar, *key) for key in ORDER):
                continue
            own = ["--only", arguments.only, *(["--grid", arguments.grid] if arguments.grid else [])]
            command = [sys.executable, __file__, "--process", name, scalar, *own]
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
    show(table)


if __name__ == "__main__":
    main()
