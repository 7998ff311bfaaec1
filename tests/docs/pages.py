# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The pages of the project: each ```cpp block compiles on its own, and each relative link leads to a file that exists,
and to a heading in it if it names one.

The page of compile errors has blocks that must not compile, so only its links are checked. CXX in the environment is
the compiler, g++ if not given.
"""
import os
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import ROOT, check, expect, finish, passes, run

CXX = os.environ.get("CXX", "g++").split()
FLAGS = ["-std=c++20", "-Wall", "-Wextra", "-Werror", "-Iinclude", "-fsyntax-only", "-x", "c++", "-"]
# A function of any line or port: it is compiled for one, or nothing in it were checked.
TEMPLATE = re.compile(r"^template <class (Line|Port)> .*?(\w+)\((?:scheduled_line<Port>|Line)& ", re.M)
FENCED = re.compile(r"^```(.*)\n((?:.*\n)*?)```$", re.M)


def with_its_templates_used(block):
    serial = "servobus::posix::serial"
    line = f"servobus::{'scheduled_line' if 'make_bus' in block else 'line'}<{serial}>"
    used = [f"[[maybe_unused]] static auto* const use_of_{name} = &{name}<{line if of == 'Line' else serial}>;\n"
            for of, name in TEMPLATE.findall(block)]
    return block + "".join(["#include <servobus/posix/serial.hpp>\n", *used] if used else [])


def all_pages():
    listed = run("git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md")
    if listed.returncode == 0 and listed.stdout:
        return [page for page in listed.stdout.splitlines() if (ROOT / page).exists()]
    return [str(page.relative_to(ROOT)) for page in sorted(ROOT.rglob("*.md"))
            if not page.relative_to(ROOT).parts[0].startswith("build")]


def text_of(page):
    return (ROOT / page).read_text("utf-8")


def anchors(page):
    """Of its headings: lower case, - for each blank, otherwise only letters, digits, - and _."""
    headings = re.findall(r"^#+ (.*)", FENCED.sub("", text_of(page)), re.M)
    return {re.sub(r"[^a-z0-9 _-]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(page):
    """The relative links of a page, without those in `...` and in indented or fenced code."""
    text = re.sub(r"^    .*", "", FENCED.sub("", text_of(page)), flags=re.M)
    found = re.findall(r"\]\(([^)]+)\)", re.sub(r"`[^`\n]*`", "", text))
    return [link for link in found if not re.match("[a-z]+:", link)]


def lead_somewhere(page):
    wrong = []
    for link in links(page):
        file, _, anchor = link.partition("#")
        target = os.path.normpath(Path(page).parent / file) if file else page
        if not (ROOT / target).exists():
            wrong.append(f"{link} leads to no file")
        elif anchor and anchor not in anchors(target):
            wrong.append(f"{link} leads to no heading")
    expect(not wrong, "\n".join(wrong))


def name_all_targets():
    """The table of fuzzing targets in the page of the tests has each corpus."""
    table = text_of("tests/README.md").split("## Fuzzing")[1].split("The source of a target")[0]
    named = {name for row in re.findall(r"(?m)^\| (`.*?) \|", table) for name in re.findall(r"`(\w+)`", row)}
    there = {folder.name for folder in (ROOT / "fuzz/corpus").iterdir()}
    expect(named == there, f"named and not there: {named - there}; there and not named: {there - named}")


check("tests/README.md names each fuzzing target", name_all_targets)
blocks = 0
for page in all_pages():
    check(f"{page}: its links lead somewhere", lead_somewhere, page)
    for block in FENCED.finditer(text_of(page)):
        if block[1] == "cpp" and page != "tests/fail/README.md":
            blocks += 1
            line = text_of(page).count("\n", 0, block.start()) + 1
            passes(f"{page}: the block that begins in line {line} compiles", *CXX, *FLAGS, typed=with_its_templates_used(block[2]))
count = sum(len(links(page)) for page in all_pages())
check(f"{blocks} blocks of code and {count} links are found", expect, blocks >= 8 and count >= 50, "too few")
finish()
