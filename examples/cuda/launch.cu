// Functions of C that start the kernels of the 7-joint arm on a stream: a library for C++ (main.cu) and for Python
// (arm7_torch.py). All pointers are to the device's memory, structures of arrays: scalar j of state i of n is number j n + i.
// The functions return CUDA's error, 0 without one, and do not wait.
#include <cuda_runtime.h>

#include "arm7_kernels.cu"

// The kernels have at most 128 threads a block.
template <class... Parameters, class... Arguments>
static int launch(void (*kernel)(Parameters...), unsigned int n, cudaStream_t stream, Arguments... arguments)
{
    if (n == 0) return cudaSuccess;
    void *all[] = {&arguments..., &n};
    return cudaLaunchKernel(kernel, dim3((n + 127) / 128), dim3(128), all, 0, stream);
}

extern "C" int arm7_run_forward_dynamics(const float *q, const float *qd, const float *tau, float *qdd, unsigned int n,
                                         cudaStream_t stream)
{
    return launch(arm7_forward_dynamics, n, stream, q, qd, tau, qdd);
}

extern "C" int arm7_run_inverse_dynamics(const float *q, const float *qd, const float *qdd, float *tau, unsigned int n,
                                         cudaStream_t stream)
{
    return launch(arm7_inverse_dynamics, n, stream, q, qd, qdd, tau);
}

// `out`: the accelerations, then the gradients of cotangent^T qdd by q, qd and tau; 7 numbers each.
extern "C" int arm7_run_forward_dynamics_vjp(const float *q, const float *qd, const float *tau, const float *cotangent,
                                             float *out, unsigned int n, cudaStream_t stream)
{
    return launch(arm7_forward_dynamics_vjp, n, stream, q, qd, tau, cotangent, out);
}
