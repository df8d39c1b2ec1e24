"""modyn itself, and its interpreter, from `modyn-runner`."""

import os

from environment import HERE, OUTPUT, call
from measure import Program

#: In the table, in the runner, and compiled for.
WAYS = [
    ("modyn native", "generated", "native"),
    ("modyn x86-64", "generated", "default"),
    ("modyn, limbs one by one", "alone", "native"),
    ("modyn batch", "batch", "native"),
    ("modyn interpreter", "interpreted", "native"),
]


def runner(toolbox, target):
    """The runner for this machine's instructions, or for any machine's."""
    flags = {"native": "-C target-cpu=native", "default": ""}[target]
    folder = OUTPUT / f"modyn-{target}"
    manifest = HERE / "modyn-runner" / "Cargo.toml"
    call(["cargo", "build", "--release", "--manifest-path", manifest, "--target-dir", folder],
         env={**os.environ, "RUSTFLAGS": flags})
    return folder / "release" / "modyn-runner"


def states(toolbox):
    """Writes the states, and the results that all others are compared with."""
    toolbox.version("rustc", call(["rustc", "--version"]))
    call([runner(toolbox, "default"), "states", toolbox.data])


def build(toolbox):
    runners = {target: runner(toolbox, target) for target in ["default", "native"]}
    for name, way, target in WAYS:
        for robot in toolbox.robots:
            for quantity in robot.quantities:
                if way == "batch" and quantity != "forward_dynamics":
                    continue
                if way == "alone" and "derivatives" in quantity:
                    continue
                yield Program(name, target, robot.name, quantity, runners[target], before=(way,))
