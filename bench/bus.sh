#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Runs bench/bench_bus.cpp: how much of a line's time a bus uses, in virtual time. Fails if a share differs from
# bench/figures/bus.tsv.
#   sh bench/bus.sh [--record]    --record: writes the shares there, and into bench/README.md
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
figures=bench/figures/bus.tsv
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/bench_bus.cpp -o "$work/bus"
"$work/bus"
"$work/bus" --record >"$work/figures"
if [ "${1:-}" = --record ]; then
    cp "$work/figures" "$figures"
    python3 -B bench/readme.py
    exit 0
fi
cmp -s "$work/figures" "$figures" || {
    echo "bus.sh: NOT AS RECORDED in $figures; if it is meant to be so: sh bench/record.sh"
    exit 1
}
