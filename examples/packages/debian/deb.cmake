# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The packages for Debian: servobus, the tool, and libservobus-dev, the headers.
set(SERVOBUS_MAINTAINER "The servobus authors <servobus@noreply.invalid>"
    CACHE STRING "Maintainer of the .deb packages: NAME <ADDRESS>")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL headers)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${SERVOBUS_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_HEADERS_PACKAGE_NAME libservobus-dev)
set(CPACK_DEBIAN_HEADERS_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_HEADERS_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_HEADERS_DESCRIPTION
    "Modbus RTU for motor drives (C++20 headers)
Typed registers and commands of motor drives with Modbus RTU: ZLTECH
ZLAC8015D, YAKOTEC steppers, Coolmay C630S. A register's range, unit and
access are checked by the compiler. No heap, no exceptions, no runtime; the
same code runs on Linux and on microcontrollers.")
if(TARGET servobus_tool)
  list(APPEND CPACK_COMPONENTS_ALL tool)
  set(CPACK_DEBIAN_TOOL_PACKAGE_NAME servobus)
  set(CPACK_DEBIAN_TOOL_PACKAGE_SECTION utils)
  set(CPACK_DEBIAN_TOOL_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_TOOL_DESCRIPTION
      "motor drives on Modbus RTU from the command line
Reads, writes and watches the registers of motor drives by name and in their
units, scans lines, backs up and restores parameters, and says captured frames
in words. It knows ZLTECH ZLAC8015D, YAKOTEC steppers and Coolmay C630S, and
simulates them. Serial ports, and gateways for RTU over TCP and Modbus TCP.")
endif()

# What Debian wants of each package; not for cmake --install.
file(READ ${CMAKE_CURRENT_SOURCE_DIR}/LICENSE license)
string(STRIP "${license}" license)
string(REGEX REPLACE "\n\n" "\n.\n" license "${license}")
string(REPLACE "\n" "\n " license " ${license}")
set(ENV{SOURCE_DATE_EPOCH} ${package_time})
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
string(TIMESTAMP package_year "%Y" UTC)
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} name)
  set(package ${CPACK_DEBIAN_${name}_PACKAGE_NAME})
  set(made ${CMAKE_CURRENT_BINARY_DIR}/debian/${package})
  configure_file(${CMAKE_CURRENT_LIST_DIR}/copyright.in ${made}/copyright @ONLY)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/changelog.in ${made}/changelog @ONLY)
  configure_file(${CMAKE_CURRENT_SOURCE_DIR}/CHANGELOG.md ${made}/CHANGELOG.md COPYONLY)
  execute_process(COMMAND gzip -9nfk ${made}/changelog ${made}/CHANGELOG.md)
  install(FILES ${made}/copyright ${made}/changelog.gz ${made}/CHANGELOG.md.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()
if(TARGET servobus_tool)
  install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/examples/servobus/README.md
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/servobus COMPONENT tool EXCLUDE_FROM_ALL)
endif()
