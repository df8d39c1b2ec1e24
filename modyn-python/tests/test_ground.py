"""Steps on the ground: their laws, by the robot's other functions; rollouts, and derivatives beside differences."""

import runpy

import numpy as np
import pytest
from conftest import ROBOTS, chain, close, states

import modyn
from modyn import ConstraintSettings, ContactTarget, Ground

FEET = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"]


def tree(**options):
    """Returns a random tree with a floating base, oblique contacts and joint limits."""
    return modyn.loads(chain(7, joints=5), base="floating", contacts={"hand": ("point", "link2", [0.1, -0.2, 0.15]), "foot": ("point", "link4", [0, 0.2, 0.1])}, **options)


def plane(rng, height, **properties):
    """Returns a target in general position."""
    q, r = np.linalg.qr(np.eye(3) + 0.3 * rng.normal(size=(3, 3)))
    rotation = q * np.sign(np.diag(r))
    velocity = 0.1 * rng.normal(size=6) * np.array([0, 0, 0, 1, 1, 1])
    return ContactTarget(rotation=rotation, translation=(0, 0, height), velocity=velocity, **properties)


def scene(n=24, seed=0, **options):
    """Returns the tree with states in which contacts stick, slip and open, and joints reach their limits."""
    own = tree(**options)
    rng = np.random.default_rng(seed)
    q, qd, _, tau = states(own, n, seed)
    for k, joint in enumerate(own.joints):
        if joint.type == "floating":
            q[:, joint.q][:, :3] *= 0.5
        else:
            # Some joints are at their limits, some a little beyond.
            q[k::6, joint.q] = np.sign(q[k::6, joint.q]) * (2 + 0.001 * rng.normal(size=q[k::6, joint.q].shape))
    kinds = [dict(friction=0.1, restitution=0.4, beta=15), dict(friction=1.5, compliance=1e-3, alpha=150, beta=150)]
    settings = ConstraintSettings([plane(rng, 0.4 * k - 0.2, **kind) for k, kind in enumerate(kinds)], beta=25)
    return own, q, 2 * qd, tau, np.asarray(settings, own.dtype)


def places(own, q, settings):
    """Returns the heights and the rows of the Jacobian of the contacts, in the axes of the targets."""
    targets = settings[4:].reshape(-1, 25)
    heights, rows = [], []
    jacobian = own.constraint_jacobian(q)
    for k, target in enumerate(targets):
        rotation = target[:9].reshape(3, 3)
        exact = np.concatenate([settings[:4], *(t if i != k else np.r_[np.eye(3).ravel(), np.zeros(9), 1, t[19:]] for i, t in enumerate(targets))])
        place = own.constraint_residual(q, np.zeros(own.nv), settings=exact).displacements[k][3:]
        heights.append(rotation[:, 2] @ (place - target[9:12]))
        rows.append(rotation.T @ jacobian[k, 3:])
    return np.array(heights), np.concatenate(rows)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_laws_of_contacts_and_stops(seed):
    own, q, qd, tau, settings = scene(seed=seed)
    dt = 0.002
    found = own.step_on_ground(q, qd, tau, dt, settings)
    assert found.residual.max() < 1e-8
    modes = found.modes(settings[4:].reshape(-1, 25)[:, 24])
    assert set(modes.ravel()) == {0, 1, 2} and (found.stop_impulses != 0).any()
    limits = own.limits
    for i in range(len(q)):
        p, s, after = found.contact_impulses[i].ravel(), found.stop_impulses[i], found.qd[i]
        heights, rows = places(own, q[i], settings)
        rest = own.inverse_dynamics(q[i], qd[i], np.zeros(own.nv))
        change = own.mass_matrix(q[i]) @ (after - qd[i])
        close(change, dt * (tau[i] - rest) + rows.T @ p + s, 1e-9)
        close(own.integrate(q[i], dt * after), found.q[i], 1e-12)
        for k, target in enumerate(settings[4:].reshape(-1, 25)):
            rotation, friction, compliance = target[:9].reshape(3, 3), target[24], target[21]
            u = rows[3 * k : 3 * k + 3] @ after - rotation.T @ target[15:18]
            before = rows[3 * k : 3 * k + 3] @ qd[i] - rotation.T @ target[15:18]
            own_p, height, (alpha, beta) = p[3 * k : 3 * k + 3], heights[k], target[19:21]
            least = -height / dt if height >= 0 else -height * beta
            if compliance > 0:
                kept = (1 - 2 * alpha * dt) * before[2]
                least = -1e6 if height >= 0 else kept - beta**2 * dt * height
            if own_p[2] > 0:
                rebound = -target[23 - 1] * before[2]
                least = max(least, rebound) if rebound > 0.01 else least
                assert abs(u[2] + compliance * own_p[2] - least) < 1e-7
            else:
                assert not own_p.any() and u[2] > least - 1e-7
            size, slip = np.linalg.norm(own_p[:2]), np.linalg.norm(u[:2])
            assert size <= friction * own_p[2] * (1 + 1e-7) + 1e-12
            if modes[i, k] == 2:
                close(own_p[:2], -friction * own_p[2] * u[:2] / slip, 1e-5)
            elif modes[i, k] == 1:
                assert slip < 1e-7
        for joint in own.joints[1:]:
            at, v = q[i, joint.q][0], after[joint.v][0]
            for limit, sign in ((limits.lower[joint.q][0], 1), (limits.upper[joint.q][0], -1)):
                beyond = sign * (limit - at)
                least = beyond * (min(settings[1], 1 / dt) if beyond > 0 else 1 / dt)
                if sign * s[joint.v][0] > 0:
                    assert abs(sign * v - least) < 1e-7
                else:
                    assert sign * v > least - 1e-7


def test_one_state_and_many():
    own, q, qd, tau, settings = scene(37)
    many = own.step_on_ground(q, qd, tau, np.linspace(0.001, 0.004, 37), settings)
    for i in (0, 9, 36):
        one = own.step_on_ground(q[i], qd[i], tau[i], np.linspace(0.001, 0.004, 37)[i], settings)
        for a, b in zip(one, many):
            assert np.allclose(a, b[i], rtol=1e-9, atol=1e-9)


def quadruped():
    """Returns the quadruped on four feet with bent legs, 5 mm above the ground."""
    robot = modyn.load(ROBOTS / "quadruped.urdf", base="floating", contacts={foot: ("point", foot, [0, 0, 0]) for foot in FEET})
    q = robot.neutral()
    q[-12:] = [[0.0, 0.6, -1.2][k % 3] * (1 if k < 6 else -1) for k in range(12)]
    q[2] += 0.005 - min(robot.link_pose(q, foot).translation[2] for foot in FEET)
    return robot, q


def hold(robot, q, state, stiffness=20.0, damping=0.4):
    """Returns the torques that hold a posture."""
    tau = np.zeros_like(state[1])
    tau[..., 6:] = stiffness * (q[-12:] - state[0][..., -12:]) - damping * state[1][..., 6:]
    return tau


def test_a_quadruped_stands():
    robot, q = quadruped()
    state = robot.step_on_ground(q, np.zeros(robot.nv), np.zeros(robot.nv), 0.002)
    for _ in range(400):
        state = robot.step_on_ground(state.q, state.qd, hold(robot, q, state), 0.002, last=state)
        assert state.residual.max() < 1e-7
    assert (state.modes() == 1).all() and np.abs(state.qd).max() < 0.01
    weight = robot.gravity_torques(robot.neutral())[2]
    close(state.contact_impulses[:, 2].sum() / 0.002, weight, 1e-3)


def test_heights_of_the_ground():
    robot, q = quadruped()
    # A ramp: 12 cm up for each metre along x, 5 cm down for each metre along y.
    x, y = np.meshgrid(np.linspace(-3, 3, 4), np.linspace(-2, 2, 3))
    ramp = modyn.HeightField(0.12 * x - 0.05 * y, origin=(-3, -2), spacing=(2, 2))
    normal = np.array([-0.12, 0.05, 1]) / np.linalg.norm([-0.12, 0.05, 1])
    first = np.array([1, 0, 0.12]) / np.linalg.norm([1, 0, 0.12])
    rotation = np.stack([first, np.cross(normal, first), normal], 1)
    planes = ConstraintSettings([ContactTarget(rotation=rotation, friction=0.3)] * 4)
    level = ConstraintSettings([ContactTarget(friction=0.3)] * 4)
    controls = np.random.default_rng(2).normal(size=(5, 40, robot.nv)) * np.r_[np.zeros(6), np.ones(12)]
    arguments = dict(q=q, qd=np.zeros(robot.nv), controls=controls, dt=0.002, step="ground")
    expected = robot.rollout(**arguments, settings=planes)
    found = robot.rollout(**arguments, settings=level, ground=Ground(heights=ramp))
    assert (expected.contact_impulses != 0).any()
    for a, b in zip(found, expected):
        close(a, b, 1e-6)
    weights = np.ones((40, robot.nq)), np.ones((40, robot.nv))
    on_ramp = robot.rollout_vjp(**arguments, q_weights=weights[0], qd_weights=weights[1], settings=level, ground=Ground(heights=ramp))
    on_planes = robot.rollout_vjp(**arguments, q_weights=weights[0], qd_weights=weights[1], settings=planes)
    close(on_ramp.controls, on_planes.controls, 1e-4)
    with pytest.raises(ValueError, match="at least two full rows of at least two columns"):
        robot.rollout(**arguments, ground=Ground(heights=modyn.HeightField([[0.0, 1.0]])))


def test_rollouts_are_single_steps():
    own, q, qd, tau, settings = scene(9)
    controls = np.random.default_rng(3).normal(size=(9, 6, own.nv))
    found = own.rollout(q, qd, controls, 0.002, step="ground", settings=settings)
    last, at = None, (q, qd)
    for k in range(6):
        last = own.step_on_ground(*at, controls[:, k], 0.002, settings, last=last)
        at = last.q, last.qd
        for name in ("q", "qd", "contact_impulses", "stop_impulses"):
            close(getattr(found, name)[:, k], getattr(last, name), 1e-7)
    end = own.rollout(q, qd, controls, 0.002, step="ground", settings=settings, trajectory=False)
    assert all(np.array_equal(a, b[:, -1]) for a, b in zip(end, found))


def test_a_feedback_holds_the_posture():
    robot, q = quadruped()
    gains = np.hstack([np.diag(np.r_[np.zeros(6), 20 * np.ones(12)]), np.diag(np.r_[np.zeros(6), 0.4 * np.ones(12)])])
    controls = np.zeros((60, robot.nv))
    feedback = dict(gains=gains, q_ref=q, qd_ref=np.zeros(robot.nv))
    found = robot.rollout(q, np.zeros(robot.nv), controls, 0.002, step="ground", **feedback)
    state, last = (q, np.zeros(robot.nv)), None
    for k in range(60):
        last = robot.step_on_ground(*state, hold(robot, q, state), 0.002, last=last)
        state = last[:2]
        close(found.q[k], last.q, 1e-8)
        close(found.contact_impulses[k], last.contact_impulses, 1e-6)
    # By the gains, where the feet hold.
    weights = np.random.default_rng(6).normal(size=(60, robot.nq)), np.zeros((60, robot.nv))
    total = lambda gains: (weights[0] * robot.rollout(q, np.zeros(robot.nv), controls, 0.002, step="ground", **(feedback | {"gains": gains})).q).sum()
    gradient = robot.rollout_vjp(q, np.zeros(robot.nv), controls, 0.002, *weights, step="ground", **feedback).gains
    change = np.random.default_rng(7).normal(size=gains.shape) * (gains != 0)
    expected = (total(gains + 1e-5 * change) - total(gains - 1e-5 * change)) / 2e-5
    close((gradient * change).sum(), expected, 1e-5)


def derivative(function, x, step, varied=True):
    """Returns central differences of a function of many arrays by the numbers of one; zero by those that are not varied."""
    changes = step * (np.eye(x.size) * varied).reshape(x.size, *x.shape)
    return (function(x + changes) - function(x - changes)) / (2 * step)


@pytest.mark.parametrize("steps", [1, 3])
def test_gradients_are_those_of_differences(steps):
    own, q, qd, tau, settings = scene(24, payload=["link4"])
    own.set_payload("link4", 0.3, (0.1, -0.2, 0.3))
    rng = np.random.default_rng(8)
    controls = np.repeat(tau[:, None], steps, 1)
    weights = rng.normal(size=(steps, own.nq)), rng.normal(size=(steps, own.nv))
    # Where two laws meet there are two derivatives; a wider step then sees the other one.
    compared = {0: 0, 1: 0, 2: 0, "stop": 0}
    for i in range(len(q)):
        arguments = {"q": q[i], "qd": qd[i], "controls": controls[i], "dt": np.array(0.002), "settings": settings}

        def total(**changed):
            found = own.rollout(**(arguments | changed), step="ground", ground=Ground(tolerance=1e-13))
            return (found.q * weights[0]).sum((-2, -1)) + (found.qd * weights[1]).sum((-2, -1))

        found = own.rollout_vjp(**arguments, q_weights=weights[0], qd_weights=weights[1], step="ground", ground=Ground(tolerance=1e-13))
        for name, x in arguments.items():
            # Rotations that are none have no meaning, and some settings are at the ends of their ranges.
            varied = True if name != "settings" else np.r_[np.ones(4), np.tile(np.r_[np.zeros(9), np.ones(16)], 2)] * (np.abs(x) > 1e-6) > 0
            fine, coarse = (derivative(lambda x: total(**{name: x}), x, step, varied) for step in (1e-7, 4e-7))
            own_gradient = getattr(found, name).ravel()
            smooth = (np.abs(fine - coarse) <= 2e-4 * (1 + np.abs(fine))) & varied
            scale = 1 + np.abs(fine[smooth]).max(initial=0)
            assert np.abs(fine - own_gradient)[smooth].max(initial=0) < 1e-4 * scale, (i, name)
            assert smooth.mean() > 0.5 or name == "settings"
        state = own.rollout(**arguments, step="ground")
        for mode in state.modes(settings[4:].reshape(-1, 25)[:, 24]).ravel():
            compared[int(mode)] += 1
        compared["stop"] += int((state.stop_impulses != 0).any())
    assert all(compared.values()), compared


def test_derivatives_in_tangent_space():
    own, q, qd, tau, settings = scene(16)
    arguments = dict(dt=0.002, settings=settings, ground=Ground(tolerance=1e-13))
    found = own.step_on_ground_derivatives(q, qd, tau, **arguments)
    state = own.step_on_ground(q, qd, tau, **arguments)
    assert np.array_equal(found.q, state.q) and np.array_equal(found.qd, state.qd)
    n, compared = own.nv, 0

    def moved(i, h):
        """Returns the change of the state after the step by each entry of q, qd and tau, over 2 h."""
        unit, zero = h * np.eye(n), np.zeros((n, n))
        ends = []
        for sign in (1, -1):
            dq, dqd, dtau = (sign * np.concatenate(x) for x in ([unit, zero, zero], [zero, unit, zero], [zero, zero, unit]))
            ends.append(own.step_on_ground(own.integrate(np.repeat(q[i : i + 1], 3 * n, 0), dq), qd[i] + dqd, tau[i] + dtau, **arguments))
        changed = own.difference(ends[1].q, ends[0].q), ends[0].qd - ends[1].qd
        return np.concatenate(changed, -1).T / (2 * h)

    for i in range(len(q)):
        fine, coarse = moved(i, 1e-7), moved(i, 4e-7)
        smooth = (np.abs(fine - coarse) <= 2e-4 * (1 + np.abs(fine))).all(0)
        columns = np.concatenate([found.a[i], found.b[i]], 1)
        assert np.abs(fine - columns)[:, smooth].max() < 1e-4 * (1 + np.abs(fine).max()), i
        compared += smooth.sum()
    assert compared > 0.8 * 16 * 3 * n
    one = own.step_on_ground_derivatives(q[3], qd[3], tau[3], **arguments)
    close(one.a, found.a[3], 1e-7)
    close(one.b, found.b[3], 1e-7)


def test_a_policy_moves_the_quadruped():
    robot, q = quadruped()
    calls = []

    def policy(time, q_now, qd_now):
        calls.append(time)
        return hold(robot, q, (q_now, qd_now))

    found = robot.simulate(policy, q, np.zeros(robot.nv), 0.002, 50)
    assert found.q.shape == (50, robot.nq) and found.contact_impulses.shape == (50, 4, 3)
    np.testing.assert_allclose(calls, 0.002 * np.arange(50))
    last, at = None, (q, np.zeros(robot.nv))
    for k in range(50):
        last = robot.step_on_ground(*at, hold(robot, q, at), 0.002, last=last)
        at = last.q, last.qd
        assert all(np.array_equal(a[k], b) for a, b in zip(found, last))
    motions = robot.simulate(policy, np.stack([q, q]), np.zeros((2, robot.nv)), 0.002, 50)
    assert motions.q.shape == (2, 50, robot.nq)
    close(motions.q[1], found.q, 1e-9)
    with pytest.raises(ValueError, match="`tau`.*expected"):
        robot.simulate(lambda time, q, qd: np.zeros(3), q, np.zeros(robot.nv), 0.002, 2)
    with pytest.raises(ValueError, match="at least 1"):
        robot.simulate(policy, q, np.zeros(robot.nv), 0.002, 0)


def test_a_fixed_number_of_sweeps():
    robot, q = quadruped()
    last = robot.step_on_ground(q, np.zeros(robot.nv), np.zeros(robot.nv), 0.002)
    swept = robot.contact_step(q, np.zeros(robot.nv), np.zeros(robot.nv), 0.002, np.zeros((4, 3)))
    for _ in range(200):
        last = robot.step_on_ground(last.q, last.qd, hold(robot, q, last), 0.002, last=last, ground=Ground(joint_limits=False))
        swept = robot.contact_step(swept.q, swept.qd, hold(robot, q, swept), 0.002, swept.impulses)
        assert swept.residual < 1e-5
    close(swept.q, last.q, 1e-5)
    close(swept.impulses, last.contact_impulses, 1e-5)


def test_gradients_in_jax():
    jax = pytest.importorskip("jax")
    import modyn.jax

    jax.config.update("jax_enable_x64", True)
    own, q, qd, tau, settings = scene(3)
    rollout = modyn.jax.rollout(own, step="ground", trajectory=False)
    controls = np.repeat(tau[:, None], 4, 1)

    def energy(q, qd, controls, settings):
        end = rollout(q, qd, controls, 0.002, settings=settings)
        return (end.qd**2).sum() + (end.q**2).sum()

    backward = jax.jit(jax.grad(energy, argnums=(0, 1, 2, 3)))(q, qd, controls, settings)
    change = [np.random.default_rng(4).normal(size=x.shape) for x in (q, qd, controls, settings)]
    _, forward = jax.jvp(energy, (q, qd, controls, settings), tuple(change))
    close(forward, sum((a * b).sum() for a, b in zip(backward, change)), 1e-8)
    end = own.rollout(q, qd, controls, 0.002, step="ground", settings=settings, trajectory=False)
    expected = own.rollout_vjp(q, qd, controls, 0.002, 2 * end.q, 2 * end.qd, step="ground", settings=settings, trajectory=False)
    close(backward[2], expected.controls, 1e-9)
    # All directions at a time: a batch of changes, and a batch of weights of the last state.
    for found, other in zip(jax.jacfwd(energy, argnums=(2, 3))(q, qd, controls, settings), backward[2:]):
        close(found, other, 1e-8)
    last = lambda controls, settings: rollout(q[0], qd[0], controls, 0.002, settings=settings).qd
    for found, other in zip(*(way(last, argnums=(0, 1))(controls[0], settings) for way in (jax.jacfwd, jax.jacrev))):
        assert np.abs(found).max() > 1e-3
        close(found, other, 1e-8)


def test_the_example_of_mppi():
    program = ROBOTS.parent / "examples" / "mppi" / "walk.py"
    walk = runpy.run_path(str(program))
    state = walk["walk"](0.3)
    assert state[0][0] > 0.03 and abs(state[0][2] - walk["HIP"]) < 0.03


def test_single_precision():
    own, q, qd, tau, settings = scene(8, scalar="f32")
    double = tree()
    found = own.step_on_ground(*(x.astype(np.float32) for x in (q, qd, tau)), 0.002, settings)
    expected = double.step_on_ground(q, qd, tau, 0.002, settings)
    assert found.q.dtype == np.float32
    close(found.qd, expected.qd, 2e-3)


def test_wrong_arguments():
    own, q, qd, tau, settings = scene(3)
    with pytest.raises(ValueError, match="`settings` of `step_on_ground` has the shape"):
        own.step_on_ground(q, qd, tau, 0.001, settings[:-1])
    with pytest.raises(TypeError, match='are the options of `step="ground"`'):
        own.rollout(q, qd, tau[:, None], 0.001, ground=Ground())
    with pytest.raises(TypeError, match='`settings` are those of `step="ground"`'):
        own.rollout(q, qd, tau[:, None], 0.001, settings=settings)
    with pytest.raises(ValueError, match="contacts"):
        modyn.loads(chain(1)).step_on_ground(np.zeros(6), np.zeros(6), np.zeros(6), 0.001)
