# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The cost of many cyclic reads in the plan of a bus.

Compiling: the instructions that the compilers execute for a program that makes a bus of the plan, steps it and asks for
the values of each read. They are counted for 31 reads and for 247, one of each node that a line can have. Fails if each
further read costs more than its bound (for g++ 12 and clang++ 14): the compiler's work must not grow with the square of
the number of reads. Fails if a figure is more than NEAR from bench/figures/plan_cost.tsv, with the same compiler.

Running: the instructions of a step while no read is due (bench_idle_step.cpp). Fails if they are more with 60 reads
than with 2, but for a tenth.

Valgrind counts them, so they are the same in every run with one compiler in one folder.

plan_cost.py [--record]    --record: writes the compilers' figures there, and into bench/README.md
"""
import re
import sys

from measuring import ROOT, built, compiler_instructions, is_near, record, recorded_with, run

FEW, MANY = 31, 247
BOUNDS = {"g++": 4190, "clang++": 7950}  # thousands
# Per cent. What clang++ does in its tables depends on the path of the folder: 1.2 % between two of them.
NEAR = {"g++": 1, "clang++": 3}
FIGURES = "bench/figures/plan_cost.tsv"
COMMENT = "# compiler, thousand instructions that it executes for each further read"
HEAD = """#include <servobus/servobus.hpp>
using namespace servobus;
struct meter { static constexpr profile facts{.name = "meter"}; };
constexpr reg<u16, access::ro, meter> level{0x0010, full<u16>, no_unit, no_default};
struct uart {
    transfer send(bytes);
    bool sent();
    transfer receive(byte_buffer);
    instant now();
};
"""


def source(reads):
    """A bus with so many reads of different nodes."""
    entries = ",\n    ".join(f"cyclic<level>(node<meter>{{{i + 1}}}, milliseconds(5000))" for i in range(reads))
    values = "".join(f"    if (const auto seen = all.latest<level>(node<meter>{{{i + 1}}}, milliseconds(9000))) sum += *seen;\n"
                     for i in range(reads))
    return (f"inline constexpr poll_plan plan{{modbus::timing_at(115200),\n    {entries}}};\n"
            "unsigned step(scheduled_line<uart>& wire) {\n    auto all = make_bus<plan>(wire);\n"
            f"    unsigned sum = all.step().us;\n{values}    return sum;\n}}\n")


def print_costs(compiler):
    """False if a figure is above its bound, or not as recorded."""
    few, many = source(FEW), source(MANY)
    counted = compiler_instructions([few, many], compiler, HEAD)
    thousands = (counted[many] - counted[few]) // (MANY - FEW) // 1000
    verdict = "" if thousands <= BOUNDS[compiler] else "  ABOVE ITS BOUND"
    known = recorded_with(compiler, FIGURES)
    if not is_recording and not is_near(thousands, known, compiler, NEAR[compiler]):
        verdict += f"  RECORDED: {known.get(compiler, ['nothing'])[0]}"
    lines.append(f"{compiler}\t{thousands}")
    print(f"{compiler:10}{thousands:10}{BOUNDS[compiler]:10}{verdict}")
    return not verdict


def idle_step(program, reads):
    """The instructions of a step while no read is due."""
    def counted(steps):
        done = run("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, reads, steps)
        return int(re.search(r"Collected : *(\d+)", done.stdout)[1])

    return (counted(3000) - counted(1000)) // 2000


is_recording = sys.argv[1:] == ["--record"]
lines = []
print(f"{'a read':10}{'counted':>10}{'bound':>10}  (thousand instructions, from {FEW} reads to {MANY})")
passes = [print_costs(compiler) for compiler in BOUNDS]
program = built("idle_step", ROOT / "bench/bench_idle_step.cpp")
two, sixty = (idle_step(program, reads) for reads in (2, 60))
passes.append(10 * sixty <= 11 * two)
print(f"an idle step with 2 reads: {two} instructions, with 60: {sixty}{'' if passes[-1] else '  NOT CONSTANT'}")
if is_recording and all(passes):
    record(FIGURES, lines, "g++ clang++", COMMENT)
sys.exit(not all(passes))
