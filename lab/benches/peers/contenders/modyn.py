"""modyn itself, and its interpreter, from `modyn-runner`."""

import shutil
from pathlib import Path

from environment import FREE, HERE, OUTPUT, Unavailable, call, cargo_build, folder
from measure import Program

#: In the table, in the runner, and compiled for.
VARIANTS = [
    ("modyn native", "generated", "native"),
    ("modyn x86-64", "generated", "default"),
    ("modyn, limbs one by one", "alone", "native"),
    ("modyn batch", "batch", "native"),
    ("modyn interpreter", "interpreted", "native"),
]
#: Another checkout's, for a comparison of two commits.
BESIDE = [(f"beside: {name}", variant, target) for name, variant, target in VARIANTS if target == "native"]


def runner(target, processor="native", here=HERE, output=OUTPUT):
    """The runner for a processor's instructions, or for any processor."""
    flags = {"native": f"-C target-cpu={processor}", "default": ""}[target]
    return cargo_build(here / "modyn-runner", output / f"modyn-{target}", flags)


def states(toolbox):
    """Writes the states, and the results that all others are compared with."""
    toolbox.version("rustc", call(["rustc", "--version"]))
    call([runner("default"), "states", toolbox.data])


def build(toolbox):
    runners = {}
    for name, _, target in VARIANTS:
        try:
            runners[target] = runners.get(target) or runner(target, toolbox.processor)
        except Unavailable as why:
            toolbox.missing[name] = str(why)
    return programs(toolbox.robots, runners, [row for row in VARIANTS if row[2] in runners])


def build_beside(toolbox):
    """The programs of the checkout `--beside`, which reads the robots that this one has copied out of wheels."""
    checkout = Path(toolbox.beside).resolve()
    output = checkout / "target" / "peers"
    shutil.copytree(folder(OUTPUT / "robots"), output / "robots", dirs_exist_ok=True)
    # Older checkouts have no folder `lab`.
    peers = next(path for path in (checkout / "lab/benches/peers", checkout / "benches/peers") if path.exists())
    runners = {"native": runner("native", toolbox.processor, peers, output)}
    known = {line.split()[0] for line in (peers / "robots.txt").read_text().splitlines() if line}
    return programs([robot for robot in toolbox.robots if robot.name in known], runners, BESIDE)


def programs(robots, runners, variants):
    for name, variant, target in variants:
        for robot in robots:
            for quantity in robot.quantities:
                if variant == "batch" and not (robot.batch and quantity.endswith("forward_dynamics")):
                    continue
                if variant == "alone" and quantity not in FREE[:-1]:
                    continue
                yield Program(name, target, robot.name, quantity, runners[target], before=(variant,))
