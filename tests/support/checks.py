# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks of a test program: prints a line for each, then a summary, and ends with status 1 if one failed.

Also what such programs share: commands, programs in the background, packages of Debian, a folder that goes away.
"""
import atexit
import difflib
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
NAME = Path(sys.argv[0]).name
SKIPPED = 77  # CTest's SKIP_RETURN_CODE
WARNINGS = "-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror".split()

results = []
sys.stdout.reconfigure(line_buffering=True)
signal.signal(signal.SIGTERM, lambda *_: sys.exit(2))


class Wrong(Exception):
    """What a check found."""


def expect(holds, found):
    if not holds:
        raise Wrong(found)


def expect_same(expected, found):
    expect(expected == found, f"expected {expected!r}, found {found!r}")


def expect_lines(expected, found):
    """Two texts of many lines are the same."""
    differences = difflib.unified_diff(expected.splitlines(), found.splitlines(), "expected", "found", n=0, lineterm="")
    expect(expected == found, "\n".join([*differences][:10]) or "other line ends")


def check(name, function, *arguments, **more):
    """Passes if the function raises no Wrong. True if it passed."""
    try:
        function(*arguments, **more)
    except Wrong as wrong:
        return report("FAILED", name, wrong)
    return report("ok", name)


def report(result, name, found=""):
    """Prints and counts a check's result."""
    results.append(result)
    lines = str(found).rstrip().split("\n")[-40:] if found else []
    print("\n".join([f"{result:7} {name}", *(f"        {line[:300]}" for line in lines)]))
    return result == "ok"


def same(name, expected, found):
    return check(name, expect_same, expected, found)


def passes(name, *command, **more):
    """A check that is a command."""
    return check(name, must, *command, **more)


def of_program(name, output, count=None):
    """Counts the checks that a program has printed, and how many they are."""
    print(output, end="")
    printed = re.findall(r"^(ok|FAILED) ", output, re.M)
    results.extend(printed)
    if count is not None:
        same(f"{name}: the program has made all its checks", count, len(printed))


def finish():
    print(f"{NAME}: {len(results)} checks, {results.count('FAILED')} failed")
    sys.exit(1 if "FAILED" in results or not results else 0)


def skip(why):
    print(f"{NAME}: skipped: {why}")
    sys.exit(SKIPPED)


def run(*command, typed="", apart=False, **more):
    """Runs a command in the project's folder: its status and output, with its errors unless they stand apart."""
    done = subprocess.run([str(word) for word in command], **{"cwd": ROOT, **more}, input=typed.encode(),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE if apart else subprocess.STDOUT)
    done.stdout = done.stdout.decode("utf-8", "replace")
    done.stderr = (done.stderr or b"").decode("utf-8", "replace")
    return done


def must(*command, **more):
    """Runs a command that must succeed: its output."""
    done = run(*command, **more)
    expect(done.returncode == 0, f"{done.stdout}{done.stderr}\nstatus {done.returncode}: {' '.join(map(str, command))}")
    return done.stdout


def must_fail(words, *command, **more):
    """Runs a command that must fail and say so."""
    done = run(*command, **more)
    expect(done.returncode != 0, f"{done.stdout}\nstatus 0")
    expect(words in done.stdout + done.stderr, f"{done.stdout}{done.stderr}\nwithout: {words}")


def work():
    """A folder that goes away when the program ends."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def begin(*command, out=subprocess.DEVNULL, err=subprocess.STDOUT, **more):
    """Begins a program in the background, which ends with this one. `out` and `err` may be paths of files."""
    def opened(to):
        return open(to, "wb") if isinstance(to, Path) else to

    process = subprocess.Popen([str(word) for word in command], **{"cwd": ROOT, "stdin": subprocess.DEVNULL, **more},
                               stdout=opened(out), stderr=opened(err))
    atexit.register(end, process)
    return process


def end(process, how=signal.SIGTERM):
    """Ends a program in the background: its status."""
    if process.poll() is None:
        process.send_signal(how)
    return process.wait()


def until(holds, process, what):
    """Waits until it holds; what it found. Raises Wrong if the process ends before."""
    while not (found := holds()):
        expect(process.poll() is None or (found := holds()), f"{what}: the program ended with {process.returncode}")
        time.sleep(0.02)
    return found


def text_of(path):
    """The text of a file, which need not exist, with the line ends that it has."""
    return path.read_bytes().decode("utf-8", "replace") if path.exists() else ""


def install(*packages):
    """Installs packages of Debian or Ubuntu, and says so; True if it could."""
    print(f"{NAME}: installing {' '.join(packages)} with apt-get")
    as_root = [] if os.geteuid() == 0 else ["sudo"]
    subprocess.run([*as_root, "apt-get", "update", "-qq"])
    done = subprocess.run([*as_root, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "install", "-y", "-qq",
                           "--no-install-recommends", *packages], stdout=subprocess.DEVNULL)
    return done.returncode == 0


def has(there, *packages):
    """True if a command or a path is there, if need be after the packages were installed."""
    def is_there():
        return there() if callable(there) else Path(there).exists() if "/" in there else shutil.which(there) is not None

    return bool(is_there() or install(*packages) and is_there())


def need(there, *packages):
    if not has(there, *packages):
        sys.exit(f"{NAME}: {' '.join(packages)} could not be installed")
