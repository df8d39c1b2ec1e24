// Functions of C around the kernels that GRiD has generated (`grid.cuh`), for cuda.py. The states are rows q, qd, u.
#include "grid.cuh"

extern "C" void *grid_model()
{
    grid::init_grid<float>();
    return grid::init_robotModel<float>();
}

extern "C" void grid_forward_dynamics(const float *states, float *qdd, void *model, int n)
{
    const size_t shared = grid::FD_DYNAMIC_SHARED_MEM_COUNT * sizeof(float);
    grid::forward_dynamics_kernel<float><<<n, grid::SUGGESTED_THREADS, shared>>>(
        qdd, states, 3 * grid::NUM_JOINTS, static_cast<grid::robotModel<float> *>(model), 9.81f, n);
}

// `gradient`: the derivatives by q, then by qd; matrices by columns.
extern "C" void grid_forward_dynamics_derivatives(const float *states, float *gradient, void *model, int n)
{
    const size_t shared = grid::FD_DU_DYNAMIC_SHARED_MEM_COUNT * sizeof(float);
    grid::forward_dynamics_gradient_kernel<float><<<n, grid::SUGGESTED_THREADS, shared>>>(
        gradient, states, 3 * grid::NUM_JOINTS, static_cast<grid::robotModel<float> *>(model), 9.81f, n);
}
