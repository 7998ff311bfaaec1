# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# check(NAME LABELS LABEL... COMMAND WORD... [COST N] [REAL_TIME] [ENVIRONMENT NAME=VALUE...] [OF PATH... [ALONE]])
#
# A test of CTest that runs in the project's folder. COST: seconds of a processor, or with REAL_TIME of the clock, as
# `python3 -B tests/costs.py` prints them; long ones begin first. REAL_TIME: it measures the real clock. It runs again if the machine was too busy
# (support/run_check.cpp), and all other checks run at a lower priority. TIMEOUT is against hangs only, and judges no speed:
# five minutes, and thirty times the COST.
# OF: it runs only if one of these files and folders, or what their code includes, has changed since all passed
# (tests/unless_unchanged.py). ALONE: what they include does not count, since other checks judge that code too.
if(NOT CMAKE_CROSSCOMPILING)
  add_executable(run_check support/run_check.cpp)
  target_compile_features(run_check PRIVATE cxx_std_20)
endif()

# names_and_seconds(VARIABLE FILE): the names in a file of one a line, and seconds_of_NAME where a number follows.
macro(names_and_seconds variable file)
  file(STRINGS ${file} lines REGEX "^[^#]")
  set(${variable})
  foreach(line IN LISTS lines)
    if(line MATCHES " ([0-9]+)$")
      string(REPLACE " ${CMAKE_MATCH_1}" "" line ${line})
      set(seconds_of_${line} ${CMAKE_MATCH_1})
    endif()
    list(APPEND ${variable} ${line})
  endforeach()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
endmacro()

function(check name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "REAL_TIME;ALONE" "COST" "LABELS;COMMAND;ENVIRONMENT;OF")
  if(NOT arg_COMMAND OR NOT arg_LABELS OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "check(${name}): it needs LABELS and COMMAND, and knows no '${arg_UNPARSED_ARGUMENTS}'")
  endif()
  set(kind computing)
  if(arg_REAL_TIME)
    set(kind real_time)
  endif()
  set(before)
  if(TARGET run_check)
    set(before $<TARGET_FILE:run_check> ${kind} ${name} ${CMAKE_BINARY_DIR}/times.tsv)
  endif()
  if(arg_OF)
    set(alone)
    if(arg_ALONE)
      set(alone --alone)
    endif()
    list(APPEND before ${Python3_EXECUTABLE} -B tests/unless_unchanged.py ${alone} ${arg_OF} --)
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
  if(arg_OF)
    set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77)
  endif()
endfunction()
