# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Debian's default clang, which is the oldest that the library promises.
set(CMAKE_CXX_COMPILER clang++ CACHE STRING "")
set(SERVOBUS_EXAMPLES OFF CACHE BOOL "")
