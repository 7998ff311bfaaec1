# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Stands in for the package's target.
add_library(hardware_interface::hardware_interface INTERFACE IMPORTED)
target_include_directories(hardware_interface::hardware_interface INTERFACE ${CMAKE_CURRENT_LIST_DIR}/../../ports/stubs/ros2_humble)
