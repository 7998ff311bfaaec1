# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Runs the simulation with one defect of defects.txt at a time. See ../judges.sh."""
import concurrent.futures
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CXX = os.environ.get("CXX", "g++").split()
FLAGS = "-std=c++20 -O1 -w -Iinclude -I.".split()
SEEDS = os.environ.get("SEEDS", "20000")


@dataclass(frozen=True)
class Defect:
    header: str
    after: str
    old: list
    new: list
    options: list
    judge: str


def defects():
    for paragraph in (HERE / "defects.txt").read_text().split("\n\n"):
        lines = [line for line in paragraph.splitlines() if line and not line.startswith("#")]
        if not lines:
            continue
        after = [line[len("after ") :] for line in lines[1:-1] if line.startswith("after ")]
        old = [line[2:] for line in lines[1:-1] if line.startswith("- ")]
        new = [line[2:] for line in lines[1:-1] if line.startswith("+")]
        options = [word for line in lines[1:-1] if line.startswith("sim ") for word in line.split()[1:]]
        yield Defect(lines[0], after[0] if after else "", old, new, options, lines[-1])


def put_into(defect, root):
    """Changes the header. Returns what is wrong with the defect's paragraph, or an empty string."""
    path = root / "include" / "servobus" / defect.header
    lines = path.read_text().split("\n")
    texts = [line.strip() for line in lines]
    first = 0
    if defect.after:
        if texts.count(defect.after) != 1:
            return f"`{defect.after}` is there {texts.count(defect.after)} times"
        first = texts.index(defect.after) + 1
    size = len(defect.old)
    places = [k for k in range(first, len(texts)) if texts[k : k + size] == defect.old]
    if not places or (len(places) > 1 and not defect.after):
        return f"`{defect.old[0]}` is there {len(places)} times"
    at = places[0]
    lines[at : at + size] = defect.new
    path.write_text("\n".join(lines))
    return ""


def judged(numbered):
    k, defect = numbered
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for part in ("include", "tests"):
            shutil.copytree(ROOT / part, root / part)
        problem = put_into(defect, root)
        if problem:
            return k, defect, False, problem
        build = subprocess.run(
            [*CXX, *FLAGS, "tests/sim/main.cpp", "-o", "sim"], cwd=root, capture_output=True, text=True
        )
        if build.returncode != 0:
            return k, defect, False, "it does not compile: " + build.stderr.splitlines()[0]
        command = ["./sim", "--seeds", SEEDS, *defect.options]
        run = subprocess.run(command, cwd=root, capture_output=True, text=True, errors="replace")
        said = [line for line in (run.stdout + run.stderr).splitlines() if defect.judge in line]
        if run.returncode == 0:
            return k, defect, False, "no judge has found it"
        if not said:
            output = (run.stdout + run.stderr).splitlines()
            found = next((line for line in output if "seed" in line), output[-1])
            return k, defect, False, f"found, but as: {found}"
        return k, defect, True, said[0].strip()


def list_all():
    """Puts each defect into a copy and builds nothing: finds lines that are not there any more."""
    failed = 0
    for k, defect in enumerate(defects(), 1):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "include" / "servobus" / defect.header
            path.parent.mkdir(parents=True)
            shutil.copy(ROOT / "include" / "servobus" / defect.header, path)
            problem = put_into(defect, Path(folder))
        failed += problem != ""
        print(f"{k:2} {defect.header}: {problem or defect.judge}")
    return 1 if failed else 0


def main():
    if sys.argv[1:] == ["--list"]:
        return list_all()
    wanted = {int(k) for k in sys.argv[1:]}
    every = [(k, d) for k, d in enumerate(defects(), 1) if not wanted or k in wanted]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for k, defect, is_found, said in pool.map(judged, every):
            failed += not is_found
            print(f"{'ok    ' if is_found else 'FAILED'} {k:2} {defect.header}: {defect.judge}: {said}", flush=True)
    print(f"judges.sh: {len(every)} defects, {failed} not found by their judge")
    return 1 if failed or not every else 0


sys.exit(main())
