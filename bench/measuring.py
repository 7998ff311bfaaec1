# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the programs that measure share: builds, sizes, and instructions that valgrind counts.

CXX in the environment is the compiler, g++ if not given; JOBS how many programs run at a time, 2 if not given.
"""
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests/support"))
from checks import ROOT, must, need, run, work

CXX = os.environ.get("CXX", "g++")
SIDES = sorted(ROOT.glob("bench/sides/*.cpp")) + sorted(ROOT.glob("bench/peers/*.cpp"))
SYNTAX = ["-std=c++20", "-fsyntax-only", "-Iinclude"]
ARM = ["arm-none-eabi-g++", "-std=c++20", "-Os", "-mthumb", "-fno-exceptions", "-fno-rtti", "-fno-unwind-tables",
       "-fno-asynchronous-unwind-tables", "-Iinclude"]
folder = work()


def side_by_side(function, *columns):
    """What a function returns for each argument; several run at a time."""
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        return list(pool.map(function, *columns))


def show(*command, **more):
    """Runs a command that prints, and ends with its status if it fails."""
    status = subprocess.run([str(word) for word in command], cwd=ROOT, **more).returncode
    if status != 0:
        sys.exit(status)


def recorded(path):
    """The rows of a file of figures."""
    lines = (ROOT / path).read_text(encoding="utf-8").splitlines()
    return [line.split("\t") for line in lines if line and not line.startswith("#")]


def record(path, lines, compiler="", comment=""):
    """Writes a file of figures, and what is made of them in bench/README.md."""
    head = [f"# {version_of(*compiler.split())}", comment] if compiler else []
    (ROOT / path).write_text("\n".join([*head, *lines, ""]), encoding="utf-8")
    show(sys.executable, "-B", "bench/readme.py")


def version_of(*compilers):
    """The first line of a file of figures that these compilers have counted."""
    return ", ".join(f"{name} {must(name, '-dumpversion').strip().split('.')[0]}" for name in compilers)


def recorded_with(compiler, path):
    """The figures of a file by their names; None if another compiler has counted them."""
    first = (ROOT / path).read_text(encoding="utf-8").split("\n")[0].removeprefix("# ").split(", ")
    return {name: figures for name, *figures in recorded(path)} if version_of(compiler) in first else None


def is_near(counted, known, name, percent=1):
    """False if a figure is more than so far from the recorded one, or none is recorded."""
    if known is None:
        return True
    return name in known and abs(counted - int(known[name][0])) * 100 <= percent * int(known[name][0])


def need_compiler():
    need(CXX, "clang" if "clang" in CXX else "g++", "libc6-dev")


def need_arm():
    need("arm-none-eabi-g++", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", "libstdc++-arm-none-eabi-newlib")


def family():
    """The compiler and its version, such as ("g++", "12")."""
    is_clang = "__clang__" in must(CXX, "-dM", "-E", "-x", "c++", "-")
    return "clang++" if is_clang else "g++", must(CXX, "-dumpversion").strip().split(".")[0]


def built(name, *sources, libraries=()):
    """A program of these sources."""
    def compiled(source):
        made = folder / f"{name}.{source.parent.name}.{source.stem}.o"
        must(CXX, "-std=c++20", "-O2", "-Iinclude", "-c", source, "-o", made)
        return made

    need_compiler()
    program = folder / name
    must(CXX, *side_by_side(compiled, sources), *libraries, "-o", program)
    return program


def built_benchmarks():
    """The time benchmarks."""
    need("/usr/include/benchmark/benchmark.h", "libbenchmark-dev")
    need("/usr/include/modbus/modbus.h", "libmodbus-dev")
    names = ("main", "bench_crc16", "bench_frames", "bench_transaction", "operations")
    return built("servobus_bench", *(ROOT / f"bench/{name}.cpp" for name in names), *SIDES,
                 libraries=["-lbenchmark", "-lmodbus", "-lpthread"])


def bytes_on(core, text):
    """The bytes of code, data and zeroed data of a source's text."""
    made = Path(tempfile.mkdtemp(dir=folder)) / "made.o"
    must(*ARM, f"-mcpu={core}", "-x", "c++", "-c", "-", "-o", made, typed=text)
    return [int(size) for size in must("arm-none-eabi-size", made).splitlines()[1].split()[:3]]


def compiler_instructions(texts, compiler="g++", head=""):
    """The instructions that the compiler proper executes for each of these sources, by their text, after a head that it
    has precompiled.

    They are the same in every run with one compiler. Cachegrind takes three fifths of the time of callgrind, which also
    follows the calls, and counts half a percent more; without chasing it takes a fifth less again.
    """
    count = ("valgrind", "--tool=cachegrind", "--cache-sim=no", "--vex-guest-chase=no", "--cachegrind-out-file=/dev/null")
    # g++ is a driver that starts cc1plus; clang++ is the compiler itself.
    command = ["g++", "-wrapper", ",".join(count)] if compiler == "g++" else [*count, compiler]
    precompiled = Path(tempfile.mkdtemp(dir=folder)) / "head.hpp"
    before = ["-include", precompiled] if head else []

    def counted(number, text):
        source = folder / f"{compiler}{number}.cpp"
        source.write_text(text)
        said = must(*command, *before, *SYNTAX, source)
        return int(re.search(r"I +refs: +([\d,]+)", said)[1].replace(",", ""))

    need(compiler, compiler.removesuffix("++") if "clang" in compiler else compiler)
    need("valgrind", "valgrind")
    if head:
        precompiled.write_text(head)
        ending = ".gch" if compiler == "g++" else ".pch"
        must(compiler, "-std=c++20", "-Iinclude", "-x", "c++-header", precompiled, "-o", f"{precompiled}{ending}")
    texts = list(dict.fromkeys(texts))
    return dict(zip(texts, side_by_side(counted, range(len(texts)), texts)))


def compiler_usage(text, times):
    """The user seconds of the shortest of some compilations, and its memory in megabytes: that of the compiler proper,
    the largest process of it."""
    def used():
        process = subprocess.Popen(["g++", *SYNTAX, source], cwd=ROOT)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"it does not compile: {text}")
        return usage.ru_utime, usage.ru_maxrss / 1024

    source = folder / "timed.cpp"
    source.write_text(text)
    return min(used() for _ in range(times))
