#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Tests the tests: changes one operator, constant or statement of the core headers and of the drives' facades at a time,
# in a copy of the tree, and checks whether a test fails. Installs missing packages first (Debian, Ubuntu).
#     sh tests/mutate/run.sh [--mutants N] [--seed S]   N changes, 60 if not given, chosen by the number S, 1
#     sh tests/mutate/run.sh --meaning [...]            the changes of meaning.txt, in its order: all, if N is not given
#     sh tests/mutate/run.sh --list [...]               only prints what would be changed
#     sh tests/mutate/run.sh --quick [...]              only with the tests of first.txt, so more survive
#     sh tests/mutate/run.sh --one K [--seed S]         only the change that has the number K
#     sh tests/mutate/run.sh --from K [...]             without the changes before K, which an earlier run has judged
#     sh tests/mutate/run.sh --only FILE:LINE           all changes of one line
#     sh tests/mutate/run.sh --in PATH[,PATH] [...]     only in these rooms or headers of include/servobus, such as
#                                                       line/,modbus/exchange.hpp; the numbers are those of this choice
#   CXX        the compiler, g++ if not given
#   CXXFLAGS   flags after the usual ones, such as -fsanitize=address,undefined
#   JOBS       changes at a time, 2 if not given
# The same S chooses the same changes. Each change has a line: where, what, and which test failed. The last line is a
# summary. The status is 1 if tests and compiler detect less than 95 of 100. Changes that cannot be detected are listed
# with their reasons in survivors.txt.
set -u
cd "$(dirname "$0")/../.." || exit 1

. tests/support/install.sh

CXX=${CXX:-g++}
command -v python3 >/dev/null 2>&1 || must_install python3
command -v "${CXX%% *}" >/dev/null 2>&1 || must_install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
if ! echo '#include <doctest/doctest.h>' | $CXX -x c++ -std=c++20 -fsyntax-only - 2>/dev/null; then
    must_install doctest-dev
fi
export CXX
exec python3 -B tests/mutate/mutate.py "$@"
