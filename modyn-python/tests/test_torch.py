"""`modyn.torch`: values and derivatives under PyTorch's transformations, and what is refused."""

import numpy as np
import pytest
from conftest import chain, close, states
from test_ground import ramp, scene

import modyn

torch = pytest.importorskip("torch", reason="PyTorch is not installed: pip install modyn[torch]")

import modyn.torch  # noqa: E402

# PyTorch's compiler warns of Python's own modules.
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")


def robot(base="floating", **options):
    return modyn.loads(chain(3, joints=4), base=base, **options)


def tensors(own, n=3, dynamics=True):
    q, qd, _, tau = states(own, n)
    return [torch.from_numpy(x) for x in (q, qd, tau)[: 3 if dynamics else 2]]


def leaves(result):
    return [leaf for field in result for leaf in leaves(field)] if isinstance(result, tuple) else [result]


ARGUMENTS = {
    "forward_dynamics": 3,
    "inverse_dynamics": 3,
    "mass_matrix": 1,
    "kinetic_energy": 2,
    "integrate": 2,
    "link_pose": 1,
    "forward_dynamics_derivatives": 3,
}


@pytest.mark.parametrize("name", ARGUMENTS)
def test_values_and_first_derivatives(name):
    own = robot()
    x = tensors(own)[: ARGUMENTS[name]]
    link = "link2" if name == "link_pose" else None
    function = modyn.torch.function(own, name, link)
    method = getattr(own, name)
    expected = method(*(a.numpy() for a in x), *([link] if link else []))
    found = function(*x)
    assert type(found) is type(expected) or not isinstance(expected, tuple)
    for a, b in zip(leaves(found), expected if isinstance(expected, tuple) else [expected]):
        close(a, b, 1e-9)
    varying = [a.clone().requires_grad_() for a in x]
    assert torch.autograd.gradcheck(lambda *x: tuple(leaves(function(*x))), varying, fast_mode=True, check_forward_ad=True)


@pytest.mark.parametrize("name", ["forward_dynamics", "inverse_dynamics", "integrate"])
def test_second_derivatives(name):
    own = robot()
    x = [a[0].clone().requires_grad_() for a in tensors(own)[: ARGUMENTS[name]]]
    function = modyn.torch.function(own, name)
    assert torch.autograd.gradgradcheck(function, x, fast_mode=True, check_fwd_over_rev=True)



def test_gradients_of_steps():
    """Those of the solution, by finite differences; the same under `torch.compile`."""
    own = robot(contacts={"foot": ("point", "link3", (0.1, -0.2, 0.05))})
    rng = np.random.default_rng(2)
    q, qd, *_ = (x[0] for x in states(own, 1))
    q[2] -= own.link_poses(q).translation[:, 2].min() + 0.05
    settings = modyn.StepSettings([modyn.ContactSurface(radius=0.02, friction=0.7)], tolerance=1e-13)
    settings = torch.from_numpy(np.asarray(settings))
    given = [torch.from_numpy(x).requires_grad_() for x in (q, qd, rng.normal(size=own.nv))]
    function = modyn.torch.function(own, "step")
    zeros = torch.zeros(own.nv, dtype=torch.float64)
    step = lambda q, qd, tau: tuple(function(q, qd, tau, 0.003, zeros, settings))[:4]
    assert (step(*given)[3][:, 2] > 0).any()
    # The noise of the solver, its tolerance times the weight, is divided by `eps`.
    assert torch.autograd.gradcheck(step, given, eps=1e-5, atol=1e-5, rtol=1e-5)
    total = lambda step: torch.autograd.grad(sum(x.sum() for x in step(*given)), given)
    for a, b in zip(total(step), total(torch.compile(step, backend="eager"))):
        assert torch.allclose(a, b, rtol=1e-9, atol=1e-9)


def test_fused_functions():
    """Values, gradients of both orders, transformations and `torch.compile`, beside the functions one by one."""
    own = robot(fused={"control": ["mass_matrix", ("link_pose", "link3"), "forward_dynamics"]})
    x = tensors(own)
    function = modyn.torch.function(own, "control")
    matrix, pose, dynamics = (
        modyn.torch.function(own, *name) for name in (("mass_matrix",), ("link_pose", "link3"), ("forward_dynamics",))
    )
    found, expected = function(*x), own.control(*(a.numpy() for a in x))
    assert type(found) is type(expected) and type(found.link_pose_link3) is modyn.Pose
    for a, b in zip(leaves(found), leaves(expected), strict=True):
        close(a, b, 1e-9)
    rng = np.random.default_rng(1)
    weights = [torch.from_numpy(rng.normal(size=a.shape[1:])) for a in leaves(found)]
    apart = lambda q, qd, tau: [matrix(q), *leaves(pose(q)), dynamics(q, qd, tau)]
    weighted = lambda results: sum((w * a).sum() for w, a in zip(weights, results, strict=True))
    fused = lambda *x: weighted(leaves(function(*x)))
    separate = lambda *x: weighted(apart(*x))
    compiled = torch.compile(fused, fullgraph=True, backend="aot_eager")
    expected = torch.autograd.grad(separate(*(y := [a.clone().requires_grad_() for a in x])), y)
    for own in (fused, compiled):
        y = [a.clone().requires_grad_() for a in x]
        for a, b in zip(torch.autograd.grad(own(*y), y), expected, strict=True):
            close(a, b, 1e-9)
    for a, b in zip(torch.func.vmap(torch.func.grad(fused, (0, 1, 2)))(*x), expected, strict=True):
        close(a, b, 1e-9)
    one = [a[0] for a in x]
    for transformation in (torch.func.hessian, lambda f: torch.func.jacfwd(torch.func.grad(f))):
        close(transformation(fused)(*one), transformation(separate)(*one), 1e-9)


def test_functional_transformations():
    own = robot()
    q, qd, tau = tensors(own)
    function = modyn.torch.function(own, "forward_dynamics")
    expected = own.forward_dynamics_derivatives(q.numpy(), qd.numpy(), tau.numpy())
    for jacobian in (torch.func.jacrev, torch.func.jacfwd):
        close(torch.vmap(jacobian(function, 2))(q, qd, tau), expected.dqdd_dtau, 1e-9)
    hessian = torch.func.hessian(lambda qd: function(q[0], qd, tau[0]).sum())(qd[0])
    close(hessian, own.forward_dynamics_hessian(q[0].numpy(), qd[0].numpy(), tau[0].numpy(), np.ones(own.nv)).hess_qd_qd, 1e-8)
    crossed = torch.vmap(torch.vmap(function, (None, 0, None)), (0, None, None))(q, qd, tau[0])
    close(crossed[2, 1], own.forward_dynamics(q[2].numpy(), qd[1].numpy(), tau[0].numpy()), 1e-9)
    close(function(q[:, None], qd[None], tau[0]), crossed, 1e-12)
    # Some arguments of all states: their gradients are sums.
    shared = tau[0].clone().requires_grad_()
    function(q, qd, shared).sum().backward()
    expected = own.forward_dynamics_derivatives(q.numpy(), qd.numpy(), np.tile(tau[0].numpy(), (3, 1)))
    close(shared.grad, expected.dqdd_dtau.sum((0, 1)), 1e-9)


def test_memory_and_precision():
    own = robot("fixed", scalar="f32")
    exact = robot("fixed")
    q, qd, tau = tensors(exact, 8)
    function = modyn.torch.function(own, "forward_dynamics")
    found = function(q, qd.float(), tau)
    assert found.dtype == torch.float32
    close(found, exact.forward_dynamics(q.numpy(), qd.numpy(), tau.numpy()), 1e-3)
    function = modyn.torch.function(exact, "forward_dynamics")
    close(function(q.T.contiguous().T, qd[::2].repeat_interleave(2, 0), tau), function(q, qd[::2].repeat_interleave(2, 0), tau), 0)
    broken = q.clone()
    broken[3, 0] = float("nan")
    found = function(broken, qd, tau)
    assert torch.isnan(found[3]).any() and not torch.isnan(found[[0, 1, 2, 4, 5, 6, 7]]).any()


def test_the_operator():
    own = robot("fixed")
    x = [a.clone().requires_grad_() for a in tensors(own)]
    number = modyn.torch._numbered(modyn.torch.ArrayFunction(own, "forward_dynamics"))
    torch.library.opcheck(torch.ops.modyn.call, (number, False, x))


def test_compiled():
    own = robot("fixed")
    function = modyn.torch.function(own, "forward_dynamics")
    motion = modyn.torch.rollout(own)

    def cost(q, qd, tau):
        return (torch.sin(function(q, qd, 2 * tau)) ** 2).sum() + motion(q, qd, tau[..., None, :].expand(3, 5, -1), 0.01).q.sum()

    x = [a.clone().requires_grad_() for a in tensors(own)]
    y = [a.clone().requires_grad_() for a in tensors(own)]
    compiled = torch.compile(cost, fullgraph=True, backend="aot_eager")
    found, expected = compiled(*x), cost(*y)
    close(found.item(), expected.item(), 1e-9)
    found.backward()
    expected.backward()
    for a, b in zip(x, y):
        close(a.grad, b.grad, 1e-9)


def test_rollouts():
    own = robot()
    q, qd, tau = tensors(own)
    controls = torch.from_numpy(np.random.default_rng(1).normal(size=(3, 5, own.nv)))
    motion = modyn.torch.rollout(own)
    expected = own.rollout(q.numpy(), qd.numpy(), controls.numpy(), 0.01)
    close(motion(q, qd, controls, 0.01).q, expected.q, 1e-12)
    x = [a.clone().requires_grad_() for a in (q, qd, controls)]
    dt = torch.tensor(0.01, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda *x: tuple(motion(*x)), (*x, dt), fast_mode=True)
    gradient = torch.func.grad(lambda c: motion(q, qd, c, 0.01).qd.sum())(controls)
    close(gradient, own.rollout_vjp(q.numpy(), qd.numpy(), controls.numpy(), 0.01, 0 * expected.q, 1 + 0 * expected.qd).controls, 1e-9)
    with pytest.raises(NotImplementedError, match="first derivatives in reverse mode"):
        torch.func.jvp(lambda c: motion(q, qd, c, 0.01).q, (controls,), (controls,))


def test_rollouts_with_a_cost():
    own = robot()
    q, qd, _ = tensors(own)
    rng = np.random.default_rng(1)
    controls = torch.from_numpy(rng.normal(size=(3, 5, own.nv)))
    cost = modyn.QuadraticCost(q[1].numpy(), *(rng.normal(size=n * own.nv) for n in (2, 1, 1, 2)))
    expected = own.rollout(q.numpy(), qd.numpy(), controls.numpy(), 0.01, cost=cost)
    motion = modyn.torch.rollout(own)
    given = [torch.from_numpy(x).requires_grad_() for x in cost]
    found = motion(q, qd, controls, 0.01, cost=modyn.QuadraticCost(*given))
    close(found.cost.detach(), expected.cost, 1e-12)
    (found.cost[:, -1]).sum().backward()
    weights = np.zeros((3, 5))
    weights[:, -1] = 1
    gradient = own.rollout_vjp(q.numpy(), qd.numpy(), controls.numpy(), 0.01, None, None, cost=cost, cost_cotangent=weights).cost
    for own_gradient, tensor in zip(gradient, given):
        close(tensor.grad, own_gradient.sum(0), 1e-9)


@pytest.mark.parametrize("ground", [None, ramp()[0]])
def test_rollouts_on_the_ground(ground):
    own, q, qd, tau, settings = scene(3)
    controls = np.repeat(tau[:, None], 4, 1)
    end = own.rollout(q, qd, controls, 0.002, step="step", settings=settings, trajectory=False, ground=ground)
    expected = own.rollout_vjp(q, qd, controls, 0.002, 2 * end.q, 2 * end.qd, step="step", settings=settings, trajectory=False, ground=ground)
    given = [torch.from_numpy(x.copy()).requires_grad_() for x in (q, qd, controls, settings)]
    fall = modyn.torch.rollout(own, step="step", trajectory=False)
    found = fall(*given[:3], 0.002, settings=given[3], ground=ground)
    close(found.qd.detach(), end.qd, 1e-12)
    ((found.q**2).sum() + (found.qd**2).sum()).backward()
    close(given[2].grad, expected.controls, 1e-12)
    close(given[3].grad, expected.settings.sum(0), 1e-12)


def test_each_world_has_its_ground():
    own, q, qd, tau, settings = scene(3)
    rng = np.random.default_rng(8)
    ground = modyn.HeightField(rng.uniform(-0.1, 0.1, size=(3, 4, 5)), rng.uniform(-3, -2, size=(3, 2)), (1.3, 1.7))
    expected = own.rollout(q, qd, tau[:, None], 0.002, step="step", settings=settings, trajectory=False, ground=ground)
    assert (expected.forces != 0).any()
    fall = modyn.torch.rollout(own, step="step", trajectory=False)
    state = [torch.from_numpy(x) for x in (q, qd, tau[:, None], settings)]

    def end(heights, settings):
        return fall(*state[:3], 0.002, settings=settings, ground=modyn.HeightField(heights, torch.from_numpy(ground.origin), (1.3, 1.7))).qd

    heights = torch.from_numpy(ground.heights)
    settings = state[3].requires_grad_()
    gradients = []
    for function in (end, torch.compile(end, fullgraph=True)):
        found = function(heights, settings)
        close(found.detach(), expected.qd, 1e-12)
        gradients += torch.autograd.grad((found**2).sum(), settings)
    close(gradients[0], gradients[1], 1e-12)
    assert gradients[0].abs().max() > 1e-3
    moved = torch.func.vmap(lambda heights, origin: fall(*(x[0] for x in state[:3]), 0.002, ground=modyn.HeightField(heights, origin)).qd)
    one = own.rollout(q[0], qd[0], tau[0, None], 0.002, step="step", trajectory=False, ground=modyn.HeightField(ground.heights, ground.origin))
    close(moved(heights, torch.from_numpy(ground.origin)), one.qd, 1e-12)
    # `torch.compile` reports errors as its own.
    for function, error in ((end, NotImplementedError), (torch.compile(end), Exception)):
        with pytest.raises(error, match="no derivatives with respect to the fields of `ground`"):
            function(heights.clone().requires_grad_(), settings).sum().backward()


def test_forward_mode_on_the_ground():
    """Arguments that do not change, such as heights, need no derivatives."""
    own, q, qd, tau, _ = scene(1)
    q, qd, tau = (torch.from_numpy(x[0]) for x in (q, qd, tau))
    ground = ramp()[0]
    points, step = (modyn.torch.function(own, name) for name in ("touching_points", "step"))
    for function in (lambda qd: points(q, qd, ground=ground).velocities, lambda qd: step(q, qd, tau, 0.002, ground=ground).qd):
        expected = torch.func.jacrev(function)(qd)
        assert expected.abs().max() > 0.1
        close(torch.func.jacfwd(function)(qd), expected, 1e-12)
    of_start = lambda start: step(q, qd, tau, 0.002, start, ground=ground).qd
    assert (torch.func.jvp(of_start, (torch.zeros_like(qd),), (qd,))[1] == 0).all()
    gaps = lambda q: points(q, qd, ground=ground).gaps.sum()
    for transformation in (torch.func.hessian, lambda f: torch.func.jacrev(torch.func.jacrev(f))):
        with pytest.raises(NotImplementedError, match="`touching_points` with a `ground` has first derivatives alone"):
            transformation(gaps)(q)
    with pytest.raises(NotImplementedError, match="no derivatives with respect to the fields of `ground`"):
        torch.func.jacfwd(lambda heights: points(q, qd, ground=modyn.HeightField(heights)).gaps)(torch.zeros(2, 2, dtype=torch.float64))


def test_run_time_parameters_and_tangent_space():
    own = robot(payload=["link3"], runtime_gravity=True)
    q, qd, tau = tensors(own)
    function = modyn.torch.function(own, "forward_dynamics")
    given = modyn.torch.parameters(own)
    mass = torch.tensor([0.5, 0.1, 0.2, 0.3, 0.1, 0, 0, 0.1, 0, 0.1], dtype=torch.float64, requires_grad=True)
    found = function(q, qd, tau, parameters={**given, "payload": {"link3": mass}})
    own.set_payload("link3", 0.5, (0.1, 0.2, 0.3), (0.1, 0, 0, 0.1, 0, 0.1))
    close(found.detach(), own.forward_dynamics(q.numpy(), qd.numpy(), tau.numpy()), 1e-9)
    assert torch.autograd.gradcheck(
        lambda mass: function(q, qd, tau, parameters={**given, "payload": {"link3": mass}}), (mass,), fast_mode=True
    )
    own = robot()
    q = q.clone().requires_grad_()
    modyn.torch.function(own, "forward_dynamics")(q, qd, tau).sum().backward()
    expected = own.forward_dynamics_vjp(q.detach().numpy(), qd.numpy(), tau.numpy(), np.ones((3, own.nv))).grad_q
    close(modyn.torch.to_tangent(own, q.detach(), q.grad), expected, 1e-9)


def test_defaults_of_contacts():
    own = robot(contacts={"foot": ("point", "link3", (0.1, -0.2, 0.05))})
    q, qd, tau = tensors(own)
    function = modyn.torch.function(own, "constrained_forward_dynamics")
    expected = own.constrained_forward_dynamics(q.numpy(), qd.numpy(), tau.numpy())
    close(function(q, qd, tau).qdd, expected.qdd, 1e-9)
    given = torch.zeros(1, dtype=torch.float64)
    close(function(q, qd, tau, active=given).qdd, own.constrained_forward_dynamics(q.numpy(), qd.numpy(), tau.numpy(), np.zeros(1)).qdd)


def test_refused():
    own = robot("fixed")
    q, qd, tau = (x[0] for x in tensors(own))
    function = modyn.torch.function(own, "forward_dynamics")
    with pytest.raises(ValueError, match=r"`qd` of `forward_dynamics` has the shape \(3,\); expected \(4,\)"):
        function(q, qd[:3], tau)
    with pytest.raises(TypeError, match="`tau` of `forward_dynamics` must be a tensor of real numbers, not of torch.complex128"):
        function(q, qd, tau + 1j)
    with pytest.raises(ValueError, match="`q` of `forward_dynamics` is on the device meta"):
        function(q.to("meta"), qd, tau)
    with pytest.raises(TypeError, match="missing a required argument: 'tau'"):
        function(q, qd)
    with pytest.raises(ValueError, match="did you mean `forward_dynamics`"):
        modyn.torch.function(own, "forward_dynamic")
