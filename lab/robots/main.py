"""Every robot of example-robot-data: modyn's diagnostics, and the differences from Pinocchio.

Writes docs/data/robots.tsv and docs/data/refusals.tsv. Exit code 1 if a robot that Pinocchio loads differs, or is
refused for a reason that is not listed (`table.REASONS`).
"""

import argparse
import concurrent.futures
import dataclasses
import sys
import time
from pathlib import Path

import numpy

import modyn
import reference
import table

ROBOTS = Path(sys.prefix).glob("lib/python3*/site-packages/cmeel.prefix/share/example-robot-data/robots")
#: Of the largest number of a result; for accelerations times the mass matrix' condition number. modyn takes angles
#: within 1e-11 of a right one as right, which Pinocchio does not.
TOLERANCE = 1e-9


@dataclasses.dataclass
class Row:
    """The findings about a robot."""
    name: str
    errors: list
    warnings: int
    #: The option that a refused robot is usable with; empty if it is not refused.
    needed: str | None
    joints: int | None = None
    velocities: int | None = None
    compared: dict | None = None
    #: Pinocchio's error.
    unloaded: str | None = None
    #: By base, the differences of mass matrix, bias forces and accelerations from Pinocchio, and the tolerances.
    differences: dict = dataclasses.field(default_factory=dict)
    #: The rank of Pinocchio's mass matrix, of its velocities, where modyn refuses.
    rank: tuple | None = None
    seconds: float = 0.0


def relative(found, expected):
    return float(numpy.abs(found - expected).max() / max(numpy.abs(expected).max(), 1e-300))


def differences(description, floating, words, states):
    """Returns the largest differences of all states, each with its tolerance."""
    words = [*words, "floating"] if floating and "floating" not in words else words
    interpreter = modyn.Interpreter(description, words)
    model, _ = reference.load(description, floating)
    mimics = {} if "independent" in words else reference.followers(description)
    theirs = reference.Reference(model, interpreter.joints, mimics)
    random = numpy.random.default_rng(1)
    given = [theirs.random_state(random) for _ in range(states)]
    worst = {}
    for state, ours in zip(given, interpreter.evaluate(given), strict=True):
        expected = theirs.evaluate(*state)
        condition = numpy.linalg.cond(expected[2])
        for name, found, right in zip(("accelerations", "bias forces", "mass matrix"), ours, expected):
            difference = relative(found, right)
            if numpy.isnan(difference):
                difference = numpy.inf
            allowed = TOLERANCE * (condition if name == "accelerations" else 1.0)
            if not difference <= allowed * worst.get(name, (0, 0, -1))[2]:
                worst[name] = difference, allowed, difference / allowed
    return len(interpreter.joints), interpreter.nv, worst


def rank(description):
    """The largest rank of Pinocchio's mass matrix in ten states, and its size."""
    model, _ = reference.load(description)
    mimics = reference.followers(description)
    names = [name for name in list(model.names)[1:] if name not in mimics]
    joints = [modyn.Joint(name, "", 1, 1) for name in names]
    theirs = reference.Reference(model, joints, mimics)
    random = numpy.random.default_rng(1)
    matrices = [theirs.mass_matrix(theirs.random_state(random)[0]) for _ in range(10)]
    return max(numpy.linalg.matrix_rank(matrix, hermitian=True) for matrix in matrices), theirs.nv


def sweep(folder, description, options):
    start = time.monotonic()
    name = str(description.relative_to(folder).with_suffix(""))
    errors, warnings = modyn.check(description)
    needed = ""
    if errors:
        needed = next((option for option in modyn.OPTIONS if not modyn.check(description, option)[0]), None)
    if needed is None:
        # Further checks, which run only on physical inertias.
        errors += [error for error in modyn.check(description, "--unphysical-inertia warn")[0] if error not in errors]
    row = Row(name, errors, warnings, needed)
    model, row.unloaded = reference.load(description)
    if needed is not None:
        words = modyn.OPTIONS.get(needed, [])
        if model:
            for base in ["fixed", "floating"] if "floating" not in words else ["floating"]:
                joints, velocities, found = differences(description, base == "floating", words, options.states)
                row.differences[base] = found
                if row.joints is None:
                    row.joints, row.velocities = joints, velocities
        else:
            interpreter = modyn.Interpreter(description, words)
            row.joints, row.velocities = len(interpreter.joints), interpreter.nv
        row.compared = modyn.compare(description, needed, row.velocities)
    elif model:
        row.rank = rank(description)
    row.seconds = time.monotonic() - start
    print(f"{name}: {row.seconds:.0f} s", file=sys.stderr)
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="robots whose path contains this; the tables go to the terminal")
    parser.add_argument("--states", type=int, default=100, help="random states against Pinocchio (default: 100)")
    parser.add_argument("--jobs", type=int, default=2, help="robots at a time (default: 2)")
    options = parser.parse_args()
    start = time.monotonic()
    modyn.build()
    folder = next(ROBOTS)
    descriptions = [path for path in sorted(folder.rglob("*.urdf")) if options.only in str(path)]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        rows = list(pool.map(lambda path: sweep(folder, path, options), descriptions))
    for name, text in table.files(rows, time.monotonic() - start).items():
        if options.only:
            print(text)
        else:
            (modyn.ROOT / "docs" / "data" / f"{name}.tsv").write_text(text)
    wrong = [row.name for row in rows if not table.fine(row)]
    if wrong:
        sys.exit(f"not as it should be: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
