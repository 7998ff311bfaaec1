# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# A stand-in for the script by which ESP-IDF finds out, before it builds, what a component requires: it runs the
# component's CMakeLists.txt without a project, and ends it at idf_component_register.
set(ESP_PLATFORM 1)
macro(idf_component_register)
  message(STATUS "registered: ${ARGN}")
  return()
endmacro()
include(${COMPONENT}/CMakeLists.txt)
