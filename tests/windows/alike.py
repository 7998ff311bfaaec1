# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The command-line tool of Windows on wine beside the one of this machine, both at one simulated drive."""
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import on_wine
import wine
from checks import check, expect, expect_lines, expect_same, finish, run, same, text_of, work

folder = work()
drive = folder / "drive"
# The times in an output, and what stands for them.
TIMES = [(r"^\d*\.\d{3} ", "T "), (r"[-0-9]{10}T[0-9:.]{12}Z", "T"), (r"T,([^,\n]*),\d{13}", r"T,\1,T"),
         (r'"unix_ms":\d*', "T")]


@dataclass
class Said:
    """A tool's output and errors, without times and the name of its port, and its status."""
    status: int
    out: str
    err: str

    @classmethod
    def of(cls, done, port):
        def plain(text):
            text = text.replace(str(port), "PORT")
            for pattern, words in TIMES:
                text = re.sub(pattern, words, text, flags=re.M)
            return text
        return cls(done.returncode, plain(done.stdout), plain(done.stderr))


def by_linux(*words, typed=""):
    """What this machine's tool says. PORT among the words is the drive's port."""
    return Said.of(run(os.environ["SERVOBUS"], *(drive if word == "PORT" else word for word in words),
                       typed=typed, apart=True), drive)


def by_windows(*words, typed=""):
    done = on_wine.run(["COM15" if word == "PORT" else str(word) for word in words], typed.encode())
    done.stdout, done.stderr = done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")
    return Said.of(done, "COM15")


def expect_alike(name, status, words, typed):
    """Each call of a port passes through wine's server.

    On a busy machine a request and its response may both have passed before the tool sees that the request has left.
    Then the line discards the response, since it cannot tell it from an echo (G3), and the tool says: no response. So
    what ends with these words is tried three times.
    """
    for attempt in range(1, 4):
        linux, windows = by_linux(*words, typed=typed), by_windows(*words, typed=typed)
        if "no response" not in windows.err or "no response" in linux.err:
            break
        on_wine.again(f"{name}: no response, attempt {attempt}")
    expect_lines(linux.out, windows.out)
    expect_lines(linux.err, windows.err)
    expect_same((status, status), (linux.status, windows.status))


def alike(name, status, *words, typed=""):
    """Both say the same, and end with this status."""
    check(f"the tool: {name}", expect_alike, name, status, words, typed)


def says(name, status, out, *words):
    """The tool of Windows has this output. A response lost as expect_alike says leaves a line out, with no word of it."""
    for attempt in range(1, 4):
        said = by_windows(*words)
        if (said.status, said.out) == (status, out):
            break
        on_wine.again(f"{name}: {said}, attempt {attempt}")
    same(f"the tool: {name}", (status, out), (said.status, said.out))


def complains(name, status, err, *words):
    """The tool of Windows has these errors."""
    said = by_windows(*words)
    same(f"the tool: {name}", (status, err), (said.status, said.err))


def complains_of(name, begin, *words):
    """The tool of Windows has a line of errors that begins with these words, and fails."""
    said = by_windows(*words)
    check(f"the tool: {name}", expect, said.status == 1 and re.search(f"^{re.escape(begin)}", said.err, re.M), said)


def main(parts):
    """Runs one of the parts: PROGRAM.py TOOL BUILD PART"""
    tool, build, part = sys.argv[1:]
    again = folder / "again"
    os.environ.update(ON_WINE="1", SERVOBUS=tool, SERVOBUS_EXE=f"{build}/servobus.exe", SERVOBUS_AGAIN=str(again))
    wine.begin_wine(folder, Path(build) / "wine")
    wine.com(12, folder / "nobody")
    parts[part]()
    print(text_of(again), end="")
    finish()


def begin_drive():
    """The drive of PORT, which is COM3 too."""
    wine.begin_drive(os.environ["SERVOBUS"], drive)
    for number in (3, 15):
        wine.com(number, drive)
