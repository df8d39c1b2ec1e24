"""`modyn.jax`: values and derivatives of all functions under JAX's transformations, and what is refused."""

import gc
import importlib
import inspect
import subprocess
import sys

import numpy as np
import pytest
from conftest import GOLDEN, chain, close, in_threads, states

import modyn
from modyn._arrays import Extras

jax = pytest.importorskip("jax", reason="JAX is not installed: pip install modyn[jax]")
import jax.export  # noqa: E402

jnp = jax.numpy
jax.config.update("jax_enable_x64", True)

from jax.test_util import check_grads  # noqa: E402

import modyn.jax  # noqa: E402

CONTACTS = {"foot": ("point", "link3", (0.1, -0.2, 0.05))}


def robot(base="floating", **options):
    return modyn.loads(chain(3, joints=4), base=base, **options)


def argument(name, one, q, n, rng):
    """Returns numbers for an argument: `n` states of a shape."""
    if name in ("q", "from_", "to"):
        return np.roll(q, 1 if name == "to" else 0, axis=0)
    if name == "dt":
        return rng.uniform(0.01, 0.05, n)
    if name == "uniforms":
        return rng.uniform(0.1, 0.9, (n, *one))
    if name == "active":
        return np.ones((n, *one))
    return rng.normal(size=(n, *one))


def arguments(own, name, n=3):
    """Returns the link and the arguments of a function for `n` states, without those that have a default."""
    rng = np.random.default_rng(len(name))
    link = "link2" if "link" in modyn.Robot.__dict__[name].__text_signature__ else None
    listed, _, _ = own._array_signature(name, link)
    q = states(own, n)[0]
    return link, [argument(one, tuple(shape), q, n, rng) for one, shape, default in listed if default is None]


# The derivatives of steps are no functions of arrays.
DERIVATIVES_OF_STEPS = [f"{step}_{form}" for step in ("step", "step_actuated") for form in ("derivatives", "vjp", "jvp")]
# `brge` returns factors; `actuate` needs actuators, which this robot lacks.
OTHERS = ["brge", "actuate", "step_actuated", *DERIVATIVES_OF_STEPS]
FUNCTIONS = [name for name in modyn.functions() if name not in OTHERS]
# Their derivatives are of third order, and long.
HESSIANS = [name for name in FUNCTIONS if name.endswith("_hessian")]


@pytest.fixture(scope="module")
def standing():
    return robot(contacts=CONTACTS)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_are_those_of_the_method(standing, name):
    link, given = arguments(standing, name)
    method = getattr(standing, name)
    expected = method(*given) if link is None else method(*given, link)
    one = method(*(x[0] for x in given)) if link is None else method(*(x[0] for x in given), link)
    own = modyn.jax.function(standing, name, link)
    for found, expected in ((jax.jit(own)(*given), expected), (own(*(x[0] for x in given)), one)):
        assert type(found) is type(expected) or not isinstance(expected, tuple)
        leaves = jax.tree.leaves(expected)
        assert len(leaves) == len(jax.tree.leaves(found))
        for a, b in zip(jax.tree.leaves(found), leaves):
            assert a.dtype == np.float64
            close(a, b, 1e-9)


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name not in HESSIANS and name != "step"])
def test_derivatives_of_all_functions(standing, name):
    """Forward mode beside finite differences, along a random direction; reverse mode beside forward mode."""
    link, given = arguments(standing, name, 1)
    x = [jnp.asarray(one[0]) for one in given]
    rng = np.random.default_rng(1)
    # Quaternions of any length.
    x = [one.at[3:7].multiply(1.3) if one.shape == (standing.nq,) else one for one in x]
    function = jax.jit(modyn.jax.function(standing, name, link))
    t = [jnp.asarray(rng.normal(size=one.shape)) for one in x]
    value, change = jax.jvp(lambda *x: function(*x), x, t)
    along = lambda h: function(*(a + h * b for a, b in zip(x, t)))
    h = 1e-4
    points = [along(k * h) for k in (-2, -1, 1, 2)]
    numeric = jax.tree.map(lambda a, b, c, d: (a - 8 * b + 8 * c - d) / (12 * h), *points)
    for found, expected in zip(jax.tree.leaves(change), jax.tree.leaves(numeric)):
        close(found, expected, 1e-6)
    weights = jax.tree.map(lambda one: jnp.asarray(rng.normal(size=one.shape)), value)
    gradients = jax.vjp(lambda *x: function(*x), *x)[1](weights)
    dot = lambda a, b: sum(float((u * v).sum()) for u, v in zip(jax.tree.leaves(a), jax.tree.leaves(b)))
    left, right = dot(weights, change), dot(gradients, tuple(t))
    assert abs(left - right) <= 1e-9 * max(1.0, abs(left), *(abs(float(one)) for one in (left, right)))


def on_the_ground():
    """Returns a robot whose joints have damping and dry friction and are beyond a limit, and a state with contacts in the ground."""
    own = robot(contacts=CONTACTS, joint_friction="coulomb")
    rng = np.random.default_rng(2)
    q, qd, *_ = (x[0] for x in states(own, 1))
    q[2] -= own.link_poses(q).translation[:, 2].min() + 0.05
    surface = modyn.ContactSurface(radius=0.02, friction=0.7)
    settings = np.asarray(modyn.StepSettings([surface] * len(own.contact_names), tolerance=1e-13))
    return own, [q, qd, rng.normal(size=own.nv), np.array(0.003), np.zeros(own.nv), settings]


def test_derivatives_of_steps():
    """Beside finite differences of the solution, with respect to the state, the forces, the time and the settings."""
    own, given = on_the_ground()
    x = [jnp.asarray(one) for one in given]
    function = jax.jit(modyn.jax.function(own, "step"))
    solution = function(*x)
    assert (solution.forces[:, 2] > 0).any() and solution.residual < 1e-12
    rng = np.random.default_rng(3)
    t = [jnp.asarray(rng.normal(size=one.shape)) for one in x]
    t[3] = t[3] * 1e-3
    t[5] = t[5].at[:3].set(0.0) * 1e-3
    value = lambda *x: function(*x)[:4]
    found, change = jax.jvp(value, x, t)
    along = lambda h: value(*(a + h * b for a, b in zip(x, t)))
    h = 1e-5
    for a, b, expected in zip(along(h), along(-h), change):
        close((a - b) / (2 * h), expected, 1e-5)
    weights = tuple(jnp.asarray(rng.normal(size=one.shape)) for one in found)
    gradients = jax.vjp(value, *x)[1](weights)
    dot = lambda a, b: sum(float((u * v).sum()) for u, v in zip(a, b))
    assert abs(dot(weights, change) - dot(gradients, t)) <= 1e-9 * max(1.0, abs(dot(weights, change)))
    # The solution does not depend on the start.
    assert not np.asarray(gradients[4]).any()
    close(jax.jacfwd(value)(*x)[1], jax.jacrev(value)(*x)[1], 1e-9)
    with pytest.raises(NotImplementedError, match="`step` has first derivatives alone"):
        jax.hessian(lambda q: value(q, *x[1:])[1].sum())(x[0])
    for name in DERIVATIVES_OF_STEPS:
        with pytest.raises(ValueError, match=f"`{name}` is no function of arrays: differentiate `step"):
            modyn.jax.function(own, name)


@pytest.mark.parametrize("name", ["forward_dynamics", "inverse_dynamics", "step_semi_implicit", "integrate", "link_pose"])
@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_second_derivatives(base, name):
    own = robot(base)
    link, given = arguments(own, name, 1)
    x = [jnp.asarray(one[0]) for one in given]
    check_grads(modyn.jax.function(own, name, link), x, order=2, modes=["fwd", "rev"], atol=1e-5, rtol=1e-5, eps=1e-5)


def test_matrices_of_derivatives():
    """`jacfwd`, `jacrev` and `hessian`: one matrix for all columns, also for states with axes of their own."""
    own = robot()
    q, qd, weights, tau = states(own, 3)
    function = modyn.jax.function(own, "forward_dynamics")
    by = (0, 1, 2)
    expected = own.forward_dynamics_derivatives(q, qd, tau)
    for jacobian in (jax.jacfwd, jax.jacrev):
        found = jax.jit(jax.vmap(jacobian(function, by)))(q, qd, tau)
        close(found[1], expected.dqdd_dqd, 1e-8)
        close(found[2], expected.dqdd_dtau, 1e-8)
        rates = jnp.stack([own.velocity_to_qdot(q, np.tile(v, (3, 1))) for v in np.eye(own.nv)], -1)
        close(found[0] @ rates, expected.dqdd_dq, 1e-8)
    # Derivatives of a batch by one argument that all states share.
    shared = jax.jacrev(lambda tau: function(q, qd, tau))(tau[0])
    close(shared, own.forward_dynamics_derivatives(q, qd, np.tile(tau[0], (3, 1))).dqdd_dtau, 1e-8)
    hessian = jax.jit(jax.hessian(lambda *x: function(*x) @ weights[0], by))(q[0], qd[0], tau[0])
    reverse = jax.jacrev(jax.grad(lambda *x: function(*x) @ weights[0], by), by)(q[0], qd[0], tau[0])
    for a, b in zip(jax.tree.leaves(hessian), jax.tree.leaves(reverse)):
        close(a, b, 1e-8)
    contracted = own.forward_dynamics_hessian(q[0], qd[0], tau[0], weights[0])
    close(hessian[1][1], contracted.hess_qd_qd, 1e-8)


def test_transformations_of_a_motion():
    own = robot()
    q, qd, _, tau = (x[0] for x in states(own, 1))
    dynamics, integrate = (modyn.jax.function(own, name) for name in ("forward_dynamics", "integrate"))
    forces = 0.1 * np.random.default_rng(1).normal(size=(6, own.nv))

    @jax.checkpoint
    def step(state, tau):
        q, qd = state
        qd = qd + 0.01 * dynamics(q, qd, tau)
        return (integrate(q, 0.01 * qd), qd), q[:3]

    def cost(forces):
        (q, qd), path = jax.lax.scan(step, (jnp.asarray(q0), jnp.asarray(qd0)), forces)
        return (q**2).sum() + (qd**2).sum() + (path**2).sum()

    q0, qd0 = q, 0.1 * qd
    gradient = jax.jit(jax.grad(cost))(forces)
    direction = np.random.default_rng(2).normal(size=forces.shape)
    numeric = (cost(forces + 1e-5 * direction) - cost(forces - 1e-5 * direction)) / 2e-5
    close(float((gradient * direction).sum()), float(numeric), 1e-6)
    many = jax.jit(jax.vmap(jax.grad(cost)))(np.stack([forces, 2 * forces]))
    close(many[0], gradient, 1e-12)
    assert np.abs(many[1] - many[0]).max() > 1e-6
    along = jax.jvp(jax.grad(cost), (forces,), (direction,))[1]
    numeric = (jax.grad(cost)(forces + 1e-5 * direction) - jax.grad(cost)(forces - 1e-5 * direction)) / 2e-5
    close(along, numeric, 1e-5)


def test_gradients_in_tangent_space():
    own = robot()
    q, qd, weights, tau = states(own, 2)
    gradient = jax.grad(lambda q: (modyn.jax.function(own, "forward_dynamics")(q, qd, tau) * weights).sum())(q)
    assert gradient.shape == q.shape
    # Lengths of quaternions have no effect.
    close((gradient[:, 3:7] * q[:, 3:7]).sum(1), np.zeros(2), 1e-9)
    close(modyn.jax.to_tangent(own, q, gradient), own.forward_dynamics_vjp(q, qd, tau, weights).grad_q, 1e-9)


OPTIONS = {"runtime_gravity": True, "runtime_inertia": ["link1", "link2"], "payload": ["link3"]}


def test_run_time_parameters():
    own = robot("fixed", **OPTIONS)
    own.set_payload("link3", 0.7, (0.1, 0.2, -0.1), (0.02, 0.001, 0.0, 0.03, 0.0, 0.02))
    q, qd, _, tau = states(own, 5)
    dynamics = modyn.jax.function(own, "forward_dynamics")
    given = modyn.jax.parameters(own)
    assert given["payload"]["link3"][0] == 0.7 and given["gravity"].shape == (3,)
    close(dynamics(q, qd, tau), own.forward_dynamics(q, qd, tau), 1e-9)
    close(dynamics(q, qd, tau, parameters=given), own.forward_dynamics(q, qd, tau), 1e-9)
    check_grads(lambda p: dynamics(q[0], qd[0], tau[0], parameters=p), (given,), order=2, modes=["rev"], atol=1e-4, rtol=1e-4)
    # A mass for each state.
    masses = np.linspace(0.1, 2.0, 5)
    payloads = jnp.tile(given["payload"]["link3"], (5, 1)).at[:, 0].set(masses)
    found = jax.jit(lambda p: dynamics(q, qd, tau, parameters={**given, "payload": {"link3": p}}))(payloads)
    for i, mass in enumerate(masses):
        own.set_payload("link3", mass, *np.split(np.asarray(payloads[i, 1:]), [3]))
        close(found[i], own.forward_dynamics(q[i], qd[i], tau[i]), 1e-9)
    with pytest.raises(ValueError, match=r'lacks \["payload"\]\["link3"\]'):
        dynamics(q, qd, tau, parameters={**given, "payload": {}})
    with pytest.raises(ValueError, match=r'\["gravity"\]. of `forward_dynamics` has the shape \(2,\); expected \(3,\)'):
        dynamics(q, qd, tau, parameters={**given, "gravity": np.zeros(2)})
    with pytest.raises(ValueError, match="the robot has no run-time parameters"):
        modyn.jax.parameters(robot("fixed"))


FUSED = {
    "control": [
        "mass_matrix", "bias_forces", ("jacobian", "link2"), ("link_pose", "link3"), "forward_dynamics", "constrained_forward_dynamics"
    ]
}


def apart(own, fused):
    """Returns the results of a fused function by its functions, one by one."""
    names = {"jacobian_link2": ("jacobian", "link2"), "link_pose_link3": ("link_pose", "link3")}
    functions = [modyn.jax.function(own, *names.get(field, (field,))) for field in fused]
    counts = [sum(name in ("q", "qd", "tau") for name in inspect.signature(function).parameters) for function in functions]
    return lambda *x: tuple(function(*x[:count]) for function, count in zip(functions, counts))


def close_leaves(found, expected, tolerance=1e-9):
    found, expected = jax.tree.leaves(found), jax.tree.leaves(expected)
    assert len(found) == len(expected)
    for a, b in zip(found, expected):
        close(a, b, tolerance)


@pytest.fixture(scope="module")
def controlled():
    return robot(contacts=CONTACTS, fused=FUSED)


def test_values_of_fused_functions(controlled):
    q, qd, _, tau = states(controlled, 3)
    function = modyn.jax.function(controlled, "control")
    expected = controlled.control(q, qd, tau)
    for own in (jax.jit(function), jax.vmap(function)):
        found = own(q, qd, tau)
        assert type(found) is type(expected) and type(found.link_pose_link3) is modyn.Pose
        close_leaves(found, expected)
    close_leaves(function(q[0], tau=tau[0], qd=qd[0]), controlled.control(q[0], qd[0], tau[0]))
    crossed = function(q[:, None], qd[:2], tau[0])
    for i, j in np.ndindex(3, 2):
        close_leaves(jax.tree.map(lambda x: x[i, j], crossed), controlled.control(q[i], qd[j], tau[0]))
    # A set of active contacts, which is an argument of one of the functions.
    close_leaves(function(q, qd, tau, active=np.zeros(1)), controlled.control(q, qd, tau, np.zeros(1)))
    assert "mass_matrix`, `bias_forces" in function.__doc__ and str(inspect.signature(function)) == "(q, qd, tau, active=None, settings=None)"


def test_derivatives_of_fused_functions(controlled):
    """Of first and second order, beside the derivatives of the functions one by one."""
    q, qd, _, tau = (jnp.asarray(x[0]) for x in states(controlled, 1))
    x = [q.at[3:7].multiply(1.3), qd, tau]
    rng = np.random.default_rng(1)
    t = [jnp.asarray(rng.normal(size=one.shape)) for one in x]
    function = modyn.jax.function(controlled, "control")
    value, change = jax.jit(lambda x, t: jax.jvp(function, x, t))(x, t)
    separate = apart(controlled, value._fields)
    close_leaves((value, change), jax.jvp(separate, x, t))
    weights = jax.tree.map(lambda one: jnp.asarray(rng.normal(size=one.shape)), value)
    close_leaves(jax.vjp(function, *x)[1](weights), jax.vjp(separate, *x)[1](tuple(weights)))
    for jacobian in (jax.jacrev, jax.jacfwd):
        close_leaves(jacobian(function, (0, 1, 2))(*x), jacobian(separate, (0, 1, 2))(*x))
    # Fewer changes than entries: products, which `vmap` repeats.
    changes = [jnp.stack([one, 2 * one]) for one in t]
    along = lambda call: jax.vmap(lambda *t: jax.jvp(call, x, list(t))[1])(*changes)
    close_leaves(along(function), along(separate))
    weighted = lambda call: lambda *x: sum((a * b).sum() for a, b in zip(jax.tree.leaves(call(*x)), jax.tree.leaves(weights)))
    close_leaves(jax.hessian(weighted(function), (0, 1))(*x), jax.hessian(weighted(separate), (0, 1))(*x))


def test_fused_functions_with_run_time_parameters():
    own = robot("fixed", **OPTIONS, fused={"both": ["inverse_dynamics", "mass_matrix", ("link_pose", "link3")]})
    own.set_payload("link3", 0.7, (0.1, 0.2, -0.1), (0.02, 0.001, 0.0, 0.03, 0.0, 0.02))
    q, qd, qdd, _ = states(own, 5)
    function, separate = modyn.jax.function(own, "both"), modyn.jax.function(own, "inverse_dynamics")
    given = modyn.jax.parameters(own)
    close_leaves(function(q, qd, qdd), own.both(q, qd, qdd))
    payloads = jnp.tile(given["payload"]["link3"], (5, 1)).at[:, 0].set(np.linspace(0.1, 2.0, 5))
    loaded = lambda call, p: call(q, qd, qdd, parameters={**given, "payload": {"link3": p}})
    forces = lambda p: loaded(function, p).inverse_dynamics
    alone = lambda p: loaded(separate, p)
    close(forces(payloads), alone(payloads), 1e-9)
    close(jax.jacrev(forces)(payloads), jax.jacrev(alone)(payloads), 1e-9)
    by_gravity = lambda call: jax.jacfwd(lambda g: jax.tree.leaves(call(q, qd, qdd, parameters={**given, "gravity": g}))[0])(given["gravity"])
    close(by_gravity(function), by_gravity(separate), 1e-9)


def test_fused_functions_that_need_an_argument_after_defaults():
    """`act` follows `active` and `settings`, which have defaults."""
    servo = ("position", 20, 0.4, {"effort": 2.7, "delay": 1})
    own = robot(contacts=CONTACTS, actuators={"joint1": servo}, fused={"both": ["constrained_forward_dynamics", "actuate"]})
    q, qd, _, tau = (x[0] for x in states(own, 1))
    function = modyn.jax.function(own, "both")
    given = {"ctrl": np.full(1, 0.3), "dt": 0.01, "act": np.full(1, 0.2)}
    close_leaves(function(q, qd, tau, **given), own.both(q, qd, tau, **given))
    with pytest.raises(TypeError, match="`both`: missing a required argument: 'act'"):
        function(q, qd, tau, given["ctrl"], 0.01)


def test_a_payload_is_found_by_gradient_descent():
    own = robot("fixed", payload=["link3"])
    q, qd, qdd, _ = states(own, 50)
    own.set_payload("link3", 1.5, (0.1, 0.0, 0.2))
    measured = own.inverse_dynamics(q, qd, qdd)
    forces = modyn.jax.function(own, "inverse_dynamics")
    payload = lambda x: {"payload": {"link3": jnp.concatenate([x[:1], x[1:] / x[0], jnp.zeros(6)])}}
    # The forces are linear in mass and mass times centre up to the inertia about the origin, so a few steps of Newton do.
    cost = lambda x: ((forces(q, qd, qdd, parameters=payload(x)) - measured) ** 2).mean()
    newton = jax.jit(lambda x: x - jnp.linalg.solve(jax.hessian(cost)(x), jax.grad(cost)(x)))
    x = jnp.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(8):
        x = newton(x)
    close(x, [1.5, 0.15, 0.0, 0.3], 1e-6)


def test_single_precision():
    own = robot("floating", scalar="f32")
    exact = robot("floating")
    q, qd, weights, tau = states(exact, 9)
    function = modyn.jax.function(own, "forward_dynamics")
    found = jax.jit(function)(q, qd, tau)
    assert found.dtype == np.float32
    close(found, exact.forward_dynamics(q, qd, tau), 1e-3)
    gradient = jax.grad(lambda tau: (function(q, qd, tau) * weights).sum())(tau.astype(np.float32))
    assert gradient.dtype == np.float32
    close(gradient, exact.forward_dynamics_vjp(q, qd, tau, weights).grad_tau, 1e-3)


def test_axes_of_states():
    """States have any axes, which are broadcast; each has its own numbers, also where one of them is no number."""
    own = robot("fixed")
    q, qd, _, tau = states(own, 12)
    function = jax.jit(modyn.jax.function(own, "forward_dynamics"))
    expected = own.forward_dynamics(q, qd, tau)
    n = own.nv
    close(function(q.reshape(3, 4, n), qd.reshape(3, 4, n), tau.reshape(3, 4, n)), expected.reshape(3, 4, n), 1e-12)
    crossed = function(q[:3, None], qd[None, :4], tau[0])
    for i, k in np.ndindex(3, 4):
        close(crossed[i, k], own.forward_dynamics(q[i], qd[k], tau[0]), 1e-9)
    nested = jax.vmap(jax.vmap(function, (None, 0, None)), (0, None, None))(q[:3], qd[:4], tau[0])
    close(nested, crossed, 1e-12)
    other = jax.vmap(function, in_axes=(1, 0, None), out_axes=1)(q[:3].T, qd[:3], tau[0])
    close(other.T, [own.forward_dynamics(q[i], qd[i], tau[0]) for i in range(3)], 1e-9)
    assert function(q[:0], qd[:0], tau[:0]).shape == (0, n)
    close(function(q[::2], np.asfortranarray(qd[::2]), tau[::2]), expected[::2], 1e-12)
    broken = q.copy()
    broken[5, 1] = np.nan
    found = function(broken, qd, tau)
    assert np.isnan(found[5]).any()
    close(np.delete(found, 5, 0), np.delete(expected, 5, 0), 1e-12)


def test_many_states_in_threads():
    own = robot("fixed")
    q, qd, _, tau = states(own, 4001)
    function = jax.jit(modyn.jax.function(own, "forward_dynamics"))
    expected = own.forward_dynamics(q, qd, tau)
    close(function(q, qd, tau), expected, 1e-12)
    wrong = []

    def work():
        for _ in range(10):
            found = function(q, qd, tau)
            wrong.extend([] if np.allclose(found, expected, rtol=1e-9, atol=1e-9) else [1])

    in_threads(work)
    assert not wrong


def test_several_robots_in_one_program():
    first, second = robot("fixed"), modyn.loads(chain(5, joints=4))
    q, qd, _, tau = (x[0] for x in states(first, 1))
    functions = [modyn.jax.function(one, "forward_dynamics") for one in (first, second)]
    both = jax.jit(jax.grad(lambda tau: sum(f(q, qd, tau).sum() for f in functions)))(tau)
    expected = sum(one.forward_dynamics_derivatives(q, qd, tau).dqdd_dtau.sum(0) for one in (first, second))
    close(both, expected, 1e-9)
    # The same description is the same function to `jit`.
    traced = []
    again = jax.jit(lambda x: traced.append(1) or functions[0](q, qd, x))
    again(tau)
    functions[0] = modyn.jax.function(robot("fixed"), "forward_dynamics")
    close(again(tau), first.forward_dynamics(q, qd, tau), 1e-12)
    assert len(traced) == 1


def test_without_machine_code():
    slow, fast = robot("fixed", machine_code=False), robot("fixed")
    q, qd, _, tau = states(fast, 3)
    function = modyn.jax.function(slow, "forward_dynamics")
    close(jax.jit(function)(q, qd, tau), fast.forward_dynamics(q, qd, tau), 1e-9)
    close(jax.jacrev(function, 2)(q[0], qd[0], tau[0]), fast.forward_dynamics_derivatives(q[0], qd[0], tau[0]).dqdd_dtau, 1e-9)


def test_the_module_can_be_reloaded():
    own = robot("fixed")
    q, qd, _, tau = (x[0] for x in states(own, 1))
    before = modyn.jax.function(own, "forward_dynamics")
    importlib.reload(modyn.jax)
    after = modyn.jax.function(own, "forward_dynamics")
    close(jax.jit(after)(q, qd, tau), before(q, qd, tau), 0)


def test_an_old_jax_is_refused(monkeypatch):
    monkeypatch.setattr(jax, "__version_info__", (0, 6, 2))
    with pytest.raises(ImportError, match="needs JAX 0.7 or later; this is JAX .*: pip install"):
        importlib.reload(modyn.jax)
    monkeypatch.undo()
    importlib.reload(modyn.jax)


def test_refused():
    own = robot("fixed")
    q, qd, _, tau = (x[0] for x in states(own, 1))
    function = modyn.jax.function(own, "forward_dynamics")
    with pytest.raises(ValueError, match=r"`qd` of `forward_dynamics` has the shape \(3,\); expected \(4,\), or \(\.\.\., 4\)"):
        function(q, qd[:3], tau)
    with pytest.raises(ValueError, match=r"do not fit: `q` \(2,\), `tau` \(3,\)"):
        function(np.tile(q, (2, 1)), qd, np.tile(tau, (3, 1)))
    with pytest.raises(TypeError, match="`tau` of `forward_dynamics` must be an array of real numbers, not of complex128"):
        function(q, qd, tau + 1j)
    with pytest.raises(TypeError, match="`q` of `forward_dynamics` must be an array of real numbers"):
        function("zero", qd, tau)
    with pytest.raises(TypeError, match="`forward_dynamics`: missing a required argument: 'tau'"):
        function(q, qd)
    with pytest.raises(TypeError, match="unexpected keyword argument 'torque'"):
        function(q, qd, tau, torque=tau)
    with pytest.raises(ValueError, match="no function `foward_dynamics`; did you mean `forward_dynamics`"):
        modyn.jax.function(own, "foward_dynamics")
    with pytest.raises(ValueError, match="`brge` returns factors"):
        modyn.jax.function(own, "brge")
    with pytest.raises(TypeError, match="`jacobian` is a function of a link"):
        modyn.jax.function(own, "jacobian")
    with pytest.raises(TypeError, match="`mass_matrix` is no function of a link"):
        modyn.jax.function(own, "mass_matrix", "link1")
    with pytest.raises(ValueError, match="no link `lnk1`; did you mean `link1`"):
        modyn.jax.function(own, "jacobian", "lnk1")
    with pytest.raises(ValueError, match="only robots with closed loops or contacts"):
        modyn.jax.function(own, "constrained_forward_dynamics")
    fused = robot("fixed", fused={"control": ["mass_matrix", "bias_forces"], "factors": ["brge", "bias_forces"]})
    with pytest.raises(ValueError, match="no function `contrl`; did you mean `control`"):
        modyn.jax.function(fused, "contrl")
    with pytest.raises(ValueError, match="no function `jacobin`; did you mean `jacobian`"):
        modyn.jax.function(fused, "jacobin", "link1")
    with pytest.raises(ValueError, match="no function `sum`; `modyn.functions.*` has all names, and `fused_names` of the robot"):
        modyn.jax.function(fused, "sum")
    with pytest.raises(ValueError, match="fused function `factors`: `brge` returns factors, which are no arrays: use `mass_matrix`"):
        modyn.jax.function(fused, "factors")
    with pytest.raises(TypeError, match="`control` is no function of a link"):
        modyn.jax.function(fused, "control", "link1")
    with pytest.raises(ValueError, match="`control` is no time step under joint forces, so it has no feedback and no cost"):
        fused._array_code("control", None, [], Extras(gains=(2, fused.nv)))
    with pytest.raises(TypeError, match="use `jax.vjp`"):
        jax.linear_transpose(function, q, qd, tau)(qd)
    close(function(q=q, tau=tau, qd=qd), function(q, qd, tau), 0)


def run(code, *arguments):
    """Runs Python in another process."""
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_double_precision_needs_a_setting():
    code = """
import sys, numpy as np, modyn, modyn.jax
x = np.zeros(7)
try:
    modyn.jax.function(modyn.load(sys.argv[1], joint_friction="none"), "forward_dynamics")(x, x, x)
except TypeError as error:
    print(error)
print(modyn.jax.function(modyn.load(sys.argv[1], joint_friction="none", scalar="f32"), "forward_dynamics")(x, x, x).dtype)
"""
    message, dtype = run(code, str(GOLDEN / "panda.urdf")).splitlines()
    assert 'jax.config.update("jax_enable_x64", True)' in message and 'scalar="f32"' in message
    assert dtype == "float32"


def test_an_exported_program_runs_in_another_process(tmp_path):
    """The key of a function is the same in each process; without the function there, the error says so."""
    own = robot("fixed")
    q, qd, _, tau = (x[0] for x in states(own, 1))
    function = modyn.jax.function(own, "forward_dynamics")
    checks = [jax.export.DisabledSafetyCheck.custom_call("modyn")]
    exported = jax.export.export(jax.jit(function), disabled_checks=checks)(q, qd, tau)
    (tmp_path / "program").write_bytes(exported.serialize())
    (tmp_path / "robot.urdf").write_text(chain(3, joints=4))
    np.save(tmp_path / "state.npy", [q, qd, tau])
    code = """
import pathlib, sys, numpy as np, jax, jax.export
jax.config.update("jax_enable_x64", True)
import modyn, modyn.jax
folder = pathlib.Path(sys.argv[1])
program = jax.export.deserialize((folder / "program").read_bytes())
state = np.load(folder / "state.npy")
try:
    program.call(*state)
except Exception as error:
    print("load the robot, call `modyn.jax.function`" in str(error))
function = modyn.jax.function(modyn.load(folder / "robot.urdf", base="fixed"), "forward_dynamics")
print(*program.call(*state).tolist())
"""
    refused, found = run(code, str(tmp_path)).splitlines()
    assert refused == "True"
    close([float(x) for x in found.split()], function(q, qd, tau), 0)


def test_code_outlives_the_calls_that_are_not_done():
    """XLA runs a program after the call returns, when nothing of Python holds the function any more."""
    matrix = jnp.full((700, 700), 1e-3)

    def started():
        own = robot("fixed")
        function = modyn.jax.function(own, "coriolis_matrix")
        q = jnp.linspace(0.1, 0.9, own.nq)

        def late(x, q):
            for _ in range(12):
                x = jnp.tanh(x @ x)
            return function(q + 0 * x[0, : own.nq], q)

        return jax.jit(late)(matrix, q)

    found = started()
    jax.clear_caches()
    gc.collect()
    own = robot("fixed")
    q = np.linspace(0.1, 0.9, own.nq)
    close(found, own.coriolis_matrix(q, q), 1e-12)


def rolled(own, steps=5, n=3):
    q, qd, *_ = states(own, n)
    return q, 0.2 * qd, np.random.default_rng(3).normal(size=(n, steps, own.nv))


@pytest.mark.parametrize("trajectory", [True, False])
def test_rollouts(trajectory):
    """The states and first and second derivatives of a rollout in one call beside those of a `scan`."""
    own = robot()
    q, qd, controls = rolled(own)
    rollout = modyn.jax.rollout(own, trajectory=trajectory)
    step = modyn.jax.function(own, "step_semi_implicit")
    close(jax.jit(rollout)(q, qd, controls, 0.01).q, own.rollout(q, qd, controls, 0.01, trajectory=trajectory).q, 1e-12)

    def scanned(q, qd, controls, dt):
        def advance(state, tau):
            state = tuple(step(*state, tau, dt))
            return state, state

        end, path = jax.lax.scan(advance, (jnp.asarray(q), jnp.asarray(qd)), controls)
        return path if trajectory else end

    given = (q[0], qd[0], controls[0], 0.01)
    by = (0, 1, 2, 3)
    weights = jax.tree.map(lambda x: np.random.default_rng(4).normal(size=x.shape), tuple(scanned(*given)))
    cost = lambda f: lambda *x: sum((w * y**2).sum() for w, y in zip(weights, f(*x)))
    found = jax.jit(jax.grad(cost(rollout), by))(*given)
    expected = jax.grad(cost(scanned), by)(*given)
    for a, b in zip(found, expected):
        close(a, b, 1e-9)
    changes = tuple(np.random.default_rng(5).normal(size=np.shape(x)) for x in given)
    for a, b in zip(jax.jvp(rollout, given, changes)[1], jax.jvp(scanned, given, changes)[1]):
        close(a, b, 1e-9)
    # Second derivatives: along a direction, backwards over backwards, and whole matrices.
    for a, b in zip(*(jax.jvp(jax.grad(cost(f), by), given, changes)[1] for f in (rollout, scanned))):
        close(a, b, 1e-8)
    along = lambda f: jax.grad(lambda c: (jax.grad(cost(f), 2)(q[0], qd[0], c, 0.01) * changes[2]).sum())(given[2])
    close(along(rollout), along(scanned), 1e-8)
    close(jax.jit(jax.jacfwd(rollout, 1))(*given).q, jax.jacfwd(scanned, 1)(*given)[0], 1e-9)
    close(jax.hessian(cost(rollout), 1)(*given), jax.hessian(cost(scanned), 1)(*given), 1e-8)
    # Many motions: some arguments have axes of `vmap`, others have axes of their own.
    many = jax.vmap(jax.grad(cost(rollout), 2), (0, None, 0, None))(q, qd[0], controls, 0.01)
    close(many[1], jax.grad(cost(scanned), 2)(q[1], qd[0], controls[1], 0.01), 1e-9)
    shared = jax.grad(lambda q: sum((x**2).sum() for x in rollout(q, qd, controls, 0.01)))(q[0])
    separate = [jax.grad(lambda q: sum((x**2).sum() for x in rollout(q, qd[i], controls[i], 0.01)))(q[0]) for i in range(3)]
    close(shared, sum(separate), 1e-9)


def test_rollouts_with_feedback_and_parameters():
    own = robot(payload=["link3"])
    q, qd, controls = (x[0] for x in rolled(own))
    rollout = modyn.jax.rollout(own)
    gains = 0.1 * np.random.default_rng(6).normal(size=(own.nv, 2 * own.nv))
    reference = {"q_ref": np.tile(q, (5, 1)), "qd_ref": 0 * qd}
    given = modyn.jax.parameters(own)
    given["payload"]["link3"] = given["payload"]["link3"].at[:].set([1.0, 0.1, 0.2, 0.3, 0.1, 0, 0, 0.1, 0, 0.1])
    cost = lambda gains, p: sum((x**2).sum() for x in rollout(q, qd, controls, 0.01, gains=gains, parameters=p, **reference))
    check_grads(cost, (gains, given), order=1, modes=["rev"], atol=1e-5, rtol=1e-5)
    own.set_payload("link3", 1.0, (0.1, 0.2, 0.3), (0.1, 0, 0, 0.1, 0, 0.1))
    expected = own.rollout(q, qd, controls, 0.01, gains=gains, **reference)
    close(rollout(q, qd, controls, 0.01, gains=gains, parameters=given, **reference).q, expected.q, 1e-9)
    with pytest.raises(TypeError, match="no run-time parameters"):
        modyn.jax.rollout(robot())(q, qd, controls, 0.01, parameters=given)


def test_rollouts_with_a_cost():
    """The cost of a rollout in one call, and its gradient, beside a cost of the states."""
    own = robot()
    q, qd, controls = rolled(own)
    rng = np.random.default_rng(8)
    states_of, difference = modyn.jax.rollout(own), modyn.jax.function(own, "difference")
    cost = modyn.QuadraticCost(q[1], *(jnp.asarray(rng.normal(size=n * own.nv)) for n in (2, 1, 1, 2)))

    def by_states(controls, cost):
        path = states_of(q, qd, controls, 0.01)
        error = jnp.concatenate([difference(path.q, cost.q_goal), cost.qd_goal - path.qd], -1)
        terminal = (cost.terminal_weights * error[:, -1] ** 2).sum()
        return (cost.state_weights * error**2).sum() + (cost.control_weights * controls**2).sum() + terminal

    for trajectory in (True, False):
        rollout = modyn.jax.rollout(own, trajectory=trajectory)
        last = lambda x: x[:, -1] if trajectory else x
        in_one_call = lambda controls, cost: last(rollout(q, qd, controls, 0.01, cost=cost).cost).sum()
        found, expected = (jax.jit(jax.value_and_grad(f, (0, 1)))(controls, cost) for f in (in_one_call, by_states))
        for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(expected)):
            close(a, b, 1e-9)
    second = [jax.grad(lambda c: (jax.grad(f)(c, cost) * controls).sum())(controls) for f in (in_one_call, by_states)]
    close(*second, 1e-8)
    assert modyn.jax.rollout(own)(q, qd, controls, 0.01, cost=modyn.QuadraticCost(q[1], np.ones(2 * own.nv))).cost.shape == (3, 5)


def test_gradients_of_rollouts_of_many_motions():
    """In single and double precision, in threads; a motion without numbers leaves the others alone."""
    exact, single = robot(), robot(scalar="f32")
    q, qd, controls = rolled(exact, 5, 300)
    controls[17, 2] = np.nan
    weights = np.ones((300, 5, exact.nq)), np.zeros((300, 5, exact.nv))
    expected = np.stack([exact.rollout_vjp(q[i], qd[i], controls[i], 0.01, *(x[i] for x in weights)).controls for i in range(300)])
    for own, tolerance in ((exact, 1e-9), (single, 1e-3)):
        rollout = modyn.jax.rollout(own)
        gradient = jax.jit(jax.grad(lambda c: rollout(q, qd, c, 0.01).q.sum()))
        found = []
        in_threads(lambda: found.append(gradient(controls.astype(own.dtype))))
        for one in found:
            assert one.dtype == own.dtype and np.isnan(one[17]).any()
            close(np.delete(one, 17, 0), np.delete(expected, 17, 0), tolerance)
