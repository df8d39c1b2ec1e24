/// The arm's problem of arm.py by aligator, which wraps Crocoddyl's action models as stage models.
#include <aligator/compat/crocoddyl/problem-wrap.hpp>
#include <aligator/solvers/proxddp/solver-proxddp.hpp>

#include <cmath>
#include <cstdio>

#include "reach.hpp"

int main() {
    constexpr int KNOTS = 30;
    constexpr Weights RUNNING{10, 1, 1e-2, 1e-2, 1e-4, 1e2}, LAST{1e2, 1e1, 1e-2, 1, 0, 1e2};
    Vector7 posture, goal, lower, upper;
    posture << 0, -0.785, 0, -2.356, 0, 1.571, 0.785;
    goal << 0.5, -0.2, -0.2, -1.9, 0.3, 2.0, 0.5;
    lower << -2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973;
    upper << 2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973;
    const Arm7::Pose pose = Arm7::link_pose(goal, HAND);
    const Task task{pose.translation, pose.rotation, posture, Arm7::bias_forces(posture, Vector7::Zero()), lower, upper};
    const auto state = std::make_shared<modyn::State<Arm7>>();
    const auto make = [&](double dt, const Weights &weights) {
        return std::make_shared<modyn::ActionModel<Arm7, ReachCost>>(state, std::make_shared<ReachCost>(task, weights), dt);
    };
    Eigen::VectorXd start = Eigen::VectorXd::Zero(14);
    start.head<7>() = posture;
    const auto problem = std::make_shared<crocoddyl::ShootingProblem>(
        start, std::vector<std::shared_ptr<crocoddyl::ActionModelAbstract>>(KNOTS, make(0.02, RUNNING)), make(0, LAST));

    auto wrapped = aligator::compat::croc::convertCrocoddylProblem<double>(problem);
    aligator::SolverProxDDPTpl<double> solver(1e-7, 1e-6, 200);
    solver.rollout_type_ = aligator::RolloutType::NONLINEAR;
    solver.setNumThreads(1);
    solver.setup(wrapped);
    const bool converged = solver.run(wrapped, std::vector<Eigen::VectorXd>(KNOTS + 1, start), std::vector<Eigen::VectorXd>(KNOTS, task.torques));
    std::printf("aligator: cost %.12f, %zu iterations\n", solver.results_.traj_cost_, solver.results_.num_iters);
    return converged && std::abs(solver.results_.traj_cost_ - 0.093943507097) < 1e-8 ? 0 : 1;
}
