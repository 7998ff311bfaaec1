# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Run by CPack on what goes into a package: modes that do not depend on the umask, and the commit's time.
file(CHMOD_RECURSE ${CPACK_TEMPORARY_DIRECTORY} DIRECTORY_PERMISSIONS
     OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
find_program(TOUCH touch)
if(TOUCH)
  file(GLOB_RECURSE staged ${CPACK_TEMPORARY_DIRECTORY}/*)
  foreach(one ${staged})
    execute_process(COMMAND ${TOUCH} -d @$ENV{SOURCE_DATE_EPOCH} ${one})
  endforeach()
endif()
