# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Stands in for ament_cmake.
function(ament_package)
  if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/package.xml)
    message(FATAL_ERROR "ament_package: there is no package.xml")
  endif()
endfunction()
