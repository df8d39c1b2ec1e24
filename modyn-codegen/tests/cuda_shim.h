// CUDA's keywords and variables for a compiler of the host: a thread after another.
#define __global__
#define __device__
#define __forceinline__ inline
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(...)
static struct {
    unsigned int x;
} blockIdx, blockDim, threadIdx;
