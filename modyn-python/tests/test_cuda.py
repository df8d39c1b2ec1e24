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
from modyn._arrays import ArrayFunction

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


def number(library, name, kind=ctypes.c_long):
    return kind.in_dll(library, name).value


def robot(base="floating", **options):
    return modyn.loads(chain(3, joints=4), base=base, **options)


def test_values_streams_and_broadcasts(torch, stand_in):
    own = robot(scalar="f32")
    exact = robot()
    q, qd, _, tau = states(exact, 300)
    given = [torch.from_numpy(x.astype(np.float32)) for x in (q, qd, tau)]
    function = modyn.torch.function(own, "forward_dynamics")
    before = number(stand_in, "launches")
    found = function(*given)
    assert number(stand_in, "launches") == before + 1
    assert number(stand_in, "last_stream", ctypes.c_void_p) == STREAM and number(stand_in, "last_context", ctypes.c_int) == 1
    expected = exact.forward_dynamics(q, qd, tau)
    close(found, expected, 1e-3)
    assert found.dtype == torch.float32
    # One state, no state, and axes that are broadcast: along the last ones, the first ones, and those between.
    close(function(*(x[0] for x in given)), expected[0], 1e-3)
    assert function(*(x[:0] for x in given)).shape == (0, own.nv)
    few = [x[:6].reshape(2, 3, -1) for x in given]
    crossed = function(few[0][:, None, :1].contiguous(), given[1][7:12, None], few[2][:1, :1])
    assert crossed.shape == (2, 5, 1, own.nv)
    for i, j in np.ndindex(2, 5):
        close(crossed[i, j, 0], exact.forward_dynamics(q[3 * i], qd[7 + j], tau[0]), 1e-3)
    between = function(few[0][:, None].contiguous(), given[1][7:12, None], given[2][0])
    for i, j, k in np.ndindex(2, 5, 3):
        close(between[i, j, k], exact.forward_dynamics(q[3 * i + k], qd[7 + j], tau[0]), 1e-3)


def test_cached(torch, stand_in):
    own = robot("fixed")
    q, qd, _, _ = states(own, 2)
    energy = lambda: modyn.torch.function(own, "kinetic_energy")(torch.from_numpy(q), torch.from_numpy(qd))
    before = [number(stand_in, name) for name in ("compilations", "libraries")]
    counts = lambda: [number(stand_in, name) - old for name, old in zip(("compilations", "libraries"), before)]
    close(energy(), own.kinetic_energy(q, qd), 1e-9)
    close(energy(), own.kinetic_energy(q, qd), 1e-9)
    assert counts() == [1, 1]
    # Another process: the machine code is that of the disk.
    reset()
    close(energy(), own.kinetic_energy(q, qd), 1e-9)
    assert counts() == [1, 2]


def test_gradients(torch):
    own = robot()
    q, qd, _, tau = (torch.from_numpy(x).requires_grad_() for x in states(own, 3))
    function = modyn.torch.function(own, "forward_dynamics")
    function(q, qd, tau).sum().backward()
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


def test_refused_tensors(torch):
    own = robot("fixed")
    q, qd, _, tau = (torch.from_numpy(x) for x in states(own, 3))
    function = modyn.torch.function(own, "forward_dynamics")
    with pytest.raises(ValueError, match="`qd` of `forward_dynamics` is on the device meta; other arguments are on cpu"):
        function(q, qd.to("meta"), tau)
    with pytest.raises(TypeError, match="`tau` of `forward_dynamics` has numbers of torch.float32"):
        function(q, qd, tau.float())
    with pytest.raises(ValueError, match="`q` of `forward_dynamics` is not contiguous"):
        function(q.T.contiguous().T, qd, tau)


@pytest.mark.parametrize(("name", "mode"), [("forward_dynamics", None), ("forward_dynamics", "reverse")])
def test_the_text_compiles_with_nvrtc(stand_in, monkeypatch, name, mode):
    """Machine code of NVIDIA's compiler: of its package, which CUDA's PyTorch and JAX bring and `tests/cuda/run` installs."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    roots = [target, target.parent]
    monkeypatch.setattr(sys, "path", [*sys.path, *(str(x) for at in roots for x in at.glob("cuda/venv/lib/*/site-packages"))])
    monkeypatch.setattr(_cuda, "NVRTC", [])
    try:
        nvrtc = _cuda.nvrtc()
    except RuntimeError as error:
        pytest.skip(str(error))
    function = ArrayFunction(robot(), name)
    code = nvrtc.cubin((function if mode is None else function.derivative(mode, [0, 1])).cuda_text(), "sm_90")
    assert code.startswith(b"\x7fELF") and b"modyn_rows" in code


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
