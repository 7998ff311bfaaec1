# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# qemu-user knows the standard baud rates only, and takes minutes for an hour of simulated commands.
set(SERVOBUS_TEST_ARGUMENTS "--test-case-exclude=*odd?baud?rate*,*an?hour?of?velocity*" CACHE STRING "")
