"""Numbers out of range are refused by name at every door, and NaN reaches the results that depend on it."""

import numpy as np
import pytest
from conftest import ROBOTS, chain, signatures, states

import modyn
from modyn import ConstraintSettings, ContactSurface, ContactTarget, HeightField, StepSettings

DT = 0.002
CONTACTS = {"hand": ("point", "link2", [0.1, -0.2, 0.15]), "foot": ("point", "link4", [0, 0.2, 0.1])}


def tree(**options):
    return modyn.loads(chain(7, joints=5), base="floating", contacts=CONTACTS, joint_friction="none", **options)


@pytest.fixture(scope="module")
def robot():
    return tree()


def state(robot):
    q, qd, _, tau = states(robot, 1)
    return q[0], qd[0], tau[0]


BAD = [
    ("restitution", 2.0, "from 0 to 1"),
    ("restitution", -5.0, "from 0 to 1"),
    ("compliance", -1.0, "not negative"),
    ("compliance", np.inf, "not negative"),
    ("weight", -1.0, "above 0"),
    ("weight", 0.0, "above 0"),
    ("alpha", -1.0, "not negative"),
    ("beta", np.nan, "not negative"),
    ("tangential", -1.0, "not negative"),
    ("translation", (0.0, np.nan, 0.0), "a finite number"),
    ("velocity", (0.0, 0.0, 0.0, np.inf, 0.0, 0.0), "a finite number"),
    ("rotation", np.zeros((3, 3)), "is no rotation"),
    ("rotation", 5 * np.eye(3), "is no rotation"),
    ("rotation", np.diag([1.0, 1.0, -1.0]), "is no rotation"),
]


def doors(robot):
    """Returns a call of each function with settings."""
    q, qd, tau = state(robot)
    functions = {
        "constrained_forward_dynamics": (q, qd, tau),
        "constrained_forward_dynamics_derivatives": (q, qd, tau),
        "constraint_residual": (q, qd),
        "impact_dynamics": (q, qd),
    }
    call = lambda name, arguments: lambda settings: getattr(robot, name)(*arguments, settings=settings)
    found = {name: call(name, arguments) for name, arguments in functions.items()}
    found["many states"] = lambda settings: robot.impact_dynamics(np.stack([q, q]), qd, settings=settings)
    return found


@pytest.mark.parametrize("name, value, expected", BAD)
def test_settings_out_of_range_are_named(robot, name, value, expected):
    settings = ConstraintSettings([ContactTarget(), ContactTarget(**{name: value})])
    for door, call in doors(robot).items():
        call(ConstraintSettings([ContactTarget(), ContactTarget()]))
        with pytest.raises(ValueError, match=rf"`{name}` of `settings.targets\[1\]`.*{expected}") as error:
            call(settings)
        assert np.ndim(value) or str(value).removesuffix(".0").lower() in str(error.value).lower(), (door, error.value)


@pytest.mark.parametrize("name", ["alpha", "beta", "tolerance", "rounding"])
def test_settings_of_all_constraints_are_named(robot, name):
    for value in (-1.0, np.nan, np.inf):
        settings = ConstraintSettings([ContactTarget()] * 2, **{name: value})
        for call in doors(robot).values():
            with pytest.raises(ValueError, match=f"`{name}` of `settings` is"):
                call(settings)


def test_the_state_of_a_wrong_number_is_named(robot):
    q, qd, tau = state(robot)
    settings = np.tile(np.asarray(ConstraintSettings([ContactTarget()] * 2)), (5, 1))
    settings[3, -1] = -0.5
    with pytest.raises(ValueError, match=r"`weight` of `settings.targets\[1\]` is -0.5.*\(in state 3\)"):
        robot.impact_dynamics(q, qd, settings=settings)


def steps(robot):
    """Returns a call of each function with settings of steps."""
    q, qd, tau = state(robot)
    zeros, controls = np.zeros(robot.nv), np.zeros((3, robot.nv))
    weights = np.zeros((3, robot.nq)), np.zeros((3, robot.nv))
    return {
        "step": lambda settings=None, dt=DT: robot.step(q, qd, tau, dt, settings=settings),
        "many states": lambda settings=None, dt=DT: robot.step(np.stack([q, q]), qd, tau, dt, settings=settings),
        "step_derivatives": lambda settings=None, dt=DT: robot.step_derivatives(q, qd, tau, dt, settings=settings),
        "rollout": lambda settings=None, dt=DT: robot.rollout(q, qd, controls, dt, step="step", settings=settings),
        "rollout_vjp": lambda settings=None, dt=DT: robot.rollout_vjp(q, qd, controls, dt, *weights, step="step", settings=settings),
        "simulate": lambda settings=None, dt=DT: robot.simulate(lambda *_: zeros, q, qd, dt, 2, settings),
    }


@pytest.mark.parametrize(
    "name, value, expected",
    [
        ("friction", np.nan, "not negative"),
        ("friction", -0.8, "not negative"),
        ("radius", -0.1, "not negative"),
        ("margin", np.inf, "a finite number"),
        ("translation", (0.0, np.nan, 0.0), "a finite number"),
        ("rotation", np.diag([1.0, 1.0, -1.0]), "is no rotation"),
    ],
)
def test_settings_of_steps_out_of_range_are_named(robot, name, value, expected):
    settings = StepSettings([ContactSurface(), ContactSurface(**{name: value})])
    for call in steps(robot).values():
        call(StepSettings([ContactSurface()] * 2))
        with pytest.raises(ValueError, match=rf"`{name}` of `settings.surfaces\[1\]`.*{expected}"):
            call(settings)


@pytest.mark.parametrize("dt", [0.0, -0.001, np.nan, np.inf])
def test_time_steps_on_the_ground_are_above_zero(robot, dt):
    for call in steps(robot).values():
        with pytest.raises(ValueError, match="`dt` is .*; expected a finite number above 0"):
            call(dt=dt)


@pytest.mark.parametrize(
    "ground, message",
    [
        (HeightField([[0, 0, 0], [0, 0, np.nan]]), r"`heights`\[1, 2\] of the height field is NaN"),
        (HeightField([[0, np.inf], [0, 0]]), r"`heights`\[0, 1\] of the height field is inf"),
        (HeightField(np.zeros((2, 2)), spacing=(1.0, 0.0)), "`spacing` of the height field is 0"),
        (HeightField(np.zeros((2, 2)), spacing=(np.nan, 1.0)), "`spacing` of the height field is NaN"),
        (HeightField(np.zeros((2, 2)), origin=(np.inf, 0.0)), "`origin` of the height field is inf"),
    ],
)
def test_height_fields_are_checked(robot, ground, message):
    q, qd, tau = state(robot)
    with pytest.raises(ValueError, match=message):
        robot.simulate(lambda *_: tau, q, qd, DT, 2, ground=ground)
    with pytest.raises(ValueError, match=message):
        robot.rollout(q, qd, np.zeros((3, robot.nv)), DT, step="step", ground=ground)


def test_heights_are_checked_in_the_scalar():
    robot = tree(scalar="f32")
    q, qd, tau = state(robot)
    with pytest.raises(ValueError, match=r"`heights`\[0, 0\] of the height field is inf"):
        robot.rollout(q, qd, np.zeros((3, robot.nv)), DT, step="step", ground=HeightField(np.full((2, 2), 1e300)))


def on_ground(robot, q, **fields):
    """Returns settings in which the foot is 10 cm below the ground."""
    pose = robot.link_pose(q, "link4")
    height = (pose.rotation @ CONTACTS["foot"][2] + pose.translation)[2] + 0.1
    return StepSettings([ContactSurface(translation=(0, 0, -9)), ContactSurface(translation=(0, 0, height), **fields)])


FIELDS = {"friction": [0.1, 0.4, 0.9], "solref": [[0.02, 1.0], [0.1, 0.7], [0.02, 2.0]]}


def test_fields_of_settings_have_axes_of_states(robot):
    q, qd, tau = state(robot)
    found = robot.step(q, qd, tau, DT, settings=on_ground(robot, q, **{name: np.array(x) for name, x in FIELDS.items()}))
    motion = robot.rollout(q, qd, np.tile(tau, (2, 1)), DT, step="step", settings=on_ground(robot, q, friction=np.array(FIELDS["friction"])))
    assert found.qd.shape == (3, robot.nv) and motion.qd.shape == (3, 2, robot.nv)
    for k in range(3):
        own = on_ground(robot, q, **{name: x[k] for name, x in FIELDS.items()})
        assert np.allclose(found.qd[k], robot.step(q, qd, tau, DT, settings=own).qd, rtol=0, atol=1e-12)
        assert np.abs(found.qd[k] - found.qd[k - 1]).max() > 1e-4 and np.abs(motion.qd[k] - motion.qd[k - 1]).max() > 1e-4
    settings = ConstraintSettings([ContactTarget(compliance=np.array([0.0, 0.3])), ContactTarget()], alpha=np.array([5.0, 9.0]))
    assert np.asarray(settings).shape[:-1] == (2,)
    qdd = robot.constrained_forward_dynamics(q, qd, tau, settings=settings).qdd
    one = ConstraintSettings([ContactTarget(compliance=0.3), ContactTarget()], alpha=9.0)
    assert np.allclose(qdd[1], robot.constrained_forward_dynamics(q, qd, tau, settings=one).qdd, rtol=0, atol=1e-10)
    with pytest.raises((TypeError, ValueError), match=r"`solref` of the settings has the shape \(3,\); expected \(2,\)"):
        robot.rollout(q, qd, np.tile(tau, (2, 1)), DT, step="step", settings=on_ground(robot, q, solref=(1, 2, 3)))


def test_jax_differentiates_fields_of_settings(robot):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import modyn.jax

    q, qd, tau = state(robot)
    rollout, step = modyn.jax.rollout(robot, step="step"), modyn.jax.function(robot, "step")
    calls = {
        "step": lambda friction: step(q, qd, tau, DT, settings=on_ground(robot, q, friction=friction)).qd.sum(),
        "rollout": lambda friction: rollout(q, qd, np.tile(tau, (3, 1)), DT, settings=on_ground(robot, q, friction=friction)).qd.sum(),
    }
    for name, call in calls.items():
        found, h = jax.jit(jax.vmap(jax.grad(call)))(np.array([0.1, 0.2])), 1e-5
        for friction, gradient in zip([0.1, 0.2], found):
            expected = (call(friction + h) - call(friction - h)) / (2 * h)
            assert abs(expected) > 1e-3 and abs(gradient - expected) < 1e-5 * max(1, abs(expected)), name


def test_jax_checks_settings(robot):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import modyn.jax

    q, qd, tau = state(robot)
    good = np.asarray(StepSettings([ContactSurface()] * 2))
    bad = np.asarray(StepSettings([ContactSurface(), ContactSurface(friction=-0.1)]))
    step = modyn.jax.function(robot, "step")
    rollout = modyn.jax.rollout(robot, step="step")
    controls = np.zeros((3, robot.nv))
    for call in (
        lambda settings: step(q, qd, tau, DT, settings=settings),
        jax.jit(lambda settings: rollout(q, qd, controls, DT, settings=settings).q),
        jax.grad(lambda settings: rollout(q, qd, controls, DT, settings=settings).q.sum()),
    ):
        jax.block_until_ready(call(good))
        with pytest.raises(Exception, match=r"`friction` of `settings.surfaces\[1\]` is -0.1"):
            jax.block_until_ready(call(bad))


def test_torch_checks_settings(robot):
    torch = pytest.importorskip("torch")
    import modyn.torch

    q, qd, tau = state(robot)
    bad = torch.from_numpy(np.asarray(ConstraintSettings([ContactTarget(), ContactTarget(compliance=-0.1)])))
    with pytest.raises(ValueError, match=r"`compliance` of `settings.targets\[1\]` is -0.1"):
        modyn.torch.function(robot, "impact_dynamics")(q, qd, np.ones(2), bad)


def test_random_parts_are_between_zero_and_one(robot):
    parts = np.full(robot.nv, 0.5)
    for wrong in (5.0, -0.1, np.inf):
        with pytest.raises(ValueError, match="`uniforms` is .*; expected a number from 0 to 1"):
            robot.random_configuration(np.where(np.arange(robot.nv) == 3, wrong, parts))
    arm = modyn.load(ROBOTS / "arm7.urdf", joint_friction="none")
    assert np.isnan(arm.random_configuration(np.full(arm.nv, np.nan))).all()


def numbers(result):
    """Returns the numbers of a result for many states, a row for each."""
    fields = result if isinstance(result, tuple) else (result,)
    flat = [numbers(field) if isinstance(field, tuple) else np.asarray(field, float).reshape(len(field), -1) for field in fields]
    return np.concatenate(flat, 1)


@pytest.mark.parametrize("machine_code", [True, False])
def test_nan_reaches_the_results_of_every_function(machine_code):
    """A number whose change changes results makes a result NaN where it is NaN. Settings are refused instead."""
    robot = tree(machine_code=machine_code)
    rng = np.random.default_rng(3)
    q, qd, tau = state(robot)
    # Both contacts are in the ground.
    q[2] -= 1.0
    own = {"q": q, "from_": q, "qd": qd, "tau": tau, "dt": DT, "uniforms": rng.random(robot.nv)}
    found = {}
    for name, arguments, link in signatures(robot, "link4"):
        given = {k: np.asarray(own.get(k, rng.normal(size=shape) if default is None else default)) for k, shape, default in arguments}
        call = lambda changed: numbers(getattr(robot, name)(*({**given, **changed}.values()), *link))
        found[name] = 0
        for argument, x in given.items():
            is_checked = argument in ("settings", "step_settings") or (name, argument) == ("step", "dt")
            if is_checked or argument == "active" or x.size == 0:
                continue
            moved, unknown = (np.tile(x.ravel(), (x.size, 1)) for _ in range(2))
            at = np.arange(x.size)
            moved[at, at] = x.ravel() * 0.9 + 0.005
            unknown[at, at] = np.nan
            shaped = lambda rows: rows.reshape(x.size, *x.shape)
            before = call({argument: shaped(np.tile(x.ravel(), (x.size, 1)))})
            effective = (call({argument: shaped(moved)}) != before).any(1)
            reached = np.isnan(call({argument: shaped(unknown)})).any(1)
            assert reached[effective].all(), (name, argument, np.flatnonzero(effective & ~reached))
            found[name] += effective.sum()
    assert all(found.values()), found


def test_nan_in_a_state_reaches_the_state_after_steps_on_the_ground(robot):
    q, qd, tau = state(robot)
    q[2] -= 1.0
    field = HeightField(np.zeros((2, 2)))
    move = lambda n, ground: robot.rollout(np.tile(q, (n, 1)), qd, np.stack([tau] * 2), DT, step="step", trajectory=False, ground=ground)
    assert (move(1, None).forces != 0).any()
    for x in (q, qd, tau):
        for n, ground in ((1, None), (9, field)):
            for k in range(len(x)):
                before, x[k] = x[k], np.nan
                after = move(n, ground)
                assert np.isnan(after.qd).any(-1).all() and np.isnan(after.residual).all(), k
                x[k] = before
