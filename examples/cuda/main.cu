// Accelerations of 100,000 states of the 7-joint arm, and the joint forces of these accelerations: the same as at first.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "launch.cu"

static void check(int error)
{
    if (error != cudaSuccess) {
        std::fprintf(stderr, "CUDA: %s\n", cudaGetErrorString(static_cast<cudaError_t>(error)));
        std::exit(1);
    }
}

// Memory on the device for several numbers of each state.
struct Array {
    float *numbers = nullptr;
    size_t bytes;

    explicit Array(size_t count) : bytes(count * sizeof(float)) { check(cudaMalloc(&numbers, bytes)); }
    explicit Array(const std::vector<float> &from) : Array(from.size())
    {
        check(cudaMemcpy(numbers, from.data(), bytes, cudaMemcpyHostToDevice));
    }
    Array(const Array &) = delete;
    ~Array() { cudaFree(numbers); }

    // Waits until the numbers are computed.
    std::vector<float> read() const
    {
        std::vector<float> copy(bytes / sizeof(float));
        check(cudaMemcpy(copy.data(), numbers, bytes, cudaMemcpyDeviceToHost));
        return copy;
    }
};

int main()
{
    const unsigned int n = 100000;
    std::vector<float> states[3];
    unsigned long long seed = 1;
    for (auto &numbers : states) {
        for (unsigned int i = 0; i < 7 * n; ++i) {
            seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
            numbers.push_back(static_cast<float>(seed >> 40) / 8388608.0f - 1.0f);
        }
    }
    const Array q(states[0]), qd(states[1]), tau(states[2]), qdd(7 * n), back(7 * n);
    check(arm7_run_forward_dynamics(q.numbers, qd.numbers, tau.numbers, qdd.numbers, n, 0));
    check(arm7_run_inverse_dynamics(q.numbers, qd.numbers, qdd.numbers, back.numbers, n, 0));

    const std::vector<float> found = back.read(), accelerations = qdd.read();
    float worst = 0, fastest = 0;
    for (unsigned int i = 0; i < 7 * n; ++i) {
        worst = std::fmax(worst, std::fabs(found[i] - states[2][i]));
        fastest = std::fmax(fastest, std::fabs(accelerations[i]));
    }
    std::printf("%u states, accelerations up to %g rad/s^2; the joint forces differ by at most %g N m\n", n, fastest, worst);
    return worst < 1e-3f && fastest > 1 ? 0 : 1;
}
