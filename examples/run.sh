#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The main job: a program drives both wheels of a ZLAC8015D.
#
#   sh examples/run.sh               a simulated drive on a pseudo-terminal
#   sh examples/run.sh /dev/ttyUSB0  a real one; it asks before anything moves
set -eu
cd "$(dirname "$0")/.."

if [ $# -gt 0 ] && [ ! -e "$1" ]; then
    echo "run.sh: there is no port $1" >&2
    exit 1
fi
if ! command -v "${CXX:-g++}" >/dev/null 2>&1; then
    . tests/support/install.sh
    must_install g++
fi
CXX=${CXX:-g++}

work=$(mktemp -d)
simulator=""
clean_up() {
    [ -z "$simulator" ] || kill "$simulator" 2>/dev/null || true
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

begun=$(date +%s)
after() { echo "run.sh: $1 after $(($(date +%s) - begun)) s"; }

echo "run.sh: compiling examples/wheels with $CXX"
"$CXX" -std=c++20 -O1 -Iinclude examples/wheels/main.cpp -o "$work/wheels"
if [ $# -gt 0 ]; then
    after compiled
    "$work/wheels" "$1"
    exit $?
fi

"$CXX" -std=c++20 -O1 -Iinclude examples/simulated_drive/main.cpp -o "$work/simulated_drive"
after "compiled, with a simulated drive,"
"$work/simulated_drive" "$work/drive" >"$work/simulator.log" 2>&1 &
simulator=$!
until [ -e "$work/drive" ]; do
    kill -0 "$simulator" 2>/dev/null || {
        cat "$work/simulator.log" >&2
        exit 1
    }
    sleep 0.05
done
echo "run.sh: a simulated ZLAC8015D answers on $(readlink "$work/drive")"
"$work/wheels" "$work/drive" --simulator "$simulator"
after done
