"""The functions beside MuJoCo, from the same MJCF."""

import mujoco
import numpy as np
import pytest
from conftest import close, states

import modyn

# A floating base with a ball joint, hinges and a slide, in general position.
WALKER = """
<mujoco model="walker">
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0.4 -0.7 -9.1"/>
  <worldbody>
    <body name="trunk" pos="0.1 0.2 0.3" quat="0.5 0.1 -0.7 0.2">
      <freejoint name="base"/>
      <inertial pos="0.02 -0.03 0.05" quat="0.9 0.1 0.3 0.2" mass="3" diaginertia="0.1 0.15 0.2"/>
      <body name="arm" pos="0.2 -0.1 0.3" quat="0.2 0.7 0.1 -0.4">
        <joint name="shoulder" type="ball"/>
        <inertial pos="0.1 0.2 -0.1" quat="0.5 -0.5 0.2 0.1" mass="1.2" diaginertia="0.03 0.02 0.04"/>
        <body name="hand" pos="0.1 0.3 -0.2" quat="0.8 0.3 0.2 0.1">
          <joint name="slider" type="slide" axis="0.6 0 0.8" armature="0.3"/>
          <inertial pos="0.03 -0.05 0.02" mass="0.6" fullinertia="0.01 0.012 0.013 0.001 -0.002 0.0015"/>
        </body>
      </body>
      <body name="leg" pos="-0.3 0.1 -0.2" quat="0.3 -0.2 0.8 0.4">
        <joint name="hip" type="hinge" axis="0 0.6 0.8" armature="0.2"/>
        <inertial pos="0.05 0.02 -0.2" quat="0.7 0.1 0.1 0.6" mass="2" diaginertia="0.05 0.06 0.02"/>
        <body name="foot" pos="0.1 -0.1 -0.4" quat="0.6 0.4 -0.3 0.2">
          <joint name="knee" type="hinge" axis="0.8 0 -0.6"/>
          <inertial pos="0 0.1 -0.1" mass="0.8" diaginertia="0.01 0.02 0.015"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def both():
    robot = modyn.loads(WALKER, file="walker.xml")
    model = mujoco.MjModel.from_xml_string(WALKER)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return robot, model, mujoco.MjData(model), modyn.conventions.MuJoCo(robot, model)


def test_dynamics(both):
    robot, model, data, theirs = both
    close(robot.gravity, model.opt.gravity)
    q, qd, qdd, tau = states(robot, 7)
    accelerations = robot.forward_dynamics(q, qd, tau)
    forces = robot.inverse_dynamics(q, qd, qdd)
    for i in range(len(q)):
        data.qpos[:], data.qvel[:] = theirs.to_qpos(q[i]), theirs.to_qvel(q[i], qd[i])
        data.qfrc_applied[:] = theirs.to_qfrc(q[i], tau[i])
        mujoco.mj_forward(model, data)
        close(accelerations[i], theirs.from_qacc(q[i], qd[i], data.qacc), 1e-8)
        close(robot.link_pose(q[i], "foot").translation, data.body("foot").xpos)
        close(robot.link_pose(q[i], "hand").rotation, data.body("hand").xmat.reshape(3, 3))
        data.qfrc_applied[:] = 0
        data.qacc[:] = theirs.to_qacc(q[i], qd[i], qdd[i])
        mujoco.mj_inverse(model, data)
        close(forces[i], theirs.from_qfrc(q[i], data.qfrc_inverse), 1e-9)


def test_states_there_and_back(both):
    robot, _, _, theirs = both
    q, qd, qdd, tau = states(robot, 5, seed=4)
    close(theirs.from_qpos(theirs.to_qpos(q)), q)
    close(theirs.from_qvel(q, theirs.to_qvel(q, qd)), qd)
    close(theirs.from_qacc(q, qd, theirs.to_qacc(q, qd, qdd)), qdd)
    close(theirs.from_qfrc(q, theirs.to_qfrc(q, tau)), tau)
    # One state is a row of many.
    close(theirs.to_qacc(q[2], qd[2], qdd[2]), theirs.to_qacc(q, qd, qdd)[2])
    with pytest.raises(ValueError, match="`q` has the shape"):
        theirs.to_qpos(q[:, 1:])


def test_another_model_is_refused(panda):
    model = mujoco.MjModel.from_xml_string(WALKER)
    with pytest.raises(ValueError, match="no revolute joint `panda_joint1`"):
        modyn.conventions.MuJoCo(panda, model)
    assert np.isfinite(panda.neutral()).all()
