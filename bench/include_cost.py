# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The cost of including a header: seconds (the shortest of five compilations), the memory of the compiler, and for some
headers, and the umbrella header with one device, the instructions that the compiler executes.

Cachegrind counts them, so they are the same in every run with one compiler. Fails if a device costs more instructions
than its bound (for g++ 12), which was 1 % above the counted figure when the bound was set, or if a figure is more than
1 % from bench/figures/include_cost.tsv, counted with the compiler that the file names. Nothing depends on the seconds.

include_cost.py [--bounds | --record]    --bounds: only the instructions; --record: writes them there, and into
                                         bench/README.md
"""
import sys
from fnmatch import fnmatch

from measuring import ROOT, compiler_instructions, compiler_usage, is_near, record, recorded_with

UMBRELLA = "servobus/servobus.hpp"
MAPS = ("zlac8015d/registers", "yako/closed_loop", "yako/open_loop", "c630s/registers")
FIGURES = "bench/figures/include_cost.tsv"
COMMENT = "# program, million instructions that the compiler executes"
HEADERS = ("span", "servobus/client/client.hpp", UMBRELLA)
BOUNDS = {"zlac8015d": 953, "yako": 1008, "c630s": 1294}  # millions


def including(*headers):
    """A program that includes them."""
    return "".join(f"#include <{header}>\n" for header in headers)


def public_headers():
    """Those of no device's, simulated drive's or Windows' own folder."""
    include = ROOT / "include"
    headers = (str(path.relative_to(include)) for path in include.rglob("*.hpp"))
    own = ("*/windows/*", "*/device/*/*", "*/sim/*/*")
    return sorted(header for header in headers if not any(fnmatch(header, pattern) for pattern in own))


def print_seconds():
    def row(name, *headers):
        seconds, megabytes = compiler_usage(including(*headers), 5)
        print(f"{name:52}{seconds:8.2f}{megabytes:6.0f}")

    print(f"{'header':52}{'seconds':>8}{'MB':>6}")
    row("nothing")
    row("<array> <span>, which are not included", "array", "span")
    for header in [*public_headers(), *(f"servobus/device/{name}.hpp" for name in MAPS)]:
        row(header, header)
    for device in BOUNDS:
        row(f"{UMBRELLA} and device/{device}.hpp", UMBRELLA, f"servobus/device/{device}.hpp")
    print()


def print_instructions(is_recording):
    """False if a device is above its bound, or a figure is not as recorded."""
    programs = {header: including(header) for header in HEADERS}
    programs |= {f"device/{device}.hpp": including(UMBRELLA, f"servobus/device/{device}.hpp") for device in BOUNDS}
    counted = compiler_instructions(programs.values())
    known = recorded_with("g++", FIGURES)
    lines, passes = [], True
    print(f"{'a header; the umbrella header and':36}{'million instr.':>14}{'bound':>14}")
    for name, program in programs.items():
        millions = counted[program] // 1_000_000
        bound = next((BOUNDS[device] for device in BOUNDS if name == f"device/{device}.hpp"), "")
        verdict = "  ABOVE ITS BOUND" if bound and millions > bound else ""
        if not is_recording and not is_near(millions, known, name):
            verdict += f"  RECORDED: {known.get(name, ['nothing'])[0]}"
        print(f"{name:36}{millions:14}{bound!s:>14}{verdict}")
        lines.append(f"{name}\t{millions}")
        passes = passes and not verdict
    if is_recording and passes:
        record(FIGURES, lines, "g++", COMMENT)
    return passes


if __name__ == "__main__":
    if not sys.argv[1:]:
        print_seconds()
    elif sys.argv[1:] not in (["--bounds"], ["--record"]):
        sys.exit(__doc__)
    sys.exit(not print_instructions(sys.argv[1:] == ["--record"]))
