"""Checks the library of kernels by its C functions, on arrays of the host: gradients against differences, and forward
dynamics against inverse dynamics. With PyTorch installed, checks its operator as well.

    check.py LIBRARY
"""

import ctypes
import random
import sys

from arm7_torch import FORWARD, GRADIENTS, INVERSE, JOINTS, Kernels, operator

N = 5
kernels = Kernels(sys.argv[1])
random.seed(1)
Array = ctypes.c_float * (JOINTS * N)


def numbers():
    return Array(*(random.uniform(-1, 1) for _ in range(JOINTS * N)))


def run(name, rows, *arguments):
    out = (ctypes.c_float * (rows * N))()
    kernels.run(name, [ctypes.addressof(argument) for argument in arguments], ctypes.addressof(out), N)
    return out


def moved(numbers, state, joint, by):
    """Returns the numbers with that of a joint of a state moved."""
    copy = Array(*numbers)
    copy[joint * N + state] += by
    return copy


q, qd, tau, cotangent = numbers(), numbers(), numbers(), numbers()
qdd = run(FORWARD, JOINTS, q, qd, tau)
back = run(INVERSE, JOINTS, q, qd, qdd)
assert max(abs(a - b) for a, b in zip(back, tau)) < 1e-3
found = run(GRADIENTS, 4 * JOINTS, q, qd, tau, cotangent)
assert max(abs(a - b) for a, b in zip(found, qdd)) < 1e-3 * max(map(abs, qdd))
step = 1e-2
largest = 0
for argument, place in ((0, 1), (1, 2), (2, 3)):
    for state in range(N):
        for joint in range(JOINTS):
            ends = []
            for by in (step, -step):
                arguments = [q, qd, tau]
                arguments[argument] = moved(arguments[argument], state, joint, by)
                out = run(FORWARD, JOINTS, *arguments)
                ends.append(sum(cotangent[j * N + state] * out[j * N + state] for j in range(JOINTS)))
            expected = (ends[0] - ends[1]) / (2 * step)
            gradient = found[(place * JOINTS + joint) * N + state]
            scale = max(abs(found[(place * JOINTS + j) * N + state]) for j in range(JOINTS))
            assert abs(gradient - expected) < 0.02 * (scale + 1), (argument, state, joint, gradient, expected)
            largest = max(largest, abs(gradient))
assert largest > 1
print("the gradients are those of differences")

try:
    import torch
except ImportError:
    print("without PyTorch its operator was not run")
else:
    tensors = [torch.tensor(list(x)).reshape(JOINTS, N).requires_grad_() for x in (q, qd, tau)]
    result = operator(sys.argv[1])(*tensors)
    result.backward(torch.tensor(list(cotangent)).reshape(JOINTS, N))
    for tensor, place in zip(tensors, (1, 2, 3)):
        expected = torch.tensor(list(found[place * JOINTS * N : (place + 1) * JOINTS * N])).reshape(JOINTS, N)
        assert torch.equal(tensor.grad, expected)
    print("PyTorch's gradients are those of the kernels")
