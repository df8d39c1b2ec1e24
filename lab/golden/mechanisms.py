"""Random mechanisms in general position, as URDF: no axis is a coordinate axis, no frame is parallel to another.

All numbers have four decimals, inertias six, so that the text is short and exact.
"""

import xml.etree.ElementTree as ElementTree

import numpy
import pinocchio

from urdf import parse, pose

#: By mechanism: its seed, and for each joint its type and how many links towards the base it leaves (0: serial).
TREES = {
    "joints_floating": (1, [("floating", 0), ("spherical", 0), ("revolute", 0), ("planar", 1), ("prismatic", 0)]),
    "joints_planar": (2, [("revolute", 0), ("planar", 0), ("universal", 0), ("floating", 1), ("revolute", 0)]),
    "joints_spherical": (3, [("prismatic", 0), ("spherical", 0), ("planar", 0), ("spherical", 2), ("universal", 0)]),
}
#: By mechanism: its seed, the type of its loop joint, and the joints of the two chains that it closes.
LOOPS = {
    "loop_spherical": (4, "spherical", ["revolute", "revolute", "prismatic"], ["revolute", "spherical"]),
    "loop_revolute": (5, "revolute", ["revolute", "universal", "prismatic"], ["spherical", "revolute"]),
    "loop_fixed": (6, "fixed", ["revolute", "spherical", "prismatic"], ["universal", "revolute", "revolute"]),
}


def text(values):
    return " ".join(f"{value:.4f}" for value in values)


class Writer:
    """Writes the links and joints of a URDF from a random stream."""

    def __init__(self, name, seed, purpose):
        self.random = numpy.random.default_rng(seed)
        self.lines = ['<?xml version="1.0" encoding="utf-8"?>',
                      f"<!-- {purpose} Made by lab/golden/run with seed {seed}. -->",
                      f'<robot name="{name}">', '  <link name="base"/>']

    def place(self):
        xyz, rpy = self.random.uniform(-0.4, 0.4, 3), self.random.uniform(-3.1, 3.1, 3)
        return f'xyz="{text(xyz)}" rpy="{text(rpy)}"'

    def axis(self, tag="axis"):
        return f'<{tag} xyz="{text(self.random.normal(size=3))}"/>'

    def link(self, name):
        """A link with the inertia of eight point masses, about its centre of mass, in axes of its own."""
        points, masses = self.random.normal(size=(8, 3)) * 0.1, self.random.uniform(0.1, 0.5, 8)
        points -= masses @ points / masses.sum()
        tensor = sum(m * (p @ p * numpy.eye(3) - numpy.outer(p, p)) for m, p in zip(masses, points))
        entries = {"ixx": tensor[0, 0], "ixy": tensor[0, 1], "ixz": tensor[0, 2],
                   "iyy": tensor[1, 1], "iyz": tensor[1, 2], "izz": tensor[2, 2]}
        entries = " ".join(f'{key}="{value:.6f}"' for key, value in entries.items())
        self.lines += [f'  <link name="{name}">', "    <inertial>", f"      <origin {self.place()}/>",
                       f'      <mass value="{masses.sum():.4f}"/>', f"      <inertia {entries}/>",
                       "    </inertial>", "  </link>"]

    def joint(self, name, kind, parent, child):
        self.lines += [f'  <joint name="{name}" type="{kind}">', f'    <parent link="{parent}"/>',
                       f'    <child link="{child}"/>', f"    <origin {self.place()}/>"]
        if kind not in ("fixed", "spherical", "floating"):
            self.lines.append(f"    {self.axis()}")
        if kind == "universal":
            self.lines.append(f'    {self.axis("axis2")}')
        if kind in ("revolute", "prismatic"):
            self.lines.append('    <limit lower="-3" upper="3" effort="100" velocity="10"/>')
        self.lines.append("  </joint>")
        self.link(child)

    def finished(self):
        return "\n".join([*self.lines, "</robot>", ""])


def tree(name):
    seed, joints = TREES[name]
    writer = Writer(name, seed, "A random tree in general position with joints of several coordinates.")
    path = ["base"]
    for number, (kind, leaves) in enumerate(joints):
        del path[len(path) - leaves:]
        child = f"link{number}"
        writer.joint(f"joint{number}", kind, path[-1], child)
        if number % 2 == 1:
            writer.joint(f"mount{number}", "fixed", child, f"tool{number}")
        path.append(child)
    return writer.finished()


def loop(name):
    """Two chains; the frame on the second one's last link is where it must be in one random configuration."""
    seed, kind, *chains = LOOPS[name]
    writer = Writer(name, seed, f"Two chains in general position, closed by a {kind} loop joint.")
    ends = []
    for letter, chain in zip("ab", chains):
        parent = "base"
        for number, joint in enumerate(chain):
            child = f"{letter}{number}"
            writer.joint(f"joint_{child}", joint, parent, child)
            parent = child
        ends.append(parent)
    mechanism = parse(writer.finished())
    model, data = mechanism.model, mechanism.model.createData()
    q = pinocchio.integrate(model, pinocchio.neutral(model), writer.random.uniform(-1, 1, model.nv))
    pinocchio.framesForwardKinematics(model, data, q)
    first, second = (data.oMf[model.getFrameId(end)] for end in ends)
    place, axis = writer.place(), writer.axis() if kind == "revolute" else None
    held = second.actInv(first * pose(ElementTree.fromstring(f"<link1 {place}/>")))
    other = f'xyz="{text(held.translation)}" rpy="{text(pinocchio.rpy.matrixToRpy(held.rotation))}"'
    writer.lines += [f'  <loop_joint name="closure" type="{kind}">', f'    <link1 link="{ends[0]}" {place}/>',
                     f'    <link2 link="{ends[1]}" {other}/>']
    if axis:
        writer.lines.append(f"    {axis}")
    writer.lines.append("  </loop_joint>")
    return writer.finished()
