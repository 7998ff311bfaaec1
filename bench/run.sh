#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs the benchmarks and prints tables: ratios of times, how much of a line a bus uses, in virtual time and
# over a pseudo-terminal, and instructions, which do not depend on the load of the machine.
# Options go to Google Benchmark, such as `--benchmark_filter=transaction`.
set -eu
cd "$(dirname "$0")/.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sh bench/build.sh "$work"
"$work/servobus_bench" --benchmark_min_time=0.1 "$@"
echo
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/bench_bus.cpp -o "$work/bus"
"$work/bus"
echo
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/bench_bus_pty.cpp -o "$work/bus_pty"
"$work/bus_pty"
echo
sh bench/instructions.sh
