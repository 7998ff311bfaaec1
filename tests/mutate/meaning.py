# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The changes of meaning.txt, in its order."""
import re

import sites


def changes_of(root, path):
    """Each paragraph as a change of a header; raises ValueError for one that does not fit the header."""
    found = []
    for paragraph in path.read_text(encoding="utf-8").split("\n\n"):
        lines = [line for line in paragraph.splitlines() if line and not line.startswith("#")]
        if not lines:
            continue
        header, what = lines[0].split(": ", 1)
        old = [line[2:] for line in lines[1:] if line.startswith("- ")]
        new = [line[2:] for line in lines[1:] if line.startswith("+")]
        if not old or not new or len(old) + len(new) + 1 != len(lines):
            raise ValueError(f"{path.name}: not a change: {lines[0]}")
        file = f"include/servobus/{header}"
        source = (root / file).read_text(encoding="utf-8")
        places = list(re.finditer(r"\n\s*".join(re.escape(line) for line in old), source))
        if len(places) != 1:
            raise ValueError(f"{path.name}: {header} has these lines {len(places)} times: {old[0]}")
        start = places[0].start()
        before = source[:start]
        found.append(
            sites.Site(
                file=file,
                line=before.count("\n") + 1,
                column=start - before.rfind("\n"),
                start=start,
                end=places[0].end(),
                new="\n".join(new),
                what=what,
                line_text=old[0],
            )
        )
    return found
