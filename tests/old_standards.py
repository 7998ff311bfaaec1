# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks that a compiler which is not set to C++20 is refused by a sentence, before any other error and without pages
of them, in each header that a program may include; and that MSVC's macro decides where it is defined.

A header that begins by including another of the library is refused by it. So that is looked at, and compiled are the
headers that do not, those that the most others stand before, and every seventh.

old_standards.py [COMPILER...]               g++ and clang++ if none is given
JOBS in the environment: compilers at a time, 2 if not given
"""
import os
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))
from checks import ROOT, check, expect, finish, must_fail, passes, run

SENTENCE = "servobus needs C++20"
MOST_LINES = 25  # of the compiler: 7, and one for each header on the way
INCLUDE = ROOT / "include"
HEADERS = sorted(str(path.relative_to(INCLUDE)) for path in INCLUDE.rglob("*.hpp")
                 if not {"detail", "windows"} & set(path.relative_to(INCLUDE).parts))
CODE = re.compile(r"^(?!\s*(//|$|#pragma once$|#include <[a-z_]+>)).*$", re.MULTILINE)  # and includes of the library
OWN = re.compile(r"#include <(servobus\S*)>")


def stands_before(header):
    """The header of the library that this one includes before any code; none if it has code first."""
    first = CODE.search((INCLUDE / header).read_text())
    own = first and OWN.fullmatch(first[0])
    return own and own[1]


def chain(header):
    """How many headers stand before the sentence."""
    before = stands_before(header)
    return 1 + chain(before) if before else 0


LONGEST = max(map(chain, HEADERS))
COMPILED = [header for number, header in enumerate(HEADERS)
            if number % 7 == 0 or not stands_before(header) or chain(header) == LONGEST]


def problem_of(compiler, header):
    """Empty if the compiler refuses the header as C++17 by the sentence, and ends there."""
    done = run(compiler, "-std=c++17", "-Iinclude", "-fsyntax-only", "-x", "c++", "-", typed=f"#include <{header}>\n")
    if done.returncode == 0:
        return f"{header} compiles"
    lines = done.stdout.splitlines()
    first = next((line for line in lines if "error" in line), "")
    if SENTENCE not in first:
        return f"{header}: the first error is not \"{SENTENCE}\": {first}"
    return "" if len(lines) <= MOST_LINES else f"{header}: the compiler prints {len(lines)} lines"


def all_refuse(compiler):
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        wrong = [problem for problem in pool.map(lambda header: problem_of(compiler, header), COMPILED) if problem]
    expect(COMPILED and not wrong, "\n".join(wrong))


def as_msvc(compiler, standard):
    """Reads the macro as MSVC without /Zc:__cplusplus."""
    return [compiler, "-Wno-builtin-macro-redefined", "-U__cplusplus", "-D__cplusplus=199711L",
            f"-D_MSVC_LANG={standard}", "-E", "-x", "c++", "include/servobus/core/cxx20.hpp"]


for each in sys.argv[1:] or ("g++", "clang++"):
    check(f"{each}: {len(COMPILED)} of {len(HEADERS)} headers refuse C++17", all_refuse, each)
    passes(f"{each}: _MSVC_LANG of C++20 is accepted", *as_msvc(each, "202002L"))
    check(f"{each}: _MSVC_LANG of C++17 is refused, with MSVC's option", must_fail, "/std:c++20",
          *as_msvc(each, "201703L"))
    check(f"{each}: _MSVC_LANG of C++17 ends the compilation", must_fail, "fatal error", *as_msvc(each, "201703L"))
finish()
