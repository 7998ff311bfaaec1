#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds the tests and runs the fast ones: unit tests but those of tests/run/busy.txt, programs that must not compile, the
# tool and the programs of the examples. .ci/run runs all. Installs missing packages first (Debian, Ubuntu).
#   sh tests/run.sh [CTEST-OPTION...]
#   CXX, CXXFLAGS    the compiler, g++ if not given, and flags after the usual ones
#   BUILD            where to build; build/tests if not given. It is used again
#   JOBS             compilers at a time, 2 if not given
#   RUNNER           a command that runs the unit tests, such as qemu-s390x; then the tool and the examples are left out
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

CXX=${CXX:-g++}
export CXX
build=${BUILD:-build/tests}
jobs=${JOBS:-2}
missing=""
need() { command -v "$1" >/dev/null 2>&1 || missing="$missing $2"; }
need cmake cmake
need ninja ninja-build
need python3 python3
need "${CXX%% *}" "$(echo "${CXX%% *}" | sed 's/^clang++/clang/') libc6-dev"
[ -e /usr/include/doctest/doctest.h ] || missing="$missing doctest-dev"
# shellcheck disable=SC2086
[ -z "$missing" ] || must_install $missing

begun=$(date +%s)
times=""
took() { # WHAT: since the end of the part before
    now=$(date +%s)
    times="$times${times:+, }$1 $((now - begun)) s"
    begun=$now
}
fail() { echo "run.sh: FAILED ($CXX): $1"; exit 1; }

examples=ON
[ -z "${RUNNER:-}" ] || examples=OFF
mkdir -p "$build"
cmake -S . -B "$build" -G Ninja -DSERVOBUS_INSTALL=OFF -DSERVOBUS_EXAMPLES=$examples -DCMAKE_CROSSCOMPILING_EMULATOR="${RUNNER:-}" \
    -DSERVOBUS_QUICK=ON >"$build/configured" 2>&1 ||
    { cat "$build/configured"; fail "it cannot be configured"; }
took configuring
cmake --build "$build" -j "$jobs" || fail "it does not compile"
took compiling
# The programs mostly wait, so more tests run than there are cores.
ctest --test-dir "$build" -L '^fast$' -j "$((jobs * 3))" --output-on-failure --no-tests=error "$@"
status=$?
took testing
. tests/support/cpu_seconds.sh
times >"$build/cpu"
echo "run.sh: $times; $(cpu_seconds "$build/cpu") CPU seconds"
[ "$status" = 0 ] || fail "the tests above; one again: ctest --test-dir $build -R NAME --output-on-failure"
echo "run.sh: all passed ($CXX)"
