#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Runs bench/bench_bus_pty.cpp: how much of a line's time a bus uses over a pseudo-terminal that is paced at 115200 Bd. It
# takes about five seconds and never fails because of a figure.
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/bench_bus_pty.cpp -o "$work/bus_pty"
"$work/bus_pty"
