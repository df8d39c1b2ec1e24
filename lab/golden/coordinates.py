"""Between modyn's velocities and Pinocchio's.

They differ at planar joints alone: modyn's are the rates of x, y and the angle in the joint's axes, Pinocchio's the
linear velocity in the body's axes. With G(q) for the map: v' = G v, a' = G a + dG/dt v, tau = G^T tau'.
"""

import numpy
import pinocchio

QUARTER = numpy.array([[0.0, -1.0], [1.0, 0.0]])


class Coordinates:
    """The coordinates of a model at one configuration, given as modyn's."""

    def __init__(self, model, q):
        self.model, self.planar = model, []
        self.q, self.map = numpy.zeros(model.nq), numpy.eye(model.nv)
        at = 0
        for joint in list(model.joints)[1:]:
            if joint.shortname() == "JointModelPlanar":
                x, y, angle = q[at:at + 3]
                c, s = numpy.cos(angle), numpy.sin(angle)
                self.q[joint.idx_q:joint.idx_q + 4] = x, y, c, s
                v = joint.idx_v
                self.map[v:v + 2, v:v + 2] = [[c, s], [-s, c]]
                self.planar.append(v)
                at += 3
            else:
                self.q[joint.idx_q:joint.idx_q + joint.nq] = q[at:at + joint.nq]
                at += joint.nq
        assert at == len(q)

    def angle_derivative(self, v, vector):
        """Of G times the vector, by the angle of the planar joint whose velocities start at v."""
        out = numpy.zeros(self.model.nv)
        out[v:v + 2] = -QUARTER @ (self.map @ vector)[v:v + 2]
        return out

    def rate(self, qd):
        """dG/dt v."""
        return sum((qd[v + 2] * self.angle_derivative(v, qd) for v in self.planar), numpy.zeros(self.model.nv))

    def velocity(self, qd):
        return self.map @ qd

    def acceleration(self, qd, qdd):
        return self.map @ qdd + self.rate(qd)

    def torques(self, theirs):
        return self.map.T @ theirs

    def inverse_dynamics_derivatives(self, qd, qdd, theirs):
        """d tau / d q and d tau / d qd from Pinocchio's tau', d tau' / d q', d tau' / d v' and mass matrix."""
        tau, by_q, by_v, mass = theirs
        by_q, by_rates = by_q @ self.map, by_v @ self.map
        for v in self.planar:
            spin, angle = qd[v + 2], v + 2
            by_velocity = self.angle_derivative(v, qd)
            by_acceleration = self.angle_derivative(v, qdd)
            # The second derivative of a rotation is minus the rotation.
            by_acceleration[v:v + 2] -= spin * (self.map @ qd)[v:v + 2]
            by_q[:, angle] += by_v @ by_velocity + mass @ by_acceleration
            # dG/dt v: by the velocities in the plane, then by the spin.
            by_rates[:, v:v + 2] += mass[:, v:v + 2] @ (-spin * QUARTER @ self.map[v:v + 2, v:v + 2])
            by_rates[:, angle] += mass @ by_velocity
        by_q, by_rates = self.map.T @ by_q, self.map.T @ by_rates
        for v in self.planar:
            # The derivative of G^T times the forces, which rotates in the other direction.
            by_q[v:v + 2, v + 2] += self.map[v:v + 2, v:v + 2].T @ QUARTER @ tau[v:v + 2]
        return by_q, by_rates


def moved(model, q, step):
    """The configuration that a small step along modyn's velocities leads to."""
    out, at = numpy.array(q), 0
    for joint in list(model.joints)[1:]:
        part = step[joint.idx_v:joint.idx_v + joint.nv]
        if joint.shortname() in ("JointModelSpherical", "JointModelFreeFlyer"):
            single = pinocchio.Model()
            made = pinocchio.JointModelSpherical() if joint.nv == 3 else pinocchio.JointModelFreeFlyer()
            single.addJoint(0, made, pinocchio.SE3.Identity(), "joint")
            out[at:at + joint.nq] = pinocchio.integrate(single, out[at:at + joint.nq], part)
            at += joint.nq
        else:
            out[at:at + joint.nv] += part
            at += joint.nv
    return out
