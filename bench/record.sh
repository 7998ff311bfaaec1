#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Records every figure of bench/README.md that a count can repeat (flash, RAM, stack, instructions, use of a line),
# writes the tables there from them and draws bench/plots/size.svg. After a change of the library that is meant to
# change them; `git diff` shows by how much. Times are not counted: bench/plots.sh measures those of the CRC.
set -eu
cd "$(dirname "$0")/.."
sh tests/target/run.sh --record
sh tests/target/operations.sh --record
sh bench/sizes.sh --record
sh bench/instructions.sh --record
CXX=clang++ sh bench/instructions.sh --record
sh bench/bus.sh --record
python3 -B bench/plot.py --sizes
python3 -B bench/readme.py --check
python3 -B bench/plot.py --check
