"""The environment of `examples/walk`: shapes, episodes, worlds that differ, and its physics beside MuJoCo's."""

import sys

import numpy as np
import pytest
from conftest import ROBOTS

jax = pytest.importorskip("jax")
mujoco = pytest.importorskip("mujoco")
jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp

sys.path.insert(0, str(ROBOTS.parent / "examples" / "walk"))
from environment import CONTROL, EPISODE, STEPS, Walk
from tasks import QUADRUPED, TASKS

from modyn.conventions import MuJoCo

COUNT = 4


@pytest.fixture(scope="module")
def walk():
    """The environment, worlds, and its functions, compiled."""
    environment = Walk(scalar="f64")
    return environment, environment.worlds(3, COUNT, starts=16), jax.jit(environment.reset), jax.jit(environment.step)


def actions(seed):
    return 0.5 * jax.random.normal(jax.random.key(seed), (COUNT, 12))


def test_episodes(walk):
    """A fall and the end of the time begin a new episode, and the state before is kept."""
    environment, worlds, reset, step = walk
    state = reset(jax.random.key(0), worlds)
    upside_down = state.q.at[0, 3:7].set(jnp.array([1.0, 0, 0, 0]))
    time = state.time.at[1].set(EPISODE - 1)
    after = step(worlds, state._replace(q=upside_down, time=time), actions(1), jax.random.key(2))
    assert after.fell.tolist() == [True, False, False, False]
    assert after.timed_out.tolist() == [False, True, False, False]
    assert after.state.time.tolist() == [0, 0, 1, 1] and after.final.time.tolist() == [1, EPISODE, 1, 1]
    changed = jnp.abs(after.state.q - after.final.q).max(-1)
    assert (changed[:2] > 0.01).all() and (changed[2:] == 0).all()
    assert after.reward[0] == -1 and (after.reward[1:] >= 0).all()
    assert after.rewards.keys() == QUADRUPED.rewards.keys()
    expected = CONTROL * jnp.maximum(sum(after.rewards.values()), 0)
    assert np.allclose(after.reward[1:], expected[1:], rtol=1e-12)
    exact, noisy = environment.observe(worlds, after.state), environment.observe(worlds, after.state, jax.random.key(3))
    assert exact.actor.shape == (COUNT, environment.actor) and exact.critic.shape == (COUNT, environment.critic)
    assert 0.001 < jnp.abs(noisy.actor - exact.actor).max() < 0.06 and (noisy.critic == exact.critic).all()
    again = step(worlds, state._replace(q=upside_down, time=time), actions(1), jax.random.key(2))
    assert jax.tree.all(jax.tree.map(lambda a, b: bool((a == b).all()), after, again))


def test_worlds_differ(walk):
    """The same state and action lead elsewhere, in each world by its friction, load and delay."""
    environment, worlds, reset, step = walk
    state = jax.tree.map(lambda x: jnp.repeat(x[:1], COUNT, 0), reset(jax.random.key(0), worlds))
    state = state._replace(q=state.q.at[:, 2].set(0.245))
    action = jnp.repeat(actions(1)[:1], COUNT, 0)
    alike = jax.tree.map(lambda x: jnp.repeat(x[:1], COUNT, 0), worlds._replace(starts=None))
    advance = jax.jit(lambda own: environment.advance(own, state, action)[0].qd)
    assert len({*np.asarray(worlds.friction).tolist()}) == COUNT
    for name in ("settings", "payload", "delay"):
        own = alike._replace(**{name: getattr(worlds, name)})
        own = own if name != "delay" else own._replace(delay=jnp.arange(COUNT))
        qd = np.asarray(advance(own))
        assert all(np.abs(qd[a] - qd[b]).max() > 1e-6 for a in range(COUNT) for b in range(a)), name


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
def test_motion_is_mujocos(task):
    """Under random actions, for a second, on the same file."""
    environment = Walk(task, scalar="f64", randomize=False)
    worlds = environment.worlds(0, 1, starts=1)
    advance = jax.jit(lambda state, action: environment.advance(worlds, state, action)[0])
    model = mujoco.MjModel.from_xml_path(str(task.robot))
    model.opt.tolerance, model.opt.ls_tolerance = 1e-14, 1e-10
    data, theirs = mujoco.MjData(model), MuJoCo(environment.robot, model)
    state = environment.start(environment.stand[None], jnp.zeros((1, environment.robot.nv)))
    data.qpos[:] = theirs.to_qpos(environment.stand)
    for k in range(round(1 / CONTROL)):
        action = actions(k)[:1]
        data.ctrl[:] = environment.targets(state.phase, state.command, action)[0]
        state = advance(state, action)
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
    assert np.abs((state.q[0] - environment.stand)[7:]).max() > 0.1 and state.feet.forces.max() > 0
    assert np.allclose(state.q[0], theirs.from_qpos(data.qpos), rtol=0, atol=1e-10)
    assert np.allclose(state.qd[0], theirs.from_qvel(state.q[0], data.qvel), rtol=0, atol=1e-9)
