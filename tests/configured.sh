#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs tests in one of the configurations of tests/config/, such as another compiler.
#   sh tests/configured.sh CONFIGURATION [FOLDER [LABEL]]
# FOLDER: where to build, build/CONFIGURATION if not given. LABEL: of the tests, unit if not given.
#   JOBS     compilers and tests at a time, 2 if not given
#   CXXFLAGS flags after those of the configuration
set -eu
cd "$(dirname "$0")/.."
name=${1:?usage: sh tests/configured.sh CONFIGURATION [FOLDER [LABEL]]}
build=${2:-build/$name}
label=${3:-unit}
jobs=${JOBS:-2}

cmake -S . -B "$build" -G Ninja -C "tests/config/$name.cmake" >"$build.log" 2>&1 || { cat "$build.log"; exit 1; }
rm "$build.log"
targets=$(cmake --build "$build" --target help | sed -n 's/^run_check: .*/run_check/p') # none where a compiler is for another machine
if [ "$label" = unit ]; then targets="$targets servobus_tests"; fi
# shellcheck disable=SC2086
[ -z "$targets" ] || cmake --build "$build" -j "$jobs" --target $targets
exec ctest --test-dir "$build" -L "^$label\$" -j "$jobs" --output-on-failure --no-tests=error
