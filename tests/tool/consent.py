# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""restore asks for consent if standard input is a terminal."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Ended, Tool, patient, play_tool, scene
from terminal import Terminal

QUESTION = "Type restore"


def at_terminal(tool: Tool, words: str, answer: str):
    with Terminal([tool.path, *patient(words.split())], tool.folder) as terminal:
        if terminal.shows(QUESTION):
            terminal.type(answer + "\n")
        terminal.wait()
    tool.last = Ended(terminal.status, terminal.shown, "")


@scene()
def restore(tool: Tool):
    with tool.simulated("zlac8015d"):
        tool.run("backup drive zlac8015d good")
        tool.run("write drive zlac8015d left_max_current=12.5")
        at_terminal(tool, "restore drive zlac8015d good", "yes")
        tool.out_has("any other word is none", "not confirmed, nothing was written")
        tool.status_is("and status 1", 1)
        first = re.search(f"EEPROM|{QUESTION}", tool.last.out)
        is_before = first and first[0] == "EEPROM" and QUESTION in tool.last.out
        tool.check("the count of writes is printed before the question", is_before)
        tool.out_has("progress is a line that moves", "reading: 86 of 86")
        tool.says("nothing indeed", "read drive zlac8015d left_max_current", "left_max_current=12.5 A")
        at_terminal(tool, "restore drive zlac8015d good", "restore")
        tool.status_is("typed consent", 0)
        tool.says("and it is done", "read drive zlac8015d left_max_current", "left_max_current=30.0 A")
        tool.run("write drive zlac8015d left_max_current=12.5")
        at_terminal(tool, "restore drive zlac8015d good --yes", "")
        tool.check("--yes is not asked", QUESTION not in tool.last.out)
        tool.status_is("and done", 0)


play_tool()
