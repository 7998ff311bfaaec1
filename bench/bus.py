# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""How much of a line's time a bus uses.

bus.py             in virtual time (bench_bus.cpp); fails if a share differs from bench/figures/bus.tsv
bus.py --record    the same, and writes the shares there and into bench/README.md
bus.py --pty       over a pseudo-terminal that is paced at 115200 Bd (bench_bus_pty.cpp), for about ten seconds; never
                   fails because of a figure
"""
import sys

from measuring import ROOT, built, must, record, show

FIGURES = "bench/figures/bus.tsv"

if sys.argv[1:] == ["--pty"]:
    show(built("bus_pty", ROOT / "bench/bench_bus_pty.cpp"))
    sys.exit()
program = built("bus", ROOT / "bench/bench_bus.cpp")
show(program)
shares = must(program, "--record")
if sys.argv[1:] == ["--record"]:
    record(FIGURES, shares.splitlines())
elif shares != (ROOT / FIGURES).read_text(encoding="utf-8"):
    sys.exit(f"bus.py: NOT AS RECORDED in {FIGURES}; if it is meant to be so: python3 -B bench/record.py")
