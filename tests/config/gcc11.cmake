# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The oldest g++ that the library promises.
set(CMAKE_CXX_COMPILER g++-11 CACHE STRING "")
set(SERVOBUS_EXAMPLES OFF CACHE BOOL "")
