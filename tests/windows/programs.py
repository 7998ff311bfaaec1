# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Builds the tool and the example wheels by mingw, and installs Windows for wine, for other tests.

programs.py BUILD      BUILD: a folder, which may be used again
"""
import sys
from pathlib import Path

import wine
from checks import WARNINGS, check, finish, must, need, passes, same

build, = sys.argv[1:]
need("x86_64-w64-mingw32-g++", "g++-mingw-w64-x86-64")
passes("mingw: configured", "cmake", "-S", ".", "-B", build, "-G", "Ninja", "-DSERVOBUS_TESTS=OFF",
       "-DCMAKE_TOOLCHAIN_FILE=examples/packages/windows/mingw.cmake", "-DCMAKE_BUILD_TYPE=Release",
       f"-DCMAKE_CXX_FLAGS_RELEASE=-O1 {' '.join(WARNINGS)}")
passes("mingw: the tool and the example wheels", "cmake", "--build", build, "-j1", "--target", "servobus_tool",
       "servobus_wheels")
libraries = [line.split()[-1] for line in must("x86_64-w64-mingw32-objdump", "-p", f"{build}/servobus.exe").split("\n")
             if "DLL Name: " in line]
same("the tool needs no library but those of Windows", ["KERNEL32.dll", "WS2_32.dll", "msvcrt.dll"], sorted(libraries))
if not (Path(build) / "wine").exists():
    check("wine begins", wine.install_windows, Path(build) / "wine")
finish()
