"""The path to CUDA, through a stand-in for the driver and for NVRTC (cuda_stand_in.cpp): the host runs the threads of the kernels."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, chain, close, states

import modyn
from modyn import _cuda
from modyn._arrays import ArrayFunction, FieldKernels

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
STREAM = 0x5EED


def reset():
    _cuda._kernels.clear()
    _cuda.driver.cache_clear()
    _cuda.nvrtc.cache_clear()


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    path = tmp_path_factory.mktemp("cuda") / "stand_in.so"
    compiler = f'-DCOMPILER="g++ -I {ROOT}/modyn-codegen/tests"'
    source = Path(__file__).with_name("cuda_stand_in.cpp")
    subprocess.run(["g++", "-std=c++17", "-shared", "-fPIC", "-w", compiler, source, "-o", path, "-ldl"], check=True)
    return path


@pytest.fixture
def stand_in(library, tmp_path_factory, monkeypatch):
    """The stand-in, in whose place calls on CUDA see no driver; kernels are cached for all tests."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(library.parent / "cache"))
    monkeypatch.setattr(_cuda, "DRIVER", str(library))
    monkeypatch.setattr(_cuda, "NVRTC", [str(library)])
    reset()
    yield ctypes.CDLL(str(library))
    reset()


@pytest.fixture
def torch(stand_in, monkeypatch):
    """PyTorch, whose tensors on the CPU are those on the stand-in's device."""
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: pip install modyn[torch]")
    import modyn.torch

    monkeypatch.setattr(modyn.torch, "_is_cuda", lambda device: device.type == "cpu")
    monkeypatch.setattr(modyn.torch, "_stream", lambda device: STREAM)
    return torch


@pytest.fixture
def jax(stand_in, monkeypatch):
    """JAX, whose arrays on the CPU are on the stand-in's device. Robots of these tests have no programs in other tests."""
    jax = pytest.importorskip("jax", reason="JAX is not installed: pip install modyn[jax]")
    import modyn.jax as functions
    from jax.interpreters import mlir

    jax.config.update("jax_enable_x64", True)
    handler = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(modyn._modyn.xla_cuda_handler(on_host=True))
    jax.ffi.register_ffi_target("modyn_cuda", jax.ffi.pycapsule(handler), platform="cpu")
    monkeypatch.setattr(functions, "_devices", lambda: [0])
    scanned = [(functions._rollout, functions._scanned), (functions._rollout_gradient, functions._gradient_by_scan)]
    mlir.register_lowering(functions._call, functions._lowered_on_cuda, platform="cpu")
    for primitive, function in scanned:
        mlir.register_lowering(primitive, mlir.lower_fun(function, multiple_results=True), platform="cpu")
    yield jax
    for primitive in (functions._call, functions._rollout, functions._rollout_gradient):
        mlir.register_lowering(primitive, functions._lowered, platform="cpu")


def number(library, name, kind=ctypes.c_long):
    return kind.in_dll(library, name).value


def robot(base="floating", **options):
    return modyn.loads(chain(3, joints=4), base=base, **options)


class Tensor:
    """What a call needs of PyTorch's tensors."""

    def __init__(self, array):
        self.array, self.shape = array, array.shape

    def data_ptr(self):
        return self.array.ctypes.data

    def is_contiguous(self):
        return self.array.flags.c_contiguous

    def stride(self):
        return tuple(bytes // self.array.itemsize for bytes in self.array.strides)

    def expand(self, *shape):
        return Tensor(np.broadcast_to(self.array, shape))

    def contiguous(self):
        return Tensor(np.ascontiguousarray(self.array))


def called(code, *arrays):
    """Returns the results of a call on CUDA."""
    tensors = [Tensor(np.asarray(array, code.dtype)) for array in arrays]
    results = _cuda.call(code, 0, STREAM, tensors, lambda shape: Tensor(np.full(shape, np.nan, code.dtype)))
    return [result.array for result in results]


def test_values_streams_and_broadcasts(stand_in):
    exact = robot()
    q, qd, _, tau = states(exact, 300)
    code = ArrayFunction(robot(scalar="f32"), "forward_dynamics")
    function = lambda *arrays: called(code, *arrays)[0]
    before = number(stand_in, "launches")
    found = function(q, qd, tau)
    assert number(stand_in, "launches") == before + 1
    assert number(stand_in, "last_stream", ctypes.c_void_p) == STREAM and number(stand_in, "last_context", ctypes.c_int) == 1
    expected = exact.forward_dynamics(q, qd, tau)
    close(found, expected, 1e-3)
    assert found.dtype == np.float32
    # One state, no state, and axes that are broadcast: along the last ones, the first ones, and those between.
    close(function(q[0], qd[0], tau[0]), expected[0], 1e-3)
    assert function(q[:0], qd[:0], tau[:0]).shape == (0, exact.nv)
    few = q[:6].reshape(2, 3, -1)
    crossed = function(few[:, None, :1], qd[7:12, None], tau[:1, None, None])
    assert crossed.shape == (2, 5, 1, exact.nv)
    for i, j in np.ndindex(2, 5):
        close(crossed[i, j, 0], exact.forward_dynamics(q[3 * i], qd[7 + j], tau[0]), 1e-3)
    between = function(few[:, None], qd[7:12, None], tau[0])
    for i, j, k in np.ndindex(2, 5, 3):
        close(between[i, j, k], exact.forward_dynamics(q[3 * i + k], qd[7 + j], tau[0]), 1e-3)
    # Columns of a wide array, every second state, a repeated state: without copies. By columns: with a copy.
    wide = np.concatenate([q, qd, tau], 1).astype(np.float32)
    nq, nv = exact.nq, exact.nv
    sliced = function(wide[:, :nq], wide[:, nq : nq + nv], np.broadcast_to(wide[5, nq + nv :], (300, nv)))
    close(sliced, exact.forward_dynamics(q, qd, np.tile(tau[5], (300, 1))), 1e-3)
    close(function(wide[::2, :nq], np.asfortranarray(qd[::2].astype(np.float32)), tau[::2]), expected[::2], 1e-3)
    with pytest.raises(ValueError, match=r"has the shape \(3, 4\); expected \(11,\)"):
        function(q[:3, :4], qd[:3], tau[:3])
    with pytest.raises(ValueError, match="axes of 3 and of 2 states do not fit"):
        function(q[:3], qd[:2], tau[:2])


def test_cached(stand_in):
    own = robot("fixed")
    q, qd, _, _ = states(own, 2)
    code = ArrayFunction(own, "kinetic_energy")
    before = [number(stand_in, name) for name in ("compilations", "libraries")]
    counts = lambda: [number(stand_in, name) - old for name, old in zip(("compilations", "libraries"), before)]
    for _ in range(2):
        close(called(code, q, qd)[0], own.kinetic_energy(q, qd), 1e-9)
    assert counts() == [1, 1]
    # Another process: the machine code is on the disk.
    reset()
    close(called(code, q, qd)[0], own.kinetic_energy(q, qd), 1e-9)
    assert counts() == [1, 2]


def test_gradients_in_torch(torch, stand_in):
    own = robot()
    q, qd, _, tau = (torch.from_numpy(x).requires_grad_() for x in states(own, 3))
    function = modyn.torch.function(own, "forward_dynamics")
    before = number(stand_in, "launches")
    function(q, qd, tau).sum().backward()
    assert number(stand_in, "launches") == before + 2 and number(stand_in, "last_stream", ctypes.c_void_p) == STREAM
    expected = own.forward_dynamics_vjp(q.detach().numpy(), qd.detach().numpy(), tau.detach().numpy(), np.ones((3, own.nv)))
    close(qd.grad, expected.grad_qd, 1e-9)
    close(tau.grad, expected.grad_tau, 1e-9)
    close(modyn.torch.to_tangent(own, q.detach(), q.grad), expected.grad_q, 1e-9)
    # A tensor of all states, a transformation, and a compiled function.
    shared = tau[0].detach().requires_grad_()
    cost = lambda tau: (function(q.detach(), qd.detach(), tau) ** 2).sum()
    (by_shared,) = torch.autograd.grad(cost(shared), shared)
    by_each = torch.func.vmap(torch.func.grad(cost))(shared.detach()[None])
    compiled = torch.compile(cost, backend="aot_eager", fullgraph=True)
    (by_compiled,) = torch.autograd.grad(compiled(shared), shared)
    close(by_each[0], by_shared, 1e-9)
    close(by_compiled, by_shared, 1e-9)
    direction = torch.ones_like(shared)
    h = 1e-6
    difference = (cost(shared.detach() + h * direction) - cost(shared.detach() - h * direction)) / (2 * h)
    close((by_shared * direction).sum(), difference, 1e-6)


def control(seed):
    """Returns a robot with a fused function."""
    fused = {"control": ["mass_matrix", ("link_pose", "link1"), "forward_dynamics"]}
    return modyn.loads(chain(seed, joints=3), base="floating", payload=["link1"], fused=fused)


def test_fused_functions_in_torch(torch, stand_in):
    """One kernel computes all results, and one all gradients."""
    own = control(13)
    q, qd, _, tau = (torch.from_numpy(x).requires_grad_() for x in states(own, 3))
    before = number(stand_in, "launches")
    found = modyn.torch.function(own, "control")(q, qd, tau)
    expected = own.control(*(x.detach().numpy() for x in (q, qd, tau)))
    assert type(found) is type(expected)
    close(found.mass_matrix.detach(), expected.mass_matrix, 1e-9)
    close(found.link_pose_link1.rotation.detach(), expected.link_pose_link1.rotation, 1e-9)
    (found.forward_dynamics.sum() + (found.mass_matrix**2).sum()).backward()
    assert number(stand_in, "launches") == before + 2
    own = {name: modyn.torch.function(own, name) for name in ("mass_matrix", "forward_dynamics")}
    total = own["forward_dynamics"](q, qd, tau).sum() + (own["mass_matrix"](q) ** 2).sum()
    for x, gradient in zip((q, qd, tau), torch.autograd.grad(total, (q, qd, tau)), strict=True):
        close(x.grad, gradient, 1e-9)


def test_refused_tensors(torch):
    own = robot("fixed")
    q, qd, _, tau = (torch.from_numpy(x) for x in states(own, 3))
    function = modyn.torch.function(own, "forward_dynamics")
    with pytest.raises(ValueError, match="`qd` of `forward_dynamics` is on the device meta; other arguments are on cpu"):
        function(q, qd.to("meta"), tau)
    with pytest.raises(TypeError, match="`tau` of `forward_dynamics` has numbers of torch.float32"):
        function(q, qd, tau.float())
    with pytest.raises(ValueError, match="the numbers of a state in `q` of `forward_dynamics` are not contiguous"):
        function(q.T.contiguous().T, qd, tau)
    with pytest.raises(ValueError, match="`qd` of `forward_dynamics` are not contiguous, or the states have no common stride"):
        function(q[:2].reshape(2, 1, -1), torch.ones(2, 3, own.nv, dtype=q.dtype)[:, :2], tau[0])


@pytest.fixture
def nvrtc(stand_in, monkeypatch):
    """NVIDIA's compiler, if it is installed, as with CUDA's PyTorch and JAX. It must be there if MODYN_NVRTC is an environment of Python that
    has it, as `tests/cuda/run` makes one."""
    given = os.environ.get("MODYN_NVRTC")
    monkeypatch.setattr(sys, "path", [*sys.path, *(str(x) for x in Path(given or os.devnull).glob("lib/*/site-packages"))])
    monkeypatch.setattr(_cuda, "NVRTC", [])
    try:
        return _cuda.nvrtc()
    except RuntimeError as error:
        if given:
            raise
        pytest.skip(str(error))


@pytest.mark.parametrize(("name", "mode"), [("forward_dynamics", None), ("forward_dynamics", "reverse")])
def test_the_text_compiles_with_nvrtc(nvrtc, name, mode):
    """Machine code of NVIDIA's compiler."""
    function = ArrayFunction(robot(), name)
    code = nvrtc.cubin((function if mode is None else function.derivative(mode, [0, 1])).cuda_text(), "sm_90")
    assert code.startswith(b"\x7fELF") and b"modyn_rows" in code


def test_the_planes_of_a_height_field_compile_with_nvrtc(nvrtc):
    for scalar in ("f32", "f64"):
        own = modyn.loads(chain(12, joints=2), base="floating", contacts={"foot": ("point", "link1", (0.1, -0.2, 0.05))}, scalar=scalar)
        kernels = FieldKernels.of(own, (4, 5))
        for kernel in (kernels.poses, kernels.planes):
            assert b"modyn_rows" in nvrtc.cubin(kernel.cuda_text(), "sm_90")


def test_faults_of_the_libraries(stand_in, monkeypatch):
    with pytest.raises(RuntimeError, match="of an NVIDIA GPU, whose library `libno.so.1` cannot be opened"):
        _cuda.Driver("libno.so.1")
    with pytest.raises(RuntimeError, match="`cuDeviceGet`: CUDA's error 101: invalid device ordinal"):
        _cuda.driver().device(1)
    with pytest.raises(RuntimeError, match="does not compile a kernel for sm_90: error 6\n(.*\n)*.*error: "):
        _cuda.nvrtc().cubin('extern "C" void modyn_rows() { fault; }', "sm_90")
    monkeypatch.setattr(_cuda, "NVRTC", ["/no/libnvrtc.so.13"])
    _cuda.nvrtc.cache_clear()
    with pytest.raises(RuntimeError, match="NVRTC of CUDA 13 or earlier.*pip install nvidia-cuda-nvrtc"):
        _cuda.nvrtc()


def test_jax(jax, stand_in):
    """Values, axes that are broadcast, transformations, and a rollout with its gradient."""
    own = modyn.loads(chain(11, joints=3), base="floating")
    q, qd, _, tau = states(own, 6)
    function = modyn.jax.function(own, "forward_dynamics")
    before = number(stand_in, "launches")
    close(function(q, qd, tau), own.forward_dynamics(q, qd, tau), 1e-9)
    assert number(stand_in, "launches") == before + 1
    between = function(q.reshape(2, 1, 3, -1), qd[:5, None], tau[0])
    for i, j, k in np.ndindex(2, 5, 3):
        close(between[i, j, k], own.forward_dynamics(q[3 * i + k], qd[j], tau[0]), 1e-9)
    by_tau = jax.jit(jax.vmap(jax.jacrev(function, 2)))(q, qd, tau)
    close(by_tau, own.forward_dynamics_derivatives(q, qd, tau).dqdd_dtau, 1e-9)
    assert function(q[:0], qd[:0], tau[:0]).shape == (0, own.nv)
    controls = np.repeat(tau[:, None], 4, 1)
    motion = modyn.jax.rollout(own)
    close(motion(q, qd, controls, 0.01).q, own.rollout(q, qd, controls, 0.01).q, 1e-12)
    gradient = jax.jit(jax.grad(lambda controls: motion(q, qd, controls, 0.01).qd.sum()))(controls)
    ones = np.ones((6, 4, own.nv))
    close(gradient, own.rollout_vjp(q, qd, controls, 0.01, np.zeros((6, 4, own.nq)), ones).controls, 1e-9)


def test_fused_functions_in_jax(jax, stand_in):
    own = control(14)
    q, qd, _, tau = states(own, 4)
    function = modyn.jax.function(own, "control")
    before = number(stand_in, "launches")
    found, expected = function(q, qd, tau), own.control(q, qd, tau)
    assert number(stand_in, "launches") == before + 1
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        close(a, b, 1e-9)
    by_tau = jax.vmap(jax.jacrev(lambda q, qd, tau: function(q, qd, tau).forward_dynamics, 2))(q, qd, tau)
    close(by_tau, own.forward_dynamics_derivatives(q, qd, tau).dqdd_dtau, 1e-9)
    # A payload for each state.
    parameters = modyn.jax.parameters(own)
    payloads = np.tile(parameters["payload"]["link1"], (4, 1))
    payloads[:, 0] = 0.1, 0.5, 1.0, 2.0
    loaded = function(q, qd, tau, parameters={"payload": {"link1": payloads}}).forward_dynamics
    for i, mass in enumerate(payloads[:, 0]):
        own.set_payload("link1", mass)
        close(loaded[i], own.forward_dynamics(q[i], qd[i], tau[i]), 1e-9)


def scene():
    """A robot whose foot is in the ground, its state, and settings."""
    own = modyn.loads(chain(12, joints=2), base="floating", contacts={"foot": ("point", "link1", (0.1, -0.2, 0.05))})
    q, qd, _, tau = (x[0] for x in states(own, 1))
    pose = own.link_pose(q, "link1")
    q[2] -= (pose.translation + pose.rotation @ np.array([0.1, -0.2, 0.05]))[2]
    return own, q, qd, tau, modyn.StepSettings([modyn.ContactSurface(radius=0.02, friction=0.7)], tolerance=1e-13)


def hills(asarray):
    """Two worlds of ground that is within 1 cm of a plane."""
    rng = np.random.default_rng(5)
    return modyn.HeightField(asarray(rng.uniform(-0.01, 0.01, size=(2, 4, 5))), asarray(rng.uniform(-3, -2, size=(2, 2))), (1.3, 1.7))


def test_a_height_field_in_jax(jax):
    own, q, qd, tau, settings = scene()
    fall = modyn.jax.rollout(own, step="step", trajectory=False)
    arguments = np.tile(tau, (3, 1)), 0.003
    ground = hills(np.asarray)
    end = lambda q, settings: fall(q, qd, *arguments, settings=settings, ground=ground)
    expected = own.rollout(q, qd, *arguments, step="step", settings=settings, ground=ground, trajectory=False)
    assert (np.abs(expected.forces).max((1, 2)) > 0).all() and np.abs(expected.q[0] - expected.q[1]).max() > 1e-6
    for a, b in zip(end(q, settings), expected):
        close(a, b, 1e-9)
    # Weights of the states of both worlds.
    gradients = jax.grad(lambda q, settings: end(q, settings).qd.sum(), argnums=(0, 1))(q, np.asarray(settings))
    ones = np.zeros((2, own.nq)), np.ones((2, own.nv))
    of_worlds = own.rollout_vjp(q, qd, *arguments, *ones, step="step", settings=settings, ground=ground, trajectory=False)
    close(gradients[0], of_worlds.q.sum(0), 1e-7)
    close(gradients[1], of_worlds.settings.sum(0), 1e-7)
    assert np.abs(gradients[1]).max() > 1e-3


def test_steps_on_the_ground_in_jax(jax):
    own, q, qd, tau, settings = scene()
    step = modyn.jax.function(own, "step")
    found = step(q, qd, tau, 0.003, settings=settings)
    expected = own.step(q, qd, tau, 0.003, settings=settings)
    assert (expected[3][:, 2] > 0).any()
    for a, b in zip(found, expected):
        close(a, b, 1e-9)
    end = lambda tau: step(q, qd, tau, 0.003, settings=settings).qd.sum()
    close(jax.grad(end)(tau), own.step_derivatives(q, qd, tau, 0.003, settings=settings).b[own.nv :].sum(0), 1e-6)


def test_rollouts_in_torch(torch, monkeypatch):
    """Values and gradients are those of the CPU: of a feedback with a cost, on planes, and on a height field in each world."""
    own = robot()
    q, qd, _, tau = (torch.from_numpy(x) for x in states(own, 2))
    rng = np.random.default_rng(1)
    random = lambda *shape: torch.from_numpy(rng.normal(size=shape))
    nv = own.nv
    cost = modyn.QuadraticCost(q[1], random(2 * nv), random(nv), random(nv), random(2 * nv))
    given = [q, qd[0], tau[:, None].repeat(1, 3, 1), torch.tensor(0.01, dtype=torch.float64), random(nv, 2 * nv)]
    on_ground, *state, settings = scene()
    lying = [*(torch.from_numpy(x) for x in state[:2]), torch.from_numpy(state[2]).repeat(2, 3, 1), torch.tensor(0.003, dtype=torch.float64)]

    def gradients(trajectory):
        motion = modyn.torch.rollout(own, trajectory=trajectory)
        fall = modyn.torch.rollout(on_ground, step="step", trajectory=trajectory)
        x = [a.clone().requires_grad_() for a in given]
        y = [a.clone().requires_grad_() for a in lying]
        numbers = torch.from_numpy(np.asarray(settings)).requires_grad_()
        found = motion(*x[:4], gains=x[4], q_ref=q[:, None], qd_ref=qd[:, None], cost=cost)
        level, hilly = fall(*y, settings=settings), fall(*y, settings=numbers, ground=hills(torch.from_numpy))
        total = sum((a**2).sum() for a in (*found, *level[:4], *hilly[:4]))
        return [*found, *level, *hilly, *torch.autograd.grad(total, [*x, *y, numbers])]

    for trajectory in (True, False):
        found = gradients(trajectory)
        with monkeypatch.context() as on_cpu:
            on_cpu.setattr(modyn.torch, "_is_cuda", lambda device: False)
            expected = gradients(trajectory)
        assert all(a.shape == b.shape for a, b in zip(found, expected))
        for a, b in zip(found, expected):
            close(a.detach(), b.detach(), 1e-7)
