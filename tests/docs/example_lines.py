# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The lines of each example, in the table of examples/README.md.

example_lines.py            writes them
example_lines.py --check    fails if they are others

A file counts with its comments. Of a folder, whose page is linked, its C++ files count. To ten lines, above a thousand to a
thousand, so that few changes touch the table.
"""
import re
import sys
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
PAGE = EXAMPLES / "README.md"
ROW = re.compile(r"^(\| (?=\[)[^|]*)\|([^|]*)\|", re.M)


def lines_of(path):
    return len(path.read_text("utf-8").splitlines())


def counted(link):
    path = EXAMPLES / link
    files = [path] if path.suffix != ".md" else [file for kind in ("*.hpp", "*.cpp") for file in path.parent.rglob(kind)]
    lines = sum(map(lines_of, files))
    to = 10 if lines < 1000 else 1000
    return str(round(lines / to) * to)


def with_counts(row):
    return f"{row[1]}| {', '.join(counted(link) for link in re.findall(r'[(]([^)]+)[)]', row[1]))} |"


text = PAGE.read_text("utf-8")
table = ROW.sub(with_counts, text)
if sys.argv[1:] == ["--check"]:
    print(f"{len(ROW.findall(text))} rows")
    sys.exit(f"{PAGE.name} is out of date: python3 tests/docs/example_lines.py" if table != text else 0)
if sys.argv[1:]:
    sys.exit(__doc__)
PAGE.write_text(table, "utf-8")
