# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Joins headers to one, in the order in which they need each other.

Each header becomes a part with an include guard of its own, so that several joined headers work in one program, in any
order. The other headers that a header includes before its code move to the top of the joined one. An include that
follows code or is inside #if stays where it is, since it may depend on it; for a header of ours there is no such place.
An include in quotes right after an #error ends the compilation and stays too.
"""
import functools
import re

OWN = re.compile(r"#\s*include\s*<servobus/([^>]+)>")
FOREIGN = re.compile(r"#\s*include\s*(<[^>]+>)")
IF = re.compile(r"#\s*if")
ENDIF = re.compile(r"#\s*endif")
ERROR = re.compile(r"#\s*error\b")
GUARDS = re.compile(r"#\s*pragma\s+once\b|// SPDX-")


class CannotJoin(Exception):
    """A header that would change its meaning if it were joined."""


def guard(header):
    return "SERVOBUS_PART_" + re.sub(r"\W", "_", header).upper()


@functools.cache
def split(header, text):
    """A header's own includes, its other includes before its code, and the lines that remain."""
    own, foreign, body = [], [], []
    depth = 0
    code_began = False
    for number, line in enumerate(text.splitlines(), 1):
        directive = line.strip()
        if IF.match(directive):
            depth += 1
        elif ENDIF.match(directive):
            depth -= 1
        is_conditional = depth > 0 or code_began
        if found := OWN.match(directive):
            if is_conditional:
                raise CannotJoin(f"{header}:{number}: an include of servobus after code or inside #if")
            own.append(found[1])
        elif (found := FOREIGN.match(directive)) and not is_conditional:
            foreign.append(found[1])
        elif re.match(r'#\s*include\s*"', directive) and not (body and ERROR.match(body[-1])):
            raise CannotJoin(f"{header}:{number}: an include that is not in <>")
        elif GUARDS.match(directive) or (not code_began and not directive and body[-1:] == [""]):
            continue
        else:
            body.append(line)
            code_began = code_began or bool(directive and not directive.startswith("//"))
    if depth:
        raise CannotJoin(f"{header}: an #if without its #endif")
    if body[:1] == ["//"]:
        del body[0]
    return own, foreign, "\n".join(body).strip("\n")


def order(headers, texts):
    """The headers and all that they include, each after those that it includes."""
    done, open_headers = {}, []

    def take(header):
        if header in done:
            return
        if header not in texts:
            raise CannotJoin(f"there is no header {header}")
        if header in open_headers:
            raise CannotJoin(f"{header} includes itself by {' -> '.join(open_headers)}")
        open_headers.append(header)
        own, foreign, body = split(header, texts[header])
        for other in own:
            take(other)
        open_headers.pop()
        done[header] = (foreign, body)

    for header in headers:
        take(header)
    return done


def join(headers, texts, version, purpose):
    """The text of one header that has what `headers` have. `texts` has all headers by their path in servobus/."""
    parts = order(headers, texts)
    major, minor, patch = (int(number) for number in version.split("."))
    number = (major * 1000 + minor) * 1000 + patch
    lines = [
        "// SPDX-FileCopyrightText: The servobus authors",
        "// SPDX-License-Identifier: BSL-1.0",
        "//",
        f"// servobus {version}: {purpose}",
        "//",
        "// Joined by examples/packages/make.py; change the headers of include/servobus/ instead. Do not include it",
        "// together with those headers.",
        "#pragma once",
        "",
        "#ifndef SERVOBUS_SINGLE_HEADER_VERSION",
        f"#define SERVOBUS_SINGLE_HEADER_VERSION {number}",
        f"#elif SERVOBUS_SINGLE_HEADER_VERSION != {number}",
        '#error "servobus: single headers of two versions"',
        "#endif",
        "",
    ]
    lines += [f"#include {name}" for name in sorted({name for foreign, _ in parts.values() for name in foreign})]
    for header, (_, body) in parts.items():
        name = guard(header)
        lines += ["", f"// ---- servobus/{header}", f"#ifndef {name}", f"#define {name}", "", body, "",
                  f"#endif // {name}"]
    return "\n".join(lines) + "\n"
