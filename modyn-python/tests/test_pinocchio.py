"""The functions beside Pinocchio: real robots with fixed and floating bases, and random trees in general position."""

import numpy as np
import pinocchio as pin
import pytest
from conftest import GOLDEN, chain, close, states

import modyn

REAL = [(name, base) for name in ("ur5", "panda", "solo12", "g1") for base in ("fixed", "floating")]
RANDOM = [(f"random{seed}", base) for seed in range(3) for base in ("fixed", "floating")]


class Both:
    """A robot in both libraries."""

    def __init__(self, name, base):
        text = chain(int(name[6:])) if name.startswith("random") else (GOLDEN / f"{name}.urdf").read_text()
        self.robot = modyn.loads(text, file=f"{name}.urdf", base=base, joint_friction="none")
        free = [pin.JointModelFreeFlyer()] if base == "floating" else []
        self.model = pin.buildModelFromXML(text, *free)
        self.data = self.model.createData()
        self.theirs = modyn.conventions.Pinocchio(self.robot, self.model)
        # For each entry of modyn's velocities, the index of Pinocchio's.
        self.order = self.theirs.from_v(np.arange(self.model.nv)).astype(int)

    def matrix(self, theirs):
        """Returns a matrix with Pinocchio's rows and columns in modyn's order."""
        return theirs[np.ix_(self.order, self.order)]


@pytest.fixture(params=REAL + RANDOM, ids=lambda case: "-".join(case))
def both(request):
    return Both(*request.param)


def test_dynamics(both):
    robot, model, data, theirs = both.robot, both.model, both.data, both.theirs
    n = 11
    q, qd, qdd, tau = states(robot, n)
    qs, vs, accelerations, torques = theirs.to_q(q), *(theirs.to_v(x) for x in (qd, qdd, tau))
    expected = [pin.aba(model, data, *state).copy() for state in zip(qs, vs, torques)]
    found = robot.forward_dynamics(q, qd, tau)
    close(found, theirs.from_v(np.array(expected)), 1e-8)
    close(robot.forward_dynamics(q[3], qd[3], tau[3]), found[3], 1e-8)
    expected = [pin.rnea(model, data, *state).copy() for state in zip(qs, vs, accelerations)]
    close(robot.inverse_dynamics(q, qd, qdd), theirs.from_v(np.array(expected)))
    expected = [pin.nle(model, data, *state).copy() for state in zip(qs, vs)]
    close(robot.bias_forces(q, qd), theirs.from_v(np.array(expected)))
    mass = robot.mass_matrix(q)
    for i in range(n):
        inertia = pin.crba(model, data, qs[i])
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        close(mass[i], both.matrix(inertia))
        close(robot.mass_matrix(q[i]), mass[i])
        coriolis = pin.computeCoriolisMatrix(model, data, qs[i], vs[i])
        # Coriolis matrices differ, their products with the velocities do not.
        forces = theirs.from_v(coriolis @ vs[i])
        close(robot.coriolis_matrix(q[i], qd[i]) @ qd[i], forces)
        energy = robot.kinetic_energy(q[i], qd[i])
        assert isinstance(energy, float)
        close(energy, pin.computeKineticEnergy(model, data, qs[i], vs[i]))
        close(robot.center_of_mass(q[i]), pin.centerOfMass(model, data, qs[i]))


def test_derivatives(both):
    robot, model, data, theirs = both.robot, both.model, both.data, both.theirs
    q, qd, qdd, tau = states(robot, 5, seed=1)
    found = robot.forward_dynamics_derivatives(q, qd, tau)
    assert type(found).__name__ == "ForwardDynamicsDerivatives"
    inverse = robot.inverse_dynamics_derivatives(q, qd, qdd)
    for i in range(len(q)):
        state = theirs.to_q(q[i]), theirs.to_v(qd[i])
        dq, dqd, dtau = pin.computeABADerivatives(model, data, *state, theirs.to_v(tau[i]))
        close(found.dqdd_dq[i], both.matrix(dq), 1e-7)
        close(found.dqdd_dqd[i], both.matrix(dqd), 1e-7)
        dtau = np.triu(dtau) + np.triu(dtau, 1).T
        close(found.dqdd_dtau[i], both.matrix(dtau), 1e-7)
        one = robot.forward_dynamics_derivatives(q[i], qd[i], tau[i])
        for single, many in zip(one, found):
            close(single, many[i], 1e-8)
        dq, dqd, _ = pin.computeRNEADerivatives(model, data, *state, theirs.to_v(qdd[i]))
        close(inverse.dtau_dq[i], both.matrix(dq), 1e-8)
        close(inverse.dtau_dqd[i], both.matrix(dqd), 1e-8)


def test_links(both):
    robot, model, data, theirs = both.robot, both.model, both.data, both.theirs
    q, qd, qdd, _ = states(robot, 4, seed=2)
    poses = robot.link_poses(q)
    assert poses.rotation.shape == (4, len(robot.link_names), 3, 3)
    for i in range(len(q)):
        state = theirs.to_q(q[i]), theirs.to_v(qd[i]), theirs.to_v(qdd[i])
        pin.forwardKinematics(model, data, *state)
        pin.updateFramePlacements(model, data)
        for k, link in enumerate(robot.link_names):
            frame = model.getFrameId(link)
            close(poses.rotation[i, k], data.oMf[frame].rotation)
            close(poses.translation[i, k], data.oMf[frame].translation)
            if k % 5:
                continue
            one = robot.link_pose(q[i], link)
            close(one.rotation, data.oMf[frame].rotation)
            close(one.translation, data.oMf[frame].translation)
            for end, axes in (("", pin.LOCAL_WORLD_ALIGNED), ("_local", pin.LOCAL)):
                jacobian = pin.computeFrameJacobian(model, data, state[0], frame, axes)
                close(getattr(robot, f"jacobian{end}")(q[i], link), jacobian[:, both.order])
                velocity = pin.getFrameVelocity(model, data, frame, axes).vector
                close(getattr(robot, f"link_velocity{end}")(q[i], qd[i], link), velocity)
                acceleration = pin.getFrameClassicalAcceleration(model, data, frame, axes).vector
                found = getattr(robot, f"link_acceleration{end}")(q[i], qd[i], qdd[i], k)
                close(found, acceleration)


def test_coordinates(both):
    robot, model, theirs = both.robot, both.model, both.theirs
    q, qd, *_ = states(robot, 6, seed=3)
    close(theirs.from_q(theirs.to_q(q)), q)
    moved = robot.integrate(q, qd)
    for i in range(len(q)):
        expected = theirs.from_q(pin.integrate(model, theirs.to_q(q[i]), theirs.to_v(qd[i])))
        found = robot.integrate(q[i], qd[i])
        close(robot.difference(found, expected), np.zeros(robot.nv), 1e-9)
        close(robot.difference(q[i], moved[i]), robot.difference(q[i], found), 1e-9)
    assert (robot.neutral() == theirs.from_q(pin.neutral(model))).all()


def test_regressor():
    both = Both("random1", "fixed")
    q, qd, qdd, _ = states(both.robot, 3)
    for i in range(3):
        found = both.robot.regressor(q[i], qd[i], qdd[i]) @ both.robot.parameters
        close(found, both.robot.inverse_dynamics(q[i], qd[i], qdd[i]))


def test_wrenches():
    """Generalized forces of wrenches are the products of Jacobians and wrenches, for links in Pinocchio's frames."""
    both = Both("random2", "floating")
    robot, model, data = both.robot, both.model, both.data
    q, qd, _, tau = states(robot, 1)
    rng = np.random.default_rng(5)
    forces = rng.normal(size=(len(robot.link_names), 6))
    expected = np.zeros(robot.nv)
    for wrench, link in zip(forces, robot.link_names):
        frame = model.getFrameId(link)
        jacobian = pin.computeFrameJacobian(model, data, both.theirs.to_q(q[0]), frame, pin.LOCAL)
        expected += both.theirs.from_v(jacobian.T @ wrench)
    close(robot.generalized_forces_local(q[0], forces).tau, expected)
    found = robot.forward_dynamics_external_local(q[0], qd[0], tau[0], forces)
    close(found, robot.forward_dynamics(q[0], qd[0], tau[0] + expected), 1e-8)


GRIPPER = """<robot name="gripper"><link name="palm"/>
  <link name="l"><inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <link name="r"><inertial><mass value="0.3"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <joint name="left" type="prismatic"><parent link="palm"/><child link="l"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="9" velocity="1"/></joint>
  <joint name="right" type="prismatic"><parent link="palm"/><child link="r"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.04" effort="9" velocity="1"/>
    <mimic joint="left" multiplier="0.5" offset="0.01"/></joint>
</robot>"""


@pytest.mark.parametrize("mimic", [True, False])
def test_mimic_joints(mimic):
    robot = modyn.loads(GRIPPER, joint_friction="none")
    model = pin.buildModelFromXML(GRIPPER, mimic=mimic)
    assert (robot.nv, model.nv) == (1, 1 if mimic else 2)
    theirs, data = modyn.conventions.Pinocchio(robot, model), model.createData()
    for q, qdd in [(np.array([0.02]), np.array([1.7])), (np.array([0.03]), np.array([-0.4]))]:
        close(theirs.from_q(theirs.to_q(q)), q)
        close(theirs.from_v(theirs.to_v(qdd)), qdd)
        close(theirs.from_tau(theirs.to_tau(qdd)), qdd)
        pin.framesForwardKinematics(model, data, theirs.to_q(q))
        poses = robot.link_poses(q)
        for name in ("l", "r"):
            close(poses.translation[robot.link_names.index(name)], data.oMf[model.getFrameId(name)].translation)
        forces = pin.rnea(model, data, theirs.to_q(q), theirs.to_v(0 * q), theirs.to_v(qdd))
        close(theirs.from_tau(forces), robot.inverse_dynamics(q, 0 * q, qdd))
