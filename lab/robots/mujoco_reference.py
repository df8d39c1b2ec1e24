"""The same quantities by MuJoCo, in modyn's coordinates.

MuJoCo gets every joint for itself; joints that follow others are put together here from MuJoCo's own table of constraints,
by the map from modyn's velocities to MuJoCo's: v' = G v, M = G^T M' G.
"""

import mujoco
import numpy

from reference import Unloaded, closed_accelerations, random_quaternion, rotation

KINDS = {int(mujoco.mjtJoint.mjJNT_FREE): (7, 6), int(mujoco.mjtJoint.mjJNT_BALL): (4, 3)}
OFF = ("FRICTIONLOSS", "LIMIT", "CONTACT", "DAMPER", "ACTUATION")
LOOPS = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


def flag(name):
    return int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))


class Reference:
    """MuJoCo's model of a file, for modyn's joints that have coordinates; without forces of fluids and tendons, if so asked."""

    def __init__(self, path, joints, with_forces=True):
        try:
            self.model = model = mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            raise Unloaded(str(error).splitlines()[0]) from error
        for name in OFF:
            model.opt.disableflags |= flag(name)
        if not with_forces:
            model.opt.density = model.opt.viscosity = 0
            model.tendon_stiffness[:] = 0
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.data = mujoco.MjData(model)
        #: The degrees of freedom whose gravity compensation MuJoCo counts as a force of actuators.
        self.by_actuators = model.jnt_actgravcomp[model.dof_jntid] != 0
        self.joints = joints
        self.nq, self.nv = sum(joint.nq for joint in joints), sum(joint.nv for joint in joints)
        self.place_joints()

    def place_joints(self):
        """Finds for each joint of MuJoCo the joint of modyn with its place, multiplier and offset."""
        model = self.model
        follows = self.followers()
        own = [j for j in range(model.njnt) if j not in follows]
        if len(own) != len(self.joints):
            raise AssertionError(f"{len(self.joints)} joints, and {len(own)} by MuJoCo")
        places, q, v = {}, 0, 0
        for j, joint in zip(own, self.joints):
            name = model.joint(j).name
            expected = KINDS.get(model.jnt_type[j], (1, 1))
            if (joint.nq, joint.nv) != expected or name and name != joint.name:
                raise AssertionError(f"the joint `{joint.name}` is `{name}` by MuJoCo")
            places[j] = q, v
            q, v = q + joint.nq, v + joint.nv
        #: For each joint of MuJoCo: modyn's q and v, multiplier and offset; without a place it does not move.
        self.sources = [(*places[j], 1.0, 0.0) if j in places else self.source(j, follows, places)
                        for j in range(model.njnt)]

    def followers(self):
        """By joint: the joint that it follows, multiplier and offset; -1 if it does not move."""
        model, follows = self.model, {}
        for e in range(model.neq):
            if not model.eq_active0[e]:
                continue
            kind, (one, other) = model.eq_type[e], (model.eq_obj1id[e], model.eq_obj2id[e])
            constant, factor = model.eq_data[e][:2]
            if kind == mujoco.mjtEq.mjEQ_TENDON:
                (one, own), *rest = self.fixed_tendon(one)
                zero = sum(coef * model.qpos0[model.jnt_qposadr[j]] for j, coef in [(one, own), *rest])
                if other >= 0:
                    second, = self.fixed_tendon(other)
                    rest.append((second[0], -factor * second[1]))
                    zero -= factor * second[1] * model.qpos0[model.jnt_qposadr[second[0]]]
                leader, coef = rest[0] if rest else (-1, 0.0)
                follows[one] = leader, -coef / own, (zero + constant) / own
            elif kind == mujoco.mjtEq.mjEQ_JOINT:
                start = model.qpos0[model.jnt_qposadr[one]] + constant
                factor = factor if other >= 0 else 0.0
                if factor != 0.0:
                    start -= factor * model.qpos0[model.jnt_qposadr[other]]
                follows[one] = (other if factor != 0.0 else -1), factor, start
        return follows

    def fixed_tendon(self, tendon):
        """Returns the joints and the coefficients of a fixed tendon."""
        model = self.model
        first = model.tendon_adr[tendon]
        wraps = range(first, first + model.tendon_num[tendon])
        return [(model.wrap_objid[w], model.wrap_prm[w]) for w in wraps]

    def source(self, joint, follows, places):
        leader, multiplier, offset = follows[joint]
        if leader < 0:
            return None, None, 0.0, offset
        if leader in places:
            return (*places[leader], multiplier, offset)
        q, v, factor, start = self.source(leader, follows, places)
        return q, v, multiplier * factor, multiplier * start + offset

    def random_state(self, random):
        """Angles within 3 rad, positions and rates within 2, torques within 5."""
        q = random.uniform(-2, 2, self.nq)
        at = 0
        for joint in self.joints:
            if joint.nq in (4, 7):
                q[at + joint.nq - 4:at + joint.nq] = random_quaternion(random)
            at += joint.nq
        return q, random.uniform(-2, 2, self.nv), random.uniform(-5, 5, self.nv)

    def drawn_state(self, random):
        """The pose in which the model is drawn, at rest, with random torques."""
        q = numpy.zeros(self.nq)
        for j, (at, _, multiplier, offset) in enumerate(self.sources):
            own = self.model.qpos0[self.model.jnt_qposadr[j]:]
            kind = KINDS.get(self.model.jnt_type[j], (1, 1))[0]
            if kind == 7:
                q[at:at + 7] = [*own[:3], *own[4:7], own[3]]
            elif kind == 4:
                q[at:at + 4] = [*own[1:4], own[0]]
            elif (multiplier, offset) == (1.0, 0.0) and at is not None:
                q[at] = own[0]
        return q, numpy.zeros(self.nv), random.uniform(-5, 5, self.nv)

    def set(self, q, qd):
        """Sets MuJoCo's state. Returns G and its time derivative times qd."""
        model, data = self.model, self.data
        velocities, drift = numpy.zeros((model.nv, self.nv)), numpy.zeros(model.nv)
        for j, (own, v, multiplier, offset) in enumerate(self.sources):
            at, to = model.jnt_qposadr[j], model.jnt_dofadr[j]
            kind = KINDS.get(model.jnt_type[j], (1, 1))[0]
            if kind == 1:
                data.qpos[at] = offset if own is None else multiplier * q[own] + offset
                if own is not None:
                    velocities[to, v] = multiplier
            elif kind == 4:
                data.qpos[at:at + 4] = [q[own + 3], *q[own:own + 3]]
                velocities[to:to + 3, v:v + 3] = numpy.eye(3)
            else:
                x = q[own:own + 7]
                data.qpos[at:at + 7] = [*x[:3], x[6], *x[3:6]]
                axes = rotation(x[3:])
                velocities[to:to + 3, v:v + 3] = axes
                velocities[to + 3:to + 6, v + 3:v + 6] = numpy.eye(3)
                drift[to:to + 3] = axes @ numpy.cross(qd[v + 3:v + 6], qd[v:v + 3])
        data.qvel[:] = velocities @ qd
        return velocities, drift

    def evaluate(self, q, qd, tau):
        """Accelerations, bias forces and mass matrix."""
        g, drift = self.set(q, qd)
        self.model.opt.disableflags |= flag("CONSTRAINT")
        mujoco.mj_forward(self.model, self.data)
        self.model.opt.disableflags &= ~flag("CONSTRAINT")
        matrix = numpy.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(matrix, numpy.eye(self.model.nv)):
            mujoco.mj_mulM(self.model, self.data, column, unit)
        passive = self.data.qfrc_passive + self.data.qfrc_gravcomp * self.by_actuators
        bias = g.T @ (self.data.qfrc_bias - passive + matrix @ drift)
        matrix = g.T @ matrix @ g
        return numpy.linalg.solve(matrix, tau - bias), bias, matrix

    def closed(self, q, tau, free, matrix):
        """Accelerations at rest with the loops closed, and the squared displacement of the loops.

        `free` has the accelerations without loops.
        """
        g, _ = self.set(q, numpy.zeros(self.nv))
        mujoco.mj_forward(self.model, self.data)
        data = self.data
        rows = [r for r in range(data.nefc) if data.efc_type[r] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
                and self.model.eq_type[data.efc_id[r]] in LOOPS]
        jacobian = data.efc_J.reshape(data.nefc, self.model.nv)[rows] @ g
        return closed_accelerations(jacobian, free, matrix), float(numpy.abs(data.efc_pos[rows]).max(initial=0))
