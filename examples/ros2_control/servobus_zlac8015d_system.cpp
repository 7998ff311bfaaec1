// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Exports the hardware interface as the plugin that servobus_hardware.xml describes.
#include "servobus_zlac8015d_system.hpp"

#include "pluginlib/class_list_macros.hpp"

PLUGINLIB_EXPORT_CLASS(servobus_ros2_control::Zlac8015dSystem, hardware_interface::SystemInterface)
