# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Programs that must not compile, a test for each, and the page that is made of them. A test passes if the compiler prints
# an error, and a line of it has the words after EXPECT. Where nothing that the program includes has changed since it was
# compiled, its error is printed again (fail/as_before.sh). Where figures are expected too, fail/programs.py looks for both.
# fail.sizes judges the errors that were printed: nothing is compiled for it.
file(GLOB wrong_programs CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/fail fail/*.cpp)
list(REMOVE_ITEM wrong_programs control.cpp)
separate_arguments(given_flags NATIVE_COMMAND "${CMAKE_CXX_FLAGS}")
set(compiler ${CMAKE_CXX_COMPILER} ${given_flags} -std=c++20 -Iinclude)

# For clang++ all that the programs include is precompiled once and put in front of each: the headers themselves are then
# skipped by their `#pragma once`. g++ maps its whole precompiled header into each program, which takes longer than what
# the program includes. A program whose mistake is a header that it lacks says `// ALONE`.
set(fail_flags -fsyntax-only)
set(fail_folder ${CMAKE_CURRENT_BINARY_DIR}/fail)
set(fail_before)
file(MAKE_DIRECTORY ${fail_folder})
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  set(fail_before -include-pch ${fail_folder}/all.pch)
  check(fail.header LABELS compile fast
        COMMAND sh tests/fail/as_before.sh ${fail_folder}/all ${compiler} -Itests/fail -w -o ${fail_folder}/all.pch
                -x c++-header tests/fail/all.hpp)
  set_tests_properties(fail.header PROPERTIES FIXTURES_SETUP fail_header FAIL_REGULAR_EXPRESSION "error: ")
endif()

# tests/run.sh compiles one program for each sentence that is expected, and .ci/run all.
set(sentences)
set(fail_tests)
check(headers.firmware LABELS compile fast COMMAND ${compiler} -fsyntax-only -Wall -Wextra -Werror tests/firmware.cpp)
check(fail.control LABELS compile fast COMMAND ${compiler} -fsyntax-only -Wall -Wextra -Werror tests/fail/control.cpp)
foreach(program IN LISTS wrong_programs)
  get_filename_component(name ${program} NAME_WE)
  file(STRINGS fail/${program} expected REGEX "^// EXPECT: ")
  file(STRINGS fail/${program} figures REGEX "^// FIGURES: ")
  set(flags ${fail_flags})
  file(STRINGS fail/${program} is_alone REGEX "^// ALONE")
  if(NOT is_alone)
    list(APPEND flags ${fail_before})
  endif()
  set(compiled sh tests/fail/as_before.sh ${fail_folder}/${name} ${compiler} ${flags})
  list(APPEND fail_tests fail.${name})
  if(figures OR NOT expected)
    check(fail.${name} LABELS compile fast
          COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py refused tests/fail/${program} ${compiled})
    set_tests_properties(fail.${name} PROPERTIES FIXTURES_REQUIRED fail_header)
    continue()
  endif()
  string(REPLACE "// EXPECT: " "" expected "${expected}")
  set(labels compile fast)
  if(expected IN_LIST sentences)
    set(labels compile)
  endif()
  list(APPEND sentences "${expected}")
  string(REGEX REPLACE "([][+.*()^$?|\\\\])" "\\\\\\1" expected "${expected}")
  check(fail.${name} LABELS ${labels} COMMAND ${compiled} tests/fail/${program})
  set_tests_properties(fail.${name} PROPERTIES FIXTURES_REQUIRED fail_header
                       PASS_REGULAR_EXPRESSION
                       "error: (.*\n[^\n]*(error|note|in call to|expansion of|static assertion))?[^\n]*${expected}")
endforeach()
if(NOT given_flags) # others than the usual ones may add warnings
  check(fail.sizes LABELS compile
        COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py sizes --of ${fail_folder} ${CMAKE_CXX_COMPILER})
  set_tests_properties(fail.sizes PROPERTIES DEPENDS "${fail_tests}")
endif()
check(fail.page LABELS compile docs fast COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py page --check)
