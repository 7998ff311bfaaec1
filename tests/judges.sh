#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Proves that the judges of the simulation can fail: puts one defect at a time into a copy of the library and runs the
# simulation, which must find it by the promise that is broken. The defects are in sim/defects.txt.
#   sh tests/judges.sh [K...]   only the defects with these numbers, counted from 1
#   sh tests/judges.sh --list   only says whether the lines of each defect are there to be replaced
#   CXX    the compiler, g++ if not given
#   JOBS   defects at a time, 2 if not given
#   SEEDS  runs of the simulation at most, 20000 if not given
# A line for each defect, with the run that found it. The last line is a summary.
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

command -v python3 >/dev/null 2>&1 || must_install python3
CXX=${CXX:-g++}
command -v "${CXX%% *}" >/dev/null 2>&1 || must_install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
export CXX
exec python3 -B tests/sim/defects.py "$@"
