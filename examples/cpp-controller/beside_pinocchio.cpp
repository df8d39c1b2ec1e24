/// The arm by modyn and by Pinocchio, in one program: the largest difference in random states, and the time of a call.
#include <pinocchio/parsers/urdf.hpp>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "arm7.hpp"

namespace {

constexpr int STATES = 200, RUNS = 51;

struct State {
    Eigen::Matrix<double, 7, 1> q, qd, tau;
};

/// The median time of a call for one state, in microseconds.
template <class Call> double time(const std::vector<State> &states, Call call) {
    std::vector<double> times;
    for (int run = 0; run < RUNS; ++run) {
        const auto before = std::chrono::steady_clock::now();
        for (const State &state : states) call(state);
        times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count() / STATES * 1e6);
    }
    std::nth_element(times.begin(), times.begin() + RUNS / 2, times.end());
    return times[RUNS / 2];
}

/// Prints a line of the table. Returns whether the results agree.
template <class Ours, class Theirs> bool compare(const char *name, const std::vector<State> &states, Ours ours, Theirs theirs) {
    double difference = 0, sum = 0;
    for (const State &state : states) {
        const auto expected = theirs(state);
        difference = std::max(difference, (ours(state) - expected).norm() / expected.norm());
    }
    const double by_us = time(states, [&](const State &state) { sum += ours(state)(0, 0); });
    const double by_them = time(states, [&](const State &state) { sum += theirs(state)(0, 0); });
    std::printf("| %s | %.0e | %.3f | %.3f |\n", name, difference, by_us, by_them);
    return difference < 1e-10 && sum == sum;
}

}

int main(int, char **arguments) {
    pinocchio::Model model;
    pinocchio::urdf::buildModel(arguments[1], model);
    pinocchio::Data data(model);
    const pinocchio::FrameIndex hand = model.getFrameId("grasp_point");
    std::srand(1);
    std::vector<State> states(STATES);
    for (State &state : states) state = {State().q.setRandom(), State().q.setRandom(), 20 * State().q.setRandom()};

    std::printf("| | difference | modyn, us | Pinocchio, us |\n|---|---|---|---|\n");
    bool agrees = compare("forward dynamics", states,
        [](const State &s) { return Arm7::forward_dynamics(s.q, s.qd, s.tau); },
        [&](const State &s) -> const Eigen::VectorXd & { return pinocchio::aba(model, data, s.q, s.qd, s.tau); });
    agrees &= compare("inverse dynamics", states,
        [](const State &s) { return Arm7::inverse_dynamics(s.q, s.qd, s.tau); },
        [&](const State &s) -> const Eigen::VectorXd & { return pinocchio::rnea(model, data, s.q, s.qd, s.tau); });
    agrees &= compare("mass matrix", states,
        [](const State &s) { return Arm7::mass_matrix(s.q); },
        [&](const State &s) -> const Eigen::MatrixXd & {
            pinocchio::crba(model, data, s.q);
            data.M.triangularView<Eigen::StrictlyLower>() = data.M.transpose().triangularView<Eigen::StrictlyLower>();
            return data.M;
        });
    Eigen::Matrix<double, 6, Eigen::Dynamic> theirs(6, 7);
    agrees &= compare("Jacobian of the hand", states,
        [](const State &s) { return Arm7::jacobian(s.q, Arm7::Link::grasp_point); },
        [&](const State &s) -> const Eigen::Matrix<double, 6, Eigen::Dynamic> & {
            pinocchio::computeFrameJacobian(model, data, s.q, hand, pinocchio::LOCAL_WORLD_ALIGNED, theirs);
            return theirs;
        });
    return agrees ? 0 : 1;
}
