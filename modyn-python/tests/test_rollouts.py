"""Rollouts in one call beside single steps, and their gradients beside differences."""

import gc
import weakref

import numpy as np
import pytest
from conftest import chain, close, states

import modyn
from modyn._arrays import Extras


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
        found = own.rollout_vjp(**arguments, q_cotangent=weights[0], qd_cotangent=weights[1], trajectory=trajectory)
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


def costs(own, n, steps):
    """Returns a cost with numbers of each step, of each motion, and of all of them."""
    rng = np.random.default_rng(7)
    return modyn.QuadraticCost(
        q_goal=np.stack([states(own, steps, k)[0] for k in range(n)]),
        qd_goal=rng.normal(size=own.nv),
        state_weights=rng.normal(size=(n, 1, 2 * own.nv)),
        control_weights=rng.normal(size=(steps, own.nv)),
        terminal_weights=rng.normal(size=2 * own.nv),
    )


@pytest.mark.parametrize("has_feedback", [False, True])
def test_cost(has_feedback):
    own = robot()
    q, qd, controls, dt = motions(own, 5, 4)
    cost = costs(own, 5, 4)
    gains, q_ref, qd_ref = references(own, 5, 4)
    feedback = {"gains": gains, "q_ref": q_ref, "qd_ref": qd_ref} if has_feedback else {}
    found = own.rollout(q, qd, controls, dt, cost=cost, **feedback)
    assert isinstance(found, modyn.RolloutCosts) and found.cost.shape == (5, 4)
    alone = own.rollout(q, qd, controls, dt, **feedback)
    close(found.q, alone.q, 1e-9)
    expected = np.zeros((5, 4))
    for k in range(4):
        forces = controls[:, k]
        if has_feedback:
            before = (q, qd) if k == 0 else (alone.q[:, k - 1], alone.qd[:, k - 1])
            error = np.concatenate([own.difference(before[0], q_ref[:, k]), qd_ref[:, k] - before[1]], -1)
            forces = forces + error @ gains[k].T
        goal = np.ascontiguousarray(cost.q_goal[:, k])
        error = np.concatenate([own.difference(np.ascontiguousarray(alone.q[:, k]), goal), cost.qd_goal - alone.qd[:, k]], -1)
        weights = cost.state_weights[:, 0] + (cost.terminal_weights if k == 3 else 0)
        expected[:, k:] += ((weights * error**2).sum(1) + (cost.control_weights[k] * forces**2).sum(1))[:, None]
    close(found.cost, expected, 1e-9)
    last = own.rollout(q, qd, controls, dt, cost=cost, trajectory=False, **feedback)
    assert np.array_equal(last.cost, found.cost[:, -1])
    # Weights of states alone, the same for all steps and motions; a motion without a step.
    plain = modyn.QuadraticCost(q[0], np.ones(2 * own.nv))
    error = np.concatenate([own.difference(np.ascontiguousarray(alone.q[:, 0]), np.tile(q[0], (5, 1))), alone.qd[:, 0]], -1)
    close(own.rollout(q, qd, controls, dt, cost=plain, **feedback).cost[:, 0], (error**2).sum(1), 1e-9)
    assert not own.rollout(q, qd, controls[:, :0], dt, cost=plain, trajectory=False).cost.any()


@pytest.mark.parametrize("trajectory", [True, False])
def test_gradients_of_a_cost(trajectory):
    """Beside differences along a random direction."""
    own, rng = robot(), np.random.default_rng(2)
    q, qd, controls, dt = motions(own, 5, 4)
    cost = costs(own, 5, 4)
    given = {"q": q, "qd": qd, "controls": controls, "dt": dt / 10}
    values = lambda x, cost: own.rollout(**x, cost=cost, trajectory=trajectory)
    weights = [rng.normal(size=x.shape) for x in values(given, cost)]
    named = dict(zip(("q_cotangent", "qd_cotangent", "cost_cotangent"), weights))
    found = own.rollout_vjp(**given, **named, cost=cost, trajectory=trajectory)
    direction = {name: rng.normal(size=x.shape) for name, x in given.items()}
    direction["dt"] = direction["dt"] * 1e-3
    towards = modyn.QuadraticCost(*(rng.normal(size=x.shape) for x in cost))

    def at(h):
        moved = modyn.QuadraticCost(*(x + h * t for x, t in zip(cost, towards)))
        return values({name: x + h * direction[name] for name, x in given.items()}, moved)

    change = [(a - 8 * b + 8 * c - d) / 12e-4 for a, b, c, d in zip(*(at(k * 1e-4) for k in (-2, -1, 1, 2)))]
    expected = sum((w * x).reshape(5, -1).sum(1) for w, x in zip(weights, change))
    pairs = [(getattr(found, name), x) for name, x in direction.items()] + list(zip(found.cost, towards))
    along = sum((gradient * np.broadcast_to(x, gradient.shape)).reshape(5, -1).sum(1) for gradient, x in pairs)
    close(along, expected, 1e-5)
    assert found.cost.state_weights.shape == (5, 1, 2 * own.nv) and found.cost.q_goal.shape == cost.q_goal.shape
    only = own.rollout_vjp(**given, q_cotangent=None, qd_cotangent=None, cost_cotangent=weights[2], cost=cost, trajectory=trajectory)
    zeros = [np.zeros_like(x) for x in weights[:2]]
    again = own.rollout_vjp(**given, q_cotangent=zeros[0], qd_cotangent=zeros[1], cost_cotangent=weights[2], cost=cost, trajectory=trajectory)
    assert np.array_equal(only.controls, again.controls) and np.abs(only.controls).max() > 0
    assert own.rollout_vjp(**given, q_cotangent=weights[0], qd_cotangent=None, trajectory=trajectory).cost is None


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


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("trajectory", [True, False])
def test_diagonal_gains(base, trajectory):
    """Gains of each joint are a diagonal matrix, for each motion and each step; gradients are its diagonals."""
    own = robot(base, contacts={"foot": ("point", "link3", (0.1, -0.2, 0.05))})
    q, qd, controls, dt = motions(own)
    rng = np.random.default_rng(6)
    nv = own.nv
    for step, shape in (("semi_implicit", (7, 2, nv)), ("semi_implicit", (11, 1, 2, nv)), ("step", (2, nv))):
        gains = rng.uniform(0, 2, size=shape)
        dense = np.concatenate([gains[..., k, None, :] * np.eye(nv) for k in range(2)], -1)
        arguments = dict(q=q, qd=qd, controls=controls, dt=dt, q_ref=q[::-1], qd_ref=0.1 * qd, step=step, trajectory=trajectory)
        arguments |= {"q_ref": q[::-1, None], "qd_ref": 0.1 * qd[:, None]}
        found, expected = (own.rollout(**arguments, gains=x) for x in (gains, dense))
        close(found.q, expected.q, 1e-9)
        weights = rng.normal(size=found.q.shape), rng.normal(size=found.qd.shape)
        arguments |= {"q_cotangent": weights[0], "qd_cotangent": weights[1]}
        found, expected = (own.rollout_vjp(**arguments, gains=x) for x in (gains, dense))
        diagonals = [np.diagonal(expected.gains[..., k * nv : (k + 1) * nv], axis1=-2, axis2=-1) for k in range(2)]
        close(found.gains, np.stack(diagonals, -2), 1e-8)
        close(found.q_ref, expected.q_ref, 1e-8)
    with pytest.raises(ValueError, match=rf"has the shape \(3, {nv}\); expected \({nv}, {2 * nv}\), or \(2, {nv}\)"):
        own.rollout(q, qd, controls, dt, gains=np.zeros((3, nv)), q_ref=q[0], qd_ref=qd[0])


def test_parameters_of_each_motion():
    """A motion with parameters is that of a robot that has them; gradients are differences."""
    own = robot(payload=["link3"], runtime_gravity=True)
    q, qd, controls, dt = motions(own)
    rng = np.random.default_rng(5)
    payload = np.concatenate([np.ones((11, 1)), 0.1 * rng.normal(size=(11, 3)), np.tile([0.1, 0, 0, 0.1, 0, 0.1], (11, 1))], 1)
    parameters = {"gravity": rng.normal(size=(11, 3)), "payload": {"link3": payload}}
    found = own.rollout(q, qd, controls, dt, parameters=parameters)
    weights = rng.normal(size=found.q.shape), rng.normal(size=found.qd.shape)
    gradient = own.rollout_vjp(q, qd, controls, dt, *weights, parameters=parameters)
    for k in range(11):
        other = robot(payload=["link3"], runtime_gravity=True)
        other.set_gravity(parameters["gravity"][k])
        other.set_payload("link3", payload[k, 0], payload[k, 1:4], payload[k, 4:])
        alone = other.rollout(q[k], qd[k], controls[k], dt[k])
        close(found.q[k], alone.q, 1e-9)
        expected = other.rollout_vjp(q[k], qd[k], controls[k], dt[k], weights[0][k], weights[1][k])
        close(gradient.q[k], expected.q, 1e-8)
    change = rng.normal(size=(11, 3)), rng.normal(size=(11, 10))

    def total(step):
        gravity, load = parameters["gravity"] + step * change[0], payload + step * change[1]
        end = own.rollout(q, qd, controls, dt, parameters={"gravity": gravity, "payload": {"link3": load}})
        return (weights[0] * end.q).sum() + (weights[1] * end.qd).sum()

    product = (gradient.parameters["gravity"] * change[0]).sum() + (gradient.parameters["payload"]["link3"] * change[1]).sum()
    close(product, (total(1e-5) - total(-1e-5)) / 2e-5, 1e-6)
    with pytest.raises(ValueError, match=r'`parameters` of .* lacks \["payload"\]\["link3"\]'):
        own.rollout(q, qd, controls, dt, parameters={"gravity": np.zeros(3)})
    with pytest.raises(TypeError, match="no run-time parameters: load it with `runtime_gravity=True`"):
        robot().rollout(q, qd, controls, dt, parameters={})


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
    with pytest.raises(TypeError, match="`cost` of `rollout` must be a `modyn.QuadraticCost`, not dict"):
        own.rollout(q, qd, controls, 0.01, cost={})
    with pytest.raises(TypeError, match="`cost` of `rollout` needs `state_weights`"):
        own.rollout(q, qd, controls, 0.01, cost=modyn.QuadraticCost(q, None))
    with pytest.raises(ValueError, match=r"`state_weights` of `rollout` has the shape \(4,\); expected \(8,\)"):
        own.rollout(q, qd, controls, 0.01, cost=modyn.QuadraticCost(q, np.ones(4)))
    with pytest.raises(ValueError, match=r"`terminal_weights` of `rollout` has the shape \(4,\); expected \(8,\)"):
        own.rollout(q, qd, controls, 0.01, cost=modyn.QuadraticCost(q, np.ones(8), terminal_weights=np.ones(4)))
    with pytest.raises(TypeError, match="`cost_cotangent` of `rollout_vjp` needs a `cost`"):
        own.rollout_vjp(q, qd, controls, 0.01, None, None, cost_cotangent=np.ones(7))
    with pytest.raises(TypeError, match="`q` of `rollout` must be an array of real numbers"):
        own.rollout("zero", qd, controls, 0.01)
    with pytest.raises(ValueError, match=r"`qd_cotangent` of `rollout_vjp` has the shape \(4,\); expected \(7, 4\)"):
        own.rollout_vjp(q, qd, controls, 0.01, np.zeros((7, 4)), np.zeros(4))


def test_a_robot_is_freed_with_its_code():
    """What a robot keeps refers to it, and is no reason to keep the robot."""
    own = robot(contacts={"foot": ("point", "link3", (0.1, -0.2, 0.05))})
    ground = modyn.HeightField(np.zeros((2, 2)), (-5, -5), (10, 10))
    for field in (None, ground):
        own.rollout(own.neutral(), np.zeros(own.nv), np.zeros((3, own.nv)), 1e-3, step="step", ground=field)
    kept = weakref.ref(next(code for code in own._kept.values() if hasattr(code, "handle")).handle), weakref.ref(own)
    del own
    gc.collect()
    assert [one() for one in kept] == [None, None]


def test_surplus_arrays_are_refused():
    own = robot()
    code = own._array_code("kinetic_energy", None, [], Extras())
    q, qd = own.neutral(), np.ones(own.nv)
    close(code.call([q, qd])[0], own.kinetic_energy(q, qd), 1e-12)
    for arrays in ([q], [q, qd, qd]):
        with pytest.raises(ValueError, match=f"{len(arrays)} arrays; expected 2"):
            code.call(arrays)
