# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Copies the library's pages as doxygen is to read them.

- Each heading gets a name of its own, `guide_turn_a_motor`, since names are one list for all pages of doxygen.
- A link to one of these pages, to a heading of it, or to a public header leads to its page of the reference.
- A link to a file that the reference does not have becomes its text, with the path.
"""
import re
from pathlib import Path

# A page of include/servobus, and its name in the reference.
PAGES = {"architecture.md": "architecture", "guide.md": "guide", "rules.md": "rules", "promises.md": "promises",
         "device/README.md": "devices"}


def anchor_of(heading):
    """As GitHub makes it."""
    return re.sub(r"[^a-z0-9 _-]", "", heading.lower()).replace(" ", "-")


def label(page, anchor):
    return f"{PAGES[page]}_{anchor}".replace("-", "_") if anchor else PAGES[page]


def resolved(page, target):
    """A path from include/servobus, or with .. from there."""
    parts = []
    for part in (Path(page).parent / target).parts:
        if part == ".." and parts and parts[-1] != "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)


def link(page, headers, text, target):
    text = " ".join(text.split())  # doxygen 1.9.4 loses its way after a link of two lines
    file, _, anchor = target.partition("#")
    path = resolved(page, file) if file else page
    if path in PAGES:
        return f"[{text}](@ref {label(path, anchor)})"
    if path in headers:
        return f"[{text}](@ref {path})"
    name = path[len("../../"):] if path.startswith("../../") else f"include/servobus/{path}"
    return f"`{name}`" if text.strip("`") in (name, path, Path(path).name) else f"{text} (`{name}`)"


def named(page, marks, heading):
    """The title of a page has the page's name."""
    return f"{marks} {heading} {{#{label(page, '' if marks == '#' else anchor_of(heading))}}}"


def prepared(page, source, headers):
    out = []
    # Fenced code stays as it is; so does code in a sentence.
    for piece in re.split(r"(^```.*?^```$)", source, flags=re.M | re.S):
        if piece.startswith("```"):
            out.append(piece.replace("```cpp", "```{.cpp}", 1))
            continue
        piece = re.sub(r"(?m)^(#+) (.*)$", lambda found: named(page, *found.groups()), piece)
        out.append(re.sub(r"\[((?:[^\[\]`]|`[^`]*`)+)\]\(([^)\s]+)\)",
                          lambda found: link(page, headers, found[1], found[2]), piece))
    return "".join(out)


def write(library, to):
    """Writes the pages of the library into a folder."""
    headers = {str(path.relative_to(library)) for path in library.rglob("*.hpp")
               if "detail" not in path.relative_to(library).parts}
    for page, name in PAGES.items():
        (to / f"{name}.md").write_text(prepared(page, (library / page).read_text("utf-8"), headers), "utf-8")
