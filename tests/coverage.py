# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Reads what llvm-cov exports of the test program, and says which of the library's lines and branches ran.

What did not run must be explained in coverage_left_out.txt. See coverage.sh and coverage.md.
"""
import collections
import json
import pathlib
import re
import sys
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
LIBRARY = HERE.parent / "include" / "servobus"
LEFT_OUT = HERE / "coverage_left_out.txt"


@dataclass(frozen=True)
class Gap:
    """Something that did not run."""

    header: str
    line: int
    what: str  # "not run", "never true", "never false" or "neither"
    text: str  # the line, or the condition

    @property
    def key(self):
        return (self.header, self.what, self.text)


def under_library(path):
    path = pathlib.Path(path).resolve()
    return str(path.relative_to(LIBRARY)) if path.is_relative_to(LIBRARY) else None


def lines_of(export):
    """header -> line -> how often it ran"""
    lines = collections.defaultdict(dict)
    header = None
    for record in export.read_text().splitlines():
        key, _, value = record.partition(":")
        if key == "SF":
            header = under_library(value)
        elif key == "DA" and header:
            line, ran = map(int, value.split(",")[:2])
            lines[header][line] = lines[header].get(line, 0) + ran
    return lines


def branches_of(export):
    """header -> place -> how often it was true, and false"""
    branches = collections.defaultdict(lambda: collections.defaultdict(lambda: [0, 0]))
    for file in json.loads(export.read_text())["data"][0]["files"]:
        header = under_library(file["filename"])
        for branch in file["branches"] if header else ():
            ran = branches[header][tuple(branch[:4])]
            ran[0] += branch[4]
            ran[1] += branch[5]
    return branches


def end_of_body(source, start):
    """Where the definition that begins at `start` ends: its closing brace, or its semicolon."""
    depth = 0
    for end in range(start, len(source)):
        depth += {"{": 1, "(": 1, "}": -1, ")": -1}.get(source[end], 0)
        if depth == 0 and source[end] == ";":
            return end
        # The braces of a member's initializer end no function.
        if depth == 0 and source[end] == "}" and not re.match(r"\s*[,{(]", source[end + 1 :]):
            return end
    return len(source) - 1


def without_comments(source):
    """The same lines, with spaces in place of comments: a brace in one ends no function."""
    return re.sub(r"//[^\n]*", lambda m: " " * len(m.group()), source)


def line_numbers(source, start, end):
    return range(source.count("\n", 0, start) + 1, source.count("\n", 0, end) + 2)


def never_in_a_program(source):
    """Lines of consteval functions, of those that only name a rule, and of closing braces."""
    source = without_comments(source)
    lines = {n for n, text in enumerate(source.splitlines(), 1) if text.strip() in ("}", "};")}
    for m in re.finditer(r"\bconsteval\b|\bvoid \w+\(\) \{\}", source):
        lines.update(line_numbers(source, m.start(), end_of_body(source, m.start())))
    return lines


def function_lines(source, name):
    """Lines of all functions of this name that have a body here."""
    source = without_comments(source)
    lines = set()
    for m in re.finditer(rf"(?<![\w.>]){re.escape(name)}\(", source):
        end = end_of_body(source, m.start())
        begin = source.rfind("\n", 0, m.start()) + 1
        is_definition = source[end] == "}" and re.match(
            r"\s*(template <.*> )?(static |friend |constexpr |\[\[.*?\]\] )*[\w:<>*&, ]*$", source[begin : m.start()]
        )
        if is_definition:
            lines.update(line_numbers(source, begin, end))
    return lines


class Coverage:
    def __init__(self, lines, branches):
        self.headers = sorted(str(p.relative_to(LIBRARY)) for p in LIBRARY.rglob("*.hpp")
                              if p.parent.name != "windows")  # tests/windows/ has those
        self.sources = {h: (LIBRARY / h).read_text() for h in self.headers}
        self.lines, self.branches = {}, {}
        for header, source in self.sources.items():
            text = source.splitlines()
            never = never_in_a_program(source)
            self.lines[header] = {n: ran for n, ran in lines[header].items() if n not in never}
            self.branches[header] = {
                place: ways
                for place, ways in branches[header].items()
                if place[0] not in never and "if constexpr" not in text[place[0] - 1]
            }

    def sums(self, headers):
        ran = sum(n > 0 for h in headers for n in self.lines[h].values())
        taken = sum((n > 0) for h in headers for ways in self.branches[h].values() for n in ways)
        return share(ran, sum(len(self.lines[h]) for h in headers)) + share(
            taken, 2 * sum(len(self.branches[h]) for h in headers)
        )

    def gaps(self, header):
        text = self.sources[header].splitlines()
        for line, ran in sorted(self.lines[header].items()):
            if ran == 0:
                yield Gap(header, line, "not run", text[line - 1].strip())
                continue
            for (first, column, last, end), ways in sorted(self.branches[header].items()):
                if first == line and 0 in ways:
                    condition = text[first - 1][column - 1 : end - 1]
                    if first != last:
                        condition = " ".join(one.strip() for one in text[first - 1 : last])
                    never = "neither" if ways == [0, 0] else "never false" if ways[0] else "never true"
                    yield Gap(header, line, never, condition)


def share(some, of):
    return f"{100 * some / of:6.1f} %  {some:5} of {of:5}" if of else "      -" + 17 * " "


class LeftOut:
    """What coverage_left_out.txt explains. A paragraph is a reason and after it, indented, what it is for:

    Why it cannot run, or need not.
        line/line.hpp: never true: the condition as the report has it
        registers/block.hpp: only the compiler calls: sort_by_address
    """

    FUNCTION = "only the compiler calls"

    def __init__(self, text, sources):
        self.entries = {}  # key -> the number of its line
        self.functions = {}  # (header, line) -> key
        self.problems = []
        reason = ""
        for number, line in enumerate(text.splitlines(), 1):
            if not line or line.startswith("#"):
                reason = ""
            elif not line.startswith("    "):
                reason += line
            else:
                self._add(number, line.strip(), reason, sources)
        self.used = set()

    def _add(self, number, entry, reason, sources):
        key = tuple(entry.split(": ", 2))
        if len(key) != 3 or key[0] not in sources or not reason:
            return self.problems.append(f"{number}: not a reason and `header: what: text`: {entry}")
        if key in self.entries:
            return self.problems.append(f"{number}: said twice: {entry}")
        self.entries[key] = number
        if key[1] == self.FUNCTION:
            lines = function_lines(sources[key[0]], key[2])
            if not lines:
                self.problems.append(f"{number}: there is no such function: {entry}")
            self.functions.update({(key[0], line): key for line in lines})

    def explains(self, gap):
        key = gap.key if gap.key in self.entries else self.functions.get((gap.header, gap.line))
        if key:
            self.used.add(key)
        return key is not None

    def obsolete(self, headers):
        for key, number in self.entries.items():
            if key not in self.used and key[0] in headers:
                yield f"{number}: it runs, or is not there any more: {': '.join(key)}"


def main(lines, branches, *wanted):
    coverage = Coverage(lines_of(pathlib.Path(lines)), branches_of(pathlib.Path(branches)))
    unknown = set(wanted) - set(coverage.headers)
    if unknown:
        print(f"coverage.py: no such header: {', '.join(sorted(unknown))}")
        return 2
    headers = wanted or coverage.headers
    print(f"{'header':40}{'lines':>8}{'branches':>28}")
    for header in headers:
        print(f"{header:40}{coverage.sums([header])}")
    print(f"{'all':40}{coverage.sums(headers)}")

    left_out = LeftOut(LEFT_OUT.read_text(), coverage.sources)
    gaps = [gap for header in headers for gap in coverage.gaps(header)]
    open_ones = [gap for gap in gaps if not left_out.explains(gap)]
    for gap in open_ones:
        print(f"{gap.header}:{gap.line}: {gap.what}: {gap.text}")
    problems = left_out.problems + list(left_out.obsolete(headers))
    for problem in problems:
        print(f"{LEFT_OUT.name}:{problem}")
    print(
        f"coverage.sh: {len(gaps)} lines and branches did not run; {len(gaps) - len(open_ones)} of them are "
        f"explained, {len(open_ones)} are not"
    )
    return 1 if open_ones or problems else 0


sys.exit(main(*sys.argv[1:]))
