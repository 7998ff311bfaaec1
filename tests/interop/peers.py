# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the tests with other programs share. CXX in the environment is the compiler, g++ if not given."""
import os
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import (WARNINGS, begin, check, expect, expect_same, finish, has, must, of_program, report, run, skip,
                    text_of, until, work)

folder = work()
CXX = os.environ.get("CXX", "g++").split()


def need_peer(there, *packages):
    """Ends the test as skipped if a peer cannot be installed."""
    if not has(there, *packages):
        skip(f"{' '.join(packages)} cannot be installed")


def has_libmodbus():
    return run(*CXX, "-x", "c++", "-fsyntax-only", "-", typed="#include <modbus/modbus.h>\n").returncode == 0


def build(name, *libraries):
    """Builds a program of this folder, without which the test cannot go on."""
    program = folder / name
    if not check(f"{name} is built", must, *CXX, "-std=c++20", "-O1", *WARNINGS, "-Iinclude",
                 f"tests/interop/{name}.cpp", *libraries, "-o", program):
        finish()
    return program


def ran(program, *arguments):
    """Runs a program that prints its checks."""
    ran_by(program.name, program, *arguments)


def ran_by(name, *command):
    """The same for a command. One that crashed has not reported a failed check."""
    done = run(*command)
    of_program(name, done.stdout)
    if done.returncode != 0 and "\nFAILED " not in "\n" + done.stdout:
        report("FAILED", f"{name} ended with {done.returncode}")


def begin_line():
    """Two serial devices that are connected."""
    ends = folder / "near", folder / "far"
    line = begin("socat", *(f"pty,raw,echo=0,link={end}" for end in ends))
    until(lambda: all(end.exists() for end in ends), line, "the line")
    return ends


def holds_what_was_written(server, client):
    """The lines of the registers and coils that were written, each and no other."""
    written, held = (set(text_of(notes).split("\n")) - {""} for notes in (client, server))
    expect(written, "nothing was written")
    expect_same(sorted(written), sorted(held))


def begin_drive(tool, device, link):
    """A simulated drive at a pseudo-terminal."""
    drive = begin(tool, "sim", device, "--link", link)
    until(link.exists, drive, f"the simulated {device}")
    return drive


def said_port(process, notes):
    """The port that a gateway or a server prints: alone in its first line, or as socat does."""
    return until(lambda: re.search(r"^(?:.*listening on .*:)?(\d+)\n", text_of(notes), re.M), process, "its port")[1]


def begin_server(name, *command):
    """Begins what prints its port: the process and the port."""
    notes = folder / f"{name}.notes"
    server = begin(*command, out=notes)
    return server, said_port(server, notes)


def ask(tool, *words, port=None):
    """What the tool says, its port called PORT."""
    done = run(tool, *words, apart=True)
    if port is not None:
        done.stdout, done.stderr = (said.replace(str(port), "PORT") for said in (done.stdout, done.stderr))
    return done


def values(said):
    """The lines of an output, in one."""
    return " ".join(said.stdout.split("\n")).rstrip()


def expect_failure(tool, status, words, arguments):
    said = ask(tool, *arguments)
    expect_same((status, ""), (said.returncode, said.stdout))
    expect(said.stderr.count("\n") == 1 and words in said.stderr, said.stderr)


def fails(tool, name, status, words, *arguments):
    """One line of errors that has the words, and no output."""
    check(name, expect_failure, tool, status, words, arguments)
