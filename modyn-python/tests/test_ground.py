"""Steps on the ground: statics, Coulomb's distance, joint stops, and many states beside one."""

from pathlib import Path

import modyn
import numpy as np
import pytest

ROBOTS = Path(__file__).parents[2] / "robots"
FEET = {leg: ("point", f"{leg}_foot") for leg in ("front_left", "front_right", "hind_left", "hind_right")}
GRAVITY = 9.81
BLOCK = """<robot name="block"><link name="body"><inertial><mass value="2"/>
  <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
CORNERS = {
    f"c{i}": ("point", "body", [x, y, -0.05]) for i, (x, y) in enumerate([(0.1, 0.1), (0.1, -0.1), (-0.1, 0.1), (-0.1, -0.1)])
}


@pytest.fixture(scope="module")
def quadruped():
    return modyn.load(ROBOTS / "quadruped.urdf", base="floating", contacts=FEET)


def posture(robot):
    q = np.array(robot.neutral())
    for leg in range(4):
        bend = 0.6 if leg < 2 else -0.6
        q[8 + 3 * leg : 10 + 3 * leg] = bend, -2 * bend
    q[2] = 0.01 - robot.constraint_residual(q, np.zeros(robot.nv)).displacements[:, 5].min()
    return q


def hold(robot, q, qd, goal):
    tau = 20.0 * robot.difference(q, np.broadcast_to(goal, q.shape)) - 0.4 * qd
    tau[..., :6] = 0.0
    return tau


def test_a_quadruped_stands(quadruped):
    goal = posture(quadruped)
    step = modyn.GroundStep(goal, np.zeros(18), *[None] * 4)
    last = None
    for _ in range(400):
        tau = hold(quadruped, step.q, step.qd, goal)
        step = last = quadruped.step_on_ground(step.q, step.qd, tau, 0.002, last=last)
        assert step.residual.max() < 1e-8
    weight = quadruped.gravity_torques(quadruped.neutral())[2]
    assert step.impulses[:, 2].sum() / 0.002 == pytest.approx(weight, rel=1e-2)
    assert (step.modes == 1).all() and np.abs(step.qd).max() < 1e-2


def test_many_states_are_those_of_one(quadruped):
    rng = np.random.default_rng(3)
    goal = posture(quadruped)
    n = 300
    q = quadruped.integrate(np.tile(goal, (n, 1)), 0.05 * rng.standard_normal((n, 18)))
    qd = 0.5 * rng.standard_normal((n, 18))
    # A knee at its limit.
    q[::7, 9] = quadruped.limits.upper[9]
    tau = rng.standard_normal((n, 18))
    settings = modyn.ConstraintSettings([modyn.ContactTarget(friction=mu) for mu in (0.2, 0.5, 0.8, 1.1)])
    many = quadruped.step_on_ground(q, qd, tau, 0.001, settings)
    assert many.q.shape == (n, 19) and many.impulses.shape == (n, 4, 3) and many.modes.shape == (n, 4)
    assert set(np.unique(many.modes)) == {0, 1, 2}
    for i in range(0, n, 10):
        one = quadruped.step_on_ground(q[i], qd[i], tau[i], 0.001, settings)
        for found, expected in zip(one, many):
            np.testing.assert_allclose(found, expected[i], atol=1e-7)
    # Impulses in the cone, and no contact through the ground.
    pressed = many.impulses[..., 2]
    mu = np.array([0.2, 0.5, 0.8, 1.1])
    assert (pressed >= 0).all()
    assert (np.linalg.norm(many.impulses[..., :2], axis=-1) <= mu * pressed * (1 + 1e-9) + 1e-12).all()


def test_a_block_slides_as_coulomb_says():
    block = modyn.loads(BLOCK, base="floating", contacts=CORNERS)
    friction, speed = 0.35, 1.5
    settings = modyn.ConstraintSettings([modyn.ContactTarget(friction=friction)] * 4)
    q, qd = np.array(block.neutral()), np.zeros(6)
    q[2], qd[:2] = 0.05, (0.6 * speed, 0.8 * speed)
    step = None
    for _ in range(600):
        step = block.step_on_ground(q, qd, np.zeros(6), 0.001, settings, last=step)
        q, qd = step.q, step.qd
    assert np.hypot(q[0], q[1]) == pytest.approx(speed**2 / (2 * friction * GRAVITY), rel=1e-2)
    assert np.abs(qd).max() < 1e-6


def test_joints_stop(quadruped):
    q = np.array(quadruped.neutral())
    q[2] = 2.0
    limit = quadruped.limits.upper[9]
    q[9] = limit - 1e-3
    qd = np.zeros(18)
    qd[8] = 5.0
    held = quadruped.step_on_ground(q, qd, np.zeros(18), 0.001)
    assert held.q[9] == pytest.approx(limit, abs=1e-9) and held.stops[8] < 0
    free = quadruped.step_on_ground(q, qd, np.zeros(18), 0.001, joint_limits=False)
    assert free.q[9] > limit + 1e-3 and (free.stops == 0).all()


def test_bad_arguments(quadruped):
    q, zero = quadruped.neutral(), np.zeros(18)
    with pytest.raises(ValueError, match="`dt` of `step_on_ground` must be a time above zero, not 0"):
        quadruped.step_on_ground(q, zero, zero, 0.0)
    with pytest.raises(ValueError, match="`q` of `step_on_ground` has the shape"):
        quadruped.step_on_ground(q[1:], zero, zero, 0.001)
    step = quadruped.step_on_ground(q, zero, zero, 0.001)
    with pytest.raises(ValueError, match="`impulses` of `last` has 12 numbers; a step of as many states has 24"):
        quadruped.step_on_ground(np.tile(q, (2, 1)), np.zeros((2, 18)), np.zeros((2, 18)), 0.001, last=step)
    with pytest.raises(ValueError, match="only robots with closed loops or contacts"):
        modyn.load(ROBOTS / "arm6.urdf").step_on_ground(np.zeros(6), np.zeros(6), np.zeros(6), 0.001)
