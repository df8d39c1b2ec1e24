"""Forward dynamics of the 7-joint arm on tensors of PyTorch, with gradients: `forward_dynamics(q, qd, tau)`.

The kernels are a library of C functions, which `run` beside this file builds; `ctypes` calls it with the addresses of the
tensors. So there is one build for all versions of PyTorch. Tensors are (7, n), in single precision, on one device: a state is
a column.
"""

import ctypes
import os
from pathlib import Path

JOINTS = 7
FORWARD, INVERSE, GRADIENTS = "forward_dynamics", "inverse_dynamics", "forward_dynamics_vjp"


class Kernels:
    """The library, called by addresses: of the arguments, of the result, and of a stream."""

    def __init__(self, path):
        self.library = ctypes.CDLL(os.fspath(path))
        for name, arguments in ((FORWARD, 3), (INVERSE, 3), (GRADIENTS, 4)):
            function = getattr(self.library, f"arm7_run_{name}")
            function.argtypes = [ctypes.c_void_p] * (arguments + 1) + [ctypes.c_uint, ctypes.c_void_p]
            function.restype = ctypes.c_int

    def run(self, name, arguments, out, n, stream=None):
        """Starts a kernel for n states."""
        error = getattr(self.library, f"arm7_run_{name}")(*arguments, out, n, stream)
        if error != 0:
            raise RuntimeError(f"CUDA's error {error} in `{name}`")


def operator(path=Path(__file__).with_name("libarm7.so")):
    """Returns `forward_dynamics(q, qd, tau)`, a function of tensors that PyTorch can differentiate."""
    import torch

    kernels = Kernels(path)

    def run(name, rows, *tensors):
        first = tensors[0]
        for tensor in tensors:
            if tensor.shape != first.shape or tensor.shape[0] != JOINTS or tensor.dim() != 2:
                raise ValueError(f"tensors are ({JOINTS}, n), not {tuple(tensor.shape)}")
            if tensor.dtype != torch.float32 or tensor.device != first.device:
                raise ValueError("tensors are of float32, on one device")
        tensors = [tensor.contiguous() for tensor in tensors]
        out = torch.empty((rows, first.shape[1]), dtype=first.dtype, device=first.device)
        on_device = first.device.type == "cuda"
        stream = torch.cuda.current_stream(first.device).cuda_stream if on_device else None
        kernels.run(name, [tensor.data_ptr() for tensor in tensors], out.data_ptr(), first.shape[1], stream)
        return out

    class ForwardDynamics(torch.autograd.Function):
        @staticmethod
        def forward(ctx, q, qd, tau):
            ctx.save_for_backward(q, qd, tau)
            return run(FORWARD, JOINTS, q, qd, tau)

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx, cotangent):
            out = run(GRADIENTS, 4 * JOINTS, *ctx.saved_tensors, cotangent)
            return out[7:14], out[14:21], out[21:28]

    return ForwardDynamics.apply
