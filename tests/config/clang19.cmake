# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The newest clang of Debian, with its own standard library and the newest standard.
set(CMAKE_CXX_COMPILER clang++-19 CACHE STRING "")
set(CMAKE_CXX_FLAGS "-std=c++2c -stdlib=libc++" CACHE STRING "")
set(SERVOBUS_EXAMPLES OFF CACHE BOOL "")
