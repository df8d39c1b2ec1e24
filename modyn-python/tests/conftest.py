"""Robots, states and programs of pages for the tests."""

import re
import threading
from pathlib import Path

import numpy as np
import pytest

import modyn

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "tests" / "golden"
ROBOTS = ROOT / "robots"


def blocks(page, language="python"):
    """Returns the programs of a page in this language."""
    return re.findall(rf"^```{language}\n(.*?)^```", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)


def rotation(rng):
    """Returns a random quaternion x, y, z, w of length 1."""
    quaternion = rng.normal(size=4)
    return quaternion / np.linalg.norm(quaternion)


def chain(seed, joints=6, branches=2):
    """Returns the URDF of a random tree in general position: rotated frames, oblique axes, full inertias."""
    rng = np.random.default_rng(seed)
    numbers = lambda values: " ".join(f"{x:.17g}" for x in values)
    text = [f'<robot name="random{seed}"><link name="base"><inertial><origin xyz="0.1 -0.2 0.3"/>'
            '<mass value="4"/><inertia ixx="0.3" ixy="0.02" ixz="-0.01" iyy="0.4" iyz="0.03" izz="0.5"/></inertial></link>']
    for i in range(joints):
        parent = "base" if i == 0 else f"link{max(0, i - rng.integers(1, branches + 1))}"
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        kind = "prismatic" if i % 3 == 2 else "revolute"
        factor = rng.normal(size=(3, 3))
        # The inertia of point masses at the rows of `factor`.
        inertia = np.trace(factor @ factor.T) * np.eye(3) - factor.T @ factor
        entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        entries = " ".join(f'{name}="{inertia[at] * 0.1:.17g}"' for name, at in entries.items())
        text.append(
            f'<joint name="joint{i}" type="{kind}"><parent link="{parent}"/><child link="link{i}"/>'
            f'<origin xyz="{numbers(rng.normal(size=3))}" rpy="{numbers(rng.uniform(-3, 3, 3))}"/>'
            f'<axis xyz="{numbers(axis)}"/><limit lower="-2" upper="2" effort="10" velocity="5"/></joint>'
            f'<link name="link{i}"><inertial><origin xyz="{numbers(rng.normal(size=3))}" '
            f'rpy="{numbers(rng.uniform(-3, 3, 3))}"/><mass value="{rng.uniform(0.5, 3)}"/>'
            f"<inertia {entries}/></inertial></link>"
        )
    return "".join(text) + "</robot>"


def states(robot, n, seed=0):
    """Returns n random states: coordinates, velocities, accelerations, joint forces."""
    rng = np.random.default_rng(seed)
    q = robot.random_configuration(rng.random((n, robot.nv)))
    for joint in robot.joints:
        if joint.type == "floating":
            q[:, joint.q][:, :3] = rng.normal(size=(n, 3))
    return q, *(rng.normal(size=(n, robot.nv)) * scale for scale in (1.0, 3.0, 5.0))


def close(found, expected, tolerance=1e-10):
    """Compares arrays relative to the largest number."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    scale = max(1.0, np.abs(expected).max(initial=0.0))
    assert np.abs(found - expected).max(initial=0.0) <= tolerance * scale


def signatures(robot, link):
    """Returns each function that the robot has: its name, its arguments as names, shapes and defaults, and its link if it needs one."""
    for name in modyn.functions():
        if name in ("brge", "neutral"):
            continue
        for of_link in ((), (link,)):
            try:
                yield name, robot._array_signature(name, *of_link)[0], of_link
            except (TypeError, ValueError):
                continue


def in_threads(work):
    """Does the work in four threads at the same time."""
    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


@pytest.fixture
def panda():
    return modyn.load(GOLDEN / "panda.urdf", joint_friction="none")
