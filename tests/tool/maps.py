# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Which rows of device files the tool takes, and why not the others; the files of examples/devices if none is given.

maps.py TOOL [FILE or FOLDER...]    For each file: the rows that are taken, and each line that is refused, with the reason.
                                    Exit 0 if all are taken.
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

DEVICES = Path(__file__).resolve().parents[2] / "examples/devices"


def refusals(tool: str, text: str) -> tuple[int, list[str]]:
    """The rows that are taken, and what is wrong with the others, `LINE: why`. A refused line is left out, and so on."""
    lines = text.splitlines()
    found = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.csv"
        while True:
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
            ended = subprocess.run([tool, "map", str(path)], capture_output=True, text=True, check=False)
            if ended.returncode == 0:
                return len(ended.stdout.splitlines()) - 1, found
            place = re.search(r"map\.csv:(\d+): (.*)", ended.stderr)
            if place is None:
                return 0, [*found, ended.stderr.strip()]
            number = int(place[1])
            found.append(f"{number}: {place[2]}")
            first_row = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines))
            is_header = number - 1 >= len(lines) or number - 1 == first_row
            if is_header or lines[number - 1].startswith("##"):
                return 0, found
            lines[number - 1] = "##"


def main() -> int:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    paths = [Path(word) for word in sys.argv[2:]] or [DEVICES]
    files = [file for path in paths for file in (sorted(path.rglob("*.csv")) if path.is_dir() else [path])]
    taken = refused = whole = 0
    for file in files:
        rows, why = refusals(sys.argv[1], file.read_text("utf-8-sig"))
        taken, refused, whole = taken + rows, refused + len(why), whole + (not why)
        print(f"{file.name}: {rows} rows taken, {len(why)} refused")
        for line in why:
            print(f"    {line}")
    print(f"{len(files)} files, {whole} of them whole; {taken} rows taken, {refused} refused")
    return refused != 0 or not files


if __name__ == "__main__":
    sys.exit(main())
