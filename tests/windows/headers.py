# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Every header but posix/ by mingw after <windows.h>; those of windows/ alone, with their examples."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import ROOT, WARNINGS, finish, must_fail, check, need, passes, work

need("x86_64-w64-mingw32-g++", "g++-mingw-w64-x86-64")
STRICT = ["x86_64-w64-mingw32-g++", "-std=c++20", *WARNINGS, "-Iinclude"]
BARE = [*STRICT, "-fno-exceptions", "-fno-rtti"]
FROM_INPUT = ["-x", "c++", "-fsyntax-only", "-"]

NO_MACRO_OF_OURS = """#include <servobus/windows/serial.hpp>
#include <winsock2.h>
#include <algorithm>
#if defined WIN32_LEAN_AND_MEAN || defined SERVOBUS_DEFINED_LEAN || defined SERVOBUS_DEFINED_NOMINMAX
#error a macro was left
#endif
int least(int a, int b) { return std::min(a, b); }
"""


def all_headers():
    include = ROOT / "include"
    headers = (str(path.relative_to(include)) for path in sorted(include.rglob("*.hpp")))
    return "".join(f"#include <{header}>\n" for header in headers if not header.startswith("servobus/posix/"))


def example_of(header):
    """The example in the first comment of a header, as a function."""
    lines = re.findall(r"^//     (.*)", (ROOT / f"include/servobus/windows/{header}.hpp").read_text("utf-8"), re.M)
    return (f"#include <servobus/servobus.hpp>\n#include <servobus/windows/{header}.hpp>\nint example() {{\n"
            + "\n".join(lines) + "\nreturn 0;\n}\n")


OTHER_ROOMS = [path.name for path in (ROOT / "include/servobus").iterdir() if path.is_dir() and path.name != "windows"]
passes("mingw: every header of windows/ compiles alone", sys.executable, "-B", "tests/headers.py",
       *(word for room in OTHER_ROOMS for word in ("--without", room)), *BARE)
before = work() / "before.hpp"
before.write_text("#include <windows.h>\n")
# All of them in one file, since what its macros break does not depend on the others.
passes("mingw: every header but posix/ compiles after <windows.h>",
       *BARE, "-include", before, *FROM_INPUT, typed=all_headers())
# The macros are defined, since otherwise the check above proves nothing.
check("mingw: a variable called near does not compile after <windows.h>",
      must_fail, "error: ", *BARE, "-include", before, *FROM_INPUT, typed="int near = 1;\n")
passes("mingw: after windows/serial.hpp there are winsock2.h and std::min, and no macro of ours",
       *BARE, *FROM_INPUT, typed=NO_MACRO_OF_OURS)
for header in ("clock", "serial", "tcp", "mbap", "detail/overlapped_transfer"):
    passes(f"mingw: the example in windows/{header}.hpp compiles",
           *BARE, "-Wno-unused", *FROM_INPUT, typed=example_of(header))
for program in ("stepper", "servo"):
    passes(f"mingw: the example {program} compiles", *STRICT, "-fsyntax-only", f"examples/{program}/main.cpp")
finish()
