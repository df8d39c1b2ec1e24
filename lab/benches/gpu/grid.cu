// Functions of C around the kernels that GRiD has generated (the file `GRID`), for libraries.py.
//
// A state is three rows of `NUM_POS` numbers, for q, qd and tau. Accelerations are such rows, too; derivatives of accelerations are
// two matrices by columns, by q and by qd. `kernel` is 0 for `forward_dynamics_kernel`, 1 for `aba_kernel`, and 2 for
// `forward_dynamics_gradient_kernel`. `tier` says how much of its memory is shared: 0 for all, 1 and 2 for less.
#include GRID

using Model = grid::robotModel<float>;

struct Kernel
{
    void (*run)(float *, unsigned char *, const float *, int, float *, const Model *, float, int);
    size_t shared;
    int threads;
};

template <int TIER>
static Kernel of_tier(int kernel)
{
    const int threads = grid::tier_max_threads<TIER>();
    if (kernel == 0)
        return {&grid::forward_dynamics_kernel<float, TIER>, grid::FORWARD_DYNAMICS_DYNAMIC_SHARED_MEM_BYTES<float, TIER>(), threads};
    if (kernel == 1)
        return {&grid::aba_kernel<float, TIER>, grid::ABA_DYNAMIC_SHARED_MEM_BYTES<float, TIER>(), threads};
    const size_t shared = grid::FORWARD_DYNAMICS_GRADIENT_DYNAMIC_SHARED_MEM_BYTES<float, TIER>();
    return {&grid::forward_dynamics_gradient_kernel<float, TIER>, shared, threads};
}

static Kernel find(int kernel, int tier)
{
    return tier == 0 ? of_tier<0>(kernel) : tier == 1 ? of_tier<1>(kernel) : of_tier<2>(kernel);
}

extern "C" void *grid_model()
{
    return grid::init_robotModel<float>();
}

// Returns the bytes of global memory that a block of threads needs.
extern "C" size_t grid_workspace()
{
    return grid::GRID_WORKSPACE_BYTES_PER_TIMESTEP<float>();
}

// Asks the cache to keep the workspace, as GRiD's own functions do for derivatives; with 0 bytes no longer.
extern "C" int grid_keep(void *workspace, size_t bytes)
{
    return bytes ? grid::grid_begin_l2_persisting(0, workspace, bytes) : grid::grid_end_l2_persisting(0);
}

// Prepares a kernel, and returns the largest number of threads of its blocks, or 0 if this processor cannot run it.
extern "C" int grid_threads(int kernel, int tier)
{
    const Kernel own = find(kernel, tier);
    const cudaError_t error = cudaFuncSetAttribute(own.run, cudaFuncAttributeMaxDynamicSharedMemorySize, int(own.shared));
    cudaFuncAttributes found;
    if (error != cudaSuccess || cudaFuncGetAttributes(&found, own.run) != cudaSuccess)
    {
        cudaGetLastError();
        return 0;
    }
    return own.threads < found.maxThreadsPerBlock ? own.threads : found.maxThreadsPerBlock;
}

// Starts a kernel, and returns the error of the start, or 0. Gravity has the sign of GRiD's Python package: negative is down.
extern "C" int grid_run(int kernel, int tier, int threads, int blocks, const float *states, float *out, unsigned char *workspace,
                        const Model *model, int n)
{
    const Kernel own = find(kernel, tier);
    own.run<<<blocks, threads, own.shared>>>(out, workspace, states, 3 * grid::NUM_POS, nullptr, model, -9.81f, n);
    return cudaGetLastError();
}
