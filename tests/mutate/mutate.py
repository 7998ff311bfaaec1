# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Changes the core headers one place at a time and counts the changes that the tests detect. See run.sh."""
import argparse
import collections
import concurrent.futures
import os
import shutil
import sys
import tempfile
import threading
from pathlib import Path

import judge
import meaning
import sites

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# The register tables, the simulators and the hosted parts have tests of another kind.
ROOMS = ("core", "modbus", "line", "client", "server", "control", "bus", "explain", "axis")
REGISTER_HEADERS = ("block", "coil_value", "register_value", "table_readings", "format", "wire", "unit")
REGISTER_HEADERS += ("catalogue", "profile", "line_choices")
# Of each device what its facade is made of.
FACADE_HEADERS = """basic_drive drive model prepared_command commands routines setting_routines set_up_progress moves
motion feedback hold axis_drive axes robot robot_model wheel_step counted_model""".split()
ENOUGH_PERCENT = 95


def headers(root):
    core = root / "include" / "servobus"
    files = [p for room in ROOMS for p in (core / room).rglob("*.hpp")]
    files += [core / "registers" / f"{name}.hpp" for name in REGISTER_HEADERS]
    files += [p for name in FACADE_HEADERS for p in (core / "device").glob(f"*/{name}.hpp")]
    return sorted(str(p.relative_to(root)) for p in files)


def known_survivors():
    """Paragraphs of survivors.txt: the file and the change, the text of the line, and the reason."""
    known = {}
    for paragraph in (HERE / "survivors.txt").read_text().split("\n\n"):
        lines = [line for line in paragraph.splitlines() if not line.startswith("#")]
        if not lines:
            continue
        file, what = lines[0].split(": ", 1)
        known[file, what, lines[1].strip()] = " ".join(line.strip() for line in lines[2:])
    return known


def arguments():
    parser = argparse.ArgumentParser(prog="mutate/run.sh", allow_abbrev=False)
    parser.add_argument("--mutants", type=int, metavar="N")
    parser.add_argument("--meaning", action="store_true")
    parser.add_argument("--from", dest="first", type=int, default=1, metavar="K")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--one", type=int, metavar="K")
    parser.add_argument("--only", metavar="FILE:LINE")
    parser.add_argument("--in", dest="within", metavar="PATH[,PATH]")
    asked = parser.parse_args()
    if asked.mutants is None:
        asked.mutants = sys.maxsize if asked.meaning else 60
    return asked


def selected(every, asked):
    """(number, site) of each requested change."""
    within = tuple(f"include/servobus/{path}" for path in asked.within.split(",")) if asked.within else ""
    every = [s for s in every if s.file.startswith(within)]
    numbered = list(enumerate(every if asked.meaning else sites.chosen(every, asked.seed), 1))
    if asked.only:
        file, _, line = asked.only.rpartition(":")
        return [(k, s) for k, s in numbered if s.file.endswith(file) and str(s.line) == line]
    if asked.one:
        return numbered[asked.one - 1 : asked.one]
    return numbered[asked.first - 1 : asked.mutants]


def problems(every, known, tests):
    keys = {s.key for s in every}
    yield from (f"survivors.txt: no such change any more: {': '.join(k)}" for k in known if k not in keys)
    yield from (f"survivors.txt: no reason: {': '.join(k)}" for k, reason in known.items() if not reason)
    yield from tests.problems()


def judged_all(mutants, known, quick, tests, work):
    """Prints one line for each mutant, and counts the verdicts."""
    main_object = work / "main.o"
    baseline = judge.Baseline(judge.Bench(tests, work, main_object, None))
    baseline.bench.compile("tests/run/main.cpp", main_object)
    own = threading.local()

    def judged(site):
        if not hasattr(own, "bench"):
            own.bench = judge.Bench(tests, work, main_object, baseline)
        # A mutant listed as equivalent is tried only with the likely tests, in case it is listed wrongly.
        return own.bench.judge(site, likely_only=quick or site.key in known)

    count = collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for (k, s), verdict in zip(mutants, pool.map(judged, [s for _, s in mutants])):
            kind = verdict.kind
            said = {
                "stillborn": f"stillborn ({verdict.by})",
                "compiler": f"killed by the compiler ({verdict.by})",
                "tests": f"killed by {verdict.by}",
                "survived": "SURVIVED",
            }[kind]
            if s.key in known:
                if kind == "survived":
                    kind, said = "equivalent", f"survived, as it must: {known[s.key]}"
                else:
                    said += "; survivors.txt lists it, WRONGLY"
                    count["listed wrongly"] += 1
            count[kind] += 1
            print(f"{k:4} {s.where}: {s.what}: {said}", flush=True)
            if kind == "survived":
                print(f"       {s.line_text}", flush=True)
    return count


def main():
    asked = arguments()
    with tempfile.TemporaryDirectory() as folder:
        # Everything runs on this copy, so that edits of the tree meanwhile have no effect.
        work = Path(folder)
        root = work / "tree"
        for part in judge.PARTS:
            shutil.copytree(ROOT / part, root / part)
        every = sites.sites_of(root, headers(root))
        try:
            of_meaning = meaning.changes_of(root, HERE / "meaning.txt")
        except ValueError as why:
            print(f"mutate/run.sh: {why}")
            return 1
        known = known_survivors()
        tests = judge.Tests(root, HERE / "first.txt")
        wrong = list(problems(every + of_meaning, known, tests))
        mutants = selected(of_meaning if asked.meaning else every, asked)
        if not mutants:
            wrong.append("nothing there can be changed")
        for problem in wrong:
            print(f"mutate/run.sh: {problem}")
        if wrong:
            return 1
        if asked.list:
            for k, s in mutants:
                print(f"{k:4} {s.where}: {s.what} in: {s.line_text}")
            print(f"mutate/run.sh: {len(mutants)} of {len(every)} changes listed")
            return 0
        try:
            count = judged_all(mutants, known, asked.quick, tests, work)
        except judge.Unsound as why:
            print(f"mutate/run.sh: {why}")
            return 1

    killed = count["compiler"] + count["tests"]
    judged = killed + count["survived"]
    percent = 100 * killed / judged if judged else 100
    print(
        f"mutate/run.sh: {len(mutants)} mutants ({'of meaning' if asked.meaning else f'seed {asked.seed}'}): {count['stillborn']} stillborn, "
        f"{count['compiler']} killed by the compiler, {count['tests']} killed by tests, "
        f"{count['equivalent']} equivalent, {count['survived']} survived: {percent:.1f} % killed"
    )
    return 1 if percent < ENOUGH_PERCENT or count["listed wrongly"] else 0


sys.exit(main())
