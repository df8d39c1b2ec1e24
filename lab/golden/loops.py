"""Closed loops: `constraintDynamics` at closed configurations, checked by a dense solution."""

import xml.etree.ElementTree as ElementTree

import numpy
import pinocchio

from urdf import pose, unit

WORLD = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
#: Between the two points that hold a hinge's axis, m.
HINGE = 0.1


def points(loop):
    """Pinocchio has constraints of points and of frames alone: two points hold a hinge."""
    kind = pinocchio.ContactType.CONTACT_6D if loop.kind == "fixed" else pinocchio.ContactType.CONTACT_3D
    shifts = [0.0, HINGE] if loop.kind == "revolute" else [0.0]
    for shift in shifts:
        along = pinocchio.SE3(numpy.eye(3), shift * loop.axis)
        yield kind, [(joint, place * along) for joint, place in loop.ends]


class Closed:
    """A mechanism with its loops, for Pinocchio's solver and for the dense one."""

    def __init__(self, mechanism):
        self.model = mechanism.model.copy()
        self.constraints, self.frames = [], []
        for kind, ends in (found for loop in mechanism.loops for found in points(loop)):
            (first, on_first), (second, on_second) = ends
            self.constraints.append(pinocchio.RigidConstraintModel(
                kind, self.model, first, on_first, second, on_second, pinocchio.ReferenceFrame.LOCAL))
            pair = [self.model.addFrame(pinocchio.Frame(f"end{len(self.frames)}{k}", joint, place,
                                                        pinocchio.FrameType.OP_FRAME))
                    for k, (joint, place) in enumerate(ends)]
            self.frames.append((kind == pinocchio.ContactType.CONTACT_6D, pair))

    def rows(self, q, v, a):
        """The displacements of the ends, the Jacobian of their relative motion, and its acceleration, in world axes."""
        data = self.model.createData()
        pinocchio.forwardKinematics(self.model, data, q, v, a)
        pinocchio.computeJointJacobians(self.model, data, q)
        pinocchio.updateFramePlacements(self.model, data)
        displacements, jacobian, acceleration = [], [], []
        for rigid, (first, second) in self.frames:
            count = 6 if rigid else 3
            places = [data.oMf[frame] for frame in (first, second)]
            difference = places[1].translation - places[0].translation
            turn = pinocchio.log3(places[1].rotation @ places[0].rotation.T)
            displacements.append(numpy.concatenate([difference, turn])[:count])
            of = [pinocchio.getFrameJacobian(self.model, data, frame, WORLD) for frame in (first, second)]
            jacobian.append((of[1] - of[0])[:count])
            of = [pinocchio.getFrameClassicalAcceleration(self.model, data, frame, WORLD).vector
                  for frame in (first, second)]
            acceleration.append((of[1] - of[0])[:count])
        return numpy.concatenate(displacements), numpy.vstack(jacobian), numpy.concatenate(acceleration)

    def closed(self, q):
        """The configuration near q that closes the loops, by Newton's method; None if there is none."""
        still = numpy.zeros(self.model.nv)
        for _ in range(60):
            displacements, jacobian, _ = self.rows(q, still, still)
            if numpy.abs(displacements).max() < 1e-15:
                break
            q = pinocchio.integrate(self.model, q, -numpy.linalg.pinv(jacobian, rcond=1e-9) @ displacements)
        return q if numpy.abs(displacements).max() < 1e-14 else None

    def closed_state(self, random, reach):
        """A closed configuration within `reach` of the neutral one and velocities that keep it closed."""
        model = self.model
        while True:
            q = pinocchio.integrate(model, pinocchio.neutral(model), random.uniform(-reach, reach, model.nv))
            q = self.closed(q)
            if q is None or numpy.abs(q).max() > 3:
                continue
            still = numpy.zeros(model.nv)
            jacobian = self.rows(q, still, still)[1]
            strengths = numpy.linalg.svd(jacobian, compute_uv=False)
            strengths = strengths[strengths > 1e-9 * strengths[0]]
            if strengths[-1] < 0.02 * strengths[0]:
                continue
            v = random.uniform(-1.5, 1.5, model.nv)
            return q, v - numpy.linalg.pinv(jacobian, rcond=1e-9) @ (jacobian @ v), len(strengths)

    def solved(self, q, v, tau):
        """Pinocchio's accelerations without stabilisation, and what its derivatives need."""
        model, data = self.model, self.model.createData()
        constraints, contents = pinocchio.StdVec_RigidConstraintModel(), pinocchio.StdVec_RigidConstraintData()
        constraints.extend(self.constraints)
        contents.extend([constraint.createData() for constraint in self.constraints])
        pinocchio.initConstraintDynamics(model, data, constraints, contents)
        settings = pinocchio.ProximalSettings(1e-14, 1e-10, 100)
        found = pinocchio.constraintDynamics(model, data, q, v, tau, constraints, contents, settings).copy()
        return found, (data, constraints, contents, settings)

    def derivatives(self, q, v, tau):
        """Of the accelerations by q, v and tau. Pinocchio's are right for CONTACT_6D alone: with loops of CONTACT_3D
        those by q and v differ from differences along closed motions by more than their size."""
        _, (data, constraints, contents, settings) = self.solved(q, v, tau)
        pinocchio.computeConstraintDynamicsDerivatives(self.model, data, constraints, contents, settings)
        return data.ddq_dq.copy(), data.ddq_dv.copy(), data.ddq_dtau.copy()

    def along(self, q, v, tau, random):
        """A direction in which the loop stays closed, dq and dv, and the change of the accelerations along it, by
        differences of fourth order. Derivatives in other directions depend on the axes of the constraint."""
        still = numpy.zeros(self.model.nv)

        def projected(vector, at):
            jacobian = self.rows(at, still, still)[1]
            return vector - numpy.linalg.pinv(jacobian, rcond=1e-9) @ (jacobian @ vector)

        moving, faster = projected(random.uniform(-1, 1, self.model.nv), q), random.uniform(-1, 1, self.model.nv)

        def at(step):
            there = self.closed(pinocchio.integrate(self.model, q, step * moving))
            velocity = projected(v + step * faster, there)
            return pinocchio.difference(self.model, q, there), velocity, self.solved(there, velocity, tau)[0]

        step = 5e-4
        near = [at(k * step) for k in (1, -1, 2, -2)]
        return [(8 * (near[0][k] - near[1][k]) - (near[2][k] - near[3][k])) / (12 * step) for k in range(3)]

    def accelerations(self, q, v, tau):
        """Pinocchio's, without stabilisation; checked against a dense minimum-norm solution."""
        model = self.model
        found, _ = self.solved(q, v, tau)
        free = pinocchio.aba(model, model.createData(), q, v, tau)
        still = numpy.zeros(model.nv)
        jacobian, bias = self.rows(q, v, still)[1:]
        upper = numpy.triu(pinocchio.crba(model, model.createData(), q))
        inverse = numpy.linalg.inv(upper + numpy.triu(upper, 1).T)
        forces = numpy.linalg.pinv(jacobian @ inverse @ jacobian.T, rcond=1e-10, hermitian=True)
        dense = free - inverse @ jacobian.T @ forces @ (jacobian @ free + bias)
        return found, float(numpy.abs(found - dense).max() / max(1.0, numpy.abs(dense).max()))


def in_general_position(source, seed):
    """A URDF of joints about one point each, turned as a whole, with every link's frame turned and shifted on its axis.

    The mechanism, its coordinates and its velocities stay the same; only the direction of gravity changes.
    """
    random = numpy.random.default_rng(seed)
    root = ElementTree.fromstring(source.encode())
    joints = root.findall("joint")

    def any_rotation():
        return pinocchio.Quaternion(random.normal(size=4)).normalized().toRotationMatrix()

    def write(parent, placement):
        element = parent.find("origin") if parent.tag in ("joint", "inertial") else parent
        if element is None:
            element = ElementTree.SubElement(parent, "origin")
        element.set("xyz", " ".join(map(repr, placement.translation.tolist())))
        element.set("rpy", " ".join(map(repr, pinocchio.rpy.matrixToRpy(placement.rotation).tolist())))

    def write_axis(parent, axis):
        parent.find("axis").set("xyz", " ".join(map(repr, axis.tolist())))

    #: By link: the old frame in the new one.
    frames = {}
    for link in root.findall("link"):
        name = link.get("name")
        joint = next((joint for joint in joints if joint.find("child").get("link") == name), None)
        shift = random.uniform(-0.3, 0.3, 3) if joint is None else random.uniform(-0.3, 0.3) * unit(joint.find("axis"))
        frames[name] = pinocchio.SE3(any_rotation(), shift).inverse()
        inertial = link.find("inertial")
        if inertial is not None:
            write(inertial, frames[name] * pose(inertial.find("origin")))
    for joint in joints:
        parent, child = (frames[joint.find(end).get("link")] for end in ("parent", "child"))
        axis = child.rotation @ unit(joint.find("axis"))
        write(joint, parent * pose(joint.find("origin")) * child.inverse())
        write_axis(joint, axis)
    for loop in root.findall("loop_joint"):
        turn = pinocchio.SE3(any_rotation(), numpy.zeros(3))
        write_axis(loop, turn.rotation.T @ unit(loop.find("axis")))
        for end in (loop.find("link1"), loop.find("link2")):
            write(end, frames[end.get("link")] * pose(end) * turn)
    root.set("name", root.get("name") + "_general")
    note = ElementTree.Comment(f" robots/four_bar.urdf in general position. Made by lab/golden/run with seed {seed}. ")
    root.insert(0, note)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
