"""Robots on the ground in MuJoCo: a block that falls, one that slides, one on a slope, a quadruped that stands, one that
trots, and a humanoid that stands.

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
        """Steps with the torques of the joints; the states at the samples, the first impact and the work of the torques."""
        dt = self.model.opt.timestep
        steps, every = round(time / dt), round(SAMPLE / dt)
        samples, impact, deepest, work = [], None, 0.0, 0.0
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
                applied = torques(self)
                for joint, torque in zip(self.joints, applied):
                    self.data.qfrc_applied[joint.dofadr[0]] = torque
                before = [self.qd(joint) for joint in self.joints]
                mujoco.mj_step(self.model, self.data)
                work += sum(torque * (rate + self.qd(joint)) * dt / 2.0
                            for torque, rate, joint in zip(applied, before, self.joints))
        x, y, z, w, qx, qy, qz = self.data.qpos[:7].tolist()
        return {"time": time, "positions": numpy.array(samples).round(7).tolist(), "impact": impact, "deepest": deepest,
                "base": [x, y, z, qx, qy, qz, w],
                "joints": {joint.name: float(self.q(joint)) for joint in self.joints},
                "largest_velocity": float(numpy.abs(self.data.qvel).max()),
                "forces": dict(zip(self.points, self.forces().tolist())),
                "mass": float(mujoco.mj_getTotalmass(self.model)), "energy": [start, self.energy()], "work": float(work)}


def hinge(world):
    """The torque that holds the flap of the block."""
    return [-10.0 * world.q(joint) - 0.1 * world.qd(joint) for joint in world.joints]


def block(root, friction, turned, **ground):
    world = World(root / "lab/paper/tests/mechanisms/block.urdf", CORNERS, friction, **ground)
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


def place(world, posture, height):
    """The joints at these angles, and the lowest point at this height."""
    for joint, angle in zip(world.joints, posture):
        world.data.qpos[joint.qposadr[0]] = angle
    mujoco.mj_forward(world.model, world.data)
    world.data.qpos[2] += height - world.heights().min()


def stand(root):
    world = World(root / "robots/quadruped.urdf", FEET, 0.8)
    posture = []
    for number in range(len(world.joints)):
        bend = 0.6 if number < 6 else -0.6
        posture.append([0.0, bend, -2.0 * bend][number % 3])
    place(world, posture, 0.02)

    def hold(now):
        return [20.0 * (wanted - now.q(joint)) - 0.4 * now.qd(joint) for wanted, joint in zip(posture, now.joints)]

    return {"posture": posture, **world.run(1.2, hold)}


#: The trot of `lab/paper/tests/ground/legged.rs`: a stride and its wait and ramp in s, the speed in m/s, lengths in m.
TROT = {"period": 0.4, "speed": 0.3, "height": 0.25, "lift": 0.04, "wait": 0.3, "ramp": 0.6}
#: The length of a thigh and of a shank, m.
LEG = 0.16
#: The direction of the robots that trot and stand, rad.
HEADING = 0.7


def foot(leg, time):
    """The place of a foot relative to its hip, forwards and upwards."""
    if time < TROT["wait"]:
        return 0.0, -TROT["height"]
    length = TROT["speed"] * TROT["period"] / 2.0 * min((time - TROT["wait"]) / TROT["ramp"], 1.0)
    phase = 2.0 * ((time / TROT["period"] + (0.5 if leg in (1, 2) else 0.0)) % 1.0)
    if phase < 1.0:
        turn = math.pi * phase
        return -length / 2.0 * math.cos(turn), TROT["lift"] * math.sin(turn) ** 2 - TROT["height"]
    return length / 2.0 - length * (phase - 1.0), -TROT["height"]


def strides(time):
    """The joint angles of the trot at this time."""
    angles = []
    for leg in range(4):
        x, z = foot(leg, time)
        bend = (1.0 if leg < 2 else -1.0) * math.acos(math.hypot(x, z) / (2.0 * LEG))
        angles += [0.0, math.atan2(-x, -z) + bend, -2.0 * bend]
    return angles


def trot(root):
    world = World(root / "robots/quadruped.urdf", FEET, 0.8)
    world.data.qpos[3:7] = rotation([0.0, 0.0, 1.0], HEADING)
    place(world, strides(0.0), 0.005)

    def follow(now):
        wanted, later = strides(now.data.time), strides(now.data.time + 1e-4)
        return [20.0 * (angle - now.q(joint)) + 0.4 * ((after - angle) / 1e-4 - now.qd(joint))
                for angle, after, joint in zip(wanted, later, now.joints)]

    return world.run(3.0, follow)


def gains(joint, inertia):
    """The stiffness and the damping of a joint of the humanoid that moves this inertia."""
    if "ankle_roll" in joint:
        return 60.0, 0.2
    if "ankle_pitch" in joint:
        return 300.0, 1.5
    if any(part in joint for part in ("hip", "knee", "waist")):
        return 500.0, 8.0
    return 400.0 * inertia, 20.0 * inertia


def stand_on_soles(root):
    world = World(root / "robots/humanoid.urdf", SOLES, 0.8)
    world.data.qpos[3:7] = rotation([0.0, 0.0, 1.0], HEADING)
    bends = {"hip_pitch": -0.2, "knee": 0.42, "ankle_pitch": -0.22, "left_elbow": 0.5}
    posture = [next((bend for part, bend in bends.items() if part in joint.name), 0.0) for joint in world.joints]
    place(world, posture, 0.01)
    mass = numpy.zeros((world.model.nv, world.model.nv))
    mujoco.mj_fullM(world.model, world.data, mass)
    feedback = [gains(joint.name, mass[joint.dofadr[0], joint.dofadr[0]]) for joint in world.joints]
    # A push to the left.
    world.data.qvel[:3] = matrix(world.data.qpos[3:7]) @ [0.0, 0.1, 0.0]

    def hold(now):
        return [stiffness * (wanted - now.q(joint)) - damping * now.qd(joint)
                for (stiffness, damping), wanted, joint in zip(feedback, posture, now.joints)]

    return world.run(2.0, hold)


def cases(root):
    """The motions, by name."""
    return {"generator": f"mujoco {mujoco.__version__}", "settings": SETTINGS, "radius": RADIUS, "sample": SAMPLE,
            "gravity": [0.0, 0.0, -GRAVITY], "drop": drop(root), "slide": slide(root), "slope": slope(root, 0.2),
            "slope_held": slope(root, 0.8), "stand": stand(root), "trot": trot(root),
            "stand_on_soles": stand_on_soles(root)}
