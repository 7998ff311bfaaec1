# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The unit tests: one program, and a test of CTest for each source. The compiler takes most of the time, so the sources of
# a folder are compiled as one. Only those that run for more than a moment are optimised (run/busy.txt), which tests/run.sh
# leaves out. One source alone, with no other compiled: `cmake --build DIR --target unit.line.line_gaps`.
find_package(doctest REQUIRED)
set(SERVOBUS_QUICK OFF CACHE BOOL "Without the unit tests of run/busy.txt, which take half of the time")
set(SERVOBUS_UNIT_FOLDERS "" CACHE STRING "Of run/, whose tests are built; all if empty")
set(SERVOBUS_TEST_ARGUMENTS "" CACHE STRING "Arguments of the unit tests' program, such as --test-case-exclude=G2*")

file(GLOB unit_sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} run/*/*.cpp)
set(known_folders ".*")
if(SERVOBUS_UNIT_FOLDERS)
  list(JOIN SERVOBUS_UNIT_FOLDERS | folders)
  set(known_folders ${folders})
  list(FILTER unit_sources INCLUDE REGEX "^run/(${folders})/")
endif()
file(GLOB static_sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} static/*.cpp)
names_and_seconds(busy run/busy.txt)

add_library(unit_settings INTERFACE)
target_link_libraries(unit_settings INTERFACE servobus::servobus strict_warnings doctest::doctest)
target_include_directories(unit_settings INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_definitions(unit_settings INTERFACE _GLIBCXX_ASSERTIONS DOCTEST_CONFIG_SUPER_FAST_ASSERTS)
# doctest ends a failed REQUIRE by an exception if exceptions are enabled.
if(CMAKE_CXX_FLAGS MATCHES "-fno-exceptions")
  target_compile_definitions(unit_settings INTERFACE DOCTEST_CONFIG_NO_EXCEPTIONS_BUT_WITH_ALL_ASSERTS)
endif()

set(quick_sources)
set(busy_sources)
foreach(source IN LISTS unit_sources)
  string(REGEX REPLACE "^run/(.*)\\.cpp$" "\\1" name ${source})
  if(name IN_LIST busy)
    list(APPEND busy_sources ${source})
    list(REMOVE_ITEM busy ${name})
  else()
    list(APPEND quick_sources ${source})
  endif()
endforeach()
if(busy AND NOT SERVOBUS_UNIT_FOLDERS)
  message(FATAL_ERROR "tests/run/busy.txt: there is no source ${busy}")
endif()
if(SERVOBUS_QUICK)
  list(REMOVE_ITEM unit_sources ${busy_sources})
  set(busy_sources)
endif()

# unit_objects(NAME LEVEL SOURCE...): one unit for each folder, or for forty of its sources. Tests of lower rooms that use a
# drive are a unit of their own: the others need no compiler after a change of control.
set(lower_rooms client line modbus registers tool)
set(uses_a_drive "<servobus/(bus/plan|bus/bus|control/|device/[a-z0-9]+(/drive)?\\.hpp)|<tests/support/(driven|simulated)")
function(unit_objects name level)
  add_library(${name} OBJECT ${ARGN})
  target_link_libraries(${name} PRIVATE unit_settings)
  target_compile_options(${name} PRIVATE ${level})
  target_precompile_headers(${name} PRIVATE support/precompiled.hpp)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    get_filename_component(folder ${source} DIRECTORY)
    get_filename_component(folder ${folder} NAME)
    file(STRINGS ${source} drives REGEX "^#include (${uses_a_drive})")
    if(folder IN_LIST lower_rooms AND drives)
      set(folder lower_with_drives)
    endif()
    list(APPEND of_${folder} ${source})
    list(LENGTH of_${folder} count)
    math(EXPR unit "(${count} - 1) / 40")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${unit})
  endforeach()
endfunction()

# An emulator runs for minutes what is not optimised. It has no precompiled header: cross compilers of g++ 12 crash with it.
set(level -O0)
if(CMAKE_CROSSCOMPILING_EMULATOR)
  set(level -O1)
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
# These put their own functions in the place of the system's before they include the library.
set_source_files_properties(run/posix/posix_kernel.cpp run/posix/serial_wakes_early.cpp
                            run/posix/tcp_kernel.cpp
                            PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
add_library(unit_main OBJECT run/main.cpp)
target_link_libraries(unit_main PRIVATE unit_settings)
add_executable(servobus_tests $<TARGET_OBJECTS:unit_main>)
# The optimised objects come first: the linker takes the first copy of an inline function, and without optimisation the
# simulated drives take ten times as long. They also take the compiler longest. Three tests that simulate most are among
# them, and what all tests simulate with.
set(optimised run/sim/conformance.cpp run/sim/conformance_of_findings.cpp run/sim/conformance_of_subjects.cpp)
list(FILTER optimised INCLUDE REGEX "^run/(${known_folders})/")
if(optimised)
  list(REMOVE_ITEM quick_sources ${optimised})
  unit_objects(unit_optimised -O1 ${optimised})
  target_sources(servobus_tests PRIVATE $<TARGET_OBJECTS:unit_optimised>)
endif()
add_library(unit_simulated OBJECT support/simulated.cpp)
target_link_libraries(unit_simulated PRIVATE unit_settings)
target_compile_options(unit_simulated PRIVATE -O1)
target_sources(servobus_tests PRIVATE $<TARGET_OBJECTS:unit_simulated>)
if(busy_sources)
  unit_objects(unit_busy -O1 ${busy_sources})
  target_sources(servobus_tests PRIVATE $<TARGET_OBJECTS:unit_busy>)
endif()
unit_objects(unit_quick ${level} ${quick_sources} ${static_sources})
target_sources(servobus_tests PRIVATE $<TARGET_OBJECTS:unit_quick>)

set(unit_tests ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:servobus_tests> --no-version)
set(nothing_ran "test cases: *0 ") # which succeeds
foreach(source IN LISTS unit_sources)
  string(REGEX REPLACE "^run/(.*)\\.cpp$" "\\1" path ${source})
  string(REPLACE / . name ${path})
  set(cost 1)
  if(source IN_LIST busy_sources)
    set(cost 5)
  endif()
  if(DEFINED seconds_of_${path})
    set(cost ${seconds_of_${path}})
  endif()
  set(labels unit fast)
  if(source IN_LIST busy_sources)
    set(labels unit)
  endif()
  check(unit.${name} LABELS ${labels} COST ${cost} ENVIRONMENT SERVOBUS_INTERPRETATIONS=default
        COMMAND ${unit_tests} --source-file=*/tests/${source} ${SERVOBUS_TEST_ARGUMENTS})
  set_tests_properties(unit.${name} PROPERTIES FAIL_REGULAR_EXPRESSION "${nothing_ran}")
  # The same safety under the other interpretations of the manuals: every position of a switch and every pair of them, or with
  # SERVOBUS_INTERPRETATIONS=whole in the environment their whole product, for an hour or more.
  file(STRINGS ${source} under_interpretations REGEX "test_suite\\(\"interpretations\"\\)")
  if(under_interpretations)
    check(interpretations.${name} LABELS interpretations COST 20
          COMMAND ${unit_tests} --source-file=*/tests/${source} --test-suite=interpretations)
    set_tests_properties(interpretations.${name} PROPERTIES FAIL_REGULAR_EXPRESSION "${nothing_ran}" TIMEOUT 86400)
  endif()

  add_executable(${name} EXCLUDE_FROM_ALL ${source} $<TARGET_OBJECTS:unit_main>)
  target_link_libraries(${name} PRIVATE unit_settings)
  target_compile_options(${name} PRIVATE ${level})
  add_custom_target(unit.${name} COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${name}> USES_TERMINAL)
endforeach()
# The code of small cores on this host. tests/run.sh, and configurations that build part of the tests, leave it out.
if(NOT SERVOBUS_UNIT_FOLDERS AND NOT SERVOBUS_QUICK)
  file(GLOB small_core_sources CONFIGURE_DEPENDS run/modbus/exchange*.cpp run/client/call_worlds.cpp
       run/client/client_retries.cpp run/line/bad_input.cpp run/line/bytes_at_once.cpp run/line/failed_sends.cpp
       run/line/line_leftovers.cpp run/line/line_steps.cpp run/line/stuck_ports.cpp run/line/wire_times.cpp
       support/small_core/is_small.cpp)
  add_executable(small_core_tests ${small_core_sources} $<TARGET_OBJECTS:unit_main>)
  target_include_directories(small_core_tests BEFORE PRIVATE support/small_core)
  target_link_libraries(small_core_tests PRIVATE unit_settings)
  target_compile_options(small_core_tests PRIVATE -O1)
  set_target_properties(small_core_tests PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  check(unit.small_core LABELS unit COST 5 COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:small_core_tests>)
  add_dependencies(servobus_tests small_core_tests)
endif()
# Each case belongs to one of these sources, or it would not run.
check(unit.no_other LABELS unit fast COMMAND ${unit_tests} --source-file-exclude=*/tests/run/*)
set_tests_properties(unit.no_other PROPERTIES PASS_REGULAR_EXPRESSION "${nothing_ran}")
