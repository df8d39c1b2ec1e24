// The names of interfaces, as ros2_control has them.
#ifndef STUB_HARDWARE_INTERFACE_TYPE_VALUES_HPP
#define STUB_HARDWARE_INTERFACE_TYPE_VALUES_HPP

namespace hardware_interface {
constexpr char HW_IF_POSITION[] = "position";
constexpr char HW_IF_VELOCITY[] = "velocity";
constexpr char HW_IF_EFFORT[] = "effort";
}

#endif
