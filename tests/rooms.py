# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks from the includes that the rooms of include/servobus/ form layers, that no header includes what programs
include by choice, and that only catalogues include descriptions of registers; names each include that breaks this, and
checks that violations are found.
"""
import re
import sys
from pathlib import Path

# What a room's headers may include, besides those of the same room.
MAY_INCLUDE = {
    "core": "",
    "modbus": "core",
    "registers": "core",
    "axis": "core registers",
    "line": "core modbus",
    "server": "core modbus registers line",
    "client": "core modbus registers line",
    "control": "core modbus registers line client axis",
    "bus": "core modbus registers line client control",
    "explain": "core modbus registers",
    "device": "core registers axis control",
    "sim": "core modbus registers line control device",
    "posix": "core registers line",
    "windows": "core registers line",
    "": "core modbus registers axis line client control bus explain",  # servobus.hpp, words.hpp
}
# Headers with what people want to know, which no other header includes: they cost a program that does not include them
# nothing.
BY_CHOICE = re.compile(r"device/\w+/(?:advice|arguments)\.hpp")
# Headers with a sentence for each register, which only the catalogues of the same device include; and what includes
# these: programs, and simulated drives.
DESCRIPTIONS = re.compile(r"device/\w+/(?:\w+_)?descriptions\.hpp")
CATALOGUE = re.compile(r"device/\w+/(?:\w+_)?catalogue\.hpp")
INCLUDE = re.compile(r"^\s*#\s*include\s*<servobus/([^>]+)>", re.MULTILINE)

# A header, a line that is added to it, and how the violation is described.
BREAKS = [
    ("line/port.hpp", "#include <servobus/control/step.hpp>",
     "line/port.hpp includes control/step.hpp: line may include core modbus"),
    ("modbus/pdu.hpp", "#include <servobus/registers/reg.hpp>", "modbus/pdu.hpp includes registers/reg.hpp"),
    ("core/slice.hpp", "#include <servobus/core/bytes.hpp>",
     "circle: core/bytes.hpp -> core/slice.hpp -> core/bytes.hpp"),
    ("control/facade.hpp", "#include <servobus/line/detail/arbiter.hpp>", "a detail/ is for its own room"),
    ("device/c630s/feedback.hpp", "#include <servobus/device/c630s/advice.hpp>",
     "device/c630s/feedback.hpp includes device/c630s/advice.hpp, which programs include by choice"),
    ("device/zlac8015d/registers.hpp", "#include <servobus/device/zlac8015d/descriptions.hpp>",
     "device/zlac8015d/registers.hpp includes device/zlac8015d/descriptions.hpp: only catalogues of the device may"),
    ("sim/yako.hpp", "#include <servobus/device/yako/common_descriptions.hpp>",
     "sim/yako.hpp includes device/yako/common_descriptions.hpp: only catalogues of the device may"),
    ("device/c630s.hpp", "#include <servobus/device/c630s/catalogue.hpp>",
     "device/c630s.hpp includes device/c630s/catalogue.hpp: of the headers, only those of sim may"),
    ("device/yako/common.hpp", "using servobus::detail::sound_row;", "device/yako/common.hpp uses servobus::detail"),
]


def room(header):
    return header.split("/")[0] if "/" in header else ""


def read_headers():
    root = Path(__file__).resolve().parent.parent / "include/servobus"
    return {str(path.relative_to(root)): path.read_text("utf-8") for path in sorted(root.rglob("*.hpp"))}


def violations(texts):
    """A line for each include that breaks the layers. `texts` has all headers by their path in servobus/."""
    includes = {header: INCLUDE.findall(text) for header, text in texts.items()}
    wrong = []
    for header, included in includes.items():
        own = room(header)
        if own not in MAY_INCLUDE:
            wrong.append(f"{header}: there is no room {own}")
            continue
        for other in included:
            if other not in includes:
                wrong.append(f"{header} includes {other}, which does not exist")
            elif room(other) != own and room(other) not in MAY_INCLUDE[own].split():
                may = MAY_INCLUDE[own] or "nothing of another room"
                wrong.append(f"{header} includes {other}: {own or 'servobus.hpp'} may include {may}")
            elif "/detail/" in other and room(other) != own:
                wrong.append(f"{header} includes {other}: a detail/ is for its own room")
            if BY_CHOICE.fullmatch(other):
                wrong.append(f"{header} includes {other}, which programs include by choice")
            of_same_device = header.rpartition("/")[0] == other.rpartition("/")[0]
            is_text = CATALOGUE.fullmatch(header) or DESCRIPTIONS.fullmatch(header)
            if DESCRIPTIONS.fullmatch(other) and not (is_text and of_same_device):
                wrong.append(f"{header} includes {other}: only catalogues of the device may")
            if CATALOGUE.fullmatch(other) and own != "sim":
                wrong.append(f"{header} includes {other}: of the headers, only those of sim may")
        if own in ("device", "sim") and "servobus::detail" in texts[header]:
            wrong.append(f"{header} uses servobus::detail: what a drive's author needs is public")
    return wrong + circles(includes)


def main():
    texts = read_headers()
    wrong = violations(texts)
    for header, line, words in BREAKS:
        if not any(words in found for found in violations({**texts, header: f"{texts[header]}\n{line}\n"})):
            wrong.append(f"{line} in {header} is not found")
    for line in wrong:
        print("rooms.py:", line)
    print(f"rooms.py: {len(texts)} headers in {len(MAY_INCLUDE) - 1} rooms, {len(wrong)} wrong")
    return 1 if wrong or len(texts) < 50 else 0


def circles(includes):
    """One line for each include that closes a circle of headers."""
    found, done = [], set()

    def follow(header, path):
        if header in path:
            found.append("circle: " + " -> ".join(path[path.index(header):] + [header]))
        elif header not in done:
            for other in includes.get(header, []):
                follow(other, path + [header])
            done.add(header)

    for header in includes:
        follow(header, [])
    return found


sys.exit(main())
