# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""sim, read, write and watch with a simulated ZLAC8015D."""
import os
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene, until

ENABLE = "left_target_speed=20 right_target_speed=20 mode_of_operation=velocity control_word=enable"


@scene()
def reads_and_writes(tool: Tool):
    with tool.simulated("zlac8015d", named="sim starts") as drive:
        tool.check("sim prints the pseudo-terminal", drive.out.startswith("/dev/pts/"))
        tool.check("sim prints one line", drive.out.count("\n") == 1)
        for name, words, *lines in [
            ("read by name and by address", "read drive zlac8015d bus_voltage 0x20A4 mode_of_operation",
             "bus_voltage=24.00 V", "motor_temperature=31/32 degC", "mode_of_operation=undefined (0x0000)"),
            ("read with the node", "read drive zlac8015d:1 node_address", "node_address=1"),
            ("read raw", "read drive raw 0x20A1 0x2088:2 --baud 115200", "0x20A1=2400 (0x0960)", "0x2088=0 (0x0000)",
             "0x2089=0 (0x0000)"),
            ("options before and after the names",
             "read --timeout 500 drive zlac8015d bus_voltage --retries=3 --baud 115200 --format 8N1 --echo off",
             "bus_voltage=24.00 V"),
            ("write in the register's unit", "write drive zlac8015d left_max_current=12.5", "left_max_current=12.5 A"),
            ("and read back", "read drive zlac8015d left_max_current", "left_max_current=12.5 A"),
            ("write bits by name", "write drive zlac8015d input_polarity=x0+x1", "input_polarity=x0+x1 (0x0003)"),
            ("write a negative pair", "write drive zlac8015d left_target_position=-20480 --yes",
             "left_target_position=-20480 pulse"),
            ("and read it back", "read drive zlac8015d left_target_position", "left_target_position=-20480 pulse"),
            ("write raw, two words in a frame", "write drive raw 0x2088:2=50,-50 --yes --baud 115200",
             "0x2088=50 (0x0032)", "0x2089=65486 (0xFFCE)"),
            ("hex is the content as it is", "write drive zlac8015d right_target_speed=0xFF9C --yes",
             "right_target_speed=-100 r/min (at the factory's scale)"),
        ]:
            tool.says(name, words, *lines)
        tool.err_has("a target warns, and says that its counts are raw", "raw counts")
        tool.says("and none of them by a number", "write drive zlac8015d input_polarity=0", "input_polarity=0x0000")
        consents(tool)
        wrong_values(tool)
        refused_by_the_drive(tool)


def consents(tool: Tool):
    tool.exits("S8: nothing is written that may move a machine before consent", f"write drive zlac8015d {ENABLE}", 1)
    tool.err_has("S8: and it says so", "not confirmed, nothing was written")
    tool.says("S8: not even what precedes it", "read drive zlac8015d mode_of_operation",
              "mode_of_operation=undefined (0x0000)")
    tool.run("write drive raw 0x200E=8")
    tool.err_has("S8: an address without a map may move it too", "not confirmed, nothing was written")
    tool.run(f"write drive zlac8015d {ENABLE}", stdin="write\n")
    tool.status_is("several writes turn the wheels", 0)
    turns = ["left_actual_speed=20.0 r/min"]
    tool.check(
        "the wheel reaches its speed", until(lambda: tool.run("read drive zlac8015d left_actual_speed").lines == turns)
    )
    tool.exits("S8: a stop needs no consent", "write drive zlac8015d left_target_speed=0 control_word=stop", 0)


def wrong_values(tool: Tool):
    """A value that the register cannot hold is not sent."""
    write, read = "write drive zlac8015d", "read drive zlac8015d"
    for name, words, text in [
        ("no whole number of counts", f"{write} left_max_current=12.55", "no whole number of counts"),
        ("outside the range", f"{write} left_max_current=31", "is outside 0.0 A .. 30.0 A"),
        ("a negative one too", f"{write} left_max_current=-1", "is outside"),
        ("read-only", f"{write} bus_voltage=1", "read-only"),
        ("an unknown name lists the known ones", f"{write} control_word=fly", "quick_stop"),
        ("counts of a rescaled register are whole", f"{write} left_target_speed=1.5", "whole counts"),
        ("no number", f"{write} left_max_current=ten", "'ten' is no number"),
        ("no value", f"{write} left_max_current", "no REG=VALUE"),
        ("no register of that name", f"{read} speed", "has no register 'speed'"),
        ("no register at that address", f"{read} 0x3000", "has no register '0x3000'"),
        ("half a pair", f"{read} 0x208B", "second word of left_target_position"),
        ("a raw address beyond the end", "read drive raw 0xFFFF:2", "is no ADDRESS"),
        ("too few raw values", "write drive raw 0x2088:2=5", "1 values for 2 registers"),
        ("no such node", f"{read}:128 bus_voltage", "no node address of zlac8015d: 1 to 127"),
        ("no register at all", read, "at least one register"),
        ("no such format", f"{read} bus_voltage --format 7E1", "--format takes"),
        ("no such baud rate", f"{read} bus_voltage --baud fast", "--baud takes"),
        ("no such echo", f"{read} bus_voltage --echo maybe", "--echo takes on or off"),
        ("an option without its value", f"{read} bus_voltage --timeout", "--timeout needs a value"),
    ]:
        tool.fails(name, words, 2, text)
    tool.fails("G4: an echo that stays out is said", f"{read} bus_voltage --echo on --retries 0", 1,
               "the request did not come back as echo")
    tool.exits("one wrong value and nothing is written", f"{write} left_max_current=10 right_max_current=99", 2)
    tool.says("nothing indeed", f"{read} left_max_current", "left_max_current=12.5 A")


def refused_by_the_drive(tool: Tool):
    tool.fails("an exception in the drive's words", "read drive raw 0x3000 --baud 115200", 1,
               "refused, exception 2 (illegal data address)")
    tool.run("write drive zlac8015d left_max_current=10 control_word=3 right_max_current=10 --yes")
    tool.status_is("a refused write is status 1", 1)
    tool.err_has("names the codes", "refused, exception 3 (illegal data value); it takes 0x00 undefined, 0x05 quick_stop")
    tool.err_has("and says how many were done", "; 1 of 3 written")
    tool.out_is("and shows them", "left_max_current=10.0 A")
    tool.fails("no response from another node", "read drive zlac8015d:9 bus_voltage --timeout 20 --retries 0", 1,
               "bus_voltage: no response")
    tool.run("write drive zlac8015d:9 left_max_current=10 --timeout 20")
    tool.err_has("a write without an answer is unknown", "left_max_current: unknown, no response")
    tool.fails("no such port", "read /dev/no-such-port zlac8015d bus_voltage", 1, "there is no such port")
    tool.fails("no serial device", "read /dev/null zlac8015d bus_voltage", 1, "no serial device")


@scene()
def watched(tool: Tool):
    with tool.simulated("zlac8015d"):
        tool.exits("watch: status 0", "watch drive zlac8015d left_actual_speed bus_voltage --count 3 --interval 10", 0)
        rounds = re.findall(r"^[0-9.]* left_actual_speed=.* r/min, bus_voltage=24\.00 V$", tool.last.out, re.M)
        tool.check("watch: a line a round", len(rounds) == 3)
        tool.check("watch: three rounds", len(tool.last.lines) == 3)
        tool.err_has("watch warns of the watchdog", "watchdog")
        watcher = tool.start("watch drive zlac8015d bus_voltage --interval 10")
        tool.check("watch goes on", until(lambda: watcher.out), watcher.err)
        if os.environ.get("ON_WINE"):
            tool.say("left out: a port has one user (Windows sees to that, wine does not)")
        else:
            tool.run("read drive zlac8015d bus_voltage")
            tool.err_has("a port has one user", "another program uses it")
        tool.ends(watcher, signal.SIGINT)
        tool.status_is("watch ends at an interrupt with status 0", 0)
    tool.fails("watch: no such interval", "watch drive zlac8015d bus_voltage --interval -1", 2, "--interval takes")


@scene()
def unplugged(tool: Tool):
    with tool.simulated("zlac8015d") as drive:
        drive.send(signal.SIGUSR1)
        tool.check("SIGUSR1 pulls the plug", until(lambda: "unplugged" in drive.err))
        tool.fails("no response", "read drive zlac8015d bus_voltage --timeout 20 --retries 0", 1,
                   "bus_voltage: no response")
        drive.send(signal.SIGUSR1)
        tool.check("and puts it in again", until(lambda: "plugged in" in drive.err))
        tool.says("and the drive answers", "read drive zlac8015d bus_voltage", "bus_voltage=24.00 V")
        tool.ends(drive, signal.SIGTERM)
        tool.status_is("sim ends at a signal with status 0", 0)
        tool.check("and takes its link away", not tool.exists("drive"))


@scene()
def another_setting(tool: Tool):
    with tool.simulated("zlac8015d --node 5 --baud 9600"):
        tool.says("another node and baud rate", "read drive zlac8015d:5 node_address --baud 9600", "node_address=5")


@scene()
def a_bad_line(tool: Tool):
    with tool.simulated("zlac8015d --faults noisy,lossy,doubled,cut --seed 7"):
        words = "read drive zlac8015d bus_voltage left_max_current --retries 9 --timeout 100"
        found = [tool.run(words).lines for _ in range(10)]
        expected = ["bus_voltage=24.00 V", "left_max_current=30.0 A"]
        tool.is_equal("a bad line delays, but gives no wrong value", found, [expected] * 10)


@scene()
def refused_simulations(tool: Tool):
    tool.write("file", "")
    for name, words, status, text in [
        ("sim: a rate that the drive does not have", "sim zlac8015d --baud 4800", 2, "--baud: zlac8015d has"),
        ("sim: an unknown fault", "sim zlac8015d --faults gremlins", 2, "--faults takes"),
        ("sim: no such node", "sim zlac8015d --node 0", 2, "--node takes"),
        ("sim: a link over a file", "sim zlac8015d --link file", 1, "File exists"),
    ]:
        tool.fails(name, words, status, text)


play_tool()
