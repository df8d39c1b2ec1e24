// A stand-in for CUDA's header, for machines without CUDA: the host runs the threads of a kernel one after another. With
// `-I host`, g++ compiles the programs of this folder unchanged.
#pragma once
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "../../../modyn-codegen/tests/cuda_shim.h"

typedef int cudaError_t;
typedef void *cudaStream_t;
enum { cudaSuccess = 0, cudaErrorMemoryAllocation = 2 };
enum cudaMemcpyKind { cudaMemcpyHostToDevice = 1, cudaMemcpyDeviceToHost = 2 };
struct dim3 {
    unsigned int x;
    explicit dim3(unsigned int x) : x(x) {}
};

template <class T> cudaError_t cudaMalloc(T **memory, size_t bytes)
{
    *memory = static_cast<T *>(std::malloc(bytes));
    return *memory ? cudaSuccess : cudaErrorMemoryAllocation;
}

inline cudaError_t cudaFree(void *memory)
{
    std::free(memory);
    return cudaSuccess;
}

inline cudaError_t cudaMemcpy(void *to, const void *from, size_t bytes, cudaMemcpyKind)
{
    std::memcpy(to, from, bytes);
    return cudaSuccess;
}

inline const char *cudaGetErrorString(cudaError_t) { return "out of memory"; }

template <class... A, size_t... I>
void run_threads(void (*kernel)(A...), dim3 blocks, dim3 threads, void **arguments, std::index_sequence<I...>)
{
    blockDim.x = threads.x;
    for (blockIdx.x = 0; blockIdx.x < blocks.x; ++blockIdx.x) {
        for (threadIdx.x = 0; threadIdx.x < threads.x; ++threadIdx.x) {
            kernel(*static_cast<A *>(arguments[I])...);
        }
    }
}

template <class... A>
cudaError_t cudaLaunchKernel(void (*kernel)(A...), dim3 blocks, dim3 threads, void **arguments, size_t, cudaStream_t)
{
    run_threads(kernel, blocks, threads, arguments, std::index_sequence_for<A...>{});
    return cudaSuccess;
}
