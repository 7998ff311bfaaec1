# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Copies the headers as doxygen is to read them.

- The paragraph after the two SPDX lines becomes the documentation of the file.
- `Errors:` begins a paragraph of its own, in which each `errc` leads to its meaning.
- [errata B5] leads to the erratum on the page of the drive's map.
- The dots of `66h .. BAh` do not end a summary.

The code stays as it is. Folders named `detail` are left out.
"""
import re

MAPS = {"A": "yako_closed_loop", "B": "zlac8015d", "C": "c630s"}
ERRATUM = r"[A-C]\d+"


def error_names(headers):
    body = re.search(r"enum class errc .*?\n};", (headers / "core/status.hpp").read_text("utf-8"), re.S)
    return set(re.findall(r"^    (\w+),", body.group(0), re.M))


def document_file(lines):
    """Turns the header's first paragraph, which ends before the first line of code, into a comment of the file."""
    at = 0
    while at < len(lines) and "SPDX-" in lines[at]:
        at += 1
    if at == 0 or lines[at] != "//":
        return
    lines[at] = "/// @file"
    for at in range(at + 1, len(lines)):
        text = lines[at][2:]
        if not lines[at].startswith("//") or text.startswith("/"):
            return
        is_example = text.startswith("     ")
        lines[at] = "///" + (text if is_example else text.replace("<", "&lt;").replace(">", "&gt;"))


def link_errata(text, path):
    """Makes each number a link."""

    def linked(found):
        page = "yako_open_loop" if "open_loop" in path.name else MAPS[found.group(2)[0]]
        return found.group(1) + re.sub(ERRATUM, rf"[\g<0>](../map_{page}.html#\g<0>)", found.group(2))

    return re.sub(rf"(errata )({ERRATUM}(?:, {ERRATUM})*)", linked, text)


def link_errors(text, errors):
    def linked(found):
        name = found.group(1)
        return f'@ref servobus::errc::{name} "{name}"' if name in errors else found.group(0)

    return re.sub(r"`(\w+)`", linked, text)


def prepared(path, errors):
    lines = path.read_text("utf-8").split("\n")
    document_file(lines)
    out = []
    in_errors = False
    for line in lines:
        if re.match(r"#\s*(define|undef)\b", line):  # for a line of the header's own: no macro is public
            continue
        comment = re.fullmatch(r"(.*?///<? ?)(.*)", line)
        if not comment:
            in_errors = False
            out.append(line)
            continue
        before, text = comment.groups()
        if not text.startswith("    "):  # an example stays as it is
            text = link_errata(text, path).replace(" .. ", " &hellip; ")
        if "Errors:" in text:
            in_errors = True
            summary, text = text.split("Errors:", 1)
            out += [before + summary, before + "@par Errors:"]
        out.append(before + (link_errors(text.strip() if "@par" in out[-1] else text, errors) if in_errors else text))
    return "\n".join(out)


def write(headers, to):
    """Writes the public headers into a folder."""
    errors = error_names(headers)
    for path in sorted(headers.rglob("*.hpp")):
        inside = path.relative_to(headers)
        if "detail" in inside.parts:
            continue
        (to / inside).parent.mkdir(parents=True, exist_ok=True)
        (to / inside).write_text(prepared(path, errors), "utf-8")
