"""Joint forces of actuators beside MuJoCo's, and how they are called."""

import numpy as np
import pytest
from conftest import ROBOTS, chain, close, states as random_states

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


def test_applied_forces_are_added_to_those_of_the_actuators():
    robot = modyn.loads(TEXT.format(ACTUATORS), file="m.xml", joint_friction="none")
    q, qd, ctrl, act = (x[0] for x in states(robot, 1))
    applied = np.array([0.3, -0.2])
    tau, after = robot.actuate(q, qd, ctrl, 0.004, act)
    expected = robot.step(q, qd, tau + applied, 0.004)
    found = robot.step_actuated(q, qd, ctrl, 0.004, act, applied)
    for name in ("q", "qd", "qdd"):
        assert np.allclose(getattr(found, name), getattr(expected, name), rtol=0, atol=1e-12)
    assert np.array_equal(found.act, after)
    without = robot.step_actuated(q, qd, ctrl, 0.004, act)
    assert np.array_equal(without.q, robot.step_actuated(q, qd, ctrl, 0.004, act, np.zeros(2)).q)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_gradients_of_steps_under_controls(integrator):
    """First derivatives with respect to the state, the controls, the activations and the applied forces, and of a rollout."""
    jax = pytest.importorskip("jax")
    import modyn.jax

    jax.config.update("jax_enable_x64", True)
    text = TEXT.format(ACTUATORS).replace("<option ", f'<option integrator="{integrator}" ')
    robot = modyn.loads(text, file="m.xml", joint_friction="none")
    rng = np.random.default_rng(5)
    q, qd, act, applied = (0.3 * rng.normal(size=n) for n in (2, 2, 2, 2))
    ctrl = 0.3 * rng.normal(size=(6, 4))
    weights = rng.normal(size=(3, 2))

    def value(q, qd, ctrl, act, applied, call):
        x = call(q, qd, ctrl, act, applied)
        last = lambda array: array[-1] if array.ndim == 2 else array
        return sum((w * last(part)).sum() for w, part in zip(weights, (x.q, x.qd, x.act)))

    step = modyn.jax.function(robot, "step_actuated")
    rollout = modyn.jax.rollout(robot, "actuated")
    calls = {
        "step": (lambda q, qd, ctrl, act, applied: step(q, qd, ctrl[0], 0.004, act, applied)),
        "rollout": (lambda q, qd, ctrl, act, applied: rollout(q, qd, ctrl, 0.004, act=act, applied=applied)),
    }
    for name, call in calls.items():
        given = [q, qd, ctrl, act, applied]
        found = jax.grad(value, argnums=range(5))(*given, call)
        for k, gradient in enumerate(found):
            for at in np.ndindex(given[k].shape):
                def moved(by):
                    arrays = [x.copy() for x in given]
                    arrays[k][at] += by
                    return float(value(*arrays, call))

                h = 1e-5
                expected = (moved(h) - moved(-h)) / (2 * h)
                assert abs(gradient[at] - expected) < 1e-7 * max(1, abs(expected)), (name, k, at)


def test_rollouts_name_what_they_lack():
    robot = modyn.loads(TEXT.format(ACTUATORS), file="m.xml")
    motion = robot.rollout([0, 0], [0, 0], np.zeros((3, 4)), 0.004, step="actuated")
    assert motion.act.shape == (3, 2) and type(motion).__name__ == "ActuatedStep"
    with pytest.raises(ValueError, match=r"`controls` of `rollout` has the shape \(3, 2\); expected \(3, 4\)"):
        robot.rollout([0, 0], [0, 0], np.zeros((3, 2)), 0.004, step="actuated")
    with pytest.raises(TypeError, match="has no feedback"):
        robot.rollout([0, 0], [0, 0], np.zeros((3, 4)), 0.004, step="actuated", gains=np.zeros((2, 4)), q_ref=[0, 0], qd_ref=[0, 0])
    with pytest.raises(TypeError, match="`act` is an argument of rollouts"):
        robot.rollout([0, 0], [0, 0], np.zeros((3, 2)), 0.004, act=[0, 0])
    gradients = robot.rollout_vjp([0, 0], [0, 0], np.zeros((3, 4)), 0.004, np.ones((3, 2)), None, step="actuated")
    assert gradients.controls.shape == (3, 4) and gradients.act.shape == (2,) and gradients.applied.shape == (2,)


class Motor:
    """A position actuator by the formulas of Isaac Lab 2.3.2's `DCMotor` and `DelayedPDActuator`."""

    def __init__(self, delay, **numbers):
        self.delay, self.numbers, self.waiting = delay, numbers, []

    def force(self, target, q, qd):
        if not self.waiting:
            self.waiting = [target] * self.delay
        self.waiting.append(target)
        target = self.waiting.pop(0)
        kp, kd, effort, saturation, velocity = self.numbers.values()
        most = velocity * (1 + effort / saturation)
        speed = np.clip(qd, -most, most)
        high = np.clip(saturation * (1 - speed / velocity), None, effort)
        low = np.clip(saturation * (-1 - speed / velocity), -effort, None)
        self.region = (speed != qd, high != effort, low != -effort)
        force = kp * (target - q) - kd * qd
        self.region += (force > high, force < low)
        return np.clip(force, low, high)


@pytest.mark.parametrize("machine_code", [True, False])
@pytest.mark.parametrize("delay", [0, 1, 4])
def test_torque_speed_lines_and_delays(delay, machine_code):
    """Rollouts beside steps under the forces of the formulas, on both sides of each kink."""
    numbers = dict(kp=90, kd=0.6, effort=9, saturation=14, velocity=2.5)
    law = ("position", 90, 0.6, {"effort": 9, "saturation": 14, "velocity": 2.5, "delay": delay})
    robot = modyn.loads(chain(3), base="floating", joint_friction="none", actuators={"*": law}, machine_code=machine_code)
    names = robot.control_names
    assert robot.activation_names == [f"{name}_before_{k}" for name in names for k in range(delay, 0, -1)]
    places = [robot.velocity_names.index(name) for name in names]
    coordinates = [robot.coordinate_names.index(name) for name in names]
    [q], [qd], _, _ = random_states(robot, 1)
    controls = np.random.default_rng(2).normal(size=(60, len(names)))
    settings = robot.step_settings()
    settings.tolerance = 1e-13
    # The queue of each actuator holds its first target, as Isaac Lab's.
    act = np.repeat(controls[0], delay) if delay else None
    motion = robot.rollout(q, qd, controls, 0.004, step="actuated", act=act, settings=settings)
    motors = [Motor(delay, **numbers) for _ in names]
    regions = set()
    qdd = np.zeros(robot.nv)
    for k, targets in enumerate(controls):
        tau = np.zeros(robot.nv)
        for motor, target, at, place in zip(motors, targets, coordinates, places):
            tau[place] = motor.force(target, q[at], qd[place])
            regions.add(motor.region)
        x = robot.step(q, qd, tau, 0.004, qdd, settings)
        for name in ("q", "qd", "qdd"):
            close(getattr(motion, name)[k], getattr(x, name), 1e-8)
        assert np.array_equal(motion.act[k], np.concatenate([[], *(motor.waiting for motor in motors)]))
        q, qd, qdd = x.q, x.qd, x.qdd
    assert len(regions) >= 8, regions


def test_gradients_of_torque_speed_lines_and_delays():
    jax = pytest.importorskip("jax")
    import modyn.jax

    jax.config.update("jax_enable_x64", True)
    law = ("position", 40, 0.6, {"effort": 9, "saturation": 14, "velocity": 2.5, "delay": 2})
    robot = modyn.loads(chain(3, joints=3), joint_friction="none", actuators={"*": law})
    rollout = modyn.jax.rollout(robot, "actuated")
    rng = np.random.default_rng(7)
    given = [0.3 * rng.normal(size=3), 2 * rng.normal(size=3), 0.5 * rng.normal(size=(5, 3)), 0.5 * rng.normal(size=6)]
    weights = rng.normal(size=(2, 5, 3))

    def value(q, qd, controls, act):
        x = rollout(q, qd, controls, 0.004, act=act)
        return (weights[0] * x.q).sum() + (weights[1] * x.qd).sum()

    found = jax.grad(value, argnums=range(4))(*given)
    for k, gradient in enumerate(found):
        change = rng.normal(size=gradient.shape)
        moved = lambda by: float(value(*given[:k], given[k] + by * change, *given[k + 1:]))
        expected = (moved(1e-5) - moved(-1e-5)) / 2e-5
        assert abs((gradient * change).sum() - expected) < 1e-6 * max(1, abs(expected)), k
    # The last two targets of each motor do not act within the motion.
    assert np.abs(found[2][-2:]).max() == 0 and np.abs(found[2][:-2]).max() > 1e-4


def test_a_quadruped_stands_on_its_actuators():
    """The same motion as by a feedback of the rollout, since no force is at a limit."""
    feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"]
    contacts = {foot: ("point", foot, [0, 0, 0]) for foot in feet}
    load = lambda **options: modyn.load(ROBOTS / "quadruped.urdf", base="floating", contacts=contacts, **options)
    robot = load(actuators={"*": ("position", 20, 0.4, {"effort": 2.7})})
    assert robot.control_names == robot.velocity_names[6:] and robot.activation_names == []
    q = robot.neutral()
    q[-12:] = [[0.0, 0.6, -1.2][k % 3] * (1 if k < 6 else -1) for k in range(12)]
    q[2] += 0.005 - min(robot.link_pose(q, foot).translation[2] for foot in feet)
    rest = np.zeros(robot.nv)
    motion = robot.rollout(q, rest, np.tile(q[-12:], (400, 1)), 0.002, step="actuated")
    assert np.abs(motion.qd[-1]).max() < 0.01
    close(motion.forces[-1, :, 2].sum(), robot.gravity_torques(robot.neutral())[2], 1e-3)
    gains = np.hstack([np.diag(np.r_[np.zeros(6), 20 * np.ones(12)]), np.diag(np.r_[np.zeros(6), 0.4 * np.ones(12)])])
    feedback = dict(gains=gains, q_ref=q, qd_ref=rest)
    expected = load().rollout(q, rest, np.zeros((400, robot.nv)), 0.002, step="step", **feedback)
    close(motion.q, expected.q, 1e-6)
    weak = load(actuators={"*": ("position", 20, 0.4, {"effort": 0.1})})
    fallen = weak.rollout(q, rest, np.tile(q[-12:], (400, 1)), 0.002, step="actuated")
    assert fallen.q[-1, 2] < motion.q[-1, 2] - 0.05
