# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the checks of the last run have cost, beside the COST that their files state.

costs.py BUILD [--all]

Prints the CPU seconds by label, the checks whose COST is wrong by half and by at least 5 s (all checks with --all), those
that ran more than once since the machine was busy, and how many were left out since nothing has changed. COST: seconds of
a processor; of a check in real time, which waits, those of the clock.
"""
import json
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

WORTH_A_LINE = 5
UNKNOWN = ["none"], 0, False  # of a check that is there no more


def measured(build):
    """The last line of each check: CPU seconds, seconds of the clock, and how often it ran."""
    rows = {}
    for line in (build / "times.tsv").read_text("utf-8").splitlines():
        name, cpu, seconds, times = line.split("\t")
        rows[name] = float(cpu), float(seconds), int(times)
    return rows


def stated(build):
    """The labels and the COST of each check, 0 if none is stated, and whether it is in real time."""
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True, check=True)
    checks = {}
    for test in json.loads(listed.stdout)["tests"]:
        properties = {one["name"]: one["value"] for one in test["properties"]}
        is_real_time = "real_time" in test.get("command", [])
        checks[test["name"]] = properties.get("LABELS", ["none"]), properties.get("COST", 0), is_real_time
    return checks


def is_wrong(cost, seconds):
    return abs(cost - seconds) >= WORTH_A_LINE and not seconds / 1.5 <= cost <= seconds * 1.5


def main(words):
    if not words or words[1:] not in ([], ["--all"]):
        sys.exit(__doc__)
    build = Path(words[0])
    rows, checks = measured(build), stated(build)
    log = (build / "Testing/Temporary/LastTest.log").read_text("utf-8", "replace")
    sums = defaultdict(float)
    for name, (cpu, _, _) in rows.items():
        labels = checks.get(name, UNKNOWN)[0]
        sums[next((label for label in labels if label != "fast"), "none")] += cpu
    print("CPU seconds:", ", ".join(f"{label} {cpu:.0f}" for label, cpu in sorted(sums.items(), key=lambda one: -one[1])),
          f"\n             together {sum(sums.values()):.0f}")
    for name, (cpu, seconds, times) in sorted(rows.items(), key=lambda one: -one[1][0]):
        _, cost, is_real_time = checks.get(name, UNKNOWN)
        if words[1:] or is_wrong(cost, (seconds if is_real_time else cpu) / times):
            print(f"{name}: COST {cost:.0f}, {cpu / times:.0f} s of a processor, {seconds / times:.0f} s of the clock")
    again = [f"{name} ({times} times)" for name, (_, _, times) in sorted(rows.items()) if times > 1]
    left_out = log.count("\nunchanged since everything passed")
    print(f"again, since the machine was busy: {', '.join(again) or 'none'}; left out, since nothing changed that they judge: {left_out}")


main(sys.argv[1:])
