# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Files that restore refuses before it sends anything."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from backup_file import with_checksum
from programs import Tool, play_tool, scene

CHANGE = "write drive zlac8015d left_max_current=12.5"  # so that a restore would change it


def edited(tool: Tool, good: str, *edits: tuple[str, str]) -> str:
    """The good file with these substitutions and a checksum that matches."""
    for pattern, replacement in edits:
        good = re.sub(pattern, replacement, good, flags=re.M)
    return with_checksum(tool, "zlac8015d", good)


@scene()
def damaged_files(tool: Tool):
    with tool.simulated("zlac8015d"):
        good = tool.run("backup drive zlac8015d").out
        tool.run(CHANGE)
        held = tool.run("backup drive zlac8015d").out

        def refused(what: str, text: str):
            tool.fails(f"a file that {what} is refused", "restore drive zlac8015d bad --yes", 2, text)
            now = tool.run("backup drive zlac8015d").out
            tool.check("and the drive is as it was", now == held)

        row = "^left_max_current="
        another = ("rows=88", "rows=89")
        for what, text, *edits in [
            ("is of another drive", "it is of a c630s, not of a zlac8015d", ("device=zlac8015d", "device=c630s")),
            ("has another format", "it has format '2', not 1", ("format=1", "format=2")),
            (
                "has an unknown name",
                "zlac8015d has no register 'left_most_current'",
                (row, "left_most_current="),
            ),
            ("lacks a name", "left_max_current is missing", (row + ".*\n", ""), ("rows=88", "rows=87")),
            ("lacks a row", "left_max_current is missing", (row + ".*\n", "")),
            ("has another number of rows", "another number of rows than its 88", another),
            (
                "has a value out of range",
                "left_max_current: 301 is outside 0 .. 300",
                (row + "[0-9]*", "left_max_current=301"),
            ),
            (
                "has no whole number",
                "left_max_current: '30.0' is no whole number",
                (row + "[0-9]*", "left_max_current=30.0"),
            ),
            ("has another line", "is no name=number", (row, "left_max_current ")),
            ("has a read-only register", "bus_voltage is ro, no parameter", (row + ".*", "bus_voltage=2400")),
            ("has a register twice", "left_max_current is there twice", (row + ".*", r"\g<0>\n\g<0>"), another),
        ]:
            tool.write("bad", edited(tool, good, *edits))
            refused(what, text)
        for what, text, content in [
            ("is no backup", "it is no backup file", "left_max_current=300\n"),
            ("is empty", "it is no backup file", ""),
            ("was edited", "it was changed or damaged: its checksum is",
             re.sub(row + "[0-9]*", "left_max_current=299", good, flags=re.M)),
            ("has no last line", "it is truncated", good[: good.rindex("\n", 0, -1) + 1]),
            ("is cut", "it is truncated", good[:1000]),
            ("lacks its last character", "it is truncated", good[:-1]),
            ("has other line ends", "its line ends were changed", good.replace("\n", "\r\n")),
        ]:
            tool.write("bad", content)
            refused(what, text)
        (tool.folder / "bad").unlink()
        refused("does not exist", "cannot read bad: No such file")
        (tool.folder / "bad").mkdir()
        refused("is a folder", "cannot read bad")


@scene()
def skipped_rows(tool: Tool):
    with tool.simulated("zlac8015d"):
        good = tool.run("backup drive zlac8015d").out
        tool.run(CHANGE)
        row = "^left_max_current="
        trigger = edited(tool, good, (row + ".*", r"\g<0>\ncontrol_word=8"), ("rows=88", "rows=89"))
        tool.write("bad", trigger)
        tool.run("restore drive zlac8015d bad")
        tool.out_is("S8: nothing is written before consent")
        tool.err_has("S8: and it says so", "not confirmed, nothing was written")
        tool.run("restore drive zlac8015d bad --yes")
        tool.out_is("S7: a trigger in a file is skipped", "left_max_current=30.0 A")
        tool.err_has("and counted", "skipped: 3 rows")
        tool.write("bad", edited(tool, good, (row + "[0-9]*", "left_max_current=?")))
        tool.run(CHANGE)
        tool.run("restore drive zlac8015d bad --yes")
        tool.out_is("a register marked ? is left alone")
        tool.err_has("and said", ", 1 marked ?")
        tool.write("good", good)
        for name, words, text in [
            ("restore takes a file", "restore drive zlac8015d", "restore takes PORT DEVICE[:NODE] FILE"),
            ("restore needs a map", "restore drive raw good", "not raw"),
            ("backup needs a map", "backup drive raw none", "not raw"),
            ("backup takes no interval", "backup drive zlac8015d --interval 5", "unknown option '--interval'"),
        ]:
            tool.fails(name, words, 2, text)


play_tool()
