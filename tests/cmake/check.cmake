# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# check(NAME LABELS LABEL... COMMAND WORD... [COST N] [REAL_TIME] [ENVIRONMENT NAME=VALUE...])
#
# A test of CTest that runs in the project's folder. COST: seconds, roughly; long ones begin first. REAL_TIME: it measures
# the real clock. It runs again if the machine was too busy (support/undisturbed.cpp), and all other checks run at a
# lower priority. TIMEOUT is against hangs only, and judges no speed: five minutes, and thirty times the COST.
find_program(SERVOBUS_NICE nice)
mark_as_advanced(SERVOBUS_NICE)

function(check name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "REAL_TIME" "COST" "LABELS;COMMAND;ENVIRONMENT")
  if(NOT arg_COMMAND OR NOT arg_LABELS OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "check(${name}): it needs LABELS and COMMAND, and knows no '${arg_UNPARSED_ARGUMENTS}'")
  endif()
  if(arg_REAL_TIME)
    set(before $<TARGET_FILE:undisturbed>)
  elseif(SERVOBUS_NICE)
    set(before ${SERVOBUS_NICE} -n 10)
  endif()
  add_test(NAME ${name} COMMAND ${before} ${arg_COMMAND} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set(seconds 300)
  if(arg_COST)
    math(EXPR seconds "${seconds} + 30 * ${arg_COST}")
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${arg_LABELS}" TIMEOUT ${seconds})
  if(arg_COST)
    set_tests_properties(${name} PROPERTIES COST ${arg_COST})
  endif()
  if(arg_ENVIRONMENT)
    set_tests_properties(${name} PROPERTIES ENVIRONMENT "${arg_ENVIRONMENT}")
  endif()
endfunction()
