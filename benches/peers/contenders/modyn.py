"""modyn itself, and its interpreter, from `modyn-runner`."""

import os
import platform

from environment import HERE, OUTPUT, call
from measure import Program

#: This machine's instructions; AVX2 and FMA alone, which LLVM can schedule better than AVX-512.
THIS_MACHINE = ["native", "v3"] if platform.machine() == "x86_64" else ["native"]
#: In the table, in the runner, and compiled for, of which the fastest counts.
WAYS = [
    ("modyn native", "generated", THIS_MACHINE),
    ("modyn x86-64", "generated", ["default"]),
    ("modyn, limbs one by one", "alone", THIS_MACHINE),
    ("modyn batch", "batch", ["native"]),
    ("modyn interpreter", "interpreted", ["native"]),
]
FLAGS = {"native": "-C target-cpu=native", "v3": "-C target-cpu=x86-64-v3", "default": ""}


def runner(toolbox, target):
    """The runner compiled for a target."""
    folder = OUTPUT / f"modyn-{target}"
    manifest = HERE / "modyn-runner" / "Cargo.toml"
    call(["cargo", "build", "--release", "--manifest-path", manifest, "--target-dir", folder],
         env={**os.environ, "RUSTFLAGS": FLAGS[target]})
    return folder / "release" / "modyn-runner"


def states(toolbox):
    """Writes the states and what all results are checked against."""
    toolbox.version("rustc", call(["rustc", "--version"]))
    call([runner(toolbox, "default"), "states", toolbox.data])


def build(toolbox):
    runners = {target: runner(toolbox, target) for target in ["default", *THIS_MACHINE]}
    for name, way, target in [(name, way, target) for name, way, targets in WAYS for target in targets]:
        for robot in toolbox.robots:
            for quantity in robot.quantities:
                if way == "batch" and quantity != "forward_dynamics":
                    continue
                if way == "alone" and "derivatives" in quantity:
                    continue
                yield Program(name, target, robot.name, quantity, runners[target], before=(way,))
