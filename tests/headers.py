# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Compiles each header of the library alone, without making code, and names those that do not compile.

headers.py [--together] [--without FOLDER]... COMPILER FLAG...     FOLDER: of include/servobus, such as posix
--together: all in one program. That a header compiles alone depends on the standard library, not on the compiler.
JOBS in the environment: compilers at a time, 2 if not given
"""
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INCLUDE = ROOT / "include"

arguments = sys.argv[1:]
together = arguments[:1] == ["--together"]
arguments = arguments[together:]
without = set()
while arguments[:1] == ["--without"] and len(arguments) > 1:
    without.add(arguments[1])
    arguments = arguments[2:]
if not arguments or any(not (INCLUDE / "servobus" / folder).is_dir() for folder in without):
    sys.exit(__doc__)


def problem_of(included):
    """What the compiler says, or that it has failed; empty if the headers compile."""
    command = [*arguments, f"-I{INCLUDE}", "-x", "c++", "-fsyntax-only", "-"]
    program = "".join(f"#include <{header}>\n" for header in included)
    done = subprocess.run(command, input=program, capture_output=True, text=True, cwd=ROOT)
    return "" if done.returncode == 0 else f"status {done.returncode}\n{done.stderr}"


headers = [
    str(path.relative_to(INCLUDE))
    for path in sorted((INCLUDE / "servobus").rglob("*.hpp"))
    if path.relative_to(INCLUDE / "servobus").parts[0] not in without
]
with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
    programs = [headers] if together else [[header] for header in headers]
    failed = [(included, said) for included, said in zip(programs, pool.map(problem_of, programs)) if said]
for included, said in failed:
    print(f"FAILED  {'all headers' if together else included[0]}\n{said[:2000]}")
print(f"{len(headers)} headers, {len(failed)} of {len(programs)} programs do not compile ({' '.join(arguments)})")
sys.exit(1 if failed or not headers else 0)
