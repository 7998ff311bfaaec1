# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""restore of more parameters than a C630S stores at a time: in parts of 200."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from backup_file import other_values, with_checksum
from programs import Tool, play_tool, scene


def many_changes(tool: Tool, saved: str) -> str:
    """The functions of terminals stay: a number higher by one would be the function of another terminal."""
    functions = dict(re.findall(r"^((?:di|do|virtual_input_)[0-9]+_function)(=.*)", saved, re.M))

    def kept(line: re.Match) -> str:
        return line[1] + functions.get(line[1], line[2])

    return re.sub(r"^([a-z0-9_]+)(=.*)", kept, other_values(tool, "c630s", saved), flags=re.M)


def harmless(name: str) -> bool:
    """A register that affects neither terminals nor modes."""
    return bool(
        re.search(
            "segment|notch|_gain|_time|_width|_depth|_threshold|_frequency|_limit|filter|_delay|offset|^virtual_output",
            name,
        )
    )


@scene()
def c630s_too_many(tool: Tool):
    with tool.simulated("c630s"):
        saved = tool.run("backup drive c630s").out
        tool.write("many", with_checksum(tool, "c630s", many_changes(tool, saved)))
        tool.exits("c630s: more than 200 are refused", "restore drive c630s many --yes", 1)
        tool.err_has("c630s: and why",
                     "more than 200 raise an alarm of the drive (Er.942, parameters stored too often); --part writes the first of them")
        tool.run("restore drive c630s many --part --dry-run")
        tool.check("c630s: --part takes 200", sum(" -> " in line for line in tool.last.lines) >= 200)
        tool.check("c630s: and says so", "servobus: writes into the EEPROM: 200" in tool.last.err_lines)


@scene()
def c630s_in_parts(tool: Tool):
    """On a drive that has not stored anything yet."""
    with tool.simulated("c630s"):
        saved = tool.run("backup drive c630s").out
        others = dict(re.findall(r"^([a-z0-9_]+)(=.*)", many_changes(tool, saved), re.M))

        def changed(line: re.Match) -> str:
            return line[1] + (others[line[1]] if harmless(line[1]) else line[2])

        most = re.sub(r"^([a-z0-9_]+)(=.*)", changed, saved, flags=re.M)
        tool.write("most", with_checksum(tool, "c630s", most))
        tool.exits("c630s: a part is done", "restore drive c630s most --part --yes", 0)
        tool.check("c630s: which is 200", len(tool.last.lines) == 200)
        tool.exits("c630s: the other part too", "restore drive c630s most --part --yes", 0)
        tool.run("restore drive c630s most --yes")
        tool.err_has("c630s: and no more", "0 of ")


play_tool()
