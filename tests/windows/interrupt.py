# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""S8: Ctrl-C ends an example program on wine, after it has stopped the wheels.    interrupt.py TOOL BUILD"""
import re
import shutil
import subprocess
import sys
from pathlib import Path

import wine
from checks import WARNINGS, begin, check, end, expect, finish, run, same, text_of, until, work
from ctrl_c import interrupted_on_a_terminal

TURNS = " 01 10 20 88 00 02 04 00 14 ff ec"
STANDS = """status_word=left_released+right_released (0x0000)
left_actual_speed=0.0 r/min
right_actual_speed=0.0 r/min
"""


class Tap:
    """The frames between the program, which has COM14, and the drive."""

    def __init__(self, folder):
        self.frames = folder / "frames"
        tapped = folder / "tapped"
        tapped.unlink(missing_ok=True)
        self.process = begin("socat", "-x", f"pty,raw,echo=0,link={tapped}", f"{folder / 'drive'},raw,echo=0",
                             out=subprocess.DEVNULL, err=self.frames)
        until(tapped.exists, self.process, "the tap")
        wine.com(14, tapped)

    def to_the_drive(self):
        end(self.process)
        return re.findall(r"^>.*\n(.*)", text_of(self.frames), re.M)


def is_stopped(name, status, said, tap):
    same(f"S8: {name} ends the program with an error", 1, status)
    frames = tap.to_the_drive()
    check(f"S8: {name}: it has said so", expect, len(re.findall("wheels: *interrupted", said)) == 1, said)
    same(f"S8: {name}: the wheels did turn", 1, sum(frame.startswith(TURNS) for frame in frames))
    same(f"S8: {name}: the last write is the stop, 07h to 200Eh", " 01 06 20 0e 00 07 a2 0b",
         [frame for frame in frames if re.match(" 01 (06|10) ", frame)][-1])
    left = run(tool, "read", folder / "drive", "zlac8015d", "status_word", "left_actual_speed", "right_actual_speed")
    same(f"S8: {name}: the wheels stand and are released", STANDS, left.stdout)


def on_a_terminal():
    tap = Tap(folder)
    status, said = interrupted_on_a_terminal("wine", folder / "wheels.exe", "COM14")
    is_stopped("Ctrl-C on a terminal", status, said, tap)


def of_the_console():
    tap = Tap(folder)
    out = folder / "out"
    program = begin("wine", "interrupt.exe", "turn", "wheels.exe", "COM14", cwd=folder, stdin=subprocess.PIPE, out=out)
    program.stdin.write(b"MOVE\n")
    program.stdin.close()
    until(lambda: "left" in text_of(out).partition("turning")[2], program, "the wheels turn")
    (folder / "turn").touch()
    is_stopped("a Ctrl-C of the console", program.wait(), text_of(out), tap)


tool, build = sys.argv[1:]
folder = work()
wine.begin_wine(folder, Path(build) / "wine")
shutil.copy(f"{build}/wheels.exe", folder)
wine.built("mingw: what interrupts it", "x86_64-w64-mingw32-g++", "-std=c++20", *WARNINGS, "-O1", "-static",
           "-fno-exceptions", "-fno-rtti", "tests/windows/interrupt.cpp", "-o", folder / "interrupt.exe")
wine.begin_drive(tool, folder / "drive")
wine.com(3, folder / "drive")
same("S8: without the typed consent nothing is sent", 1,
     wine.in_wine(folder / "wheels.exe", "COM3", typed="no\n").stdout.count("Nothing was sent"))
on_a_terminal()
of_the_console()
finish()
