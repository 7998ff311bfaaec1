# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The tool with the winch of examples/own_device, which registers itself: every command that takes a drive takes it."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import crc
from programs import Tool, play_tool, scene


@scene()
def is_known(tool: Tool):
    tool.run("map winch")
    tool.check("its map", len(tool.last.lines) == 1 + 10 + 8 and "0x0011,position,2,i32,ro" in tool.last.out)
    tool.says("its alarms", "alarms winch", "code,class,resettable,name,cause,remedy,reset",
              '1,fault,yes,overload,"The load is too heavy.","Take some off.","control_word = 4"',
              '2,fault,no,rope,"The rope is slack.","Wind it by hand.","Switch it off and on."')
    tool.fails("among the others, by their names", "map x", 2,
               "unknown device 'x'; known: c630s, winch, yako-closed-loop, yako-open-loop, zlac8015d")
    tool.fails("as the others", "map wintch", 2, "unknown device 'wintch'; did you mean winch?")
    frame = bytes.fromhex("050600010002")
    tool.run("explain winch", stdin=(frame + crc(frame)).hex(" ") + "\n")
    tool.out_has("a frame of it in words", "write control_word (0x0001) = turn")
    tool.run("header winch")
    tool.check("its header", tool.last.status == 0 and "control_word" in tool.last.out)


@scene()
def moves(tool: Tool):
    line = "--format 8N1" # a pseudo-terminal has no parity
    with tool.simulated("winch --node 5"):
        tool.says("it is read", f"read drive winch:5 status_word ramp {line}", "status_word=0x0000", "ramp=500 ms")
        tool.run(f"write drive winch:5 control_word=turn {line}", stdin="no\n")
        tool.err_has("what may move it asks", "control_word moves the motor of an enabled drive")
        tool.run(f"write drive winch:5 control_word=hold --yes {line}")
        tool.run(f"write drive winch:5 speed=30 control_word=turn --yes {line}")
        tool.says("and turns it", f"read drive winch:5 status_word {line}", "status_word=energised+turning (0x0003)")
        tool.fails("nothing is restored while it is energised", f"restore drive winch:5 saved.txt --yes {line}", 2, "saved.txt")
        tool.run(f"write drive winch:5 control_word=off {line}")
        tool.check("what stops it is written unasked", tool.last.status == 0)
        tool.run(f"backup drive winch:5 saved.txt {line}")
        tool.check("its parameters in a file", "ramp" in tool.read("saved.txt") and "limit" in tool.read("saved.txt"))
        tool.run(f"write drive winch:5 ramp=900 {line}")
        tool.run(f"restore drive winch:5 saved.txt --yes {line}")
        tool.says("and back", f"read drive winch:5 ramp {line}", "ramp=500 ms")


@scene()
def examined(tool: Tool):
    """Its own checks for doctor, as a table."""
    line = "--format 8N1"
    with tool.simulated("winch --node 5"):
        tool.run(f"doctor drive winch:5 {line}")
        tool.check("nothing is found", tool.last.status == 0 and "winch:5: nothing refuses an enable" in tool.last.out,
                   tool.found())
        tool.run(f"write drive winch:5 limit=0 control_word=hold --yes {line}")
        tool.run(f"doctor drive winch:5 {line}")
        tool.status_is("what matters is no refusal", 0)
        tool.out_has("a row of its table", "matters  limit=0.0 A: the motor gets no current -> servobus write drive winch:5 "
                                           "limit=10 --format 8N1")
        tool.out_has("and another", "matters  status_word=energised (0x0001): another program commands the winch")
        tool.out_has("and the sum", "winch:5: nothing refuses an enable; 2 findings matter")


play_tool()
