# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The wrong programs of this folder, each with one mistake that the compiler must refuse.

programs.py refused PROGRAM COMPILER FLAG...   it does not compile, and the error contains the words after `// EXPECT:`,
                                               and those after `// FIGURES:` if there are any
programs.py all COMPILER FLAG...               so for each of them
programs.py page                               makes README.md, the page of compile errors
programs.py page --check                       fails if README.md is not that page, or control.cpp lacks a mend
"""
import itertools
import re
import subprocess
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
HEAD = """# Compile errors and their mends

Search this page for words of the compiler's error, which is often a dozen lines long: the headings are those words, in the
order of the alphabet. Below each stand the mistakes that lead to it, and the code that compiles in their place. `drive` is a
client of a ZLAC8015D, `zlac` is `servobus::zlac8015d`, `units` is `servobus::units`, `tank` is the device of
[served.hpp](served.hpp). [plan_errors.hpp](../../include/servobus/bus/detail/plan_errors.hpp) explains the figures of a
plan's errors.

`programs.py` makes this page from the programs beside it, which the tests compile with g++ and clang++.
"""


@dataclass
class Program:
    name: str
    title: str = ""
    expected: str = ""
    figures: str = ""
    mend: str = ""
    wrong: str = ""


def read(path):
    """A comment is the title; then come EXPECT and MEND, whose text may go on in further comments."""
    program = Program(path.name)
    code = None
    titles = []
    is_mend = False
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("// EXPECT: "):
            program.expected = line[len("// EXPECT: ") :]
        elif line.startswith("// FIGURES: "):
            program.figures = line[len("// FIGURES: ") :]
        elif line.startswith("// MEND: "):
            program.mend = line[len("// MEND: ") :]
            is_mend = True
            continue
        elif is_mend and line.startswith("// "):
            program.mend += ("\n" if line[3] in " }" else " ") + line[3:]
            continue
        elif line.startswith("#include"):
            code = code or []
        elif code is not None:
            code.append(line)
        elif line.startswith("// ") and not line.startswith("// SPDX"):
            titles.append(line[3:])
        is_mend = False
    program.title = " ".join(titles).removesuffix(".")
    if not program.expected or not program.mend:
        sys.exit(f"{path.name}: it needs a line \"// EXPECT: \" and one \"// MEND: \"")
    marked = max(i for i, line in enumerate(code) if line.endswith("// wrong"))
    first = marked
    while first > 0 and not re.match(r" *(\(void\)|constexpr auto|inline constexpr)", code[first]):
        first -= 1
    while not code[first] or code[first] == "using namespace servobus;":
        first += 1
    lines = [re.sub(r" *// wrong$", "", line) for line in code[first : marked + 1]]
    program.wrong = textwrap.dedent("\n".join(re.sub(r"^( *)\(void\)", r"\1", line) for line in lines))
    return program


def all_programs():
    return [read(path) for path in sorted(HERE.glob("*.cpp")) if path.name != "control.cpp"]


def page(programs):
    text = HEAD
    by_words = sorted(programs, key=lambda p: (p.expected.casefold(), p.figures, p.name))
    for expected, alike in itertools.groupby(by_words, key=lambda p: p.expected):
        text += f"\n## `{expected}`\n"
        for p in alike:
            figures = f", with the figures `{p.figures}`" if p.figures else ""
            text += (f"\n[{p.title}]({p.name}){figures}:\n\n```cpp\n{p.wrong}\n// compiles:\n"
                     f"{p.mend.removeprefix('(void)')}\n```\n")
    return text


def plain(code):
    """Without blanks, and without the numbers that keep the names of control.cpp apart."""
    return re.sub(r"(gain|request|frame|plan)_[0-9]+", r"\1", re.sub(r"[ \n]", "", code))


def check_page(programs):
    control = plain((HERE / "control.cpp").read_text(encoding="utf-8"))
    wrong = [f"control.cpp does not have the mend of {p.name}" for p in programs if plain(p.mend) not in control]
    if (HERE / "README.md").read_text(encoding="utf-8") != page(programs):
        wrong.append("README.md is out of date: python3 tests/fail/programs.py page")
    for line in wrong:
        print(f"FAILED  {line}")
    print(f"{len(programs)} wrong programs, {len(wrong)} failed")
    return 1 if wrong or not programs else 0


def refused(path, command):
    program = read(Path(path))
    done = subprocess.run([*command, str(path)], capture_output=True, text=True, errors="replace")
    if done.returncode == 0:
        print(f"FAILED  {path} compiles")
        return 1
    said = done.stdout + done.stderr
    is_error = re.compile(r"(error|note)[: ]|in call to|expansion of|static assertion")
    shown = [line for line in said.splitlines() if is_error.search(line)]
    for expected in filter(None, (program.expected, program.figures)):
        line = next((line for line in shown if expected in line), None)
        if line is None:
            print(f"FAILED  {path}: the error does not say \"{expected}\":\n{said}")
            return 1
        print(line)
    return 0


match sys.argv[1:]:
    case ["refused", path, *command] if command:
        sys.exit(refused(path, command))
    case ["all", *command] if command:
        sys.exit(max(refused(HERE / p.name, command) for p in all_programs()))
    case ["page"]:
        (HERE / "README.md").write_text(page(all_programs()), encoding="utf-8")
    case ["page", "--check"]:
        sys.exit(check_page(all_programs()))
    case _:
        sys.exit(__doc__)
