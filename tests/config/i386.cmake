# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# A 32-bit host, C++23, without exceptions and RTTI. The traps of UBSan only: ASan takes the compiler as long again, and
# has the simulation and the fuzzing.
set(CMAKE_SYSTEM_NAME Linux CACHE STRING "")
set(CMAKE_CXX_COMPILER clang++ CACHE STRING "")
set(CMAKE_CXX_FLAGS "-m32 -idirafter /usr/include/x86_64-linux-gnu -std=c++2b -fno-exceptions -fno-rtti -fsanitize=undefined -fsanitize-trap=all" CACHE STRING "")
set(SERVOBUS_EXAMPLES OFF CACHE BOOL "")

# The rooms whose code depends on the width of a pointer. Lines and facades run on 32 bits in tests/target, on a Cortex-M0+.
set(SERVOBUS_QUICK ON CACHE BOOL "")
set(SERVOBUS_UNIT_FOLDERS core modbus registers CACHE STRING "")

# Where the machine cannot execute a 32-bit program, qemu-user does it.
set(probe ${CMAKE_CURRENT_BINARY_DIR}/executes_i386)
file(WRITE ${probe}.cpp "int main() { return 0; }\n")
execute_process(COMMAND clang++ -m32 ${probe}.cpp -o ${probe} RESULT_VARIABLE built OUTPUT_QUIET ERROR_QUIET)
execute_process(COMMAND ${probe} RESULT_VARIABLE executed OUTPUT_QUIET ERROR_QUIET)
if(built EQUAL 0 AND NOT executed EQUAL 0)
  include(${CMAKE_CURRENT_LIST_DIR}/qemu_user.cmake)
  set(CMAKE_CROSSCOMPILING_EMULATOR qemu-i386 CACHE STRING "")
endif()
