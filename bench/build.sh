#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# build.sh DIRECTORY: builds the time benchmarks there, as servobus_bench, and installs the packages that it needs.
# Used by run.sh and plots.sh.
set -eu
cd "$(dirname "$0")/.."
work=$1

missing=""
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
[ -e /usr/include/benchmark/benchmark.h ] || missing="$missing libbenchmark-dev"
[ -e /usr/include/modbus/modbus.h ] || missing="$missing libmodbus-dev"
if [ -n "$missing" ]; then
    . tests/support/install.sh
    # shellcheck disable=SC2086
    must_install $missing
fi

for source in main bench_crc16 bench_frames bench_transaction operations; do
    "${CXX:-g++}" -std=c++20 -O2 -Iinclude -c "bench/$source.cpp" -o "$work/$source.o"
done
for source in bench/sides/*.cpp bench/peers/*.cpp; do
    name=$(echo "$source" | tr / _)
    "${CXX:-g++}" -std=c++20 -O2 -Iinclude -c "$source" -o "$work/$name.o"
done
"${CXX:-g++}" "$work"/*.o -lbenchmark -lmodbus -lpthread -o "$work/servobus_bench"
