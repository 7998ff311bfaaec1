#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Makes the packages of examples/packages/README.md from the commit that is checked out. The version is that of
# CMakeLists.txt. The same commit gives the same bytes.   sh examples/packages/make.sh [OUT]
#   OUT                 a folder, build/packages if not given; packages of an earlier run in it are replaced
#   SOURCE_DATE_EPOCH   the time of all files in seconds since 1970, that of the commit if not given
# Exit status: 0 made; 1 a tool is missing or OUT cannot be written; 2 wrong usage, or a tree that is not a commit.
# If it is not 0, nothing was written, also if a signal ended it.
set -u
command -v python3 >/dev/null 2>&1 || { echo "make.sh: python3 is needed" >&2; exit 1; }
exec python3 -B "$(dirname "$0")/make.py" "$@"
