# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The command-line tool and the programs of the examples, over pseudo-terminals and in real time.
add_executable(undisturbed support/undisturbed.cpp)
target_compile_features(undisturbed PRIVATE cxx_std_20)
set(tool $<TARGET_FILE:servobus_tool>)
# A build without a type is for tests: it compiles quickly, and its programs are quick enough.
if(NOT CMAKE_BUILD_TYPE)
  foreach(program servobus_tool servobus_wheels servobus_stepper servobus_servo servobus_robot)
    target_compile_options(${program} PRIVATE -O1)
  endforeach()
endif()

file(GLOB parts CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} tool/*.py)
foreach(part IN LISTS parts)
  get_filename_component(name ${part} NAME_WE)
  check(tool.${name} LABELS tool fast REAL_TIME COST 10 COMMAND ${Python3_EXECUTABLE} -B tests/${part} ${tool})
endforeach()
foreach(program wheels stepper servo robot)
  check(example.${program} LABELS example fast REAL_TIME COST 20
        COMMAND ${Python3_EXECUTABLE} -B tests/examples/${program}.py ${tool} $<TARGET_FILE:servobus_${program}>)
endforeach()
foreach(machine robot lift press)
  check(example.${machine}_simulated LABELS example fast COST 2
        COMMAND $<TARGET_FILE:servobus_${machine}_simulated> ${CMAKE_CURRENT_BINARY_DIR}/${machine}.svg)
  set_tests_properties(example.${machine}_simulated PROPERTIES PASS_REGULAR_EXPRESSION "as it should be" FAIL_REGULAR_EXPRESSION "NOT|WRONG")
endforeach()
