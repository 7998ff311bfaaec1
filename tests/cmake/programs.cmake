# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The command-line tool and the programs of the examples, over pseudo-terminals and in real time.
set(tool $<TARGET_FILE:servobus_tool>)
# The tool with a drive that is not the library's.
add_executable(tool_with_winch $<TARGET_OBJECTS:servobus_tool_parts>
                               ${PROJECT_SOURCE_DIR}/examples/own_device/own_tool_drive.cpp)
target_link_libraries(tool_with_winch PRIVATE servobus::servobus strict_warnings)
# A build without a type is for tests: it compiles quickly, and its programs are quick enough.
if(NOT CMAKE_BUILD_TYPE)
  foreach(program servobus_tool_parts servobus_wheels servobus_stepper servobus_servo servobus_robot servobus_cell)
    target_compile_options(${program} PRIVATE $<IF:$<BOOL:${SERVOBUS_QUICK}>,-O0,-O1>)
  endforeach()
endif()

file(GLOB parts CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} tool/*.py)
list(REMOVE_ITEM parts tool/own_drive.py tool/troubles.py tool/line_texts.py)
check(tool.own_drive LABELS tool fast REAL_TIME COST 2
      COMMAND ${Python3_EXECUTABLE} -B tests/tool/own_drive.py $<TARGET_FILE:tool_with_winch>)
names_and_seconds(busy_parts tool/busy.txt)
foreach(part IN LISTS parts)
  get_filename_component(name ${part} NAME_WE)
  set(labels tool fast)
  if(name IN_LIST busy_parts)
    set(labels tool)
    list(REMOVE_ITEM busy_parts ${name})
  endif()
  set(cost 8)
  if(DEFINED seconds_of_${name})
    set(cost ${seconds_of_${name}})
  endif()
  check(tool.${name} LABELS ${labels} REAL_TIME COST ${cost} COMMAND ${Python3_EXECUTABLE} -B tests/${part} ${tool})
endforeach()
if(busy_parts)
  message(FATAL_ERROR "tests/tool/busy.txt: there is no ${busy_parts}")
endif()
foreach(program wheels stepper servo robot cell)
  check(example.${program} LABELS example fast REAL_TIME COST 20
        COMMAND ${Python3_EXECUTABLE} -B tests/examples/${program}.py ${tool} $<TARGET_FILE:servobus_${program}>)
endforeach()
foreach(machine robot lift press)
  check(example.${machine}_simulated LABELS example fast COST 2
        COMMAND $<TARGET_FILE:servobus_${machine}_simulated> ${CMAKE_CURRENT_BINARY_DIR}/${machine}.svg)
  set_tests_properties(example.${machine}_simulated PROPERTIES PASS_REGULAR_EXPRESSION "as it should be" FAIL_REGULAR_EXPRESSION "NOT|WRONG")
endforeach()
