"""The commands of modyn, on one description."""

import dataclasses
import json
import os
import subprocess
from pathlib import Path

import numpy

ROOT = Path(__file__).resolve().parents[2]
RELEASE = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
#: Options of `modyn` that are tried one after the other on a refused description, with words of `evaluate`.
OPTIONS = {
    "--mimic independent": ["independent"],
    "--unphysical-inertia warn": ["warn"],
    "--unsupported-forces warn": ["forces"],
    "--base floating": ["floating"],
}
#: The compared functions of robots with more than `SMALL` velocities, whose other functions take rustc minutes.
FEW = "forward_dynamics,inverse_dynamics,mass_matrix,center_of_mass"
SMALL = 7


def build():
    cargo = ["cargo", "build", "--release", "--quiet", "--manifest-path", ROOT / "Cargo.toml"]
    subprocess.run([*cargo, "-p", "modyn-cli"], check=True)
    subprocess.run([*cargo, "-p", "modyn-codegen", "--example", "evaluate"], check=True)


def call(*words, given=None, seconds=600):
    return subprocess.run([str(word) for word in words], input=given, capture_output=True, text=True, timeout=seconds)


def check(description, options=""):
    """All that is wrong with a description."""
    done = call(RELEASE / "modyn", "check", "--json", description, *options.split())
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{description}: modyn check: {done.stderr}")
    found = json.loads(done.stdout)[0]["diagnostics"]
    errors = [one for one in found if one["severity"] == "error"]
    assert (done.returncode == 1) == bool(errors), "the exit code says what the diagnostics say"
    return errors, len(found) - len(errors)


def compare(description, options, velocities):
    """Generated code against the interpreter: its JSON."""
    functions = [] if velocities <= SMALL else ["--functions", FEW]
    done = call(RELEASE / "modyn", "compare", "--json", description, *options.split(), *functions)
    if done.returncode not in (0, 1) or not done.stdout:
        raise RuntimeError(f"{description}: modyn compare: {done.stderr}")
    return json.loads(done.stdout)


@dataclasses.dataclass
class Joint:
    """A joint that has coordinates of its own."""
    name: str
    kind: str
    nq: int
    nv: int


class Interpreter:
    """The interpreter on a description, read with words of the example `evaluate`."""

    def __init__(self, description, words):
        self.command = [RELEASE / "examples" / "evaluate", description, *words]
        self.joints = []
        for line in self.run("").split("\n\n")[0].splitlines():
            nq, nv, kind, name = line.split(" ", 3)
            self.joints.append(Joint(name, kind, int(nq), int(nv)))
        self.nv = sum(joint.nv for joint in self.joints)

    def run(self, given):
        done = call(*self.command, given=given)
        if done.returncode != 0:
            raise RuntimeError(f"evaluate: {done.stderr}")
        return done.stdout

    def evaluate(self, states):
        """Accelerations, bias forces and mass matrix of each state (q, qd, tau)."""
        given = "".join(" ".join(map(repr, numpy.concatenate(state).tolist())) + "\n" for state in states)
        n = self.nv
        for line in self.run(given).split("\n\n")[1].splitlines():
            numbers = numpy.array(line.split(), dtype=float)
            yield numbers[:n], numbers[n:2 * n], numbers[2 * n:(2 + n) * n].reshape(n, n).T

    def evaluate_kinematics(self, states):
        """By joint, the rotation, the position and the velocity of its link, of a robot without inertia."""
        given = "".join(" ".join(map(repr, numpy.concatenate(state).tolist())) + "\n" for state in states)
        for line in self.run(given).split("\n\n")[1].splitlines():
            yield numpy.array(line.split(), dtype=float).reshape(len(self.joints), 18)

    def evaluate_loops(self, states):
        """Accelerations of each state with the loops closed, and the largest displacement of a loop; None without loops."""
        given = "".join(" ".join(map(repr, numpy.concatenate(state).tolist())) + "\n" for state in states)
        n = self.nv
        for line in self.run(given).split("\n\n")[1].splitlines():
            closed = numpy.array(line.split()[(2 + n) * n:], dtype=float)
            yield (closed[:n], float(numpy.abs(closed[n:]).max())) if len(closed) else None
