# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Programs that must not compile, a test for each, and the page that is made of them.
file(GLOB wrong_programs CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/fail fail/*.cpp)
list(REMOVE_ITEM wrong_programs control.cpp)
separate_arguments(given_flags NATIVE_COMMAND "${CMAKE_CXX_FLAGS}")
set(compiler ${CMAKE_CXX_COMPILER} ${given_flags} -std=c++20 -Iinclude -fsyntax-only)

check(fail.control LABELS compile fast COMMAND ${compiler} -Wall -Wextra -Werror tests/fail/control.cpp)
foreach(program IN LISTS wrong_programs)
  get_filename_component(name ${program} NAME_WE)
  check(fail.${name} LABELS compile fast
        COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py refused tests/fail/${program} ${compiler})
endforeach()
check(fail.page LABELS compile docs fast COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py page --check)
