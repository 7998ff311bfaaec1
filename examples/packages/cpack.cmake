# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Included by CMakeLists.txt: makes packages by CPack, .deb files or a zip for Windows (README.md in this folder).

if(NOT SERVOBUS_IS_TOP_LEVEL)
  return()
endif()

# The time of all files in packages, so that the same commit gives the same bytes. Archives of zip have local time.
set(package_time $ENV{SOURCE_DATE_EPOCH})
if(NOT package_time)
  execute_process(COMMAND git -C ${CMAKE_CURRENT_SOURCE_DIR} log -1 --format=%ct OUTPUT_VARIABLE package_time
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT package_time) # an unpacked archive
  file(TIMESTAMP ${CMAKE_CURRENT_SOURCE_DIR}/CHANGELOG.md package_time "%s" UTC)
endif()
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/package_time.cmake 
     "set(ENV{SOURCE_DATE_EPOCH} ${package_time})\nset(ENV{TZ} UTC)\n")
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_BINARY_DIR}/package_time.cmake)

set(CPACK_PACKAGE_VENDOR "The servobus authors")
set(CPACK_PACKAGE_CHECKSUM SHA256)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 1)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/staged.cmake)
if(WIN32)
  include(${CMAKE_CURRENT_LIST_DIR}/windows/zip.cmake)
else()
  include(${CMAKE_CURRENT_LIST_DIR}/debian/deb.cmake)
endif()
include(CPack)
