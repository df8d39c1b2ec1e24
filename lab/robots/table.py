"""The findings as files of docs/data."""

import datetime
import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

import modyn

#: By code: why such a description has no dynamics as it is.
REASONS = {
    "indefinite-inertia": "no rigid body has such an inertia",
    "triangle-inequality": "no rigid body has such an inertia",
    "singular-joint": "a joint moves nothing that has inertia: any torque would accelerate it without bound",
    "no-moving-joint": "nothing moves, unless the base floats",
    "mimic-target": "a joint mimics one that is not in the file",
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
    return "refused" + (f"; usable with `{row.needed}`" if row.needed else "")


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
        return f"the mass matrix has rank {row.rank[0]} of {row.rank[1]}"
    return row.unloaded or ""


def processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    return next((line.split(": ")[1] for line in lines if line.startswith("model name")), platform.processor())


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=modyn.ROOT).stdout.strip()


def data(head, rows, note, command="lab/robots/run"):
    """The text of a file of docs/data: how it was made, the titles of the columns, and the rows."""
    lines = [
        f"# command: {command}",
        f"# date: {datetime.date.today()}",
        f"# commit: {output('git', 'describe', '--always', '--dirty')}",
        f"# note: {note}",
    ]
    return "\n".join(lines + ["\t".join(str(cell) for cell in row) for row in [head, *rows]]) + "\n"


def files(rows, seconds):
    """The files of docs/data by name: all robots, and the reasons of those that are refused."""
    note = (f"example-robot-data {version('example-robot-data')}, Pinocchio {version('pin')}; {seconds / 60:.0f} minutes "
            f"on {os.cpu_count()} cores, {processor()}")
    head = ["robot", "joints", "`modyn check`", "compiled", "mass matrix, Pinocchio", "bias forces", "accelerations"]
    robots = [[row.name, "" if row.joints is None else row.joints, checked(row), compared(row), *pinocchio(row)]
              for row in rows]
    refused = [[row.name, *line, aside(row)] for row in rows if row.errors for line in refusals(row)]
    why = ["robot", "code", "first error of this kind", "reason", "Pinocchio"]
    return {"robots": data(head, robots, note), "refusals": data(why, refused, note)}


def is_model(row):
    """Whether a file is a whole model: parts, and files that only MuJoCo's programs complete, are not."""
    return row.verdict in ("accepted", "by an option", "refused") and row.compared not in ("static", "not loaded") or row.compared == "loads"


def collections(rows, seconds):
    """The files of docs/data by name: the sums of each collection and format, and all files."""
    note = (f"MuJoCo {version('mujoco')}, Pinocchio {version('pin')}, Drake {version('drake')}; {seconds / 60:.0f} minutes "
            f"on {os.cpu_count()} cores, {processor()}")
    groups = {}
    for row in rows:
        groups.setdefault((row.collection, row.format), []).append(row)
    sums = [[*key, len(found), sum(is_model(row) for row in found), sum(row.verdict == "accepted" for row in found),
             sum(row.verdict == "by an option" for row in found),
             sum(row.compared == "agrees" for row in found), sum(row.compared.startswith("DIFFERS") for row in found),
             sum(row.compared.startswith("not compared") for row in found)] for key, found in sorted(groups.items())]
    head = ["collection", "format", "files", "models that move", "accepted", "by an option", "agree", "differ", "not compared"]
    every = [[row.collection, row.file, row.format, row.option and f"{row.verdict}, `{row.option}`" or row.verdict, "" if row.joints is None else row.joints, row.compared,
              "" if row.difference is None else f"{row.difference:.0e}", row.code, " ".join(row.why.split())]
             for row in rows]
    titles = ["collection", "file", "format", "verdict", "joints", "compared", "difference", "code", "why"]
    command = "lab/robots/run collections NAME=FOLDER ..."
    return {"collections": data(head, sums, note, command), "collected": data(titles, every, note, command)}
