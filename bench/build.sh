#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# build.sh DIRECTORY: builds the benchmarks of times there, as servobus_bench; for run.sh and plots.sh, which see to
# it that the compiler and the libraries are there.
set -eu
cd "$(dirname "$0")/.."
work=$1

for source in main crc16 frames transaction operations; do
    "${CXX:-g++}" -std=c++20 -O2 -Iinclude -c "bench/$source.cpp" -o "$work/$source.o"
done
for source in bench/sides/*.cpp bench/peers/*.cpp; do
    name=$(echo "$source" | tr / _)
    "${CXX:-g++}" -std=c++20 -O2 -Iinclude -c "$source" -o "$work/$name.o"
done
"${CXX:-g++}" "$work"/*.o -lbenchmark -lmodbus -lpthread -o "$work/servobus_bench"
