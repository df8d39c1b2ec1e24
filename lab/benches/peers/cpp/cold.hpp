// Calls whose code and data are in no cache, as ../modyn-runner/src/cold.rs measures them: between two calls, every line of
// the process's memory is flushed from all levels of the caches.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace cold {

// The number of calls.
constexpr std::size_t CALLS = 401;

using Mapping = std::pair<std::uintptr_t, std::uintptr_t>;

// The readable mappings of this process, without the pages of the kernel, which the clock reads.
inline std::vector<Mapping> mappings() {
    std::vector<Mapping> found;
    std::ifstream file("/proc/self/maps");
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::uintptr_t begin, end;
        char dash;
        std::string access, offset, device, node, name;
        words >> std::hex >> begin >> dash >> end >> access >> offset >> device >> node >> name;
        if (access[0] == 'r' && name.rfind("[v", 0) != 0) found.emplace_back(begin, end);
    }
    return found;
}

// Flushes the mappings from all caches.
inline void flush(const std::vector<Mapping> &mappings) {
#ifdef __x86_64__
    for (const auto &[begin, end] : mappings)
        for (std::uintptr_t address = begin; address < end; address += 64)
            _mm_clflush(reinterpret_cast<const void *>(address));
    _mm_mfence();
#else
    (void)mappings;
#endif
}

// The times of the calls, ns, in ascending order.
template <class Call> std::vector<double> times(const std::vector<Mapping> &mappings, std::size_t states, Call call) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> times;
    times.reserve(CALLS);
    for (std::size_t i = 0; i < CALLS; ++i) {
        flush(mappings);
        // The code of the clock is in the caches again.
        Clock::time_point start = Clock::now();
        asm volatile("" ::"r"(&start) : "memory");
        start = Clock::now();
        asm volatile("" ::"r"(&start) : "memory");
        start = Clock::now();
        call(i % states);
        asm volatile("" ::: "memory");
        times.push_back(std::chrono::duration<double, std::nano>(Clock::now() - start).count());
    }
    std::sort(times.begin(), times.end());
    return times;
}

// Prints the median, the 99th percentile and the largest time of a call with empty caches, ns, each less the median time of the
// clock; nothing on other processors than x86-64 and other systems than Linux.
template <class Call> void print(std::size_t states, Call call) {
#ifdef __x86_64__
    const std::vector<Mapping> all = mappings();
    if (all.empty()) return;
    const double clock = times(all, states, [](std::size_t) {})[CALLS / 2];
    const std::vector<double> found = times(all, states, call);
    std::printf("cold %g\ncold_99 %g\ncold_most %g\n", found[CALLS / 2] - clock, found[CALLS * 99 / 100] - clock,
                found[CALLS - 1] - clock);
#else
    (void)states, (void)call;
#endif
}

} // namespace cold
