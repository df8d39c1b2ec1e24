"""The same quantities by Drake, in modyn's coordinates."""

import xml.etree.ElementTree as ElementTree

import numpy
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from reference import Unloaded, random_quaternion, rotation


class Reference:
    """Drake's model of a file, for modyn's joints that have coordinates."""

    def __init__(self, path, joints):
        self.plant = MultibodyPlant(0.0)
        try:
            Parser(self.plant).AddModels(str(path))
            world = ElementTree.parse(path).getroot().find("world")
            if world is not None:
                # Drake does not read it; the default is SDF's.
                gravity = world.findtext("gravity", "0 0 -9.8").split()
                self.plant.mutable_gravity_field().set_gravity_vector([float(number) for number in gravity])
            self.plant.Finalize()
        except Exception as error:
            raise Unloaded(str(error).splitlines()[0]) from error
        self.context, self.joints = self.plant.CreateDefaultContext(), joints
        self.nq, self.nv = sum(joint.nq for joint in joints), sum(joint.nv for joint in joints)
        if self.plant.num_velocities() != self.nv:
            raise Unloaded(f"{self.plant.num_velocities()} velocities by Drake, of which some may mimic others")
        named = [self.plant.get_joint(index) for index in self.plant.GetJointIndices()]
        floating = [joint for joint in named if joint.num_velocities() == 6]
        self.theirs = []
        for joint in joints:
            found = floating if joint.nv == 6 else [one for one in named if one.name() == joint.name]
            if len(found) != 1 or found[0].num_velocities() != joint.nv or joint.nv not in (1, 6):
                raise Unloaded(f"no single joint `{joint.name}` by Drake")
            self.theirs.append(found[0])

    def random_state(self, random):
        q, at = random.uniform(-2, 2, self.nq), 0
        for joint in self.joints:
            if joint.nq == 7:
                q[at + 3:at + 7] = random_quaternion(random)
            at += joint.nq
        return q, random.uniform(-2, 2, self.nv), random.uniform(-5, 5, self.nv)

    def evaluate(self, q, qd, tau):
        """Accelerations, bias forces and mass matrix."""
        plant = self.plant
        theirs = numpy.zeros(plant.num_positions())
        g, drift = numpy.zeros((self.nv, self.nv)), numpy.zeros(self.nv)
        at = v = 0
        for joint, own in zip(self.joints, self.theirs):
            start, to = own.position_start(), own.velocity_start()
            if joint.nv == 1:
                theirs[start], g[to, v] = q[at], 1.0
            else:
                x, axes = q[at:at + 7], rotation(q[at + 3:at + 7])
                theirs[start:start + 7] = [x[6], *x[3:6], *x[:3]]
                g[to:to + 3, v + 3:v + 6], g[to + 3:to + 6, v:v + 3] = axes, axes
                drift[to + 3:to + 6] = axes @ numpy.cross(qd[v + 3:v + 6], qd[v:v + 3])
            at, v = at + joint.nq, v + joint.nv
        plant.SetPositions(self.context, theirs)
        plant.SetVelocities(self.context, g @ qd)
        matrix = plant.CalcMassMatrixViaInverseDynamics(self.context)
        bias = plant.CalcBiasTerm(self.context) - plant.CalcGravityGeneralizedForces(self.context)
        bias = g.T @ (bias + matrix @ drift)
        matrix = g.T @ matrix @ g
        return numpy.linalg.solve(matrix, tau - bias), bias, matrix
