# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# A stand-in for vcpkg: runs a portfile with functions that do what those of vcpkg do for a library of headers.
#   cmake -DPORTFILE=... -DPORT=... -DCURRENT_BUILDTREES_DIR=... -DCURRENT_PACKAGES_DIR=... -P tests/packages/vcpkg.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(status)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()

function(vcpkg_extract_source_archive out)
  cmake_parse_arguments(arg "" "ARCHIVE" "" ${ARGN})
  set(folder ${CURRENT_BUILDTREES_DIR}/src)
  file(MAKE_DIRECTORY ${folder})
  execute_process(COMMAND ${CMAKE_COMMAND} -E tar xf ${arg_ARCHIVE} WORKING_DIRECTORY ${folder} RESULT_VARIABLE status)
  file(GLOB unpacked ${folder}/*)
  list(LENGTH unpacked count)
  if(status OR NOT count EQUAL 1)
    message(FATAL_ERROR "${arg_ARCHIVE} is not an archive of one folder")
  endif()
  set(${out} ${unpacked} PARENT_SCOPE)
endfunction()

function(vcpkg_cmake_configure)
  cmake_parse_arguments(arg "" "SOURCE_PATH" "OPTIONS" ${ARGN})
  run(${CMAKE_COMMAND} -S ${arg_SOURCE_PATH} -B ${CURRENT_BUILDTREES_DIR}/build -DCMAKE_BUILD_TYPE=Release
      -DCMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR} ${arg_OPTIONS})
endfunction()

function(vcpkg_cmake_install)
  run(${CMAKE_COMMAND} --build ${CURRENT_BUILDTREES_DIR}/build --target install)
endfunction()

# Moves the package's files to share/PORT and makes the prefix that they compute that of the new folder.
function(vcpkg_cmake_config_fixup)
  cmake_parse_arguments(arg "" "CONFIG_PATH" "" ${ARGN})
  set(new ${CURRENT_PACKAGES_DIR}/share/${PORT})
  file(RENAME ${CURRENT_PACKAGES_DIR}/${arg_CONFIG_PATH} ${new})
  file(READ ${new}/servobus-targets.cmake text)
  string(REGEX REPLACE "\nget_filename_component\\(_IMPORT_PREFIX \"\\\${CMAKE_CURRENT_LIST_FILE}\" PATH\\)(\nget_filename_component\\(_IMPORT_PREFIX \"\\\${_IMPORT_PREFIX}\" PATH\\))*"
         "\nget_filename_component(_IMPORT_PREFIX \"\${CMAKE_CURRENT_LIST_DIR}/../../\" ABSOLUTE)" fixed "${text}")
  if(fixed STREQUAL text)
    message(FATAL_ERROR "no prefix in servobus-targets.cmake")
  endif()
  file(WRITE ${new}/servobus-targets.cmake "${fixed}")
endfunction()

function(vcpkg_fixup_pkgconfig)
  set(file ${CURRENT_PACKAGES_DIR}/share/pkgconfig/${PORT}.pc)
  file(READ ${file} text)
  string(REGEX REPLACE "prefix=[^\n]*\nincludedir" "prefix=\${pcfiledir}/../..\nincludedir" text "${text}")
  file(WRITE ${file} "${text}")
endfunction()

function(vcpkg_install_copyright)
  cmake_parse_arguments(arg "" "" "FILE_LIST" ${ARGN})
  file(COPY ${arg_FILE_LIST} DESTINATION ${CURRENT_PACKAGES_DIR}/share/${PORT})
  get_filename_component(name ${arg_FILE_LIST} NAME)
  file(RENAME ${CURRENT_PACKAGES_DIR}/share/${PORT}/${name} ${CURRENT_PACKAGES_DIR}/share/${PORT}/copyright)
endfunction()

include(${PORTFILE})
if(NOT VCPKG_BUILD_TYPE STREQUAL "release")
  message(FATAL_ERROR "a port of headers alone is built once: set(VCPKG_BUILD_TYPE release)")
endif()
