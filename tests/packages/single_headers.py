# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The joined headers: each alone and the README's programs by g++ and clang++, all together in both orders by four."""
import re

from package_tree import folder, make_tree, maker, out
from checks import ROOT, check, expect, finish, must, need, passes, run

need("g++", "g++")
need("clang++", "clang", "libc6-dev")
need("arm-none-eabi-g++", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", "libstdc++-arm-none-eabi-newlib")
need("x86_64-w64-mingw32-g++", "g++-mingw-w64-x86-64")
COMPILERS = {"g++": [], "clang++": [], "arm-none-eabi-g++": ["-mcpu=cortex-m4", "-mthumb"],
             "x86_64-w64-mingw32-g++": []}
STRICT = ["-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror", f"-I{out}/single",
          "-I."]
DRIVES = {"zlac8015d": "zlac8015d::drive", "yako": "yako::closed_loop::drive", "c630s": "c630s::drive"}
# The headers that the README's programs include, and the single ones in their place.
SINGLE = [(r"<servobus/device/(\w+)\.hpp>", r"<servobus_\1.hpp>"),
          ("<servobus/posix/serial.hpp>", "<servobus_posix.hpp>"), ("<servobus/servobus.hpp>", "<servobus.hpp>"),
          ("<servobus/words.hpp>", "<servobus.hpp>")]


def alone(compiler, header, *defines):
    passes(f"{compiler[0]}: {header} alone", *compiler, *STRICT, "-fno-exceptions", "-fno-rtti",
           f"-DSINGLE_HEADER=<{header}>", *defines, "-c", "tests/packages/single/alone.cpp", "-o", folder / "alone.o")


def linked(compiler):
    for source in ("one", "two"):
        must(*compiler, *STRICT, "-fno-exceptions", "-fno-rtti", "-c", f"tests/packages/single/{source}.cpp",
             "-o", folder / f"{source}.o")
    must(*compiler, folder / "one.o", folder / "two.o", *(["--specs=nosys.specs"] if "-mthumb" in compiler else []),
         "-o", folder / "single")


def readme_programs(compiler):
    programs = re.findall(r"^```cpp\n(.*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.M | re.S)
    expect(len(programs) >= 3, f"only {len(programs)} programs")
    for program in programs:
        for header, single in SINGLE:
            program = re.sub(header, single, program)
        expect("<servobus/" not in program, program)
        must(compiler, *STRICT, "-c", "-x", "c++", "-", "-o", folder / "program.o", typed=program)


make_tree()
must(*maker(), out)
for name, options in COMPILERS.items():
    compiler = [name, *options]
    if name in ("g++", "clang++"):
        alone(compiler, "servobus.hpp")
        for drive, type_name in DRIVES.items():
            alone(compiler, f"servobus_{drive}.hpp", f"-DDRIVE={type_name}", f"-DCOMMANDS={drive}")
        alone(compiler, "servobus_posix.hpp")
    check(f"{name}: all in two orders, linked", linked, compiler)
    if name in ("g++", "clang++"):
        passes(f"{name}: the program of both sources runs", folder / "single")
        check(f"{name}: the README's first programs with single headers", readme_programs, name)
passes("g++: servobus.hpp computes no table of a CRC", "g++", "-std=c++20", f"-I{out}/single", "-fsyntax-only",
       "-fconstexpr-ops-limit=2000", "-x", "c++", "-", typed="#include <servobus.hpp>\n")
done = run("g++", "-std=c++17", f"-I{out}/single", "-fsyntax-only", "-x", "c++", "-", typed="#include <servobus.hpp>\n")
check("g++ as C++17: servobus.hpp is refused in few lines", expect,
      "servobus needs C++20" in done.stdout and done.stdout.count("\n") < 15, done.stdout)
finish()
