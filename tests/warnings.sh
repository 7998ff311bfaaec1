#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Checks that programs that use every header of the library compile without a warning at each level of optimisation,
# since a compiler gives some warnings only after it has optimised. tests/windows.sh has those of windows/.
#   sh tests/warnings.sh [COMPILER...]
set -eu
cd "$(dirname "$0")/.."
[ "$#" != 0 ] || set -- g++ clang++
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Clients of every kind and a server; a bus; the three facades over a serial port; the three simulated drives, one on a
# pseudo-terminal; the explanation of frames; the ports of the network.
programs="tests/warnings/clients.cpp bench/bench_bus.cpp
    examples/wheels/main.cpp examples/stepper/main.cpp examples/servo/main.cpp
    examples/simulated_drive/main.cpp
    fuzz/fuzz_simulators.cpp examples/servobus/commands/explain.cpp tests/warnings/network.cpp"
flags="-std=c++20 -Wall -Wextra -Werror -Iinclude"

find include/servobus -name '*.hpp' ! -path '*/windows/*' | sort >"$work/headers"
for program in $programs; do
    # shellcheck disable=SC2086
    "$1" $flags -MM "$program" | tr -s ' \\' '\n'
done | grep '^include/' | sort -u >"$work/used"
if comm -23 "$work/headers" "$work/used" | grep . >"$work/unused"; then
    echo "warnings.sh: FAILED: no program here uses $(tr '\n' ' ' <"$work/unused")"
    exit 1
fi

for level in -O3 -O2 -O1 -Os -O0; do
    for compiler in "$@"; do
        for program in $programs; do echo "$compiler $flags $level -c $program"; done
    done
done >"$work/commands"
if xargs -P "${JOBS:-2}" -I{} sh -c '{} -o /dev/null 2>&1 || { echo "FAILED  {}"; exit 1; }' \
    <"$work/commands" >"$work/said"; then
    echo "warnings.sh: $(wc -l <"$work/commands") compilations without a warning ($*)"
else
    cat "$work/said"
    echo "warnings.sh: FAILED"
    exit 1
fi
