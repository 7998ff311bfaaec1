#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs the benchmarks, and prints tables of ratios at the end: times first, then how much of a line a
# bus uses, and instructions, which no neighbour on the machine disturbs. Options go to Google Benchmark, `--benchmark_filter=transaction` say.
set -eu
cd "$(dirname "$0")/.."

missing=""
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
command -v valgrind >/dev/null 2>&1 || missing="$missing valgrind"
[ -e /usr/include/benchmark/benchmark.h ] || missing="$missing libbenchmark-dev"
[ -e /usr/include/modbus/modbus.h ] || missing="$missing libmodbus-dev"
if [ -n "$missing" ]; then
    echo "run.sh: installing$missing with apt-get"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sh bench/build.sh "$work"
"$work/servobus_bench" --benchmark_min_time=0.1 "$@"
echo
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/bus.cpp -o "$work/bus"
"$work/bus"
echo
sh bench/instructions.sh
