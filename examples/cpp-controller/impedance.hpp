/// A controller of the 7-joint arm: the hand is held at a pose by springs and dampers in the world's axes.
#ifndef IMPEDANCE_HPP
#define IMPEDANCE_HPP

#include <Eigen/Geometry>

#include "arm7.hpp"

class ImpedanceController {
public:
    /// The stiffness and damping of displacements (N/m, N s/m) and rotations (N m, N m s), and the damping of joints, N m s.
    struct Gains {
        double stiffness = 600, damping = 60;
        double angular_stiffness = 40, angular_damping = 4;
        double joint_damping = 0.5;
    };

    /// Where the hand should be, and how fast it should move.
    struct Target {
        Arm7::Pose pose;
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    };

    explicit ImpedanceController(const Gains &gains) : gains(gains) {}

    /// Returns the joint torques, N m. The gravity and the Coriolis forces of the arm are balanced.
    Arm7::Vector<7> torques(const Arm7::VectorRef<7> &q, const Arm7::VectorRef<7> &qd, const Target &target) const noexcept {
        const Arm7::Pose hand = Arm7::link_pose(q, Arm7::Link::grasp_point);
        const Arm7::Matrix<6, 7> jacobian = Arm7::jacobian(q, Arm7::Link::grasp_point);
        const Eigen::Matrix<double, 6, 1> velocity = jacobian * qd;
        const Eigen::AngleAxisd turn(Eigen::Matrix3d(target.pose.rotation * hand.rotation.transpose()));
        Eigen::Matrix<double, 6, 1> wrench;
        wrench << gains.stiffness * (target.pose.translation - hand.translation) + gains.damping * (target.velocity - velocity.head<3>()),
            gains.angular_stiffness * turn.angle() * turn.axis() - gains.angular_damping * velocity.tail<3>();
        return jacobian.transpose() * wrench + Arm7::bias_forces(q, qd) - gains.joint_damping * qd;
    }

private:
    Gains gains;
};

#endif
