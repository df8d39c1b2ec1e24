"""Rollouts in one call beside single steps, and their gradients beside differences."""

import numpy as np
import pytest
from conftest import chain, close, states

import modyn


def robot(base="floating", **options):
    return modyn.loads(chain(3, joints=4), base=base, **options)


def motions(own, n=11, steps=7):
    """Returns the first states and the controls of motions."""
    q, qd, *_ = states(own, n)
    return q, 0.3 * qd, np.random.default_rng(1).normal(size=(n, steps, own.nv)), np.linspace(0.001, 0.01, n)


def stepped(own, q, qd, controls, dt, method="semi_implicit", feedback=None):
    """Returns the states after each step, by single calls."""
    found = []
    for k in range(controls.shape[1]):
        tau = controls[:, k]
        if feedback is not None:
            gains, q_ref, qd_ref = (np.broadcast_to(x, (len(q), *x.shape[-n:])) for x, n in zip(feedback(k), (2, 1, 1)))
            error = np.concatenate([own.difference(q, q_ref), qd_ref - qd], -1)
            tau = tau + np.einsum("nij,nj->ni", gains, error)
        q, qd = getattr(own, f"step_{method}")(q, qd, tau, dt)
        found.append((q, qd))
    return tuple(np.stack(x, 1) for x in zip(*found))


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("method", ["semi_implicit", "rk4"])
def test_states_are_those_of_single_steps(base, method):
    own = robot(base)
    q, qd, controls, dt = motions(own)
    expected = stepped(own, q, qd, controls, dt, method)
    found = own.rollout(q, qd, controls, dt, step=method)
    assert isinstance(found, modyn.RolloutStates)
    close(found.q, expected[0], 1e-9)
    close(found.qd, expected[1], 1e-9)
    last = own.rollout(q, qd, controls, dt, step=method, trajectory=False)
    assert np.array_equal(last.q, found.q[:, -1]) and np.array_equal(last.qd, found.qd[:, -1])
    one = own.rollout(q[2], qd[2], controls[2], dt[2], step=method)
    close(one.q, expected[0][2], 1e-9)


def references(own, n, steps):
    rng = np.random.default_rng(5)
    gains = 0.2 * rng.normal(size=(steps, own.nv, 2 * own.nv))
    return gains, np.stack([states(own, steps, k)[0] for k in range(n)]), rng.normal(size=(n, steps, own.nv))


def test_feedback():
    own = robot()
    q, qd, controls, dt = motions(own, 5, 4)
    gains, q_ref, qd_ref = references(own, 5, 4)
    # Gains of each step; references of each motion and step.
    expected = stepped(own, q, qd, controls, dt, feedback=lambda k: (gains[k], q_ref[:, k], qd_ref[:, k]))
    found = own.rollout(q, qd, controls, dt, gains=gains, q_ref=q_ref, qd_ref=qd_ref)
    close(found.q, expected[0], 1e-9)
    # The same for all steps and motions.
    constant = gains[0], q_ref[0, 0], qd_ref[0, 0]
    expected = stepped(own, q, qd, controls, dt, feedback=lambda k: constant)
    found = own.rollout(q, qd, controls, dt, gains=constant[0], q_ref=constant[1], qd_ref=constant[2])
    close(found.qd, expected[1], 1e-9)
    # The same for all steps, with one of each motion.
    expected = stepped(own, q, qd, controls, dt, feedback=lambda k: (gains[0], q_ref[:, 0], qd_ref[:, 0]))
    found = own.rollout(q, qd, controls, dt, gains=gains[:1], q_ref=q_ref[:, :1], qd_ref=qd_ref[:, :1])
    close(found.qd, expected[1], 1e-9)


@pytest.mark.parametrize("steps, trajectory", [(4, True), (4, False), (150, False)])
def test_gradients(steps, trajectory):
    """Beside differences along a random direction; a long motion is computed again in parts."""
    own = robot()
    q, qd, controls, dt = motions(own, 5, steps)
    dt = dt / 10
    gains, q_ref, qd_ref = references(own, 5, steps)
    given = {"q": q, "qd": qd, "controls": controls, "dt": dt, "q_ref": q_ref}
    shared = {"gains": gains[0], "qd_ref": qd_ref[0, 0]}
    for arguments in ({**given, **shared}, {name: given[name] for name in ("q", "qd", "controls", "dt")}):
        rng = np.random.default_rng(2)
        states_of = lambda x: own.rollout(**x, trajectory=trajectory)
        weights = [rng.normal(size=x.shape) for x in states_of(arguments)]
        found = own.rollout_vjp(**arguments, q_weights=weights[0], qd_weights=weights[1], trajectory=trajectory)
        assert (found.gains is None) == ("gains" not in arguments)
        direction = {name: rng.normal(size=x.shape) for name, x in arguments.items()}
        direction["dt"] = direction["dt"] * 1e-3
        # Steps scale quaternions, so that these may have any length.
        at = lambda h: states_of({name: x + h * direction[name] for name, x in arguments.items()})
        change = [(a - 8 * b + 8 * c - d) / 12e-4 for a, b, c, d in zip(*(at(k * 1e-4) for k in (-2, -1, 1, 2)))]
        axes = lambda x: tuple(range(1, x.ndim))
        expected = sum((w * x).sum(axes(x)) for w, x in zip(weights, change))
        along = 0.0
        for name, x in arguments.items():
            gradient = getattr(found, name)
            assert gradient.shape == ((5, *x.shape) if name in shared else x.shape), name
            along = along + (gradient * direction[name]).reshape(5, -1).sum(1)
        close(along, expected, 1e-5)


def test_single_precision_and_no_machine_code():
    own = robot("fixed")
    q, qd, controls, dt = motions(own)
    expected = own.rollout(q, qd, controls, dt)
    single = robot("fixed", scalar="f32").rollout(q.astype("f4"), qd.astype("f4"), controls.astype("f4"), np.float32(dt))
    assert single.q.dtype == np.float32
    close(single.q, expected.q, 1e-3)
    slow = robot("fixed", machine_code=False)
    close(slow.rollout(q, qd, controls, dt).q, expected.q, 1e-9)
    weights = np.ones_like(expected.q), np.ones_like(expected.qd)
    close(slow.rollout_vjp(q, qd, controls, dt, *weights).q, own.rollout_vjp(q, qd, controls, dt, *weights).q, 1e-9)


def test_many_motions_in_threads_and_axes_of_motions():
    own = robot("fixed")
    q, qd, controls, dt = motions(own, 600, 9)
    found = own.rollout(q, qd, controls, 0.01)
    for i in (0, 299, 599):
        close(found.q[i], own.rollout(q[i], qd[i], controls[i], 0.01).q, 1e-9)
    crossed = own.rollout(q[:3, None], qd[0], controls[:4], 0.01, trajectory=False)
    assert crossed.q.shape == (3, 4, own.nq)
    close(crossed.q[2, 3], own.rollout(q[2], qd[0], controls[3], 0.01).q[-1], 1e-9)
    broken = controls.copy()
    broken[7, 3] = np.nan
    other = own.rollout(q, qd, broken, 0.01)
    assert np.isnan(other.q[7, -1]).any()
    close(np.delete(other.q, 7, 0), np.delete(found.q, 7, 0), 1e-12)
    none = own.rollout(q, qd, controls[:, :0], 0.01)
    assert none.q.shape == (600, 0, own.nq)
    assert np.array_equal(own.rollout(q, qd, controls[:, :0], 0.01, trajectory=False).q, q)


def test_run_time_parameters():
    own = robot("fixed", payload=["link3"])
    q, qd, controls, dt = motions(own)
    before = own.rollout(q, qd, controls, dt)
    own.set_payload("link3", 2.0, (0.1, 0.2, 0.3))
    found = own.rollout(q, qd, controls, dt)
    close(found.q, stepped(own, q, qd, controls, dt)[0], 1e-9)
    assert np.abs(found.q - before.q).max() > 1e-6


def test_refused():
    own = robot("fixed")
    q, qd, controls, _ = (x[0] for x in motions(own))
    with pytest.raises(ValueError, match="no time step `euler`; there are: .*semi_implicit"):
        own.rollout(q, qd, controls, 0.01, step="euler")
    with pytest.raises(ValueError, match=r"`controls` of `rollout` has the shape \(4,\); expected \(steps, 4\)"):
        own.rollout(q, qd, controls[0], 0.01)
    with pytest.raises(ValueError, match=r"`qd` of `rollout` has the shape \(3,\); expected \(4,\)"):
        own.rollout(q, qd[:3], controls, 0.01)
    with pytest.raises(TypeError, match="`gains`, `q_ref` and `qd_ref` together: `q_ref` is missing"):
        own.rollout(q, qd, controls, 0.01, gains=np.zeros((4, 8)))
    with pytest.raises(TypeError, match="`q` of `rollout` must be an array of real numbers"):
        own.rollout("zero", qd, controls, 0.01)
    with pytest.raises(ValueError, match=r"`qd_weights` of `rollout_vjp` has the shape \(4,\); expected \(7, 4\)"):
        own.rollout_vjp(q, qd, controls, 0.01, np.zeros((7, 4)), np.zeros(4))
