"""The same quantities by Pinocchio, in the order of modyn's coordinates.

Pinocchio gets every joint for itself; joints that mimic others are put together here, by the map from modyn's
velocities to all of Pinocchio's: v' = G v, M = G^T M' G. So Pinocchio's own mimics, which refuse a leader that is
named after its follower, are not needed.
"""

import re
import xml.etree.ElementTree as ElementTree

import numpy
import pinocchio


class Unloaded(Exception):
    """The other library does not load a file, or not in a form that can be compared."""


def rotation(quaternion):
    """The rotation matrix of a quaternion x, y, z, w."""
    return pinocchio.Quaternion(numpy.asarray(quaternion, dtype=float)).normalized().matrix()


def random_quaternion(random):
    quaternion = random.normal(size=4)
    return quaternion / numpy.linalg.norm(quaternion)


def closed_accelerations(jacobian, free, matrix):
    """The accelerations at rest that keep the rows of `jacobian`, by Gauss's principle; `free` has those without rows."""
    to_forces = numpy.linalg.solve(matrix, jacobian.T)
    forces = numpy.linalg.pinv(jacobian @ to_forces, rcond=1e-9, hermitian=True) @ (jacobian @ free)
    return free - to_forces @ forces


def load(description, floating=False):
    """Returns the model, or Pinocchio's error. White space in numbers is left out, since urdfdom drops such an inertia."""
    root = [pinocchio.JointModelFreeFlyer()] if floating else []
    text = re.sub(r'\s+"', '"', description.read_text(errors="replace").strip())
    try:
        return pinocchio.buildModelFromXML(text, *root), None
    except Exception as error:
        return None, str(error)


def followers(description):
    """By joint: which it mimics, multiplier and offset; chains are followed to their ends."""
    direct = {}
    for joint in ElementTree.fromstring(description.read_bytes().strip()).findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") != "fixed":
            numbers = float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))
            direct[joint.get("name")] = mimic.get("joint"), *numbers

    def resolved(name):
        leader, multiplier, offset = direct[name]
        if leader not in direct:
            return direct[name]
        first, ratio, shift = resolved(leader)
        return first, multiplier * ratio, multiplier * shift + offset

    return {name: resolved(name) for name in direct}


class Reference:
    """Pinocchio's model, with the coordinates of modyn's joints."""

    def __init__(self, model, joints, mimics):
        self.model, self.data, self.joints = model, model.createData(), joints
        self.q_at, self.v_at, q, v = {}, {}, 0, 0
        for joint in joints:
            self.q_at[joint.name], self.v_at[joint.name] = q, v
            q, v = q + joint.nq, v + joint.nv
        self.nq, self.nv = q, v
        #: By joint of Pinocchio: modyn's joint, multiplier and offset.
        self.sources = []
        for name in list(model.names)[1:]:
            if name == "root_joint" and name not in self.q_at:
                name = next(joint.name for joint in joints if joint.kind == "floating")
            self.sources.append((name, 1.0, 0.0) if name in self.q_at else mimics[name])
        self.velocities = numpy.zeros((model.nv, self.nv))
        for joint, (name, multiplier, _) in self.each():
            for k in range(joint.nv):
                self.velocities[joint.idx_v + k, self.v_at[name] + k] = multiplier

    def each(self):
        return zip(list(self.model.joints)[1:], self.sources)

    def random_state(self, random):
        """Angles within 3 rad, positions, rates within 2, torques within 5."""
        q = random.uniform(-3, 3, self.nq)
        for joint in self.joints:
            if joint.kind == "floating":
                at = self.q_at[joint.name] + 3
                q[at:at + 4] = random.normal(size=4)
                q[at:at + 4] /= numpy.linalg.norm(q[at:at + 4])
        return q, random.uniform(-2, 2, self.nv), random.uniform(-5, 5, self.nv)

    def coordinates(self, q):
        theirs = numpy.zeros(self.model.nq)
        for joint, (name, multiplier, offset) in self.each():
            own, at = self.q_at[name], joint.idx_q
            if joint.nv == 1:
                angle = multiplier * q[own] + offset
                # Pinocchio stores a continuous joint as cosine and sine.
                theirs[at:at + joint.nq] = angle if joint.nq == 1 else (numpy.cos(angle), numpy.sin(angle))
            elif joint.nq == 7:
                theirs[at:at + 7] = q[own:own + 7]
            else:
                raise NotImplementedError(f"the coordinates of {name}")
        return theirs

    def mass_matrix(self, q):
        upper = numpy.triu(pinocchio.crba(self.model, self.data, self.coordinates(q)))
        return self.velocities.T @ (upper + numpy.triu(upper, 1).T) @ self.velocities

    def kinematics(self, q, qd):
        """By modyn's joint, the rotation by rows, the position and the velocity in world axes of the link it moves."""
        pinocchio.forwardKinematics(self.model, self.data, self.coordinates(q), self.velocities @ qd)
        rows = []
        for joint in self.joints:
            number = self.model.getJointId(joint.name if self.model.existJointName(joint.name) else "root_joint")
            pose = self.data.oMi[number]
            velocity = pinocchio.getVelocity(self.model, self.data, number, pinocchio.LOCAL_WORLD_ALIGNED)
            rows.append(numpy.concatenate([pose.rotation.ravel(), pose.translation, velocity.linear, velocity.angular]))
        return numpy.array(rows)

    def evaluate(self, q, qd, tau):
        """Accelerations, bias forces and mass matrix; by the articulated-body algorithm if nothing mimics."""
        theirs, g = self.coordinates(q), self.velocities
        bias = g.T @ pinocchio.nonLinearEffects(self.model, self.data, theirs, g @ qd)
        matrix = self.mass_matrix(q)
        if self.model.nv == self.nv:
            theirs = pinocchio.aba(self.model, self.data, theirs, g @ qd, g @ tau)
            return g.T @ theirs, bias, matrix
        return numpy.linalg.solve(matrix, tau - bias), bias, matrix
