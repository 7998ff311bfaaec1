#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs the simulation of clients, blocking lines, buses, facades, fleets, scans and lives of a drive on
# hostile lines (tests/sim/).
#   sh tests/sim.sh [ARGS]
#   CXX        the compiler, g++ if not given
#   CXXFLAGS   flags after the usual ones
# ARGS: [--only KIND[,KIND...]] --seeds N [--from S] for more runs, --least N to require N transactions for every interpretation
# and N stalls in every place, --seed S [--trace] for one run. KIND: plain, echo, blocking_line, bus, facades, scan, fleet,
# lives. The last line is a summary. Runs of 1000 seeds or more of all kinds fail if they have played a kind of event too
# seldom.
set -u
cd "$(dirname "$0")/.." || exit 1
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
# shellcheck disable=SC2086
${CXX:-g++} -std=c++20 -O1 $warnings -Iinclude -I. ${CXXFLAGS:-} tests/sim/main.cpp -o "$build/sim" || exit 1
"$build/sim" "$@"
