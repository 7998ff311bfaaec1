# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Machine files: apply, diff, and what interrupts them; turn. Judged by what the simulated drives hold after a power cycle."""
import os
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from hand_turned import WHEELS
from programs import Tool, play_tool, scene, until
from shared_wire import shared_wire

WAIT = "--timeout 1000 --retries 0"
LIFT = """servobus-machine format=1
# The lift of cell 3
[lift] device=yako-closed-loop node=2
require microstep_resolution=1000   # compared, never written
holding_current=60 %
max_current=3.0 A
x0_function=home
positioning_speed=200
"""
MACHINE = """servobus-machine format=1
[wheels] device=zlac8015d node=1
left_max_current=12.5 A
right_max_current=12.5 A
host_timeout=500 ms
[lift] device=yako-closed-loop node=2
max_current=3.0 A
x2_function=stop
"""


def tell(drive, number: int, note: str):
    """Sends the simulated drive a signal, and waits until it has been noticed."""
    before = drive.err.count(note)
    drive.send(number)
    until(lambda: drive.err.count(note) > before)


def power_cycle(drive):
    """As a person switches a drive off and on."""
    tell(drive, signal.SIGUSR2, "switched off and on")


@scene()
def a_drive(tool: Tool):
    tool.write("machine.txt", LIFT)
    with tool.simulated("yako-closed-loop --node 2") as drive:
        tool.run(f"diff drive machine.txt {WAIT}")
        shown = ["lift.x0_function", "lift.max_current", "lift.positioning_speed", "lift.holding_current"]
        tool.check("diff", tool.last.status == 1 and tool.last.err == "", tool.found())
        differing = [line.split()[0] for line in tool.last.lines]
        tool.check("names what differs, and that alone", "lift.max_current" in differing and
                   "lift.microstep_resolution" not in differing and set(differing) <= set(shown), str(differing))
        tool.run(f"apply drive machine.txt {WAIT}", stdin="yes\n")
        tool.check("is refused while the motor is enabled", tool.last.status == 1 and "auxiliary_command=release" in
                   tool.last.err and tool.last.out == "", tool.found())
        tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
        tool.run(f"apply drive machine.txt --dry-run {WAIT}")
        tool.check("a dry run", tool.last.status == 0 and len(tool.last.lines) == len(differing), tool.found())
        planned = tool.last.lines
        tool.err_has("says what it costs", "writes into the EEPROM: none, but one save at the end")
        tool.check("and makes no file", not tool.exists("machine.txt.unsaved"))
        tool.run(f"apply drive machine.txt {WAIT}", stdin="no\n")
        tool.check("without consent nothing is written", tool.last.status == 1 and "not confirmed" in tool.last.err)
        tool.check("what it shows is what differs", tool.last.lines == planned)
        tool.exits("and is so", f"diff drive machine.txt {WAIT}", 1)
        tool.run(f"apply drive machine.txt {WAIT}", stdin="apply\n")
        tool.check("with consent it is", tool.last.status == 0 and tool.last.lines[: len(planned)] == planned,
                   tool.found())
        tool.check("and saved", not tool.exists("machine.txt.unsaved"))
        tool.exits("as diff sees", f"diff drive machine.txt {WAIT}", 0)
        power_cycle(drive)
        tool.exits("also after a power cycle", f"diff drive machine.txt {WAIT}", 0)
        tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
        tool.run(f"apply drive machine.txt --yes {WAIT}")
        tool.check("twice: the second writes nothing", tool.last.status == 0 and tool.last.out == "", tool.found())
        tool.err_has("and says so", "nothing to write")
        tool.run(f"write drive yako-closed-loop:2 max_current=2000 {WAIT}")
        power_cycle(drive)
        tool.exits("what is only written is lost with the power", f"diff drive machine.txt {WAIT}", 0)
        tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release positioning_speed=150 --yes {WAIT}")
        tool.write("slower.txt", LIFT.replace("=200", "=150"))
        tool.run(f"apply drive slower.txt --yes --save {WAIT}")
        tool.check("--save keeps it where nothing differs", tool.last.status == 0 and "0 parameters of 4 differ" in
                   tool.last.err, tool.found())
        power_cycle(drive)
        tool.exits("over a power cycle", f"diff drive slower.txt {WAIT}", 0)
        tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
        tool.run(f"apply drive machine.txt --yes {WAIT}")
        tool.write("other.txt", LIFT.replace("=1000", "=3200"))
        tool.run(f"apply drive other.txt --yes {WAIT}")
        tool.check("what is required is compared", tool.last.status == 1 and tool.last.lines ==
                   ["lift.microstep_resolution is 1000, required 3200"], tool.found())
        tool.err_has("and nothing is written", "nothing was written")
        tool.run(f"diff drive other.txt {WAIT}")
        tool.check("also by diff", tool.last.status == 1 and "required 3200" in tool.last.out)


@scene()
def a_machine(tool: Tool):
    """Two drives on one line; the file's order, one by name."""
    tool.write("machine.txt", MACHINE)
    with tool.simulated("zlac8015d", link="wheels_drive"), tool.simulated("yako-closed-loop --node 2", link="lift_drive"):
        with shared_wire([tool.folder / "wheels_drive", tool.folder / "lift_drive"]) as wire:
            tool.run(f"write {wire} yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
            tool.run(f"diff {wire} machine.txt lift {WAIT}")
            tool.check("one by its name", {line.split(".")[0] for line in tool.last.lines} == {"lift"}, tool.found())
            tool.run(f"apply {wire} machine.txt --yes {WAIT}")
            tool.check("both", tool.last.status == 0, tool.found())
            tool.exits("are as the file says", f"diff {wire} machine.txt {WAIT}", 0)
            tool.says("read by name", f"read {wire} zlac8015d left_max_current host_timeout {WAIT}",
                      "left_max_current=12.5 A", "host_timeout=500 ms")
            tool.run(f"write {wire} zlac8015d left_max_current=10 {WAIT}")
            tool.run(f"diff {wire} machine.txt {WAIT}")
            tool.check("what somebody has changed", tool.last.lines == ["wheels.left_max_current 10.0 A -> 12.5 A"])
            tool.fails("a name that is none", f"apply {wire} machine.txt lifd --yes {WAIT}", 2, "did you mean lift?")
            tool.fails("the same twice", f"diff {wire} machine.txt lift lift {WAIT}", 2, "is named twice")
            tool.fails("--at for two", f"apply {wire} machine.txt --at 5 {WAIT}", 2, "--at is about one drive")
            tool.write("third.txt", MACHINE + "[third] device=zlac8015d node=3\nhost_timeout=500 ms\n")
            tool.run(f"apply {wire} third.txt --yes {WAIT}")
            tool.check("one that is not there: nothing is written to any", tool.last.status == 1 and
                       "[third] does not respond at node 3" in tool.last.err and
                       "left_max_current=12.5" not in tool.last.out.replace("->", "="), tool.found())
            tool.says("", f"read {wire} zlac8015d left_max_current {WAIT}", "left_max_current=10.0 A")


@scene()
def changed_meanwhile(tool: Tool):
    """Another program writes between the list and the consent."""
    tool.write("machine.txt", LIFT)
    with tool.simulated("yako-closed-loop --node 2"):
        tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
        reads, writes = os.pipe()
        with os.fdopen(reads) as stdin:
            running = tool.start(f"apply drive machine.txt {WAIT}", stdin=stdin)
            until(lambda: "Type apply" in running.err)
            tool.run(f"write drive yako-closed-loop:2 max_current=2000 {WAIT}")
            os.write(writes, b"apply\n")
            os.close(writes)
            ended = tool.ends(running)
        tool.check("nothing is written to it", ended.status == 1 and "has changed since the list" in ended.err, tool.found())
        tool.says("", "read drive yako-closed-loop:2 max_current x0_function", "max_current=2000 mA", "x0_function=home (0x0001)")


@scene()
def interrupted(tool: Tool):
    """The power, the program or the line ends at any register; run again it ends the same, also in the EEPROM."""
    tool.write("machine.txt", LIFT)
    played = {"power": 0, "program": 0, "line": 0, "left unsaved": 0}
    for what in ("power", "program", "line"):
        for written in range(4):
            with tool.simulated("yako-closed-loop --node 2") as drive:
                tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
                running = tool.start(f"apply drive machine.txt --yes {WAIT}")
                seen = until(lambda: running.out.count("lift.") >= 3 + written or running.process.poll() is not None)
                if what == "power":
                    power_cycle(drive)
                elif what == "program":
                    running.send(signal.SIGINT)
                else:
                    tell(drive, signal.SIGUSR1, "unplugged")
                first = tool.ends(running)
                if what == "line":
                    tell(drive, signal.SIGUSR1, "plugged in")
                played[what] += seen and first.status != 0
                played["left unsaved"] += tool.exists("machine.txt.unsaved")
                tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
                tool.run(f"apply drive machine.txt --yes {WAIT}")
                tool.check(f"{what} after {written}: again", tool.last.status == 0, first.err + tool.found())
                power_cycle(drive)
                tool.exits(f"{what} after {written}: it is kept", f"diff drive machine.txt {WAIT}", 0)
                tool.check("and nothing is left unsaved", not tool.exists("machine.txt.unsaved"))
    tool.check("each kind was played, and one left a drive unsaved", all(played.values()), str(played))


@scene()
def written_but_not_saved(tool: Tool):
    """A program that was killed between the last write and the save: the drive holds all, and would lose it."""
    tool.write("machine.txt", LIFT)
    with tool.simulated("yako-closed-loop --node 2") as drive:
        tool.run(f"write drive yako-closed-loop:2 auxiliary_command=release --yes {WAIT}")
        tool.run(f"write drive yako-closed-loop:2 holding_current=60 max_current=3000 x0_function=home positioning_speed=200 {WAIT}")
        tool.exits("the drive holds it", f"diff drive machine.txt {WAIT}", 0)
        tool.write("machine.txt.unsaved", "lift\n")
        tool.run(f"apply drive machine.txt --dry-run {WAIT}")
        tool.err_has("a dry run says so", "[lift] was left unsaved by an apply that did not end")
        tool.run(f"apply drive machine.txt --yes {WAIT}")
        tool.check("it is saved", tool.last.status == 0 and not tool.exists("machine.txt.unsaved"), tool.found())
        power_cycle(drive)
        tool.exits("and kept", f"diff drive machine.txt {WAIT}", 0)


@scene()
def rate_and_address_of_a_servo(tool: Tool):
    """A C630S changes them at once, and is found again. It answers only at its own rate."""
    tool.write("press.txt", "servobus-machine format=1\n[press] device=c630s node=3 baud=38400 character_format=8N1\n"
               "node_address=3\nrs485_baud_rate=38400 Bd\ndata_format=8N1\nspeed_reached_threshold=900\n")
    with tool.simulated("c630s --strict-rate on") as drive:
        tool.fails("it is not there yet", f"apply drive press.txt --yes {WAIT}", 1,
                   "[press] does not respond at node 3, 38400 baud 8N1; --at, --baud and --format say where it is now")
        before = f"--at 1 --baud 57600 --format 8N2 {WAIT}"
        tool.run(f"apply drive press.txt --dry-run {before}")
        tool.check("where it is now", tool.last.status == 0 and "press.node_address 1 -> 3" in tool.last.out, tool.found())
        tool.run(f"apply drive press.txt --yes {before}")
        tool.check("it is set and found again", tool.last.status == 0 and
                   "press.node_address: it responds at node 3, 38400 baud 8N1" in tool.last.out, tool.found())
        tool.exits("there", f"diff drive press.txt {WAIT}", 0)
        tool.run(f"apply drive press.txt --yes {before}")
        tool.check("and with the old place too", tool.last.status == 0 and "nothing to write" in tool.last.err, tool.found())
        power_cycle(drive)
        tool.exits("also after a power cycle", f"diff drive press.txt {WAIT}", 0)


@scene()
def rate_and_address_of_wheels(tool: Tool):
    """A ZLAC8015D changes them at the next power-on, and is said to be where it was until then."""
    tool.write("robot.txt", "servobus-machine format=1\n[wheels] device=zlac8015d node=4 baud=57600\n"
               "node_address=4\nrs485_baud_rate=57600 Bd\nhost_timeout=500 ms\n")
    with tool.simulated("zlac8015d --strict-rate on") as drive:
        before = f"--at 1 --baud 115200 {WAIT}"
        tool.run(f"apply drive robot.txt --yes {before}")
        tool.check("it is set", tool.last.status == 0, tool.found())
        tool.err_has("and stays where it was", "responds at node 1, 115200 baud 8N1 until it is switched off and on; "
                     "then at node 4, 57600 baud 8N1")
        tool.run(f"apply drive robot.txt --yes {before}")
        tool.check("again: nothing to write", tool.last.status == 0 and "nothing to write" in tool.last.err, tool.found())
        tool.fails("it is not where it will be", f"diff drive robot.txt {WAIT}", 1, "does not respond at node 4")
        power_cycle(drive)
        tool.exits("but then", f"diff drive robot.txt {WAIT}", 0)


@scene()
def rate_of_the_command_line(tool: Tool):
    """A file that says no rate is about drives at the rate of the command line, and announces no other."""
    tool.write("robot.txt", "servobus-machine format=1\n[wheels] device=zlac8015d node=1\nhost_timeout=500 ms\n")
    with tool.simulated("zlac8015d --baud 57600 --strict-rate on"):
        tool.run(f"apply drive robot.txt --yes --baud 57600 {WAIT}")
        tool.check("it is applied", tool.last.status == 0, tool.found())
        tool.err_lacks("and stays where it is", "115200")
        tool.exits("there", f"diff drive robot.txt --baud 57600 {WAIT}", 0)


@scene()
def two_at_both_places(tool: Tool):
    tool.write("machine.txt", "servobus-machine format=1\n[lift] device=yako-closed-loop node=2\nnode_address=2\n")
    with tool.simulated("yako-closed-loop --node 1", link="one"), tool.simulated("yako-closed-loop --node 2", link="two"):
        with shared_wire([tool.folder / "one", tool.folder / "two"]) as wire:
            tool.run(f"apply {wire} machine.txt lift --at 1 --yes {WAIT}")
            tool.check("two drives would share an address", tool.last.status == 1 and
                       "two drives respond, at node 1" in tool.last.err and "connect one alone" in tool.last.err, tool.found())


HEAD = "servobus-machine format=1\n[lift] device=yako-closed-loop node=2\n"
WRONG = [
    ("", 1, "the file is empty; it begins with servobus-machine format=1"),
    ("# nothing\n", 1, "the file is empty"),
    ("[lift] device=yako-closed-loop node=2\n", 1, "it is no machine file"),
    ("servobus-machine format=2\n", 1, "format '2' is of a later version of this tool, which reads 1"),
    ("servobus-machine\n", 1, "the first line says format=1"),
    ("servobus-machine format=1\n", 1, "there is no drive"),
    ("servobus-machine format=1\nmax_current=3\n", 2, "is before any drive"),
    ("servobus-machine format=1\n[lift]\n", 2, "device= is missing"),
    ("servobus-machine format=1\n[lift] node=2\n", 2, "device= comes first"),
    ("servobus-machine format=1\n[lift] device=yako-closed-loop\n", 2, "node= is missing"),
    ("servobus-machine format=1\n[lift] device=yako node=2\n", 2, "unknown device 'yako'; did you mean"),
    ("servobus-machine format=1\n[lift] device=none.csv node=2\n", 2, "cannot read none.csv"),
    ("servobus-machine format=1\n[lift] device=zlac8015d node=128\n", 2, "node takes 1 to 127 for a zlac8015d, not '128'"),
    ("servobus-machine format=1\n[lift] device=zlac8015d node=1 node=2\n", 2, "'node' is given twice"),
    ("servobus-machine format=1\n[lift] device=zlac8015d nod=1\n", 2, "unknown word 'nod'; did you mean node?"),
    ("servobus-machine format=1\n[lift] device=zlac8015d node=1 baud=x\n", 2, "baud takes 600 to 4000000, not 'x'"),
    ("servobus-machine format=1\n[lift] device=zlac8015d node=1 character_format=7E1\n", 2, "character_format takes 8N1"),
    ("servobus-machine format=1\n[lift device=zlac8015d node=1\n", 2, "a drive's line begins with its name in brackets"),
    ("servobus-machine format=1\n[a b] device=zlac8015d node=1\n", 2, "a drive's line begins with its name in brackets"),
    (HEAD + "[lift] device=yako-closed-loop node=3\n", 3, "[lift] is there twice, first in line 2"),
    (HEAD + "[other] device=yako-closed-loop node=2\n", 3, "node 2 is that of [lift] in line 2"),
    (HEAD + "[press] device=c630s node=3\n", 3, "it has 57600 baud, 8N2, and [lift] in line 2 has 115200, 8N1"),
    (HEAD + "max_current\n", 3, "'max_current' is no REG=VALUE"),
    (HEAD + "max_curent=3\n", 3, "has no register 'max_curent'; did you mean max_current?"),
    (HEAD + "max_current=3 V\n", 3, "max_current is in mA, not in 'V'"),
    (HEAD + "microstep_resolution=1000 A\n", 3, "microstep_resolution has no unit, not in 'A'"),
    (HEAD + "max_current=99 A\n", 3, "max_current: '99000' is outside 0 mA .. 5600 mA"),
    (HEAD + "max_current=3.00005 A\n", 3, "'3000.05' is no whole number of counts"),
    (HEAD + "x0_function=hoem\n", 3, "did you mean home?"),
    (HEAD + "max_current=3 A\nmax_current=4 A\n", 4, "max_current is there twice, first in line 3"),
    (HEAD + "require max_current=3 A\nmax_current=4 A\n", 4, "max_current is there twice, first in line 3"),
    (HEAD + "motion_command=stop\n", 3, "motion_command is no parameter: it acts as it is written"),
    (HEAD + "target_position=5\n", 3, "target_position is no parameter: it moves the machine"),
    (HEAD + "status_word=0\n", 3, "status_word is read-only; 'require' in front of it compares it"),
    (HEAD + "node_address=3\n", 3, "node_address=3, but the drive's line has node=2, its address on the finished machine"),
    (HEAD + "rs485_baud_rate=9600\n", 3, "'9600' is outside"),
    (HEAD + "rs485_baud_rate=9600 Bd\n", 3, "rs485_baud_rate is 9600 baud, but the drive's line has 115200"),
    (HEAD + "rs485_format=8E1\n", 3, "rs485_format is 8E1, but the drive's line has 8N1"),
    (HEAD + "größe=1\n", 3, "is no ASCII text"),
    ("servobus-machine format=1\n[press] device=c630s node=3\ndi1_function=servo_on\ndi2_function=servo_on\n", 4,
     "di2_function and di1_function in line 3 cannot have the same function"),
    ("servobus-machine format=1\n[press] device=c630s node=3\nhost_timeout=5\n", 3, "has no register"),
]


@scene()
def wrong_files(tool: Tool):
    for text, line, why in WRONG:
        tool.write("machine.txt", text)
        tool.fails(f"{text.splitlines()[-1:]}: {why}", "apply no-such-port machine.txt --yes", 2, f"machine.txt:{line}: ")
        tool.err_has("with the reason", why)
        tool.fails("diff too", "diff no-such-port machine.txt", 2, f"machine.txt:{line}: ")
    tool.write("machine.txt", "\ufeff" + LIFT.replace("\n", "\r\n"))
    tool.fails("CR LF and a byte order mark are accepted", "diff no-such-port machine.txt", 1, "no-such-port")
    tool.fails("no file", "diff no-such-port none.txt", 2, "cannot read none.txt")
    tool.fails("a folder", "apply no-such-port . --yes", 2, "it is a folder")
    tool.fails("words that are missing", "apply no-such-port", 2, "apply takes PORT, a machine FILE")
    tool.fails("of diff too", "diff no-such-port", 2, "diff takes PORT, a machine FILE")
    tool.write("machine.txt", LIFT)
    tool.fails("a node that is none", "diff no-such-port machine.txt --at 300", 2, "--at")
    tool.write("robot.txt", "servobus-machine format=1\n[wheels] device=zlac8015d node=1\nrs485_baud_rate=115200 Bd\n")
    tool.fails("a gateway keeps its rate", "apply tcp://127.0.0.1:1 robot.txt --yes", 2,
               "robot.txt:3: rs485_baud_rate cannot be set through a gateway")


@scene()
def device_of_a_file(tool: Tool):
    os.mkdir(tool.folder / "machines")
    tool.write("machines/meter.csv", "address,name,type,access,min,max,unit,scale,flags\n1,ratio,u16,rw,1,1000,times,0.01,\n"
               "2,span,i32,rw,-5,5,,,\n8,clear,u16,rw,,,,,trigger\n")
    tool.write("machines/plant.txt", "servobus-machine format=1\n[meter] device=meter.csv node=7\nratio=2.5 times\nspan=-3\n")
    with tool.simulated("machines/meter.csv --node 7"):
        tool.run(f"apply drive machines/plant.txt --yes {WAIT}")
        tool.check("beside its machine file", tool.last.status == 0 and "meter.ratio=2.50 times" in tool.last.out, tool.found())
        tool.exits("and so", f"diff drive machines/plant.txt {WAIT}", 0)
        tool.check("it has no save", not tool.exists("machines/plant.txt.unsaved"))
    tool.write("machines/meter.csv", "address,name,access,flags\n1,ratio,rw,\n3,speed,rw,motion\n")
    tool.write("machines/plant.txt", "servobus-machine format=1\n[meter] device=meter.csv node=7\nratio=25\n")
    tool.fails("one that moves is refused", "apply no-such-port machines/plant.txt --yes", 2, "apply is refused, since speed moves")


@scene()
def turns(tool: Tool):
    with tool.simulated("zlac8015d"):
        tool.run(f"turn drive zlac8015d {WAIT}", stdin="\n")
        tool.check("nobody has turned it", tool.last.status == 1 and "no position has changed" in tool.last.err, tool.found())
        tool.run(f"turn drive zlac8015d {WAIT}")
        tool.check("nor pressed Enter", tool.last.status == 1 and "nobody has pressed Enter" in tool.last.err)
        tool.run(f"write drive zlac8015d mode_of_operation=velocity control_word=enable --yes {WAIT}")
        tool.run(f"turn drive zlac8015d {WAIT}", stdin="\n")
        tool.check("enabled", tool.last.status == 1 and "refused: a shaft is held" in tool.last.err, tool.found())
    tool.write("wheels.csv", WHEELS)
    with tool.simulated("wheels.csv"), shared_wire([tool.folder / "drive"], 2) as (wire, hand):
        def turned(left: int, right: int, turns: str = ""):
            tool.run(f"write {hand} wheels.csv left=-1000 right=2147483000 --yes {WAIT}")
            reads, writes = os.pipe()
            with os.fdopen(reads) as stdin:
                running = tool.start(f"turn {wire} zlac8015d {turns} {WAIT}", stdin=stdin)
                until(lambda: "press Enter" in running.err)
                tool.run(f"write {hand} wheels.csv left={left} right={right} --yes {WAIT}")
                os.write(writes, b"\n")
                os.close(writes)
                return tool.ends(running)

        turned(-1000 + 40960, 2147483000 - 163830)
        tool.out_is("ten turns of both wheels", "left: 40960 counts, 4096 a turn, forward is positive; 4 x left_encoder_lines is 4096",
                    "right: -163830 counts, 16383 a turn, forward is negative; 4 x right_encoder_lines is 16384")
        tool.status_is("as the settings say", 0)
        ended = turned(-1000 + 4096 * 3, -2147483648 + 100, "--turns 3")
        tool.check("one that is not", ended.status == 1 and ended.out.splitlines()[-1] ==
                   "right: 748 counts, 249 a turn, forward is positive; 4 x right_encoder_lines is 16384, which is not so",
                   tool.found())
        tool.err_has("with a way out", "a turn too many or too few?")
        ended = turned(-1000 + 4096 * 2, 2147483000, "--turns 2")
        tool.check("one wheel alone", ended.status == 0 and len(ended.out.splitlines()) == 1, tool.found())
    tool.fails("no encoder", "turn no-such-port yako-open-loop", 2, "does not count what is turned by hand")
    tool.fails("raw", "turn no-such-port raw:3", 2, "does not count what is turned by hand")
    tool.fails("no turns", "turn no-such-port zlac8015d --turns 0", 2, "--turns")


play_tool()
