# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# A big-endian host, in an emulator: the rooms that store bytes and words. Those above them know numbers only.
set(CMAKE_SYSTEM_NAME Linux CACHE STRING "")
set(CMAKE_SYSTEM_PROCESSOR s390x CACHE STRING "")
set(CMAKE_CXX_COMPILER s390x-linux-gnu-g++ CACHE STRING "")
set(CMAKE_CXX_FLAGS "-static -fno-exceptions -fno-rtti" CACHE STRING "")
set(SERVOBUS_EXAMPLES OFF CACHE BOOL "")
set(SERVOBUS_QUICK ON CACHE BOOL "")
set(SERVOBUS_UNIT_FOLDERS core explain modbus registers CACHE STRING "")
include(${CMAKE_CURRENT_LIST_DIR}/qemu_user.cmake)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-s390x CACHE STRING "")
