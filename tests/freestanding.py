# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Targets without an operating system: every header but posix/ and windows/ for ARM with -ffreestanding, the library
for RISC-V (rv32imc), every header with the macros of an Arduino sketch, and the protocol core on an ATmega328P, built
by clang and run in simavr.
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))
from avr import clang_avr, libstdcpp, search_path
from checks import ROOT, WARNINGS, check, expect, finish, has, must, must_fail, need, passes, report, work

BARE = ["-std=c++20", *WARNINGS, "-fno-exceptions", "-fno-rtti", "-Iinclude", "-I."]
ARM = ["arm-none-eabi-g++", *BARE, "-mthumb", "-Os"]
M0 = [*ARM, "-mcpu=cortex-m0plus"]
FREESTANDING = [*BARE, "-Os", "-ffreestanding", "-nostdinc++"]
DEVICE = "tests/freestanding/device.cpp"
# An Arduino sketch has its macros before the headers of the library. After these macros no standard C++ header
# compiles, such as <span>. So the standard headers that the library includes come first, as in a sketch that includes
# them first.
HOSTILE = ["-include", "tests/freestanding/standard_headers.hpp", "-include", "tests/freestanding/arduino_macros.hpp"]
AVR_IO = "/usr/lib/avr/include/avr/io.h"
folder = work()


def headers(*left_out):
    include = ROOT / "include"
    found = sorted(str(path.relative_to(include)) for path in include.rglob("*.hpp"))
    return [header for header in found if not any(part in header for part in ("/posix/", "/windows/", *left_out))]


def all_headers(name, command, *left_out):
    """One source includes all headers, to save time."""
    text = "".join(f"#include <{header}>\n" for header in headers(*left_out))
    passes(name, *command, "-x", "c++", "-fsyntax-only", "-", typed=text)


def on_arm_and_riscv():
    all_headers("ARM, freestanding: all headers, Cortex-M0+", [*M0, "-ffreestanding"])
    all_headers("ARM, freestanding: all headers, Cortex-M4", [*ARM, "-mcpu=cortex-m4", "-ffreestanding"])
    passes("ARM, freestanding: umbrella, device, client", *M0, "-ffreestanding", "-c", DEVICE, "-o", folder / "arm.o")
    passes("RISC-V rv32imc, clang++: umbrella, device, client", "clang++", "--target=riscv32-unknown-elf",
           "-march=rv32imc", "-mabi=ilp32", *FREESTANDING, *libstdcpp(), *search_path("/arm-none-eabi/include$"),
           "-c", DEVICE, "-o", folder / "riscv.o")


def after_hostile_macros():
    all_headers("hostile macros, g++: all headers", ["g++", *BARE, *HOSTILE])
    all_headers("hostile macros, ARM: all headers", [*M0, *HOSTILE])
    # The macros are defined, since otherwise the checks above prove nothing.
    check("hostile macros: a header with a bare min does not compile", must_fail, "error", "g++", *BARE, *HOSTILE,
          "-x", "c++", "-fsyntax-only", "-",
          typed="#include <limits>\nint least() { return std::numeric_limits<int>::min(); }\n")


def link_avr(libgcc):
    """Not by the compiler driver: it lets Debian's avr-ld (2.26) relax the code, which moves clang's jumps to wrong
    targets.
    """
    must("avr-ld", "-mavr5", "--gc-sections", "-L/usr/lib/avr/lib/avr5", f"-L{libgcc.parent}", "--start-group",
         "-l:crtatmega328p.o", folder / "avr.o", "-lgcc", "-lm", "-lc", "-latmega328p", "--end-group",
         "--defsym=__DATA_REGION_ORIGIN__=0x800100", "-o", folder / "avr.elf")


def run_avr():
    """The program ends by sleeping without interrupts. After a crash simavr would wait for a debugger forever, so there
    is a time limit, far above the time that the program needs.
    """
    said = must("timeout", "300", "simavr", "-m", "atmega328p", "-f", "16000000", folder / "avr.elf")
    expect(re.search("avr: [1-9][0-9]* passed, 0 failed", said), said)


def on_avr():
    clang = clang_avr()
    if not clang or not has(AVR_IO, "binutils-avr", "avr-libc", "gcc-avr"):
        return report("skipped", "AVR", "clang-19 or avr-libc cannot be installed")
    compiler = [clang, "--target=avr", "-mmcu=atmega328p", *FREESTANDING, *libstdcpp(), "-isystem",
                "/usr/lib/avr/include"]
    # The simulated drives and the catalogues are for hosts.
    all_headers(f"AVR ATmega328P, {clang}: all headers for targets", compiler, "/sim/", "catalogue")
    is_built = passes(f"AVR ATmega328P, {clang}: the protocol core", *compiler, "-c", "tests/freestanding/avr.cpp",
                      "-o", folder / "avr.o")
    libgcc = sorted(Path("/usr/lib/gcc/avr").glob("*/avr5/libgcc.a"))
    if not is_built or not libgcc:
        return report("skipped", "AVR: link and run", "no object, or no libgcc (gcc-avr)")
    is_linked = check("AVR ATmega328P: it links into flash and RAM", link_avr, libgcc[-1])
    if not is_linked or not has("simavr", "simavr"):
        return report("skipped", "AVR: run", "not linked, or simavr cannot be installed")
    return check("AVR ATmega328P: CRC, frames and transactions in simavr", run_avr)


need("g++", "g++")
need("arm-none-eabi-g++", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", "libstdc++-arm-none-eabi-newlib")
need("clang++", "clang", "libc6-dev")
on_arm_and_riscv()
after_hostile_macros()
on_avr()
finish()
