# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""windows/serial.hpp on wine, against a peer that plays the other end and against a simulated drive.

port.py TOOL BUILD
"""
import sys
from pathlib import Path

import wine
from checks import WARNINGS, begin, finish, of_program, same, until, work

tool, build = sys.argv[1:]
folder = work()
wine.begin_wine(folder, Path(build) / "wine")
strict = ["-std=c++20", *WARNINGS, "-Iinclude", "-O1"]
wine.built("mingw: the port's test", "x86_64-w64-mingw32-g++", *strict, "-fno-exceptions", "-fno-rtti", "-static",
           "tests/windows/port.cpp", "-o", folder / "port.exe")
wine.built("the peer", "g++", *strict, "tests/windows/peer.cpp", "-o", folder / "peer")
peer = begin(folder / "peer", folder / "peer_line")
until((folder / "peer_line").exists, peer, "the peer")
wine.com(12, folder / "peer_line")
wine.begin_drive(tool, folder / "drive")
wine.com(3, folder / "drive")
of_program("bytes on COM12", wine.in_wine(folder / "port.exe", "bytes", "COM12").stdout, 72)
of_program("a drive on COM3", wine.in_wine(folder / "port.exe", "drive", "COM3").stdout, 9)
same("a drive on COM3, named with its prefix",
     "ok      it responds\n", wine.in_wine(folder / "port.exe", "look", r"\\.\COM3").stdout)
finish()
