# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Counts the instructions of each operation with callgrind, and those of the same operation written by hand in C.

Fails if a ratio is above its bound. The counts are the same in every run with the same compiler: a figure is the
difference between two runs of many operations, which excludes the start of the program. All figures include the loop
around each operation, 10 instructions.
Each compiler has its own bounds: clang++ unrolls the peer's table look-ups and g++ does not, so the peer is faster with
clang++. bench/figures/instructions.tsv has the figures of g++ 12 and clang++ 14. With one of these compilers, a figure
that differs by more than 1 % from the recorded one fails too.

CXX=clang++ instructions.py [--record]    --record: writes the counts there, and into bench/README.md
"""
import itertools
import re
import sys

from measuring import ROOT, SIDES, built, family, must, need, record, recorded, run, show, side_by_side

FIGURES = "bench/figures/instructions.tsv"
SIDE_NAMES = ("servobus", "hand-written", "only reading", "libmodbus")
# Hundredths of the instructions of the hand-written operation.
BOUNDS = {"g++": {"transaction": 125, "frame": 80}, "clang++": {"transaction": 160, "frame": 105}}


def counted(program, side, operation, times):
    done = run("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, side, operation, times)
    return int(re.search(r"Collected : *(\d+)", done.stdout)[1]) if done.returncode == 0 else None


def cost(program, side, operation):
    """Instructions per operation as text; a dash if the side does not have it."""
    few = counted(program, side, operation, 1000)
    return "-" if few is None else str((counted(program, side, operation, 3000) - few + 1000) // 2000)


def is_as_recorded(compiler, operation, *found):
    """True for a compiler without recorded figures."""
    return all(99 * int(old) <= 100 * int(now) <= 101 * int(old)
               for row in recorded(FIGURES) if row[:2] == [compiler, operation]
               for now, old in zip(found, row[2:]))


def count_all(program, operations):
    """The cost on each side, in the order of SIDE_NAMES, for each operation."""
    pairs = list(itertools.product(operations, SIDE_NAMES))
    costs = dict(zip(pairs, side_by_side(lambda pair: cost(program, pair[1], pair[0]), pairs)))
    return {operation: [costs[operation, side] for side in SIDE_NAMES] for operation in operations}


def record_counts(compiler, rows):
    """Replaces this compiler's rows; those of g++ come first."""
    lines = (ROOT / FIGURES).read_text(encoding="utf-8").splitlines()
    comment = [line for line in lines if line.startswith("#")]
    others = [line for line in lines[len(comment):] if not line.startswith(f"{compiler}\t")]
    record(FIGURES, comment + sorted(others + rows, key=lambda line: line.split()[0], reverse=True))


def main():
    is_recording = sys.argv[1:] == ["--record"]
    need("valgrind", "valgrind")
    need("/usr/include/modbus/modbus.h", "libmodbus-dev")
    program = built("instructions", ROOT / "bench/bench_instructions.cpp", ROOT / "bench/operations.cpp", *SIDES,
                    libraries=["-lmodbus"])
    show(program, "check")
    name, version = family()
    compiler = f"{name} {version}"
    line = "{:22}{:>10}{:>14}{:>8}{:>8}{:>14}{:>11}{}"
    print(f"{compiler} -O2")
    print(line.format("instructions", "servobus", "hand-written", "ratio", "bound", "only reading", "libmodbus", ""))
    rows, passes = [], True
    for operation, costs in count_all(program, must(program, "operations").splitlines()).items():
        own, other, reading, library = costs
        rows.append("\t".join([compiler, operation, own, other, library]))
        ratio = int(own) / int(other)
        bound = BOUNDS[name]["transaction" if operation.startswith("transaction") else "frame"] / 100
        verdict = "" if is_recording or is_as_recorded(compiler, operation, own, other) else "  NOT AS RECORDED"
        verdict += "  ABOVE ITS BOUND" if ratio > bound else ""
        passes = passes and not verdict
        print(line.format(operation, own, other, f"{ratio:.2f}", f"{bound:.2f}", reading, library, verdict))
    if is_recording and passes:
        record_counts(compiler, rows)
    sys.exit(not passes)


if __name__ == "__main__":
    main()
