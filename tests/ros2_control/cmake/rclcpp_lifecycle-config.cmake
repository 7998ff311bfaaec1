# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Stands in for the package's target.
add_library(rclcpp_lifecycle::rclcpp_lifecycle INTERFACE IMPORTED)
target_include_directories(rclcpp_lifecycle::rclcpp_lifecycle INTERFACE ${CMAKE_CURRENT_LIST_DIR}/../../ports/stubs/ros2)
