"""The findings as Markdown."""

import os
import platform
from importlib.metadata import version
from pathlib import Path

import modyn

#: By code: why such a description has no dynamics as it is.
REASONS = {
    "indefinite-inertia": "no rigid body has such an inertia",
    "triangle-inequality": "no rigid body has such an inertia",
    "singular-joint": "a joint moves nothing that has inertia: any torque would accelerate it without bound",
    "no-moving-joint": "nothing moves, unless the base floats",
    "mimic-target": "a joint mimics one that is not in the file: what it follows is unknown",
    "no-link": "there is nothing in the file",
}


def differing(row):
    """Returns the quantities that differ from Pinocchio, by base."""
    return [f"{quantity} ({base})" for base, found in row.differences.items()
            for quantity, (difference, allowed, _) in found.items() if not difference <= allowed]


def fine(row):
    explained = all(error["code"] in REASONS for error in row.errors)
    agrees = row.compared is None or row.compared["agrees"]
    return explained and agrees and not differing(row) and (row.rank is None or row.rank[0] < row.rank[1])


def checked(row):
    if not row.errors:
        return "usable" + (f", {row.warnings} warning{'s' * (row.warnings > 1)}" if row.warnings else "")
    return "refused" + (f"; usable with `{row.way}`" if row.way else "")


def compared(row):
    if row.compared is None:
        return ""
    functions = row.compared["functions"]
    if not row.compared["agrees"]:
        return "DIFFERS: " + ", ".join(one["name"] for one in functions if not one["agrees"])
    return f"{max(one['difference'] for one in functions):.0e} ({len(functions)})"


def pinocchio(row):
    """A column a quantity: the largest difference over both bases."""
    if row.unloaded:
        return ["does not load", "", ""]
    if not row.differences:
        return ["loads", "", ""]
    cells = []
    for quantity in ("mass matrix", "bias forces", "accelerations"):
        worst = max((found[quantity] for found in row.differences.values()), key=lambda found: found[2])
        cells.append(f"{worst[0]:.0e}" + ("" if worst[0] <= worst[1] else " DIFFERS"))
    return cells


def refusals(row):
    """A line for each kind of error, with the first of its kind."""
    kinds = {}
    for error in row.errors:
        kinds.setdefault(error["code"], []).append(error)
    for code, errors in kinds.items():
        first, more = errors[0], f", and {len(errors) - 1} more" if len(errors) > 1 else ""
        subject = first["subject"]
        about = f"{subject['kind']} `{subject['name']}`: " if subject else ""
        yield [f"`{code}`", f"{about}{first['message']}{more}", REASONS.get(code, "NOT EXPLAINED")]


def aside(row):
    """Returns Pinocchio's error for a description that modyn refuses with all options."""
    if row.rank:
        return f"its mass matrix in Pinocchio has rank {row.rank[0]} of {row.rank[1]}"
    return f"Pinocchio: {row.unloaded}" if row.unloaded else ""


def processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    return next((line.split(": ")[1] for line in lines if line.startswith("model name")), platform.processor())


def lines(head, rows):
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield f"| {' | '.join(str(cell) for cell in row)} |"


def text(rows, options, seconds):
    usable = [row for row in rows if not row.errors]
    by_option = [row for row in rows if row.errors and row.way]
    loaded = [row for row in rows if not row.unloaded]
    against = [row for row in rows if row.differences]
    agreeing = [row for row in against if not differing(row)]
    out = [
        "# Real robots",
        "",
        f"The PyPI package `example-robot-data` {version('example-robot-data')} has {len(rows)} descriptions of real "
        f"robots. {len(usable)} of them are usable as they are, {len(by_option)} with an option, and "
        f"{len(rows) - len(usable) - len(by_option)} are refused. Pinocchio {version('pin')} loads {len(loaded)}; "
        f"{len(against)} of these were computed by both, and {len(agreeing)} agree.",
        "",
        "```console",
        "tools/robots/run",
        "```",
        "",
        f"writes this page ({seconds / 60:.0f} minutes on {os.cpu_count()} cores, {processor()}, most of them in rustc). "
        "It fetches the robots; none of their files are part of modyn.",
        "",
        "- *joints* are those with coordinates of their own, on a fixed base; joints that mimic others follow them. "
        "Where an option was needed, all that stands behind it was found with that option.",
        "- *compiled*: `modyn compare`, generated code against the interpreter in 100 random states: the largest "
        "difference relative to the largest number of a result, and of how many functions "
        f"(all up to {modyn.SMALL} velocities, beyond them those of dynamics without derivatives).",
        f"- *Pinocchio*: the interpreter against Pinocchio in {options.states} random states, on a fixed and on a "
        "floating base: largest differences relative to the largest number of a result. Allowed is 1e-9, for "
        "accelerations times the condition number of the mass matrix: modyn takes angles within 1e-11 of a right one, "
        "such as 1.57079632679, as right, and Pinocchio does not.",
        "",
    ]
    head = ["robot", "joints", "`modyn check`", "compiled", "mass matrix, Pinocchio", "bias forces", "accelerations"]
    out += lines(head, ([row.name, "" if row.joints is None else row.joints, checked(row), compared(row),
                         *pinocchio(row)] for row in rows))
    out += ["", "## What is refused, and why", ""]
    refused = [row for row in rows if row.errors]
    head = ["robot", "code", "the first of its kind", "why", "besides"]
    out += lines(head, ([row.name, *line, aside(row)] for row in refused for line in refusals(row)))
    return "\n".join(out) + "\n"
