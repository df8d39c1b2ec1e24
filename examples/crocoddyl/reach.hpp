/// A cost in C++ for the arm: its hand at a pose.
#ifndef REACH_HPP
#define REACH_HPP

#include "arm7.hpp"
#include "modyn_crocoddyl.hpp"

constexpr auto HAND = Arm7::Link::grasp_point;
using Vector7 = Eigen::Matrix<double, 7, 1>;

/// The hand's goal, and the posture and torques to stay close to.
struct Task {
    Eigen::Vector3d place;
    Eigen::Matrix3d rotation;
    Vector7 posture, torques, lower, upper;
};

struct Weights {
    double place, turn, posture, velocity, control, limit;
};

/// A cost with matrices of fixed sizes: the hand at a pose, soft joint limits, small velocities. Crocoddyl calls `calc` before
/// `calcDiff`.
class ReachCost {
public:
    ReachCost(const Task &task, const Weights &weights) : task(task), weights(weights) {}

    struct Data {
        double cost = 0;
        Eigen::Matrix<double, 14, 1> Lx;
        Vector7 Lu;
        Eigen::Matrix<double, 14, 14> Lxx = Eigen::Matrix<double, 14, 14>::Zero();
        Eigen::Matrix<double, 14, 7> Lxu = Eigen::Matrix<double, 14, 7>::Zero();
        Eigen::Matrix<double, 7, 7> Luu = Eigen::Matrix<double, 7, 7>::Zero();
        Eigen::Matrix3d rotation, error;
        Eigen::Vector3d place, turn;
        Vector7 posture, outside;
    };

    std::shared_ptr<Data> createData(crocoddyl::DataCollectorAbstract *) const { return std::make_shared<Data>(); }

    void calc(const std::shared_ptr<Data> &d, const modyn::VectorIn &x) const {
        const Arm7::Pose hand = Arm7::link_pose(x.head<7>(), HAND);
        d->rotation = hand.rotation;
        d->error = task.rotation.transpose() * d->rotation;
        d->place = hand.translation - task.place;
        d->turn = pinocchio::log3(d->error);
        d->posture = x.head<7>() - task.posture;
        d->outside = (x.head<7>() - task.upper).cwiseMax(0) + (x.head<7>() - task.lower).cwiseMin(0);
        d->cost = 0.5 * (weights.place * d->place.squaredNorm() + weights.turn * d->turn.squaredNorm() + weights.posture * d->posture.squaredNorm()
                         + weights.velocity * x.tail<7>().squaredNorm() + weights.limit * d->outside.squaredNorm());
    }

    void calc(const std::shared_ptr<Data> &d, const modyn::VectorIn &x, const modyn::VectorIn &u) const {
        calc(d, x);
        d->cost += 0.5 * weights.control * (u - task.torques).squaredNorm();
    }

    void calcDiff(const std::shared_ptr<Data> &d, const modyn::VectorIn &x) const {
        const Arm7::Matrix<6, 7> jacobian = Arm7::jacobian(x.head<7>(), HAND);
        Eigen::Matrix3d log = Eigen::Matrix3d::Zero();
        pinocchio::Jlog3(d->error, log);
        const Eigen::Matrix<double, 3, 7> place = jacobian.topRows<3>(), turn = log * d->rotation.transpose() * jacobian.bottomRows<3>();
        d->Lx << weights.place * place.transpose() * d->place + weights.turn * turn.transpose() * d->turn + weights.posture * d->posture
                     + weights.limit * d->outside,
            weights.velocity * x.tail<7>();
        d->Lxx.topLeftCorner<7, 7>() = weights.place * place.transpose() * place + weights.turn * turn.transpose() * turn;
        d->Lxx.diagonal().head<7>().array() += weights.posture + weights.limit * (d->outside.array() != 0).cast<double>();
        d->Lxx.diagonal().tail<7>().setConstant(weights.velocity);
    }

    void calcDiff(const std::shared_ptr<Data> &d, const modyn::VectorIn &x, const modyn::VectorIn &u) const {
        calcDiff(d, x);
        d->Lu = weights.control * (u - task.torques);
        d->Luu.diagonal().setConstant(weights.control);
    }

private:
    Task task;
    Weights weights;
};

#endif
