"""The quantities at one state, all by Pinocchio, for velocities of modyn or of Pinocchio."""

import numpy
import pinocchio


def symmetric(upper):
    return numpy.triu(upper) + numpy.triu(upper, 1).T


def parameters(turn):
    """The map from modyn's ten parameters of a link to Pinocchio's of a body whose axes are turned by `turn`.

    modyn has Ixx, Ixy, Ixz, Iyy, Iyz, Izz; Pinocchio has Iyy before Ixz.
    """
    def turned(vector):
        mass, first, (xx, xy, xz, yy, yz, zz) = vector[0], vector[1:4], vector[4:]
        tensor = turn.T @ numpy.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn
        entries = tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        return numpy.concatenate([[mass], turn.T @ first, entries])
    return numpy.array([turned(unit) for unit in numpy.eye(10)]).T


def on_joints(model, wrenches):
    """Wrenches on links, force first, in their axes at their origins, as Pinocchio's forces on joints."""
    forces = [pinocchio.Force.Zero() for _ in range(model.njoints)]
    for name, wrench in wrenches.items():
        frame = model.frames[model.getFrameId(name, pinocchio.FrameType.BODY)]
        forces[frame.parentJoint] += frame.placement.act(pinocchio.Force(numpy.array(wrench)))
    return forces


class Same:
    """The coordinates as Pinocchio has them."""

    def __init__(self, model, q):
        self.q, self.map = numpy.array(q), numpy.eye(model.nv)

    def velocity(self, qd):
        return qd

    def acceleration(self, _, qdd):
        return qdd

    def rate(self, qd):
        return numpy.zeros(len(qd))

    def torques(self, theirs):
        return theirs

    def inverse_dynamics_derivatives(self, _qd, _qdd, theirs):
        return theirs[1:3]


def evaluate(model, turned, frames, coordinates, state, regressor=False):
    """All quantities; `state` has `v`, `tau`, `a` and `wrenches`. The regressor is long."""
    data = model.createData()
    q, g = coordinates.q, coordinates.map
    v, tau, a = (numpy.array(state[name]) for name in ("v", "tau", "a"))
    velocity, acceleration = coordinates.velocity(v), coordinates.acceleration(v, a)
    forces = on_joints(model, state["wrenches"])
    out = {}

    def accelerations(*outside):
        theirs = pinocchio.aba(model, data, q, velocity, numpy.linalg.solve(g.T, tau), *outside)
        return numpy.linalg.solve(g, theirs - coordinates.rate(v))

    out["qdd"] = accelerations()
    out["tau_rnea"] = coordinates.torques(pinocchio.rnea(model, data, q, velocity, acceleration))
    mass = symmetric(pinocchio.crba(model, data, q))
    out["M"] = g.T @ mass @ g
    out["nle"] = coordinates.torques(pinocchio.nonLinearEffects(model, data, q, velocity) + mass @ coordinates.rate(v))
    out["gravity_tau"] = coordinates.torques(pinocchio.computeGeneralizedGravity(model, data, q))
    out["kinetic_energy"] = pinocchio.computeKineticEnergy(model, data, q, velocity)
    out["potential_energy"] = pinocchio.computePotentialEnergy(model, data, q)

    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    out["frames"] = {}
    for name in frames:
        frame = model.getFrameId(name, pinocchio.FrameType.BODY)
        place = data.oMf[frame]
        jacobian = pinocchio.getFrameJacobian(model, data, frame, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        out["frames"][name] = {"R": place.rotation.copy(), "p": place.translation.copy(), "J": jacobian @ g}

    def inverse_derivatives(accelerated, ours):
        by_q, by_v, matrix = pinocchio.computeRNEADerivatives(model, data, q, velocity, accelerated)
        theirs = data.tau.copy(), by_q.copy(), by_v.copy(), symmetric(matrix)
        return coordinates.inverse_dynamics_derivatives(v, ours, theirs)

    if isinstance(coordinates, Same):
        pinocchio.computeABADerivatives(model, data, q, velocity, tau)
        derivatives = data.ddq_dq.copy(), data.ddq_dv.copy(), data.Minv.copy()
    else:
        found = coordinates.acceleration(v, out["qdd"])
        inverse = numpy.linalg.inv(out["M"])
        derivatives = *(-inverse @ part for part in inverse_derivatives(found, out["qdd"])), inverse
    out["dqdd_dq"], out["dqdd_dv"], out["dqdd_dtau"] = derivatives
    out["dtau_dq"], out["dtau_dv"] = inverse_derivatives(acceleration, a)

    out["qdd_ext"] = accelerations(forces)
    out["tau_ext"] = coordinates.torques(pinocchio.rnea(model, data, q, velocity, acceleration, forces))
    out["com"] = pinocchio.centerOfMass(model, data, q).copy()
    pinocchio.ccrba(model, data, q, velocity)
    out["Ag"], out["hg"] = data.Ag @ g, data.hg.vector.copy()
    if regressor:
        theirs = pinocchio.computeJointTorqueRegressor(model, data, q, velocity, acceleration)
        blocks = [theirs[:, 10 * (j - 1):10 * j] @ parameters(turn) for j, turn in turned.items()]
        out["regressor"] = g.T @ numpy.hstack(blocks)
    return out
