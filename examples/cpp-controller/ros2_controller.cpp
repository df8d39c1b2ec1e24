/// The impedance controller as a plugin of ros2_control (ROS 2 Jazzy or later). It holds the hand where it was at activation.
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "impedance.hpp"
#include "pluginlib/class_list_macros.hpp"

namespace arm7_controllers {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;

class HoldPose : public controller_interface::ControllerInterface {
public:
    CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }

    InterfaceConfiguration command_interface_configuration() const override {
        return {interface_configuration_type::INDIVIDUAL, of_joints({hardware_interface::HW_IF_EFFORT})};
    }

    /// The positions of all joints, then their velocities.
    InterfaceConfiguration state_interface_configuration() const override {
        return {interface_configuration_type::INDIVIDUAL,
                of_joints({hardware_interface::HW_IF_POSITION, hardware_interface::HW_IF_VELOCITY})};
    }

    CallbackReturn on_activate(const rclcpp_lifecycle::State &) override {
        if (!read()) return CallbackReturn::ERROR;
        target.pose = Arm7::link_pose(q, Arm7::Link::grasp_point);
        return CallbackReturn::SUCCESS;
    }

    controller_interface::return_type update(const rclcpp::Time &, const rclcpp::Duration &) override {
        if (!read()) return controller_interface::return_type::ERROR;
        const Arm7::Vector<Arm7::nv> tau = controller.torques(q, qd, target);
        for (int joint = 0; joint < Arm7::nv; ++joint)
            if (!command_interfaces_[static_cast<std::size_t>(joint)].set_value(tau[joint]))
                return controller_interface::return_type::ERROR;
        return controller_interface::return_type::OK;
    }

private:
    static std::vector<std::string> of_joints(const std::vector<std::string> &interfaces) {
        std::vector<std::string> names;
        for (const std::string &interface : interfaces)
            for (const char *joint : arm7_q_names) names.push_back(std::string(joint) + "/" + interface);
        return names;
    }

    /// Reads the state of the joints. Returns false where an interface has no value.
    bool read() {
        for (int joint = 0; joint < Arm7::nv; ++joint) {
            const auto position = state_interfaces_[static_cast<std::size_t>(joint)].get_optional();
            const auto velocity = state_interfaces_[static_cast<std::size_t>(Arm7::nv + joint)].get_optional();
            if (!position || !velocity) return false;
            q[joint] = *position;
            qd[joint] = *velocity;
        }
        return true;
    }

    ImpedanceController controller{ImpedanceController::Gains()};
    ImpedanceController::Target target;
    Arm7::Vector<Arm7::nq> q;
    Arm7::Vector<Arm7::nv> qd;
};

}

PLUGINLIB_EXPORT_CLASS(arm7_controllers::HoldPose, controller_interface::ControllerInterface)
