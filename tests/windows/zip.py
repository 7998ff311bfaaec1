# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The zip for Windows that CPack makes of what programs.py has built.    zip.py TOOL BUILD"""
import os
import shutil
import sys
from pathlib import Path

import wine
from checks import ROOT, check, expect_lines, expect_same, finish, must, need, same, work


def pack(to, **more):
    must("cpack", "-D", f"CPACK_PACKAGE_DIRECTORY={to}", cwd=build, **more)
    shutil.rmtree(to / "_CPack_Packages")


def has_tool_page_and_license():
    must("unzip", "-q", packed / f"{name}.zip", "-d", folder)
    expect_same(["LICENSE.txt", "README.md", "servobus.exe"], sorted(os.listdir(unpacked)))
    must("cmp", unpacked / "LICENSE.txt", ROOT / "LICENSE")
    must("cmp", unpacked / "README.md", ROOT / "examples/servobus/README.md")


tool, build = sys.argv[1:]
need("unzip", "unzip")
folder = work()
packed = folder / "packed"
check("CPack makes the zip for Windows", pack, packed)
check("the zip again, in another umask and time zone", pack, folder / "again", umask=0o077,
      env={**os.environ, "TZ": "Asia/Tokyo"})
check("the same bytes", must, "diff", "-r", packed, folder / "again")
same("a zip and its sum", 2, len([*packed.iterdir()]))
name = next(packed.glob("servobus-*-windows-x86_64.zip")).stem
unpacked = folder / name
check("it has the tool, its page and the license", has_tool_page_and_license)
wine.begin_wine(folder, Path(build) / "wine")
same("its tool runs on wine", must(tool, "--version"), wine.in_wine(unpacked / "servobus.exe", "--version").stdout)
check("and has the same map", lambda: expect_lines(must(tool, "map", "c630s"),
                                                   wine.in_wine(unpacked / "servobus.exe", "map", "c630s").stdout))
finish()
