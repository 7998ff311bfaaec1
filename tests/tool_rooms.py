# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks from the includes that the rooms of the tool, the folders of examples/servobus/, form layers, that the table of
its page lists them from the top down, and that servobus.cpp includes each source; names each include and each entry of the
table below that breaks this, and checks that violations are found.
"""
import posixpath
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent / "examples/servobus"
ONE_SOURCE = "../servobus.cpp"
# What a room's files may include, besides those of the same room. "here" has main.cpp and the table of the commands.
MAY_INCLUDE = {
    "streams": "",
    "words": "",
    "command_line": "streams words",
    "device_file": "words",
    "frames": "words",
    "interpretations": "words",
    "cpp": "device_file words",
    "devices": "device_file interpretations streams words",
    "help": "command_line streams",
    "os": "command_line frames streams words",
    "probe": "interpretations",
    "registers": "command_line device_file devices frames os streams words",
    "simulators": "device_file devices interpretations streams",
    "capture": "frames registers streams",
    "parameters": "devices os registers streams words",
    "records": "command_line os registers streams words",
    "doctor": "devices frames os parameters registers streams words",
    "machine": "command_line device_file devices parameters registers streams words",
    "commands": "capture command_line cpp device_file devices doctor frames interpretations machine os parameters probe "
                "records registers simulators streams words",
    "drives": "devices doctor interpretations probe registers simulators words",
    "here": "command_line commands help streams",
}
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
SOURCE = re.compile(r'^#include "servobus/(.+)"$', re.MULTILINE)
# The first cell of a row of the page's table.
ROW = re.compile(r"^\| (?:`(\w+)/`|(here)) \|", re.MULTILINE)

# A small tool, its table, its page and its one source, without a mistake; and each mistake with words that describe it.
# Files that a mistake names replace those of the tool, None takes one away.
TOOL = {
    ONE_SOURCE: '#include "servobus/high/user.cpp"\n#include "servobus/low/word.cpp"\n#include "servobus/main.cpp"\n',
    "main.cpp": '#include "high/user.hpp"\n',
    "high/user.hpp": '#include "../low/word.hpp"\n#include "../../host.hpp"\n',
    "high/user.cpp": '#include "user.hpp"\n',
    "low/word.hpp": "#pragma once\n",
    "low/word.cpp": '#include "word.hpp"\n',
}
TABLE = {"low": "", "high": "low", "here": "high"}
PAGE = "| room | what is in it |\n|---|---|\n| here | |\n| `high/` | |\n| `low/` | |\n"
BREAKS = [
    ("low/word.hpp includes high/user.hpp: low may include nothing of another room",
     {"low/word.hpp": '#include "../high/user.hpp"\n'}, {}, PAGE),
    ("main.cpp includes low/word.hpp: here may include high", {"main.cpp": TOOL["high/user.hpp"].replace("../low", "low") +
                                                               TOOL["main.cpp"]}, {}, PAGE),
    ("the table has a circle: low -> high -> low", {"low/word.cpp": '#include "../high/user.hpp"\n'}, {"low": "high"}, PAGE),
    ("new/file.hpp: there is no room new", {"new/file.hpp": "\n"}, {}, PAGE),
    ("high includes nothing of middle", {"middle/file.hpp": "\n"}, {"middle": "", "high": "low middle"},
     PAGE + "| `middle/` | |\n"),
    ("middle has no file", {}, {"middle": ""}, PAGE + "| `middle/` | |\n"),
    ("high may include middle, which is no room", {}, {"high": "low middle"}, PAGE),
    ("low/word.cpp includes low/other.hpp, which does not exist", {"low/word.cpp": '#include "other.hpp"\n'}, {}, PAGE),
    ("low/word.cpp includes low/word.hpp, which does not exist", {"low/word.hpp": None}, {}, PAGE),
    ("low/deep/file.hpp: a room has no folders", {"low/deep/file.hpp": "\n"}, {}, PAGE),
    ("circle: low/a.hpp -> low/b.hpp -> low/a.hpp", {"low/a.hpp": '#include "b.hpp"\n', "low/b.hpp": '#include "a.hpp"\n'},
     {}, PAGE),
    ("README.md lists no room low", {}, {}, PAGE.replace("| `low/` | |\n", "")),
    ("README.md lists the room cellar, which does not exist", {}, {}, PAGE + "| `cellar/` | |\n"),
    ("README.md lists the room low twice", {}, {}, PAGE + "| `low/` | |\n"),
    ("README.md lists low above high, which includes it", {}, {},
     PAGE.replace("| `high/` | |\n| `low/` | |\n", "| `low/` | |\n| `high/` | |\n")),
    ("servobus.cpp does not include low/other.cpp", {"low/other.cpp": "\n"}, {}, PAGE),
    ("servobus.cpp includes low/word.cpp, which is no source of the tool", {"low/word.cpp": None}, {}, PAGE),
    ("servobus.cpp includes low/word.cpp twice",
     {ONE_SOURCE: TOOL[ONE_SOURCE] + '#include "servobus/low/word.cpp"\n'}, {}, PAGE),
]


def room(file):
    return file.split("/")[0] if "/" in file else "here"


def read_files():
    files = {str(path.relative_to(ROOT)): path.read_text("utf-8") for path in sorted(ROOT.rglob("*.?pp"))}
    return {**files, ONE_SOURCE: (ROOT / ONE_SOURCE).read_text("utf-8")}


def violations(all_texts, table, page):
    """A line for each violation. `all_texts` has all files of the tool by their path in its folder, and the one source."""
    texts = {file: text for file, text in all_texts.items() if file != ONE_SOURCE}
    includes = {}
    for file, text in texts.items():
        found = (posixpath.normpath(f"tool/{posixpath.dirname(file)}/{name}") for name in INCLUDE.findall(text))
        includes[file] = [other.removeprefix("tool/") for other in found if other.startswith("tool/")]
    wrong = [f"{file}: a room has no folders" for file in texts if file.count("/") > 1]
    used = set()
    for file, included in includes.items():
        own = room(file)
        if own not in table:
            wrong.append(f"{file}: there is no room {own}")
            continue
        for other in included:
            used.add((own, room(other)))
            if other not in includes:
                wrong.append(f"{file} includes {other}, which does not exist")
            elif room(other) != own and room(other) not in table[own].split():
                may = table[own] or "nothing of another room"
                wrong.append(f"{file} includes {other}: {own} may include {may}")
    for own, allowed in table.items():
        if own not in map(room, texts):
            wrong.append(f"{own} has no file: take it out of the table")
        for other in allowed.split():
            if other not in table:
                wrong.append(f"{own} may include {other}, which is no room")
            elif (own, other) not in used:
                wrong.append(f"{own} includes nothing of {other}: take that out of the table")
    wrong += circles("the table has a circle", {own: allowed.split() for own, allowed in table.items()})
    wrong += violations_of_source(texts, SOURCE.findall(all_texts[ONE_SOURCE]))
    return wrong + circles("circle", includes) + violations_of_page(table, page)


def circles(title, edges):
    """One line for each edge that closes a circle."""
    found, done = [], set()

    def follow(one, path):
        if one in path:
            found.append(f"{title}: " + " -> ".join(path[path.index(one):] + [one]))
        elif one not in done:
            for other in edges.get(one, []):
                follow(other, path + [one])
            done.add(one)

    for one in edges:
        follow(one, [])
    return found


def violations_of_source(texts, included):
    sources = [file for file in texts if file.endswith(".cpp")]
    wrong = [f"servobus.cpp does not include {file}" for file in sources if file not in included]
    wrong += [f"servobus.cpp includes {file}, which is no source of the tool" for file in included if file not in sources]
    return wrong + [f"servobus.cpp includes {file} twice" for file in sources if included.count(file) > 1]


def violations_of_page(table, page):
    listed = [folder or here for folder, here in ROW.findall(page)]
    wrong = [f"README.md lists no room {own}" for own in table if own not in listed]
    wrong += [f"README.md lists the room {own}, which does not exist" for own in listed if own not in table]
    wrong += [f"README.md lists the room {own} twice" for own in table if listed.count(own) > 1]
    if wrong:
        return wrong
    return [f"README.md lists {other} above {own}, which includes it" for own, allowed in table.items()
            for other in allowed.split() if other in listed and listed.index(other) < listed.index(own)]


def unfound():
    """A line for each violation of the small tool that is not found, or that it does not have."""
    wrong = [f"the small tool is without a mistake, but: {line}" for line in violations(TOOL, TABLE, PAGE)]
    for words, files, rows, page in BREAKS:
        texts = {file: text for file, text in {**TOOL, **files}.items() if text is not None}
        if not any(words in line for line in violations(texts, {**TABLE, **rows}, page)):
            wrong.append(f"not found: {words}")
    return wrong


def floors():
    def floor(own):
        return 1 + max((floor(other) for other in MAY_INCLUDE[own].split()), default=0)
    return max(floor(own) for own in MAY_INCLUDE)


def main():
    texts = read_files()
    wrong = violations(texts, MAY_INCLUDE, (ROOT / "README.md").read_text("utf-8")) + unfound()
    for line in wrong:
        print("tool_rooms.py:", line)
    if wrong or len(texts) < 100:
        print(f"tool_rooms.py: {len(texts) - 1} files, {len(wrong)} wrong")
        return 1
    print(f"tool_rooms.py: {len(texts) - 1} files in {len(MAY_INCLUDE)} rooms on {floors()} floors, 0 wrong")
    return 0


sys.exit(main())
