"""Floating robots of this project in MuJoCo, with spheres that touch a plane.

MuJoCo reads the URDFs by its own reader. Each touching point is a sphere of radius `RADIUS` on a plane that lies `RADIUS` lower, so the
centre of the sphere touches the height zero.
"""

import math
import xml.etree.ElementTree as ElementTree

import mujoco
import numpy

RADIUS = 1e-4
GRAVITY = 9.81

FEET = {name: (f"{link}_foot", [0.0, 0.0, 0.0])
        for name, link in (("fl", "front_left"), ("fr", "front_right"), ("hl", "hind_left"), ("hr", "hind_right"))}


#: Each sole of the humanoid has four points.
SOLES = {f"{side}_{name}": (f"{side}_ankle_roll_link", [x, y if side == "left" else -y, -0.035])
         for side in ("left", "right")
         for name, x, y in (("toe_out", 0.12, 0.03), ("toe_in", 0.12, -0.03), ("heel_out", -0.05, 0.025),
                            ("heel_in", -0.05, -0.025))}


def rotation(axis, angle):
    """The quaternion w x y z."""
    axis = numpy.array(axis) / numpy.linalg.norm(axis)
    return numpy.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])


def matrix(quaternion):
    rows = numpy.zeros(9)
    mujoco.mju_quat2Mat(rows, quaternion)
    return rows.reshape(3, 3)


class World:
    """A floating robot on a plane."""

    def __init__(self, path, points, friction, quaternion=(1.0, 0.0, 0.0, 0.0), place=(0.0, 0.0, 0.0)):
        robot = ElementTree.parse(path).getroot()
        root = ({link.get("name") for link in robot.findall("link")}
                - {joint.find("child").get("link") for joint in robot.findall("joint")}).pop()
        extension = ElementTree.SubElement(robot, "mujoco")
        ElementTree.SubElement(extension, "compiler", fusestatic="false")
        ElementTree.SubElement(robot, "link", name="world")
        floating = ElementTree.SubElement(robot, "joint", name="floating base", type="floating")
        ElementTree.SubElement(floating, "parent", link="world")
        ElementTree.SubElement(floating, "child", link=root)
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(robot, encoding="unicode"))

        spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
        spec.option.gravity = [0.0, 0.0, -GRAVITY]
        self.normal = matrix(numpy.array(quaternion))[:, 2]
        self.place = numpy.array(place)
        contact = {"condim": 3, "friction": [friction, 0.0, 0.0]}
        spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0],
                                pos=self.place - RADIUS * self.normal, quat=quaternion, contype=1, conaffinity=0, **contact)
        self.points = list(points)
        for name, (link, position) in points.items():
            spec.body(link).add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0.0, 0.0], pos=position,
                                     mass=0.0, contype=0, conaffinity=1, **contact)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.joints = [self.model.joint(joint.get("name")) for joint in robot.findall("joint")
                       if joint.get("type") in ("revolute", "prismatic")]

    def heights(self):
        """The height of each point above the ground."""
        return numpy.array([self.normal @ (self.data.geom(name).xpos - self.place) for name in self.points])

    def place_at(self, posture, height):
        """Sets the joints to these angles, and the lowest point to this height."""
        for joint, angle in zip(self.joints, posture):
            self.data.qpos[joint.qposadr[0]] = angle
        mujoco.mj_forward(self.model, self.data)
        self.data.qpos[2] += height - self.heights().min()
