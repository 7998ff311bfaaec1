# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Records every counted figure of bench/README.md (flash, RAM, stack, instructions, use of a line), writes the tables
there and draws bench/plots/size.svg.

Run it after a change of the library that is meant to change a figure; `git diff` shows by how much. It records no
times: bench/plot.py measures those of the CRC.
"""
from measuring import show

for command in ("sh tests/target/run.sh --record",
                "sh tests/target/server.sh --record",
                "sh tests/target/operations.sh --record",
                "sh tests/target/axis.sh --record",
                "python3 -B bench/sizes.py --record",
                "python3 -B bench/instructions.py --record",
                "env CXX=clang++ python3 -B bench/instructions.py --record",
                "python3 -B bench/include_cost.py --record",
                "python3 -B bench/plan_cost.py --record",
                "python3 -B bench/bus.py --record",
                "python3 -B bench/plot.py --sizes",
                "python3 -B bench/readme.py --check",
                "python3 -B bench/plot.py --check"):
    show(*command.split())
