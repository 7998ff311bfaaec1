# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Programs that must not compile, a test for each, and the page that is made of them. A test is the compiler alone: it
# passes if there is an error, and a line of it has the words after EXPECT. Where figures are expected too, fail/programs.py looks for both.
file(GLOB wrong_programs CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/fail fail/*.cpp)
list(REMOVE_ITEM wrong_programs control.cpp)
separate_arguments(given_flags NATIVE_COMMAND "${CMAKE_CXX_FLAGS}")
set(compiler ${CMAKE_CXX_COMPILER} ${given_flags} -std=c++20 -Iinclude)

# g++ takes the precompiled header of the programs where it finds it before the header itself, so copies of them lie
# apart. clang++ is told where it is, and cross compilers of g++ 12 crash with one.
set(fail_folder ${PROJECT_SOURCE_DIR}/tests/fail)
set(fail_flags -fsyntax-only)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND NOT CMAKE_CROSSCOMPILING)
  set(fail_folder ${CMAKE_CURRENT_BINARY_DIR}/fail/copies)
  set(fail_flags -fsyntax-only -I${CMAKE_CURRENT_BINARY_DIR}/fail -Itests/fail)
  file(MAKE_DIRECTORY ${fail_folder})
  check(fail.header LABELS compile fast
        COMMAND ${compiler} -w -x c++-header tests/fail/program.hpp -o ${CMAKE_CURRENT_BINARY_DIR}/fail/program.hpp.gch)
  set_tests_properties(fail.header PROPERTIES FIXTURES_SETUP fail_header)
elseif(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  set(fail_header ${CMAKE_CURRENT_BINARY_DIR}/fail/program.pch)
  file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/fail)
  check(fail.header LABELS compile fast COMMAND ${compiler} -w -x c++-header tests/fail/program.hpp -o ${fail_header})
  set_tests_properties(fail.header PROPERTIES FIXTURES_SETUP fail_header)
endif()

check(fail.control LABELS compile fast COMMAND ${compiler} -fsyntax-only -Wall -Wextra -Werror tests/fail/control.cpp)
foreach(program IN LISTS wrong_programs)
  get_filename_component(name ${program} NAME_WE)
  configure_file(fail/${program} ${CMAKE_CURRENT_BINARY_DIR}/fail/copies/${program} COPYONLY)
  file(STRINGS fail/${program} expected REGEX "^// EXPECT: ")
  file(STRINGS fail/${program} figures REGEX "^// FIGURES: ")
  if(figures OR NOT expected)
    check(fail.${name} LABELS compile fast
          COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py refused tests/fail/${program} ${compiler} -fsyntax-only)
    continue()
  endif()
  string(REPLACE "// EXPECT: " "" expected "${expected}")
  string(REGEX REPLACE "([][+.*()^$?|\\\\])" "\\\\\\1" expected "${expected}")
  set(flags ${fail_flags})
  file(STRINGS fail/${program} has_header REGEX "#include \"(program|stepper).hpp\"")
  if(DEFINED fail_header AND has_header)
    list(APPEND flags -include-pch ${fail_header})
  endif()
  check(fail.${name} LABELS compile fast COMMAND ${compiler} ${flags} ${fail_folder}/${program})
  set_tests_properties(fail.${name} PROPERTIES FIXTURES_REQUIRED fail_header
                       PASS_REGULAR_EXPRESSION
                       "error: (.*\n[^\n]*(error|note|in call to|expansion of|static assertion))?[^\n]*${expected}")
endforeach()
check(fail.page LABELS compile docs fast COMMAND ${Python3_EXECUTABLE} -B tests/fail/programs.py page --check)
