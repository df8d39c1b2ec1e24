"""Joint forces of actuators beside MuJoCo's, and how they are called."""

import numpy as np
import pytest

import modyn

mujoco = pytest.importorskip("mujoco")

TEXT = """
<mujoco model="m"><compiler angle="radian"/><option timestep="0.004"/><worldbody>
  <body name="a"><joint name="hip" axis="0 1 0" range="-1 2" actuatorfrcrange="-3 5"/><geom size="0.1" pos="0.2 0 0"/>
    <body name="b" pos="0.3 0 0"><joint name="knee" axis="0 1 0"/><geom size="0.1" pos="0.2 0 0"/></body></body></worldbody>
  <tendon><fixed name="string"><joint joint="hip" coef="1"/><joint joint="knee" coef="-0.5"/></fixed></tendon>
  <actuator>{}</actuator></mujoco>"""
ACTUATORS = """
  <position name="servo" joint="hip" kp="20" dampratio="0.7" inheritrange="0.9"/>
  <position name="slow" joint="knee" kp="9" kv="1" timeconst="0.05" ctrlrange="-1 1"/>
  <intvelocity tendon="string" kp="4" kv="1" actrange="-1 1"/>
  <motor joint="knee" gear="3" ctrlrange="-1 1"/>"""


def states(robot, count):
    rng = np.random.default_rng(3)
    return [2 * rng.normal(size=(count, n))
            for n in (robot.nq, robot.nv, len(robot.control_names), len(robot.activation_names))]


def test_forces_are_mujocos():
    text = TEXT.format(ACTUATORS)
    robot = modyn.loads(text, file="m.xml")
    assert robot.control_names == ["servo", "slow", "string", "knee"]
    assert robot.activation_names == ["slow", "string"]
    assert np.allclose(robot.control_ranges[:2], [[-0.85, 1.85], [-1, 1]])
    assert np.array_equal(robot.control_ranges[2], [-np.inf, np.inf])
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    q, qd, ctrl, act = states(robot, 20)
    found = robot.actuate(q, qd, ctrl, 0.004, act)
    for k in range(20):
        data.qpos[:], data.qvel[:], data.ctrl[:], data.act[:] = q[k], qd[k], ctrl[k], act[k]
        mujoco.mj_step(model, data)
        one = robot.actuate(q[k], qd[k], ctrl[k], 0.004, act[k])
        for tau, after in (one, (found.tau[k], found.act[k])):
            assert np.allclose(tau, data.qfrc_actuator, rtol=0, atol=1e-11)
            assert np.allclose(after, data.act, rtol=0, atol=1e-13)


def test_activations_are_left_out_where_there_are_none():
    motors = modyn.loads(TEXT.format('<motor joint="hip" gear="2"/>'), file="m.xml")
    assert motors.activation_names == []
    assert np.array_equal(motors.actuate([0, 0], [0, 0], [1.5], 0.01).tau, [3, 0])
    robot = modyn.loads(TEXT.format(ACTUATORS), file="m.xml")
    with pytest.raises(TypeError, match="`actuate` needs the argument `act`"):
        robot.actuate([0, 0], [0, 0], [0, 0, 0, 0], 0.01)


def test_robots_without_actuators_do_not_have_the_function():
    robot = modyn.loads(TEXT.format(""), file="m.xml")
    with pytest.raises(ValueError, match="only robots with actuators .* have the function `actuate`"):
        robot.actuate([0, 0], [0, 0], [], 0.01)
