"""Robots on the ground in MuJoCo: a block that falls, one that slides, one on a slope, and a quadruped that stands.

MuJoCo reads the URDFs of this project by its own reader. Each touching point is a sphere of radius `RADIUS` on a plane
that lies `RADIUS` lower, so the centre of the sphere touches the height zero. Torques of the joints are computed here
before each step, as in the tests.

MuJoCo's contacts are springs and dampers (solref, solimp) within elliptic cones of friction. With the settings below a
contact at rest is less than a tenth of a millimetre in the ground, and a held contact creeps by less than a millimetre a
second.
"""

import math
import xml.etree.ElementTree as ElementTree

import mujoco
import numpy

RADIUS = 1e-4
GRAVITY = 9.81
#: The time constant and the damping ratio of a contact, and its impedance: nearly rigid.
SOLREF = [0.004, 1.0]
SOLIMP = [0.99, 0.999, 0.0005, 0.5, 2.0]
SETTINGS = {"timestep": 1e-4, "integrator": "implicitfast", "solver": "Newton", "iterations": 100, "tolerance": 1e-12,
            "cone": "elliptic", "impratio": 100.0, "solref": SOLREF, "solimp": SOLIMP}
#: The time from one sample to the next, s.
SAMPLE = 0.05

CORNERS = {name: ("body", [x, y, -0.05])
           for name, x, y in (("a", 0.15, 0.1), ("b", -0.15, 0.1), ("c", 0.15, -0.1), ("d", -0.15, -0.1))}
FEET = {name: (f"{link}_foot", [0.0, 0.0, 0.0])
        for name, link in (("fl", "front_left"), ("fr", "front_right"), ("hl", "hind_left"), ("hr", "hind_right"))}


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

        spec.option.timestep = SETTINGS["timestep"]
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
        spec.option.iterations = SETTINGS["iterations"]
        spec.option.tolerance = SETTINGS["tolerance"]
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.impratio = SETTINGS["impratio"]
        spec.option.gravity = [0.0, 0.0, -GRAVITY]
        self.normal = matrix(numpy.array(quaternion))[:, 2]
        self.place = numpy.array(place)
        contact = {"condim": 3, "friction": [friction, 0.0, 0.0], "solref": SOLREF, "solimp": SOLIMP}
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

    def q(self, joint):
        return self.data.qpos[joint.qposadr[0]]

    def qd(self, joint):
        return self.data.qvel[joint.dofadr[0]]

    def heights(self):
        """The height of each point above the ground."""
        return numpy.array([self.normal @ (self.data.geom(name).xpos - self.place) for name in self.points])

    def speeds(self):
        """The speed of each point along the normal."""
        speeds = []
        for name in self.points:
            jacobian, geom = numpy.zeros((3, self.model.nv)), self.data.geom(name)
            mujoco.mj_jac(self.model, self.data, jacobian, None, geom.xpos, self.model.geom(name).bodyid[0])
            speeds.append(self.normal @ jacobian @ self.data.qvel)
        return numpy.array(speeds)

    def forces(self):
        """The force of the ground on each point, in world axes."""
        forces = dict.fromkeys(self.points, numpy.zeros(3))
        for k, contact in enumerate(self.data.contact[:self.data.ncon]):
            wrench = numpy.zeros(6)
            mujoco.mj_contactForce(self.model, self.data, k, wrench)
            # From the first geom to the second, whose first axis is the normal.
            first, second = (self.model.geom(geom).name for geom in (contact.geom1, contact.geom2))
            force = contact.frame.reshape(3, 3).T @ wrench[:3]
            name, sign = (second, 1.0) if first == "ground" else (first, -1.0)
            forces[name] = forces[name] + sign * force
        return numpy.array([forces[name] for name in self.points])

    def energy(self):
        """The kinetic and the potential energy."""
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        return float(sum(self.data.energy))

    def run(self, time, torques):
        """Steps with the torques of the joints; the states at the samples and the first impact."""
        steps = round(time / self.model.opt.timestep)
        every = round(SAMPLE / self.model.opt.timestep)
        samples, impact, deepest = [], None, 0.0
        mujoco.mj_forward(self.model, self.data)
        start = self.energy()
        for step in range(steps + 1):
            mujoco.mj_forward(self.model, self.data)
            heights = self.heights()
            deepest = min(deepest, float(heights.min()))
            if impact is None and heights.min() < 0.0:
                point = int(heights.argmin())
                impact = {"time": self.data.time, "point": self.points[point],
                          "speed": float(self.speeds()[point])}
            if step % every == 0:
                samples.append(self.data.qpos[:3].copy())
            if step < steps:
                for joint, torque in zip(self.joints, torques(self)):
                    self.data.qfrc_applied[joint.dofadr[0]] = torque
                mujoco.mj_step(self.model, self.data)
        x, y, z, w, qx, qy, qz = self.data.qpos[:7].tolist()
        return {"time": time, "positions": numpy.array(samples).round(7).tolist(), "impact": impact, "deepest": deepest,
                "base": [x, y, z, qx, qy, qz, w],
                "joints": {joint.name: float(self.q(joint)) for joint in self.joints},
                "largest_velocity": float(numpy.abs(self.data.qvel).max()),
                "forces": dict(zip(self.points, self.forces().tolist())),
                "mass": float(mujoco.mj_getTotalmass(self.model)), "energy": [start, self.energy()]}


def hinge(world):
    """The torque that holds the flap of the block."""
    return [-10.0 * world.q(joint) - 0.1 * world.qd(joint) for joint in world.joints]


def block(root, friction, turned, **ground):
    world = World(root / "reproduce/tests/mechanisms/block.urdf", CORNERS, friction, **ground)
    world.data.qpos[3:7] = turned
    return world


def drop(root):
    world = block(root, 0.6, rotation([0.3, 1.0, -0.4], 0.6))
    world.data.qpos[2] = 0.4
    return world.run(1.2, hinge)


def slide(root):
    world = block(root, 0.35, rotation([0.0, 0.0, 1.0], 0.8))
    world.data.qpos[2] = 0.05
    # MuJoCo's linear velocity is in world axes; this one has the direction (0.6, 0.8) in the block's.
    world.data.qvel[:2] = matrix(world.data.qpos[3:7])[:2, :2] @ [0.9, 1.2]
    return world.run(0.6, hinge)


def slope(root, friction):
    quaternion, place = rotation([0.6, -0.8, 0.0], 0.5), [0.3, -0.2, 0.7]
    world = block(root, friction, quaternion, quaternion=quaternion, place=place)
    world.data.qpos[:3] = place + 0.05 * world.normal
    return world.run(0.6, hinge)


def stand(root):
    world = World(root / "robots/quadruped.urdf", FEET, 0.8)
    posture = []
    for number, joint in enumerate(world.joints):
        bend = 0.6 if number < 6 else -0.6
        posture.append([0.0, bend, -2.0 * bend][number % 3])
        world.data.qpos[joint.qposadr[0]] = posture[-1]
    mujoco.mj_forward(world.model, world.data)
    world.data.qpos[2] = 0.02 - world.heights().min()

    def hold(now):
        return [20.0 * (wanted - now.q(joint)) - 0.4 * now.qd(joint) for wanted, joint in zip(posture, now.joints)]

    return {"posture": posture, **world.run(1.2, hold)}


def cases(root):
    """The motions, by name."""
    return {"generator": f"mujoco {mujoco.__version__}", "settings": SETTINGS, "radius": RADIUS, "sample": SAMPLE,
            "gravity": [0.0, 0.0, -GRAVITY], "drop": drop(root), "slide": slide(root), "slope": slope(root, 0.2),
            "slope_held": slope(root, 0.8), "stand": stand(root)}
