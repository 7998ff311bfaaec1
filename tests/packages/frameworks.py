# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The packages for frameworks, each used as its ecosystem uses it. What stands in for one that cannot be installed here
is in this folder, and examples/packages/README.md says so.
"""
import os
import re
import shutil

from package_tree import VERSION, folder, make_tree, maker, out, tree, unpack
from avr import clang_avr, libstdcpp
from checks import ROOT, check, expect, finish, must, need, passes, run

DEBIAN_PYTHON = "/usr/bin/python3"  # the one that has Debian's modules
need("g++", "g++")
need("clang++", "clang", "libc6-dev")
need("arm-none-eabi-g++", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", "libstdc++-arm-none-eabi-newlib")
need("cmake", "cmake")
need("arduino-builder", "arduino-builder", "arduino-ctags")
need("/usr/share/arduino/hardware/arduino/avr", "arduino-core-avr")
need("/usr/lib/avr/include/avr/io.h", "gcc-avr", "avr-libc", "binutils-avr")
need("avr-g++", "gcc-avr", "avr-libc", "binutils-avr")
need(lambda: run(DEBIAN_PYTHON, "-c", "import kconfiglib").returncode == 0, "python3", "python3-kconfiglib")

used = folder / "used"
user = ROOT / "tests/packages/user/main.cpp"
work = folder / "arduino"
CPP20 = "compiler.cpp.extra_flags=-std=gnu++20"


# ---- Arduino: Debian's arduino-builder and AVR core. The compiler for the sketch is clang.

def prepare_arduino():
    """The environment of arduino-builder."""
    for name in ("hardware", "tools", "bin"):
        (work / name).mkdir(parents=True)
    shutil.copytree("/usr/share/arduino/hardware/arduino", work / "hardware/arduino", symlinks=True)
    for tool in ("avr-gcc", "avr-gcc-ar", "avr-objcopy", "avr-size"):
        (work / "bin" / tool).symlink_to(shutil.which(tool))
    (work / "bin/cxx").symlink_to(ROOT / "tests/packages/arduino/cxx")
    clang = clang_avr()
    expect(clang, "no clang for AVR can be installed")
    return {**os.environ, "CLANG_AVR": clang, "LIBSTDCPP": " ".join(libstdcpp())}


def sketch(*lines):
    """Builds the package's example, which has to find the library in the zip, with lines of platform.local.txt."""
    settings = [f"compiler.path={work}/bin/", "compiler.cpp.cmd=cxx",
                "compiler.c.elf.extra_flags=-Wl,--no-relax", *lines]
    (work / "hardware/arduino/avr/platform.local.txt").write_text("\n".join(settings) + "\n")
    shutil.rmtree(work / "build", ignore_errors=True)
    (work / "build").mkdir()
    return ["arduino-builder", "-compile", "-hardware", work / "hardware", "-hardware", "/usr/share/arduino-builder",
            "-tools", work / "tools", "-libraries", used / "arduino", "-fqbn", "arduino:avr:mega:cpu=atmega2560",
            "-build-path", work / "build", "-warnings", "all", used / "arduino/servobus/examples/wheels/wheels.ino"]


def arduino_builds():
    said = must(*sketch(CPP20), env=environment)
    expect(not re.search("servobus/.*warning:", said), said)
    expect((work / "build/wheels.ino.hex").stat().st_size > 20000, must("avr-size", work / "build/wheels.ino.elf"))


def arduino_needs_cpp20():
    done = run(*sketch(), env=environment)
    expect(done.returncode != 0 and re.search(r"error.*servobus needs C\+\+20: -std=gnu\+\+20", done.stdout),
           done.stdout)


def sketch_drives():
    arduino = used / "arduino/servobus"
    must("g++", "-std=gnu++20", "-O1", "-Wall", "-Wextra", "-Werror", "-isystem", "tests/ports/stubs/arduino",
         f"-I{arduino}/src", f'-DSKETCH="{arduino}/examples/wheels/wheels.ino"', "tests/packages/arduino/sketch.cpp",
         "-o", folder / "sketch")
    must(folder / "sketch")


# ---- Zephyr: stand-ins for its CMake and its symbols

def zephyr_app(config):
    """Builds and runs an application."""
    build = folder / f"zephyr{config}"
    must("cmake", "-S", "tests/packages/zephyr", "-B", build, f"-DMODULE_CMAKE={used}/zephyr/servobus/zephyr",
         f"-DUSER_SOURCE={user}", f"-DCONFIG_SERVOBUS={config}")
    done = run("cmake", "--build", build)
    if config:
        expect(done.returncode == 0, done.stdout)
        must(build / "app")
    else:
        expect(done.returncode != 0 and re.search("servobus/.*No such file", done.stdout), done.stdout)


# ---- ESP-IDF: stand-ins for its CMake; both with the package and with a checkout

def esp_idf(component):
    said = must("cmake", f"-DCOMPONENT={component}", "-P", "tests/packages/esp_idf/requirements.cmake")
    expect("registered: INCLUDE_DIRS;include" in said, said)
    build = folder / "esp"
    shutil.rmtree(build, ignore_errors=True)
    must("cmake", "-S", "tests/packages/esp_idf", "-B", build, f"-DCOMPONENT={component}", f"-DUSER_SOURCE={user}")
    must("cmake", "--build", build)
    must(build / "app")


make_tree()
must(*maker(), out)
unpack(out, VERSION, used)
environment = prepare_arduino()
check("arduino-builder: the example, from the zip by #include <servobus.h>", arduino_builds)
check("arduino-builder: without -std=gnu++20, an error that names it", arduino_needs_cpp20)
check("Arduino: the example with a simulated drive, restarted and out of reach", sketch_drives)
# PlatformIO: a stand-in, the include path that a library with include/ gets.
STRICT = ["-std=gnu++20", "-Wall", "-Wextra", "-Werror", f"-I{used}/platformio/servobus/include"]
passes("PlatformIO: a program with the package's include path", "g++", *STRICT, "-c", user, "-o", folder / "pio.o")
# After an Arduino.h that includes a standard header before it defines its macros; they are there again afterwards.
for compiler in ("g++", "clang++", "arm-none-eabi-g++"):
    passes(f"{compiler}: servobus.h after the macros of an Arduino.h", compiler, *STRICT, "-I.", "-fsyntax-only",
           "-x", "c++", "-", typed="""#include "tests/freestanding/arduino_macros.hpp"
#include <servobus.h>
#include <servobus/device/zlac8015d.hpp>
int least = min(1, 2), most = max(1, 2);
""")
check("Zephyr: an application with CONFIG_SERVOBUS", zephyr_app, "y")
check("Zephyr: without it, no header is found", zephyr_app, "")
passes("Zephyr: Kconfig asks for C++20 and a full library", DEBIAN_PYTHON, "-B", "tests/packages/zephyr/kconfig.py",
       used / "zephyr/servobus/zephyr/Kconfig")
check("ESP-IDF: the package as a component", esp_idf, used / "esp-idf/servobus")
check("ESP-IDF: the repository as a component", esp_idf, tree)
finish()
