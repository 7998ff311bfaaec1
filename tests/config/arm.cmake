# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# A Cortex-M0+ without an operating system: for the label "compile", since nothing is linked.
set(CMAKE_SYSTEM_NAME Generic CACHE STRING "")
set(CMAKE_SYSTEM_PROCESSOR arm CACHE STRING "")
set(CMAKE_CXX_COMPILER arm-none-eabi-g++ CACHE STRING "")
set(CMAKE_CXX_FLAGS "-mcpu=cortex-m0plus -mthumb -fno-exceptions -fno-rtti" CACHE STRING "")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY CACHE STRING "")
set(SERVOBUS_EXAMPLES OFF CACHE BOOL "")
