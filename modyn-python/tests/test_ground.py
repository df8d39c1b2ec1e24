"""Rollouts and derivatives of `step`: beside single steps, differences, and the library's planes."""

import functools
import itertools
import runpy

import numpy as np
import pytest
from conftest import ROBOTS, chain, close, states

import modyn
from modyn import ContactSurface, StepSettings

CONTACTS = {"hand": ("point", "link2", [0.1, -0.2, 0.15]), "foot": ("point", "link4", [0, 0.2, 0.1])}
FEET = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"]


def tree(**options):
    """Returns a random tree with a floating base, oblique contacts and joint limits."""
    return modyn.loads(chain(7, joints=5), base="floating", contacts=CONTACTS, **options)


def surface(rng, height, **properties):
    """Returns a surface in general position."""
    q, r = np.linalg.qr(np.eye(3) + 0.3 * rng.normal(size=(3, 3)))
    return ContactSurface(rotation=q * np.sign(np.diag(r)), translation=(0, 0, height), **properties)


def scene(n=24, seed=0, **options):
    """Returns the tree with states in which contacts stick, slip and open, and joints reach their limits."""
    robot = tree(**options)
    rng = np.random.default_rng(seed)
    q, qd, _, tau = states(robot, n, seed)
    for k, joint in enumerate(robot.joints):
        if joint.type == "floating":
            q[:, joint.q][:, :3] *= 0.1
        else:
            # Some joints are at their limits, some a little beyond.
            q[k::6, joint.q] = np.sign(q[k::6, joint.q]) * (2 + 0.001 * rng.normal(size=q[k::6, joint.q].shape))
    kinds = [dict(friction=0.1, radius=0.02), dict(friction=1.5, margin=0.01, solref=(0.01, 1.2), solimp=(0.6, 0.8, 0.1, 0.4))]
    surfaces = [surface(rng, 0.4 * k - 0.2, **kind) for k, kind in enumerate(kinds)]
    tolerance = 1e-12 if robot.dtype == np.float64 else None
    return robot, q, qd, tau, np.asarray(StepSettings(surfaces, tolerance=tolerance, impratio=2.0, coulomb=0.4), robot.dtype)


def modes(forces, friction):
    """Returns the modes of contacts with elliptic or pyramidal cones: open, sticking, sliding."""
    tangential = np.abs(forces[..., :2]).sum(-1)
    normal = forces[..., 2]
    return set(np.where(normal <= 0, 0, np.where(tangential < friction * normal * (1 - 1e-6), 1, 2)).ravel())


def quadruped(**options):
    """Returns the quadruped on four feet with bent legs, 5 mm above the ground."""
    robot = modyn.load(ROBOTS / "quadruped.urdf", base="floating", contacts={foot: ("point", foot, [0, 0, 0]) for foot in FEET}, **options)
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
    state = robot.step(q, np.zeros(robot.nv), np.zeros(robot.nv), 0.002)
    for _ in range(400):
        state = robot.step(state.q, state.qd, hold(robot, q, state), 0.002, state.qdd)
        assert state.residual < 1e-8
    assert np.abs(state.qd).max() < 0.01
    weight = robot.gravity_torques(robot.neutral())[2]
    close(state.forces[:, 2].sum(), weight, 1e-3)


def test_a_quadruped_stands_on_rigid_contacts():
    robot, q = quadruped()
    settings = robot.step_settings().rigid()
    state = robot.step(q, np.zeros(robot.nv), np.zeros(robot.nv), 0.002, settings=settings)
    for _ in range(400):
        state = robot.step(state.q, state.qd, hold(robot, q, state), 0.002, state.qdd, settings)
        assert state.residual < 1e-8
    heights = [robot.link_pose(state.q, foot).translation[2] for foot in FEET]
    # By the default settings, feet sink by 3 mm.
    assert np.abs(heights).max() < 2e-5 and np.abs(state.qd).max() < 1e-3
    close(state.forces[:, 2].sum(), robot.gravity_torques(robot.neutral())[2], 1e-3)


@pytest.mark.parametrize("machine_code", [True, False])
def test_rollouts_are_single_steps(machine_code):
    robot, q, qd, tau, settings = scene(9, machine_code=machine_code)
    controls = np.random.default_rng(3).normal(size=(9, 6, robot.nv))
    warm_start = np.random.default_rng(4).normal(size=(9, robot.nv))
    arguments = dict(step="step", settings=settings, warm_start=warm_start)
    rollout = robot.rollout(q, qd, controls, 0.002, **arguments)
    assert modes(rollout.forces[:, :, 0], 0.1) >= {0, 2} and 1 in modes(rollout.forces[:, :, 1], 1.5)
    at = q, qd, warm_start
    for k in range(6):
        step = robot.step(*at[:2], controls[:, k], 0.002, at[2], settings)
        at = step[:3]
        for name in ("q", "qd", "qdd", "forces"):
            close(getattr(rollout, name)[:, k], getattr(step, name), 1e-8)
        assert (rollout.residual[:, k] < 1e-12).all()
    one = robot.rollout(q[4], qd[4], controls[4], 0.002, step="step", settings=settings, warm_start=warm_start[4])
    close(one.q, rollout.q[4], 1e-9)
    end = robot.rollout(q, qd, controls, 0.002, **arguments, trajectory=False)
    for name in ("q", "qd", "qdd", "forces"):
        assert np.array_equal(getattr(end, name), getattr(rollout, name)[:, -1])
    assert np.array_equal(end.residual, rollout.residual.max(-1)) and np.array_equal(end.iterations, rollout.iterations.max(-1))
    assert (rollout.iterations[:, -1] < end.iterations).any()


def test_a_feedback_holds_the_posture():
    robot, q = quadruped()
    gains = np.hstack([np.diag(np.r_[np.zeros(6), 20 * np.ones(12)]), np.diag(np.r_[np.zeros(6), 0.4 * np.ones(12)])])
    controls = np.zeros((60, robot.nv))
    feedback = dict(gains=gains, q_ref=q, qd_ref=np.zeros(robot.nv))
    rollout = robot.rollout(q, np.zeros(robot.nv), controls, 0.002, step="step", **feedback)
    at = q, np.zeros(robot.nv), np.zeros(robot.nv)
    for k in range(60):
        step = robot.step(*at[:2], hold(robot, q, at), 0.002, at[2])
        at = step[:3]
        close(rollout.q[k], step.q, 1e-8)
        close(rollout.forces[k], step.forces, 1e-6)
    # A quaternion of the reference is scaled to length 1.
    scaled = q * np.r_[np.ones(3), 2 * np.ones(4), np.ones(12)]
    close(robot.rollout(q, np.zeros(robot.nv), controls, 0.002, step="step", **(feedback | {"q_ref": scaled})).q, rollout.q)
    # With respect to the gains, where the feet hold.
    weights = np.random.default_rng(6).normal(size=(60, robot.nq)), np.zeros((60, robot.nv))
    total = lambda gains: (weights[0] * robot.rollout(q, np.zeros(robot.nv), controls, 0.002, step="step", **(feedback | {"gains": gains})).q).sum()
    gradient = robot.rollout_vjp(q, np.zeros(robot.nv), controls, 0.002, *weights, step="step", **feedback).gains
    change = np.random.default_rng(7).normal(size=gains.shape) * (gains != 0)
    expected = (total(gains + 1e-5 * change) - total(gains - 1e-5 * change)) / 2e-5
    close((gradient * change).sum(), expected, 1e-5)


def ramp():
    """Returns a ramp, 12 cm up for each metre along x and 5 cm down for each metre along y, and its plane."""
    x, y = np.meshgrid(np.linspace(-3, 3, 4), np.linspace(-2, 2, 3))
    field = modyn.HeightField(0.12 * x - 0.05 * y, origin=(-3, -2), spacing=(2, 2))
    unit = lambda *v: np.array(v) / np.linalg.norm(v)
    normal, first = unit(-0.12, 0.05, 1), unit(1, 0, 0.12)
    return field, dict(rotation=np.stack([first, np.cross(normal, first), normal], 1))


def test_the_heights_of_the_ground():
    robot, q = quadruped()
    field, plane = ramp()
    planes, level = StepSettings([ContactSurface(**plane, friction=0.3)] * 4), StepSettings([ContactSurface(friction=0.3)] * 4)
    controls = np.random.default_rng(2).normal(size=(5, 40, robot.nv)) * np.r_[np.zeros(6), np.ones(12)]
    arguments = dict(q=q, qd=np.zeros(robot.nv), controls=controls, dt=0.002, step="step")
    expected = robot.rollout(**arguments, settings=planes)
    on_field = robot.rollout(**arguments, settings=level, ground=field)
    assert (expected.forces != 0).any()
    for a, b in zip(on_field[:4], expected[:4]):
        close(a, b, 1e-6)
    weights = {"q_cotangent": np.ones((40, robot.nq)), "qd_cotangent": np.ones((40, robot.nv))}
    of_field = robot.rollout_vjp(**arguments, **weights, settings=level, ground=field)
    of_planes = robot.rollout_vjp(**arguments, **weights, settings=planes)
    close(of_field.controls, of_planes.controls, 1e-4)
    # The planes are those of the field: those of the settings have no effect.
    each = lambda settings: settings[..., 3:].reshape(*settings.shape[:-1], 4, 23)
    close(each(of_field.settings)[..., 12:], each(of_planes.settings)[..., 12:], 1e-4)
    assert not each(of_field.settings)[..., :12].any() and each(of_planes.settings)[..., :12].any()
    policy = lambda time, q_now, qd_now: controls[0, round(time / 0.002)]
    close(robot.simulate(policy, q, np.zeros(robot.nv), 0.002, 40, level, ground=field).q, on_field.q[0], 1e-6)


def hills(worlds=(), rows=7, columns=9):
    """Returns ground of hills 4 cm high below the quadruped, with a grid of its own in each world."""
    rng = np.random.default_rng(11)
    heights = rng.uniform(-0.02, 0.02, size=(*worlds, rows, columns))
    spacing = rng.uniform(0.1, 0.2, size=(*worlds, 2))
    return modyn.HeightField(heights, -0.5 * spacing * (columns - 1, rows - 1), spacing)


def test_each_world_has_its_ground():
    robot, q = quadruped()
    field = hills((5,))
    level = StepSettings([ContactSurface(friction=0.3)] * 4)
    turned = np.repeat(q[None], 5, 0)
    turned[:, 2] += 0.02
    turned[:, 3:7] = np.random.default_rng(4).normal(size=(5, 4)) * 0.1 + [0, 0, 0, 1]
    arguments = dict(qd=np.zeros(robot.nv), controls=np.zeros((30, robot.nv)), dt=0.002, step="step", settings=level)
    weights = {"q_cotangent": np.ones((30, robot.nq)), "qd_cotangent": np.ones((30, robot.nv))}
    own = lambda world: modyn.HeightField(field.heights[world], field.origin[world], field.spacing[world])
    for function, more in ((robot.rollout, {}), (robot.rollout_vjp, weights)):
        together = function(turned, **arguments, **more, ground=field)
        for world in range(5):
            alone = function(turned[world], **arguments, **more, ground=own(world))
            close(together[0][world], alone[0], 1e-9)
            close(together[1][world], alone[1], 1e-9)
    forces = robot.rollout(turned[0], **arguments, ground=field).forces
    assert all(np.abs(forces[i] - forces[j]).max() > 1e-3 for i, j in itertools.combinations(range(5), 2))
    expected = robot.rollout(turned, **arguments, ground=field)
    shapes = set()

    def policy(time, q_now, qd_now):
        shapes.add((q_now.shape, qd_now.shape))
        return np.zeros(robot.nv)

    # Worlds of the ground alone are motions from the first step on.
    one = robot.simulate(policy, turned[0], np.zeros(robot.nv), 0.002, 3, level, ground=field)
    close(one.q, robot.rollout(turned[0], **{**arguments, "controls": np.zeros((3, robot.nv))}, ground=field).q, 1e-6)
    assert shapes == {((5, robot.nq), (5, robot.nv))}
    close(robot.simulate(policy, turned, np.zeros((5, robot.nv)), 0.002, 30, level, ground=field).q, expected.q, 1e-6)
    with pytest.raises(ValueError, match=r"axes of states of the arguments of `step` do not fit: `q` \(3,\), .*`ground.heights` \(5,\)"):
        robot.simulate(policy, turned[:3], np.zeros((3, robot.nv)), 0.002, 30, level, ground=field)


def test_servos_on_the_ground():
    """A rollout of `actuated` is that of `step` under the same joint forces."""
    robot, q = quadruped(actuators={"*": ("position", 5, 0.05)})
    passive, _ = quadruped()
    q[2] += 0.005
    targets = q[-12:] + 0.05 * np.random.default_rng(3).normal(size=(20, 12))
    more = dict(settings=StepSettings([ContactSurface(friction=0.3)] * 4), ground=hills())
    moved = robot.rollout(q, np.zeros(robot.nv), targets, 0.002, step="actuated", **more)
    before = np.concatenate([q[None], moved.q[:-1]]), np.concatenate([np.zeros((1, robot.nv)), moved.qd[:-1]])
    forces = robot.actuate(*before, targets, 0.002).tau
    expected = passive.rollout(q, np.zeros(robot.nv), forces, 0.002, step="step", **more)
    close(moved.q, expected.q, 1e-8)
    assert (expected.forces != 0).any()


def test_heights_that_are_unknown():
    """Heights of a camera: only those below a foot have to be known."""
    robot, q = quadruped()
    field = hills((2,), rows=41, columns=41)
    arguments = dict(q=q, qd=np.zeros(robot.nv), controls=np.zeros((3, robot.nv)), dt=0.002, step="step")
    x, y = robot.link_pose(q, "hind_left_foot").translation[:2]
    column, row = (int((at - field.origin[1, k]) / field.spacing[1, k]) for k, at in enumerate((x, y)))
    field.heights[0, 0, 0] = field.heights[1, 0, 0] = np.nan
    assert np.isfinite(robot.rollout(**arguments, ground=field).q).all()
    field.heights[1, row + 1, column] = np.nan
    message = rf"`heights`\[{row + 1}, {column}\] of the height field is NaN; expected a finite number \(in state 1\)"
    with pytest.raises(ValueError, match=message):
        robot.rollout(**arguments, ground=field)
    one = modyn.HeightField(field.heights[1], field.origin[1], field.spacing[1])
    weights = {"q_cotangent": np.ones((3, robot.nq)), "qd_cotangent": None}
    with pytest.raises(ValueError, match=r"is NaN; expected a finite number$"):
        robot.rollout_vjp(**arguments, **weights, ground=one)
    for ground, message in (
        (modyn.HeightField([[0.0, 1.0]]), r"`heights` of `HeightField` has the shape \(1, 2\); expected two rows and two columns, or more"),
        (modyn.HeightField(None), "`heights` of `HeightField` is `None`; expected an array"),
        (modyn.HeightField([0.0, 1.0]), r"`heights` of `HeightField` has the shape \(2,\); expected \(rows, columns\)"),
        (modyn.HeightField(np.zeros((2, 2)), spacing=(1, -1)), "`spacing` of the height field is -1; expected"),
        (modyn.HeightField(np.zeros((2, 2)), origin=(1, 2, 3)), r"`ground.origin` of `rollout` has the shape \(3,\); expected \(2,\)"),
        (modyn.HeightField(np.zeros((4, 2, 2)), origin=np.zeros((3, 2))), "axes of states of the arguments of `rollout` do not fit"),
        (modyn.HeightField(np.zeros((2, 2), complex)), "`ground.heights` of `rollout` must be an array of real numbers"),
    ):
        with pytest.raises((ValueError, TypeError), match=message):
            robot.rollout(**arguments, ground=ground)


BALL = """<mujoco model="ball"><worldbody><geom type="plane" size="0 0 1" friction="0.8 0.01 0.001" condim="6"/><body pos="0.3 -0.2 0.5"><freejoint/>
<geom type="sphere" size="0.1" pos="0.02 -0.03 0.01" mass="2" condim="6" friction="0.8 0.01 0.001"/></body></worldbody></mujoco>"""


BALL_OF_A_URDF = """<robot name="ball"><link name="ball"><inertial><origin xyz="0.02 -0.03 0.01"/><mass value="2"/>
<inertia ixx="0.008" iyy="0.008" izz="0.008" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.02 -0.03 0.01"/><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"""


def test_a_collision_of_a_urdf_rolls_down_a_ramp():
    """The plane below the centre of the shape is that of the ramp, for the option `ground` as for a floor of an MJCF."""
    field, plane = ramp()
    mjcf = modyn.loads(BALL.replace('condim="6"', "").replace('friction="0.8 0.01 0.001"', ""))
    urdf = modyn.loads(BALL_OF_A_URDF, base="floating", ground="plane")
    assert urdf.touching_shape_names == ["ball_collision_1"]
    given = modyn.loads(BALL_OF_A_URDF, base="floating", ground=("plane", [0, 0, 0.1], [0, 0, 2], {"friction": 0.4}))
    [surface] = given.step_settings().surfaces
    assert (surface.friction, surface.radius, list(surface.translation)) == (0.4, 0.1, [0, 0, 0.1])
    motions = []
    for robot in (mjcf, urdf):
        q = np.array([0.3, -0.2, 0.2, 0, 0, 0, 1])
        arguments = dict(q=q, qd=np.zeros(6), controls=np.zeros((200, 6)), dt=0.002, step="step", ground=field)
        motions.append(robot.rollout(**arguments))
    close(motions[0].q, motions[1].q, 1e-9)
    normal = plane["rotation"][:, 2]
    center = motions[1].q[-1, :3] + [0.02, -0.03, 0.01]
    assert motions[1].q[-1, 0] < q[0] and abs(center @ normal - 0.1) < 0.02


def test_a_ball_rolls_down_a_ramp():
    robot = modyn.loads(BALL)
    field, plane = ramp()
    settings = robot.step_settings()
    assert settings.surfaces[0].radius == 0.1
    on_plane = StepSettings([ContactSurface(**{**vars(settings.surfaces[0]), **plane, "translation": (0, 0, 0)})])
    q, qd = robot.neutral(), np.zeros(robot.nv)
    q[:3] = 0.3, -0.2, 0.15
    arguments = (q, qd, np.zeros((500, robot.nv)), 0.002)
    rolled = robot.rollout(*arguments, step="step", ground=field)
    assert rolled.q[-1, 0] < 0.2 and np.linalg.norm(rolled.qd[-1, 3:]) > 1
    for a, b in zip(rolled[:4], robot.rollout(*arguments, step="step", settings=on_plane)[:4]):
        close(a, b, 1e-6)


def derivative(function, x, step, varied=True):
    """Returns central differences of a function of many arrays by the numbers of one; zero by those that are not varied."""
    changes = step * (np.eye(x.size) * varied).reshape(x.size, *x.shape)
    return (function(x + changes) - function(x - changes)) / (2 * step)


@pytest.mark.parametrize("steps, trajectory", [(1, True), (3, True), (4, False), (130, False)])
def test_gradients_are_those_of_differences(steps, trajectory):
    robot, q, qd, tau, settings = scene(24 if steps < 10 else 2, payload=["link4"])
    robot.set_payload("link4", 0.3, (0.1, -0.2, 0.3))
    rng = np.random.default_rng(8)
    controls = np.repeat(tau[:, None], steps, 1)
    lead = (steps,) if trajectory else ()
    weights = rng.normal(size=(*lead, robot.nq)), rng.normal(size=(*lead, robot.nv))
    # Many steps are not smooth enough for steps of 2 ms.
    dt = 0.002 if steps < 10 else 2e-5
    checked = 0
    for i in range(len(q)):
        arguments = {"q": q[i], "qd": qd[i], "controls": controls[i], "dt": np.array(dt), "settings": settings}

        def total(**changed):
            motion = robot.rollout(**(arguments | changed), step="step", trajectory=trajectory)
            axes = (-2, -1) if trajectory else -1
            return (motion.q * weights[0]).sum(axes) + (motion.qd * weights[1]).sum(axes)

        gradient = robot.rollout_vjp(**arguments, q_cotangent=weights[0], qd_cotangent=weights[1], step="step", trajectory=trajectory)
        for name, x in arguments.items():
            if name == "controls" and steps > 10:
                continue
            # Rotations that are none have no meaning, and some settings are at the ends of their ranges.
            varied = True if name != "settings" else np.r_[0, 1, 1, np.tile(np.r_[np.zeros(9), np.ones(14)], 2)] * (np.abs(x) > 1e-6) > 0
            wide = 1 if name != "dt" else 0.1
            fine, coarse = (derivative(lambda x: total(**{name: x}), x, step * wide, varied) for step in (1e-7, 4e-7))
            of_name = getattr(gradient, name).ravel()
            # Where two laws meet there are two derivatives; a wider step then sees the other one.
            smooth = (np.abs(fine - coarse) <= 2e-4 * (1 + np.abs(fine))) & varied
            scale = 1 + np.abs(fine[smooth]).max(initial=0)
            assert np.abs(fine - of_name)[smooth].max(initial=0) < 1e-3 * scale, (i, name)
            checked += smooth.sum()
    assert checked > 50


def test_derivatives_in_tangent_space():
    robot, q, qd, tau, settings = scene(16)
    arguments = dict(dt=0.002, settings=settings)
    matrices = robot.step_derivatives(q, qd, tau, **arguments)
    state = robot.step(q, qd, tau, **arguments)
    close(matrices.q, state.q)
    close(matrices.qd, state.qd)
    n, compared = robot.nv, 0

    def moved(i, h):
        """Returns the change of the state after the step by each entry of q, qd and tau, over 2 h."""
        unit, zero = h * np.eye(n), np.zeros((n, n))
        ends = []
        for sign in (1, -1):
            dq, dqd, dtau = (sign * np.concatenate(x) for x in ([unit, zero, zero], [zero, unit, zero], [zero, zero, unit]))
            ends.append(robot.step(robot.integrate(np.repeat(q[i : i + 1], 3 * n, 0), dq), qd[i] + dqd, tau[i] + dtau, **arguments))
        changed = robot.difference(ends[1].q, ends[0].q), ends[0].qd - ends[1].qd
        return np.concatenate(changed, -1).T / (2 * h)

    for i in range(len(q)):
        fine, coarse = moved(i, 1e-7), moved(i, 4e-7)
        smooth = (np.abs(fine - coarse) <= 2e-4 * (1 + np.abs(fine))).all(0)
        columns = np.concatenate([matrices.a[i], matrices.b[i]], 1)
        assert np.abs(fine - columns)[:, smooth].max() < 1e-4 * (1 + np.abs(fine).max()), i
        compared += smooth.sum()
    assert compared > 0.8 * 16 * 3 * n
    one = robot.step_derivatives(q[3], qd[3], tau[3], **arguments)
    close(one.a, matrices.a[3], 1e-7)
    close(one.b, matrices.b[3], 1e-7)
    # Products with the matrices.
    random = np.random.default_rng(16)
    cotangent, tangents = random.normal(size=(len(q), 2 * n)), random.normal(size=(3, len(q), n))
    gradients = robot.step_vjp(q, qd, tau, state_cotangent=cotangent, **arguments)
    close(gradients.grad_x, np.einsum("sij,si->sj", matrices.a, cotangent), 1e-7)
    close(gradients.grad_tau, np.einsum("sij,si->sj", matrices.b, cotangent), 1e-7)
    of_state, of_tau = np.concatenate(tangents[:2], -1), tangents[2]
    expected = np.einsum("sij,sj->si", matrices.a, of_state) + np.einsum("sij,sj->si", matrices.b, of_tau)
    close(robot.step_jvp(q, qd, tau, *tangents, **arguments).tangent_x, expected, 1e-7)


def test_a_policy_moves_the_quadruped():
    robot, q = quadruped()
    calls = []

    def policy(time, q_now, qd_now):
        calls.append(time)
        return hold(robot, q, (q_now, qd_now))

    motion = robot.simulate(policy, q, np.zeros(robot.nv), 0.002, 50)
    assert motion.q.shape == (50, robot.nq) and motion.forces.shape == (50, 4, 3)
    np.testing.assert_allclose(calls, 0.002 * np.arange(50))
    at = q, np.zeros(robot.nv), np.zeros(robot.nv)
    for k in range(50):
        step = robot.step(*at[:2], hold(robot, q, at), 0.002, at[2])
        at = step[:3]
        close(motion.q[k], step.q)
    motions = robot.simulate(policy, np.stack([q, q]), np.zeros((2, robot.nv)), 0.002, 50)
    assert motions.q.shape == (2, 50, robot.nq)
    close(motions.q[1], motion.q, 1e-9)
    with pytest.raises(ValueError, match="`tau`.*expected"):
        robot.simulate(lambda time, q, qd: np.zeros(3), q, np.zeros(robot.nv), 0.002, 2)
    with pytest.raises(ValueError, match="at least 1"):
        robot.simulate(policy, q, np.zeros(robot.nv), 0.002, 0)


@pytest.mark.parametrize("ground", [None, ramp()[0]])
def test_gradients_in_jax(ground):
    jax = pytest.importorskip("jax")
    import modyn.jax

    jax.config.update("jax_enable_x64", True)
    robot, q, qd, tau, settings = scene(3)
    rollout = functools.partial(modyn.jax.rollout(robot, step="step", trajectory=False), ground=ground)
    controls = np.repeat(tau[:, None], 4, 1)

    def energy(q, qd, controls, settings):
        end = rollout(q, qd, controls, 0.002, settings=settings)
        return (end.qd**2).sum() + (end.q**2).sum() + 1e-4 * (end.forces**2).sum()

    backward = jax.jit(jax.grad(energy, argnums=(0, 1, 2, 3)))(q, qd, controls, settings)
    change = [np.random.default_rng(4).normal(size=x.shape) for x in (q, qd, controls, settings)]
    _, forward = jax.jvp(energy, (q, qd, controls, settings), tuple(change))
    close(forward, sum((a * b).sum() for a, b in zip(backward, change)), 1e-8)
    end = robot.rollout(q, qd, controls, 0.002, step="step", settings=settings, trajectory=False, ground=ground)
    for a, b in zip(rollout(q, qd, controls, 0.002, settings=settings), end):
        close(a, b)
    motion = lambda controls: sum((x**2).sum() for x in rollout(q, qd, controls, 0.002, settings=settings)[:2])
    expected = robot.rollout_vjp(q, qd, controls, 0.002, 2 * end.q, 2 * end.qd, step="step", settings=settings, trajectory=False, ground=ground)
    close(jax.grad(motion)(controls), expected.controls, 1e-9)
    # All directions at a time: a batch of changes, and a batch of weights of the last state.
    for a, b in zip(jax.jacfwd(energy, argnums=(2, 3))(q, qd, controls, settings), backward[2:]):
        close(a, b, 1e-7)
    last = lambda controls, settings: rollout(q[0], qd[0], controls, 0.002, settings=settings).qd
    for a, b in zip(*(way(last, argnums=(0, 1))(controls[0], settings) for way in (jax.jacfwd, jax.jacrev))):
        assert np.abs(a).max() > 1e-3
        close(a, b, 1e-7)


def test_the_example_of_mppi():
    program = ROBOTS.parent / "examples" / "mppi" / "walk.py"
    walk = runpy.run_path(str(program))
    state = walk["walk"](0.3)
    assert state[0][0] > 0.03 and abs(state[0][2] - walk["HIP"]) < 0.03


def test_single_precision():
    robot, q, qd, tau, settings = scene(8, scalar="f32")
    double = tree()
    controls = np.repeat(tau[:, None], 3, 1).astype(np.float32)
    arguments = dict(step="step", settings=settings)
    single = robot.rollout(q.astype(np.float32), qd.astype(np.float32), controls, np.float32(0.002), **arguments)
    expected = double.rollout(q, qd, controls, 0.002, **arguments)
    assert single.q.dtype == np.float32
    close(single.qd, expected.qd, 2e-3)


def test_wrong_arguments():
    robot, q, qd, tau, settings = scene(3)
    controls = tau[:, None]
    with pytest.raises(ValueError, match="`settings` of `rollout` has the shape"):
        robot.rollout(q, qd, controls, 0.001, step="step", settings=settings[:-1])
    for name, x in {"ground": ramp()[0], "settings": settings, "warm_start": qd}.items():
        with pytest.raises(TypeError, match=f'`{name}` is an argument of rollouts with `step="step"`'):
            robot.rollout(q, qd, controls, 0.001, **{name: x})
    with pytest.raises(TypeError, match="`ground` must be a `modyn.HeightField`, not ndarray"):
        robot.rollout(q, qd, controls, 0.001, step="step", ground=np.zeros((3, 3)))
    with pytest.raises(TypeError, match="has no cost: compute it from the states"):
        robot.rollout(q, qd, controls, 0.001, step="step", cost=modyn.QuadraticCost(q[0], np.ones(2 * robot.nv)))
    with pytest.raises(ValueError, match="there is no time step `ground`; there are: .*step"):
        robot.rollout(q, qd, controls, 0.001, step="ground")


def test_touching_points():
    """Points on planes, on a ramp, and on hills below each of two feet, in NumPy and in JAX."""
    jax = pytest.importorskip("jax")
    import modyn.jax

    jax.config.update("jax_enable_x64", True)
    robot, q, qd, _, settings = scene(5)
    points = robot.touching_points(q, qd, settings)
    forces = robot.step(q, qd, np.zeros(robot.nv), 0.001, settings=settings).forces
    assert points.gaps.shape == (5, 2) and ((points.gaps > 0.05) <= (forces == 0).all(-1)).all()
    function = modyn.jax.function(robot, "touching_points")
    for a, b in zip(function(q, qd, settings), points):
        close(a, b, 1e-12)
    # The rate of a gap is the velocity along the normal.
    rates = modyn.jax.function(robot, "velocity_to_qdot")(q, qd)
    gaps = lambda q: function(q, qd, settings).gaps
    close(jax.jvp(gaps, (q,), (rates,))[1], points.velocities[..., 2], 1e-9)
    field, plane = ramp()
    on_plane = StepSettings([ContactSurface(**plane)] * 2)
    found = function(q, qd, StepSettings([ContactSurface()] * 2), ground=field)
    for a, b in zip(found, robot.touching_points(q, qd, on_plane)):
        close(a, b, 1e-9)
    second = lambda settings, **ground: jax.hessian(lambda q: function(q, qd[0], settings, **ground).gaps.sum())(q[0])
    with pytest.raises(NotImplementedError, match="first derivatives alone; for others, set the planes of the surfaces in the settings"):
        second(StepSettings([ContactSurface()] * 2), ground=field)
    assert np.abs(second(on_plane)).max() > 0.1
    ground = hills((5,))
    found = jax.jit(lambda heights: function(q, qd, ground=modyn.HeightField(heights, ground.origin, ground.spacing)))(ground.heights)
    level = robot.touching_points(q, qd, StepSettings([ContactSurface()] * 2))
    assert (np.abs(found.gaps - level.gaps) < 0.05).all() and np.abs(found.gaps - level.gaps).max() > 1e-3
    step = modyn.jax.function(robot, "step")
    one = robot.rollout(q, qd, np.zeros((1, robot.nv)), 0.001, step="step", ground=ground)
    close(step(q, qd, np.zeros(robot.nv), 0.001, ground=ground).q, one.q[:, 0], 1e-9)
    with pytest.raises(ValueError, match="axes of states of the arguments of `touching_points` do not fit: .*ground.heights` \\(5,\\)"):
        function(q[:3], qd[:3], ground=ground)
    with pytest.raises(TypeError, match="`mass_matrix`: got an unexpected keyword argument 'ground'"):
        modyn.jax.function(robot, "mass_matrix")(q, ground=ground)
    with pytest.raises(ValueError, match="only robots with shapes that touch the ground .* have the function `touching_points`"):
        modyn.loads(chain(7)).touching_points(np.zeros(3), np.zeros(3))
    # As part of a fused function.
    fused = modyn.loads(chain(7, joints=5), base="floating", contacts=CONTACTS, fused={"feet": ["difference", "touching_points"]})
    together = modyn.jax.function(fused, "feet")
    found = together(q, qd, from_=q, to=q[::-1], ground=ground)
    close(found.touching_points.gaps, function(q, qd, ground=ground).gaps, 1e-9)


def test_grounds_in_jax():
    """Heights are an argument: of `jit`, and of `vmap`."""
    jax = pytest.importorskip("jax")
    import modyn.jax

    jax.config.update("jax_enable_x64", True)
    robot, q = quadruped()
    rollout = modyn.jax.rollout(robot, step="step", trajectory=False)
    field, qd, controls = hills((3,)), np.zeros(robot.nv), np.zeros((20, robot.nv))
    traces = []

    @jax.jit
    def end(heights, origin, spacing):
        traces.append(heights)
        return rollout(q, qd, controls, 0.002, ground=modyn.HeightField(heights, origin, spacing)).q

    expected = robot.rollout(q, qd, controls, 0.002, step="step", trajectory=False, ground=field).q
    parts = field.heights, field.origin, field.spacing
    for world in range(3):
        close(end(*(x[world] for x in parts)), expected[world], 1e-9)
    assert len(traces) == 1
    close(jax.vmap(end)(*parts), expected, 1e-9)
    # A ground is an argument of `jit` and of `vmap` by itself.
    at = jax.jit(lambda ground: rollout(q, qd, controls, 0.002, ground=ground).q)
    close(at(field), expected, 1e-9)
    close(jax.vmap(at)(field), expected, 1e-9)
    with pytest.raises(NotImplementedError, match="no derivatives with respect to the fields of `ground`"):
        jax.grad(lambda heights: end(heights, *parts[1:])[0, 2])(field.heights)
    one = modyn.HeightField(*(x[0] for x in parts))
    for transformation in (jax.hessian, lambda f: jax.jacfwd(jax.jacfwd(f))):
        with pytest.raises(NotImplementedError, match="`step` has first derivatives alone"):
            transformation(lambda qd: rollout(q, qd, controls, 0.002, ground=one).q[2])(qd)
