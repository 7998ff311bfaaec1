# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Programs that use every header of the library give no warning, from a compiler or an analyser.

programs.py g++ | clang-tidy | cppcheck

g++ optimises them in two ways, since it gives some warnings only then; the unit tests have -O0 and -O1. clang-tidy gives
the warnings of clang++ too.
cppcheck gets clients and ports only: it would take four times as long with simulated drives and facades.
The analysers are set up as a user's would be who drops the headers in: .clang-tidy says what is left out, and why.
windows/headers.py has those of windows/.
"""
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Clients of every kind and a server; servers of rows; the network's ports; values of every type; the simulated drives with a
# bus, and the judges of a drive; the facades over a serial port, robots and axes, and the explanation of frames. As few as
# possible: an analyser looks at a header once for each program.
ANALYSED = [f"tests/warnings/{name}.cpp" for name in ("clients", "servers", "network", "values", "simulators", "facades")]
SOURCE = ["-std=c++20", "-Iinclude", "-I."]
STRICT = ["-Wall", "-Wextra", "-Werror"]
CPPCHECK = ["--std=c++20", "--enable=warning,performance,portability", "--inline-suppr", "--error-exitcode=1", "-q"]


def commands(judge: str) -> list[list[str]]:
    if judge == "g++":
        return [["g++", *SOURCE, *STRICT, level, "-c", program, "-o", "/dev/null"]
                for level in ("-O3", "-Os") for program in ANALYSED]
    if judge == "clang-tidy":
        return [["clang-tidy", "--quiet", "--checks=clang-diagnostic-*", program, "--", *SOURCE, "-Wall", "-Wextra"]
                for program in ANALYSED]
    if judge == "cppcheck":
        return [["cppcheck", *CPPCHECK, "-Iinclude", "-I.", program] for program in ANALYSED[:3]]
    sys.exit(__doc__)


def run(command: list[str]) -> subprocess.CompletedProcess:
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def unused_headers() -> set[str]:
    headers = {str(p.relative_to(ROOT)) for p in ROOT.glob("include/servobus/**/*.hpp")}
    used = set()
    for program in ANALYSED:
        used |= set(run(["g++", *SOURCE, "-MM", program]).stdout.split())
    return {header for header in headers - used if "/windows/" not in header}


def main() -> None:
    judge = sys.argv[1] if len(sys.argv) == 2 else ""
    todo = commands(judge)
    failed = 0
    if unused := unused_headers():
        sys.exit(f"FAILED: no program here uses {' '.join(sorted(unused))}")
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for command, done in zip(todo, pool.map(run, todo)):
            if done.returncode:
                print("FAILED ", *command, "\n" + done.stdout + done.stderr)
                failed += 1
    print(f"{len(todo)} runs of {judge}, {failed} with a warning")
    sys.exit(failed != 0)


main()
