# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Compares the list of promises, include/servobus/promises.md, with the tests that name them and their errors.

promises.py          each promise has a test, each number in a test is a promise, the errors in the list exist, and each
                     errc is in the list
promises.py G19      prints the tests that name this promise
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import ROOT, check, expect, finish

LIST = "include/servobus/promises.md"
TESTS = ["run/*/*.cpp", "sim/*.hpp", "interop/*.cpp", "ports/*pp", "*.sh", "*/*.py"]


def text_of(path):
    return (ROOT / path).read_text("utf-8")


def named():
    """Each number that the name of a test begins with, and where it is: perhaps on the line after TEST_CASE."""
    for path in sorted(path for pattern in TESTS for path in ROOT.glob(f"tests/{pattern}")):
        for name in re.findall(r'"((?:[GS]\d+, )*[GS]\d+\b[^"]*)"', path.read_text("utf-8")):
            for number in re.findall(r"[GS]\d+", name):
                yield number, f'{path.relative_to(ROOT)}: "{" ".join(name.split())}"'


def names_of(kind):
    """The names of an enumeration in core/status.hpp."""
    body = re.search(rf"^enum class {kind}\b.*?^}};", text_of("include/servobus/core/status.hpp"), re.M | re.S)[0]
    return re.findall(r"^    ([a-z]\w*)", body, re.M)


def nothing(found, why):
    expect(not found, "\n".join(f"{one} {why}" for one in found))


def main():
    uses = list(named())
    if sys.argv[1:]:
        print("\n".join(where for number, where in uses if number == sys.argv[1]))
        return
    tested = {number for number, _ in uses}
    rows = [line.split(" | ") for line in re.findall(r"^\| ([GS]\d+ \| .*)", text_of(LIST), re.M)]
    promised = {row[0] for row in rows}
    said = "\n".join(row[2] for row in rows)
    errors = [name for name in names_of("errc") if name != "ok"]
    expected = "\n".join(errors + names_of("outcome") + [
        line for path in ROOT.glob("tests/fail/*.cpp")
        for line in re.findall(r"^// EXPECT: (.*)", path.read_text("utf-8"), re.M)])
    examples = "\n".join(path.read_text("utf-8", "replace") for path in ROOT.glob("examples/**/*") if path.is_file())
    check(f"{len(promised)} promises, each named by a test", nothing, promised - tested, "is named by no test")
    check(f"{len(uses)} namings in tests, each of a promise", nothing, tested - promised, "is no promise")
    check(f"{len(errors)} errors, each in the list of a promise", nothing,
          [error for error in errors if f"`{error}`" not in said], "is in the list of no promise")
    check("each word of a list is an error", nothing,
          [word for word in set(re.findall("`([^`]*)`", said)) if word not in expected], "is said by nothing")
    check("each quotation of a list is in a program", nothing,
          [words for words in set(re.findall('"([^"]*)"', said)) if words not in examples], "is said by no program")
    finish()


main()
