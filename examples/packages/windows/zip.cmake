# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The zip for Windows: the tool and its page, to unpack anywhere.
set(in_zip DESTINATION . COMPONENT zip EXCLUDE_FROM_ALL)
if(TARGET servobus_tool)
  install(TARGETS servobus_tool RUNTIME ${in_zip})
endif()
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/examples/servobus/README.md ${in_zip})
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/LICENSE RENAME LICENSE.txt ${in_zip})
set(CPACK_GENERATOR ZIP)
set(CPACK_COMPONENTS_ALL zip)
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_COMPONENT_INCLUDE_TOPLEVEL_DIRECTORY ON)
set(CPACK_PACKAGE_FILE_NAME servobus-${PROJECT_VERSION}-windows-x86_64)
