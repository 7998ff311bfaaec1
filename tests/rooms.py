# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks from the includes that the rooms of include/servobus/ form layers, and names each include that breaks them.

rooms.py [INCLUDE]    INCLUDE: the directory that holds servobus/, include/ if not given
"""
import re
import sys
from pathlib import Path

# What a room's headers may include, besides those of the same room.
MAY_INCLUDE = {
    "core": "",
    "modbus": "core",
    "registers": "core",
    "line": "core modbus",
    "client": "core modbus registers line",
    "control": "core modbus registers line client",
    "bus": "core modbus registers line client control",
    "explain": "core modbus registers",
    "device": "core registers control",
    "sim": "core modbus registers line device",
    "posix": "core registers line",
    "windows": "core registers line",
    "": "core modbus registers line client control bus explain",  # servobus.hpp
}
INCLUDE = re.compile(r"^\s*#\s*include\s*<servobus/([^>]+)>", re.MULTILINE)


def room(header):
    return header.split("/")[0] if "/" in header else ""


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent / "include") / "servobus"
    texts = {str(p.relative_to(root)): p.read_text(encoding="utf-8") for p in sorted(root.rglob("*.hpp"))}
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
        if own in ("device", "sim") and "servobus::detail" in texts[header]:
            wrong.append(f"{header} uses servobus::detail: what a drive's author needs is public")
    wrong += circles(includes)
    for line in wrong:
        print("rooms.py:", line)
    edges = {(room(a), room(b)) for a, bs in includes.items() for b in bs if room(a) != room(b)}
    print(f"rooms.py: {len(includes)} headers in {len(MAY_INCLUDE) - 1} rooms, {len(edges)} arrows between rooms, "
          f"{len(wrong)} wrong")
    return 1 if wrong or len(includes) < 50 else 0


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
