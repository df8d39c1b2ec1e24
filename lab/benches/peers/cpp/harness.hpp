// Checking and timing, as ../modyn-runner/src/measure.rs does it: every contender in C or C++ reads
// its states here, and ends in `run`.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cold.hpp"

using Numbers = std::vector<double>;

struct State {
    Numbers q, qd, tau, qdd;
};

// A robot's joints in modyn's order, which is that of the states; a floating base is the first.
struct Joints {
    std::size_t nq, nv;
    std::vector<std::string> names;

    Joints(const std::string &folder, const std::string &robot) {
        std::ifstream model(folder + "/" + robot + ".model");
        model >> nq >> nv;
        for (std::string joint; model >> joint;) names.push_back(joint);
    }

    bool floating() const { return nq != nv; }
};

// FOLDER ROBOT QUANTITY REPETITIONS, and the files that `modyn-runner states` has written for them.
struct Job {
    std::string folder, robot, quantity;
    std::size_t repetitions;
    Joints joints;
    std::vector<State> states;
    Numbers reference;

    Job(int count, char **arguments)
        : folder(argument(count, arguments, 1)), robot(argument(count, arguments, 2)),
          quantity(argument(count, arguments, 3)),
          repetitions(std::stoul(argument(count, arguments, 4))), joints(folder, robot) {
        const Numbers all = numbers(file("states"));
        for (auto next = all.begin(); next != all.end();) {
            const auto take = [&](std::size_t n) {
                const auto begin = std::exchange(next, next + n);
                return Numbers(begin, next);
            };
            State state;
            state.q = take(joints.nq), state.qd = take(joints.nv);
            state.tau = take(joints.nv), state.qdd = take(joints.nv);
            states.push_back(state);
        }
        reference = numbers(file(quantity));
    }

    static std::string argument(int count, char **arguments, int k) {
        if (k >= count) throw std::runtime_error("FOLDER ROBOT QUANTITY REPETITIONS ...");
        return arguments[k];
    }

  private:
    std::string file(const std::string &extension) const {
        return folder + "/" + robot + "." + extension;
    }

    static Numbers numbers(const std::string &path) {
        std::ifstream file(path, std::ios::binary);
        if (!file) throw std::runtime_error("no " + path);
        const std::string bytes{std::istreambuf_iterator<char>(file), {}};
        Numbers numbers(bytes.size() / sizeof(double));
        std::copy_n(bytes.data(), numbers.size() * sizeof(double),
                    reinterpret_cast<char *>(numbers.data()));
        return numbers;
    }
};

// The results at the first states are compared with modyn's interpreter's.
constexpr std::size_t CHECKED = 64;

template <class Result> void check(const Job &job, Result result) {
    double error = 0;
    const std::size_t size = job.reference.size() / CHECKED;
    for (std::size_t i = 0; i < CHECKED; ++i) {
        const Numbers got = result(i);
        if (got.size() != size) throw std::runtime_error("a result's size");
        const double *expected = &job.reference[i * size];
        double scale = 1;
        for (std::size_t k = 0; k < size; ++k) scale = std::max(scale, std::abs(expected[k]));
        for (std::size_t k = 0; k < size; ++k) {
            const double difference = std::abs(got[k] - expected[k]) / scale;
            error = std::isfinite(difference) ? std::max(error, difference) : INFINITY;
        }
    }
    std::printf("error %g\n", error);
    if (!(error < 1e-8)) std::exit(1);
}

// The median of the repetitions, ns a call; `call(i)` computes at state i.
template <class Call> void time(const Job &job, Call call) {
    using Clock = std::chrono::steady_clock;
    const auto seconds = [](Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    };
    const auto pass = [&] {
        for (std::size_t i = 0; i < job.states.size(); ++i) {
            call(i);
            asm volatile("" ::: "memory");
        }
    };
    const auto warm = Clock::now();
    std::size_t passes = 0;
    for (; seconds(warm) < 20e-3; ++passes) pass();
    passes = std::max(1.0, std::ceil(4e-3 * passes / seconds(warm)));
    Numbers times;
    for (std::size_t k = 0; k < job.repetitions; ++k) {
        const auto start = Clock::now();
        for (std::size_t n = 0; n < passes; ++n) pass();
        times.push_back(seconds(start) * 1e9 / (passes * job.states.size()));
    }
    std::sort(times.begin(), times.end());
    std::printf("ns %g\n", times[times.size() / 2]);
}

// `call(i)` computes at state i, `result(i)` returns the result in modyn's order and by columns.
template <class Call, class Result> void run(const Job &job, Call call, Result result) {
    check(job, [&](std::size_t i) {
        call(i);
        return result(i);
    });
    time(job, call);
    cold::print(job.states.size(), call);
}
