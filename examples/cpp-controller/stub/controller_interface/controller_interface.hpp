// The part of ros2_control's interface that the controller uses, to compile it where ROS is not installed.
#ifndef STUB_CONTROLLER_INTERFACE_HPP
#define STUB_CONTROLLER_INTERFACE_HPP

#include <optional>
#include <string>
#include <vector>

namespace rclcpp {
class Time {};
class Duration {};
}

namespace rclcpp_lifecycle {
class State {};
}

namespace hardware_interface {
class LoanedCommandInterface {
public:
    [[nodiscard]] bool set_value(double value);
};
class LoanedStateInterface {
public:
    std::optional<double> get_optional() const;
};
}

namespace controller_interface {
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };

struct InterfaceConfiguration {
    interface_configuration_type type;
    std::vector<std::string> names;
};

class ControllerInterface {
public:
    virtual ~ControllerInterface() = default;
    virtual CallbackReturn on_init() = 0;
    virtual InterfaceConfiguration command_interface_configuration() const = 0;
    virtual InterfaceConfiguration state_interface_configuration() const = 0;
    virtual return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;
    virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &previous_state);

protected:
    std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
    std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
};
}

#endif
