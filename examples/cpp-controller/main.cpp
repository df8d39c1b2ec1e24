/// The arm at 1 kHz under an impedance controller: its hand follows a circle, then it is pushed.
#define EIGEN_RUNTIME_NO_MALLOC
#include <chrono>
#include <cmath>
#include <cstdio>

#include "impedance.hpp"

namespace {

constexpr double DT = 1e-3, RADIUS = 0.08, FREQUENCY = 0.5, PI = 3.14159265358979323846;

/// The target at a time, on a circle through the pose at the start.
ImpedanceController::Target circle(const Arm7::Pose &start, double time) {
    const double speed = 2 * PI * FREQUENCY, angle = speed * time;
    ImpedanceController::Target target{start, RADIUS * speed * Eigen::Vector3d(0, std::cos(angle), std::sin(angle))};
    target.pose.translation += RADIUS * Eigen::Vector3d(0, std::sin(angle), 1 - std::cos(angle));
    return target;
}

}

int main() {
    Arm7::Vector<7> q;
    q << 0, -0.4, 0, -2.1, 0, 1.8, 0.8;
    Arm7::Vector<7> qd = Arm7::Vector<7>::Zero();
    const Arm7::Pose start = Arm7::link_pose(q, Arm7::Link::grasp_point);
    const ImpedanceController::Gains gains;
    const ImpedanceController controller(gains);
    const Eigen::Vector3d push(12, -9, 6);
    std::array<Arm7::Wrench, Arm7::links> wrenches;
    for (auto &wrench : wrenches) wrench.moment.setZero(), wrench.force.setZero();
    double largest = 0, in_controller = 0;

    Eigen::internal::set_is_malloc_allowed(false);
    for (int tick = 0; tick < 8000; ++tick) {
        const double time = tick * DT;
        // Two turns of the circle, then a push at the start of the circle.
        const ImpedanceController::Target target = time < 4 ? circle(start, time) : ImpedanceController::Target{start};
        const Arm7::Pose hand = Arm7::link_pose(q, Arm7::Link::grasp_point);
        if (time < 4) largest = std::fmax(largest, (hand.translation - target.pose.translation).norm());
        const std::size_t pushed = static_cast<std::size_t>(Arm7::Link::grasp_point);
        wrenches[pushed].force = hand.rotation.transpose() * (time < 4 ? Eigen::Vector3d::Zero().eval() : push);

        const auto before = std::chrono::steady_clock::now();
        const Arm7::Vector<7> tau = controller.torques(q, qd, target);
        in_controller += std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();

        qd += DT * Arm7::forward_dynamics_external_local(q, qd, tau, wrenches);
        q = Arm7::integrate(q, DT * qd);
    }
    Eigen::internal::set_is_malloc_allowed(true);

    // At rest, the spring balances the push.
    const Eigen::Vector3d moved = Arm7::link_pose(q, Arm7::Link::grasp_point).translation - start.translation;
    const double wrong = (gains.stiffness * moved - push).norm() / push.norm();
    std::printf("on the circle at most %.1f mm off; the push of %.1f N moves the hand by %.2f mm\n", 1e3 * largest, push.norm(),
                1e3 * moved.norm());
    std::fprintf(stderr, "%.2f us a call of the controller\n", in_controller / 8000 * 1e6);
    return largest < 0.011 && wrong < 1e-3 ? 0 : 1;
}
