# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The cost of including a header: seconds (the shortest of five compilations), the memory of the compiler, and for the
umbrella header with one device the instructions that the compiler executes.

Cachegrind counts them, so they are the same in every run with one compiler. Fails if a device costs more instructions
than its bound (for g++ 12), which was 1 % above the counted figure when the bound was set. Nothing depends on the
seconds.

include_cost.py [--bounds]    --bounds: only the figures that have bounds
"""
import sys
from fnmatch import fnmatch

from measuring import ROOT, compiler_instructions, compiler_usage

UMBRELLA = "servobus/servobus.hpp"
MAPS = ("zlac8015d/registers", "yako/closed_loop", "yako/open_loop", "c630s/registers")
BOUNDS = {"zlac8015d": 882, "yako": 946, "c630s": 1217}  # millions


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


def print_instructions():
    """False if a device is above its bound."""
    programs = {device: including(UMBRELLA, f"servobus/device/{device}.hpp") for device in BOUNDS}
    counted = compiler_instructions(programs.values())
    millions = {device: counted[program] // 1_000_000 for device, program in programs.items()}
    print(f"{'the umbrella header and':36}{'million instr.':>14}{'bound':>14}")
    for device, bound in BOUNDS.items():
        verdict = "  ABOVE ITS BOUND" if millions[device] > bound else ""
        print(f"{f'device/{device}.hpp':36}{millions[device]:14}{bound:14}{verdict}")
    return all(millions[device] <= bound for device, bound in BOUNDS.items())


if __name__ == "__main__":
    if sys.argv[1:] != ["--bounds"]:
        print_seconds()
    sys.exit(not print_instructions())
