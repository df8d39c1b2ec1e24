"""CUDA: kernels of functions of arrays, compiled by NVRTC and loaded by the driver's library.

Both libraries are opened at the first call. NVRTC is that of the package `nvidia-cuda-nvrtc`, which PyTorch and JAX bring, or the
system's. Compiled kernels are kept in the folder `modyn` of the user's cache, by their content.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib.util
import math
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ._arrays import Code
from ._modyn import CudaKernel

DRIVER = "libcuda.so.1"
"""the driver's library"""

NVRTC: list[str] = []
"""the paths of NVRTC; if there are none, NVRTC is found among the installed packages"""

OPTIONS = (b"--std=c++17",)
"""the options of NVRTC beside the architecture"""

# CUDA's numbers of what is asked of a device: its architecture's two digits.
_MAJOR, _MINOR = 75, 76

_MISSING = "calls on CUDA need the driver of an NVIDIA GPU, whose library `{}` cannot be opened: {}"
_NO_NVRTC = (
    "calls on CUDA need NVIDIA's compiler NVRTC of CUDA {} or earlier, which PyTorch and JAX bring for GPUs: "
    "pip install nvidia-cuda-nvrtc{}"
)


class Driver:
    """The driver's library."""

    def __init__(self, path: str) -> None:
        try:
            self.library = ctypes.CDLL(path)
        except OSError as error:
            raise RuntimeError(_MISSING.format(path, error)) from None
        self.run("cuInit", ctypes.c_uint(0))
        self.version = self.found("cuDriverGetVersion", ctypes.c_int)
        names = ("cuLaunchKernel", "cuCtxPushCurrent_v2", "cuCtxPopCurrent_v2", "cuGetErrorString")
        self.addresses = [ctypes.cast(getattr(self.library, name), ctypes.c_void_p).value or 0 for name in names]

    def run(self, name: str, *arguments: Any) -> None:
        """Calls a function, which returns an error."""
        error = getattr(self.library, name)(*arguments)
        if error:
            text = ctypes.c_char_p()
            self.library.cuGetErrorString(error, ctypes.byref(text))
            raise RuntimeError(f"`{name}`: CUDA's error {error}: {(text.value or b'unknown').decode()}")

    def found(self, name: str, kind: Any, *arguments: Any) -> Any:
        """Returns the number or the address that a function finds."""
        result = kind()
        self.run(name, ctypes.byref(result), *arguments)
        return result.value

    @functools.lru_cache(None)  # noqa: B019
    def device(self, index: int) -> tuple[str, int]:
        """Returns the architecture, such as `sm_90`, and the context of a device, which PyTorch and JAX share."""
        device = self.found("cuDeviceGet", ctypes.c_int, index)
        major, minor = (self.found("cuDeviceGetAttribute", ctypes.c_int, what, device) for what in (_MAJOR, _MINOR))
        return f"sm_{major}{minor}", self.found("cuDevicePrimaryCtxRetain", ctypes.c_void_p, device)

    def kernel(self, cubin: bytes) -> int:
        """Returns the address of the kernel of a text."""
        none, no = ctypes.c_void_p(), ctypes.c_uint(0)
        library = self.found("cuLibraryLoadData", ctypes.c_void_p, cubin, none, none, no, none, none, no)
        return int(self.found("cuLibraryGetKernel", ctypes.c_void_p, ctypes.c_void_p(library), b"modyn_rows"))


class Nvrtc:
    """NVIDIA's compiler at run time."""

    def __init__(self, path: str) -> None:
        for builtins in Path(path).parent.glob("libnvrtc-builtins.so*") if os.sep in path else ():
            ctypes.CDLL(str(builtins), mode=ctypes.RTLD_GLOBAL)
        self.library = ctypes.CDLL(path)
        major, minor = ctypes.c_int(), ctypes.c_int()
        self.library.nvrtcVersion(ctypes.byref(major), ctypes.byref(minor))
        self.version = f"{major.value}.{minor.value}"

    def cubin(self, text: str, architecture: str) -> bytes:
        """Compiles a text to machine code."""
        program = ctypes.c_void_p()
        error = self.library.nvrtcCreateProgram(ctypes.byref(program), text.encode(), b"modyn.cu", 0, None, None)
        try:
            options = [f"--gpu-architecture={architecture}".encode(), *OPTIONS]
            error = error or self.library.nvrtcCompileProgram(program, len(options), (ctypes.c_char_p * len(options))(*options))
            if error:
                log = self.bytes_of(program, "ProgramLog").rstrip(b"\0").decode() if program else ""
                raise RuntimeError(f"NVRTC {self.version} does not compile a kernel for {architecture}: error {error}\n{log}")
            return self.bytes_of(program, "CUBIN")
        finally:
            self.library.nvrtcDestroyProgram(ctypes.byref(program))

    def bytes_of(self, program: ctypes.c_void_p, what: str) -> bytes:
        """Returns the bytes that a program has."""
        size = ctypes.c_size_t()
        getattr(self.library, f"nvrtcGet{what}Size")(program, ctypes.byref(size))
        buffer = ctypes.create_string_buffer(size.value)
        getattr(self.library, f"nvrtcGet{what}")(program, buffer)
        return buffer.raw


@functools.cache
def driver() -> Driver:
    """Returns the driver's library, opened."""
    return Driver(DRIVER)


@functools.cache
def nvrtc() -> Nvrtc:
    """Returns NVRTC, opened: the newest one that the driver's version allows."""
    most = driver().version // 1000
    paths = list(NVRTC)
    if not paths:
        spec = importlib.util.find_spec("nvidia")
        folders = (spec and spec.submodule_search_locations) or []
        found = [path for folder in folders for path in Path(folder).glob("*/lib/libnvrtc.so.*")]
        major = lambda path: int(path.suffix[1:]) if path.suffix[1:].isdigit() else 0
        paths = [str(path) for path in sorted(found, key=major, reverse=True) if major(path) <= most]
    for path in [*paths, *(() if NVRTC else (f"libnvrtc.so.{most}", "libnvrtc.so"))]:
        try:
            return Nvrtc(path)
        except OSError:
            continue
    raise RuntimeError(_NO_NVRTC.format(most, f"-cu{most}" if most < 13 else ""))


def cubin(text: str, architecture: str) -> bytes:
    """Returns the machine code of a text, from the cache if it is there."""
    key = hashlib.sha256("\0".join((text, architecture, nvrtc().version, repr(OPTIONS))).encode()).hexdigest()
    folder = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "modyn")
    try:
        return (folder / f"{key}.cubin").read_bytes()
    except OSError:
        compiled = nvrtc().cubin(text, architecture)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
            file.write(compiled)
        os.replace(file.name, folder / f"{key}.cubin")
    except OSError:
        # Without a cache the next process compiles again.
        pass
    return compiled


_kernels: dict[tuple[int, int], CudaKernel] = {}


def kernel(code: Code, device: int) -> CudaKernel:
    """Returns the kernel of a function of arrays on a device, compiled at its first use."""
    found = _kernels.get((code.key, device))
    if found is None:
        architecture, _ = driver().device(device)
        function = driver().kernel(cubin(code.cuda_text(), architecture))
        shapes = [list(map(list, code.inputs)), list(map(list, code.outputs))]
        is_double = code.dtype == np.float64
        found = _kernels[code.key, device] = CudaKernel(code.key, driver().addresses, function, shapes, is_double)
    return found


def stride(array: Any, own: tuple[int, ...]) -> int | None:
    """Returns how many numbers the rows of a tensor are apart, one row for each state; `None` if they are not equally far apart, or
    not contiguous."""
    size = math.prod(own)
    if array.is_contiguous():
        return size
    axes = [axis for axis in zip(array.shape, array.stride()) if axis[0] != 1]
    split = len(axes) - sum(length != 1 for length in own)
    following = lambda axes: all(a[1] == b[0] * b[1] for a, b in zip(axes, axes[1:]))
    rows, numbers = axes[:split], [*axes[split:], (1, 1)]
    if not following(rows) or not following(numbers):
        return None
    return int(rows[-1][1]) if rows else size


def call(code: Code, device: int, stream: int, arrays: list[Any], empty: Callable[[tuple[int, ...]], Any]) -> list[Any]:
    """Starts a function of arrays on a stream, given PyTorch's tensors on a device. Tensors without a stride are copied.

    `empty` returns a new tensor on the device. Nothing waits for the results.
    """
    own = kernel(code, device)
    shapes = [array.shape for array in arrays]
    lead, repeated = own.states(shapes)
    strides = []
    for k, shape in enumerate(code.inputs):
        step = None if k in repeated else stride(arrays[k], shape)
        if step is None:
            array = arrays[k].expand(*lead, *shape) if k in repeated else arrays[k]
            arrays[k] = array.contiguous()
            shapes[k], step = arrays[k].shape, math.prod(shape)
        strides.append(step)
    results = [empty((*lead, *shape)) for shape in code.outputs]
    addresses = [array.data_ptr() for array in (*arrays, *results)]
    own.launch(driver().device(device)[1], stream, shapes, strides, addresses)
    return results
