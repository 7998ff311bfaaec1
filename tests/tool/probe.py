# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The probe of a drive on a line, and simulators that behave as it has found: the same comes out as went in."""
import os
import re
import select
import signal
import sys
import threading
import time
import tty
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene, until
from tapped_line import open_terminal

# PROBED in the environment: the drives, `zlac8015d` if it is not given, since each takes half a minute.

WAIT = "--timeout 2000"
ZLAC = """servobus-findings format=1 device=zlac8015d
resumes_after_watchdog=no
save=all
host_timeout=off
while_turning=released
in_torque_mode=locked
after_quick_stop=locked
bit=driven
code=until_restart
by_fault=its_wheel
code_1=engages
idle_shaft=emergency
shows_speed_of_moves=no
position_start=by_200F
enables_without_mode=yes
speed_ramp=begins_anew
checks_option_codes=no
rescales_immediately=yes
"""
YAKO = """servobus-findings format=1 device=yako-closed-loop
is_enabled_at_power_on=no
answers_bad_crc=yes
kept=line_settings
restart_keeps_place=yes
in_position=at_target
homed=until_place_lost
refuses_unfit=yes
commands_read_back=yes
interrupts_from_target=yes
"""

C630S = """servobus-findings format=1 device=c630s
stores_eeprom_off=no
resets_while_enabled=yes
echoes_byte_count=yes
restart_keeps=everything
software_reset_is_power_on=no
brake=always_released
bus_stop=frees_shaft
commands_end=no
segment_start_is_level=yes
jog_follows_command=yes
delay_is_additional=yes
first_output_shows=yes
gear_keeps_rest=yes
"""
SWITCHES = {"zlac8015d": ZLAC, "yako-closed-loop": YAKO, "c630s": C630S}


def ways(text: str) -> dict[str, str]:
    lines = [line.split("#")[0].strip() for line in text.splitlines()[1:]]
    return dict(line.split("=") for line in lines if line)


def probed(tool: Tool, drive, device: str, consent: str = "move", power: bool = True) -> dict[str, str]:
    """A person who answers what is asked: types what is wanted, and switches the drive off and on."""
    reads, writes = os.pipe()
    with os.fdopen(reads) as stdin:
        running = tool.start(f"probe drive {device} found.txt {WAIT}", stdin=stdin)
        answered = 0
        while running.process.poll() is None:
            until(lambda: running.process.poll() is not None or running.err.count(": ") > answered and
                  running.err.endswith((": ", "] ")))
            asked = running.err
            if running.process.poll() is not None or not asked.endswith((": ", "] ")):
                continue
            answer = "?"
            if asked.endswith("leave it out: "):
                answer = consent
            elif asked.endswith("leaves it out): "):
                if power:
                    before = drive.err.count("switched off and on")
                    drive.send(signal.SIGUSR2)
                    until(lambda: drive.err.count("switched off and on") > before)
                answer = "on" if power else "no"
            answered = asked.count(": ")
            os.write(writes, (answer + "\n").encode())
            until(lambda: running.err != asked or running.process.poll() is not None)
        os.close(writes)
        tool.ends(running)
    return ways(tool.read("found.txt"))


@scene(*os.environ.get("PROBED", "zlac8015d").split())
def comes_back(tool: Tool, device: str):
    tool.write("switches.txt", SWITCHES[device])
    with tool.simulated(f"{device} --switches switches.txt") as drive:
        if device.startswith("yako"):
            tool.run(f"write drive {device} auxiliary_command=release --yes")
        found = probed(tool, drive, device)
        tool.status_is(f"{device}: it ends well", 0)
        wanted = ways(SWITCHES[device])
        open_ones = {"code_1"}  # nobody sees a brake here
        wrong = {name: found.get(name) for name, way in wanted.items() if name not in open_ones and found.get(name) != way}
        tool.check(f"{device}: what went in comes out", not wrong, str(wrong) + tool.found())
        tool.check(f"{device}: with the version, and no place", found["firmware"].isdigit() and "drive" not in
                   tool.read("found.txt").replace(device, "").replace("drive_", "").split("\n", 2)[0])
        tool.run(f"probe drive {device} again.txt {WAIT}", stdin="")
        tool.check(f"{device}: and it is at rest", "refused" not in tool.last.err and tool.exists("again.txt"))
    with tool.simulated(f"{device} --switches found.txt", named=f"{device}: a simulator behaves so"):
        pass


@scene()
def without_consent(tool: Tool):
    with tool.simulated("zlac8015d") as drive:
        found = probed(tool, drive, "zlac8015d", consent="no", power=False)
        tool.status_is("without consent it ends well too", 0)
        settled = {name for name, way in found.items() if way != "?"} - {"firmware"}
        tool.is_equal("and settles what needs no motion", settled, {"code", "checks_option_codes"})
        tool.says("nothing was enabled", f"read drive zlac8015d control_word mode_of_operation {WAIT}",
                  "control_word=stop (0x0007)", "mode_of_operation=undefined (0x0000)")


@scene(*os.environ.get("PROBED", "zlac8015d").split())
def interrupted(tool: Tool, device: str):
    """Ctrl-C at a question, and while the motor is held or turns: it stands, without an alarm, and the drive has its words."""
    status = {"zlac8015d": "status_word", "c630s": "servo_status"}.get(device, "pair_word_order")  # a stepper's says where it has been
    with tool.simulated(device):
        if device.startswith("yako"):
            tool.run(f"write drive {device} auxiliary_command=release --yes {WAIT}")
        tool.run(f"backup drive {device} before.txt {WAIT}")
        tool.run(f"read drive {device} {status} {WAIT}")
        at_rest = tool.last.out
        for seconds in (0, 0.2, 3):
            reads, writes = os.pipe()
            with os.fdopen(reads) as stdin:
                running = tool.start(f"probe drive {device} found.txt {WAIT}", stdin=stdin)
                until(lambda: running.err.endswith((": ", "] ")))
                while seconds and running.process.poll() is None and "free to turn" not in running.err:
                    asked = running.err
                    os.write(writes, b"move\n" if asked.endswith("leave it out: ") else b"?\n")
                    until(lambda: running.err != asked and running.err.endswith((": ", "] ")))
                if seconds:
                    os.write(writes, b"move\n")
                time.sleep(seconds)  # somewhere in a step
                running.send(signal.SIGINT)
                os.close(writes)
                tool.ends(running)
            tool.check(f"{device}, after {seconds} s: it says so", tool.last.status == 1 and "ended early: interrupted" in
                       tool.last.err, tool.found())
            tool.check(f"{device}, after {seconds} s: and keeps its findings", tool.exists("found.txt"))
            tool.run(f"backup drive {device} after.txt {WAIT}")
            tool.is_equal(f"{device}, after {seconds} s: the drive has its words", tool.read("after.txt"), tool.read("before.txt"))
            tool.says(f"{device}, after {seconds} s: and its state", f"read drive {device} {status} {WAIT}", *at_rest.splitlines())
            tool.run(f"restore drive {device} before.txt --dry-run {WAIT}")
            tool.check(f"{device}, after {seconds} s: and is at rest", tool.last.status == 0, tool.found())


class DyingLine:
    """A line between a client and a drive that goes dead at a request, and comes back when it is told to."""

    def __init__(self, client: Path, drive: Path):
        self.client, self.keeper = open_terminal(client)
        self.drive = os.open(drive, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.drive)
        self.left = -1  # requests until it is dead; below 0: any
        self.died = 0.0
        threading.Thread(target=self.relay, daemon=True).start()

    def relay(self):
        while True:
            for one in select.select([self.client, self.drive], [], [])[0]:
                data = os.read(one, 4096)
                if not data:  # the simulated drive has ended
                    return
                if one == self.client and self.left >= 0:
                    self.left -= self.left > 0
                    if self.left == 0 and not self.died:
                        self.died = time.monotonic()
                if self.left:
                    os.write(self.drive if one == self.client else self.client, data)


def begun(tool: Tool, device: str) -> tuple:
    """A probe that has been allowed to move the motor, and what its answers are written to."""
    reads, writes = os.pipe()
    with os.fdopen(reads) as stdin:
        running = tool.start(f"probe client {device} found.txt --timeout 500", stdin=stdin)
    while running.process.poll() is None:
        until(lambda: running.process.poll() is not None or running.err.endswith((": ", "] ")))
        asked = running.err
        os.write(writes, b"move\n" if asked.endswith("leave it out: ") else b"?\n")
        if "free to turn" in asked:
            break
        until(lambda: running.err != asked)
    return running, writes


@scene(*os.environ.get("PROBED", "zlac8015d").split())
def dead_line(tool: Tool, device: str):
    """It ends 20 s after the line went dead, and names what the drive keeps and the commands that undo it."""
    with tool.simulated(device) as drive:
        line = DyingLine(tool.folder / "client", tool.folder / "drive")
        if device.startswith("yako"):
            tool.run(f"write client {device} auxiliary_command=release --yes")
        tool.run(f"backup client {device} before.txt")
        running, writes = begun(tool, device)
        if device == "c630s":  # S-ON becomes a virtual input at a power cycle
            until(lambda: running.err.endswith("leaves it out): "))
            drive.send(signal.SIGUSR2)
            until(lambda: "switched off and on" in drive.err)
            os.write(writes, b"on\n")
        line.left = 40
        until(lambda: line.died)
        tool.ends(running)
        took = time.monotonic() - line.died
        os.close(writes)
        tool.check(f"{device}: it ends after 20 s", took < 21, took)
        tool.status_is(f"{device}: with status 1", 1)
        tool.err_has(f"{device}: it says why", "ended early: ")
        said = tool.last.err_lines
        count = [int(line.split()[0]) for line in said if line.endswith("not put back:")]
        named = [line for line in said if re.fullmatch(r"  \w+: .+ before, .+ now", line)]
        tool.check(f"{device}: each register has its old word and its present one", count == [len(named)] and named, tool.found())
        commands = [line.partition("servobus ")[2] for line in said if "servobus write client" in line]
        tool.check(f"{device}: a stop, and what puts them back", len(commands) == 2 and "stop it first" in tool.last.err,
                   tool.found())
        line.left = -1
        for command in commands:
            tool.exits(f"{device}: {command}", f"{command} --yes", 0)
        tool.run(f"backup client {device} after.txt")
        tool.is_equal(f"{device}: and the drive has its words", tool.read("after.txt"), tool.read("before.txt"))


@scene()
def refused(tool: Tool):
    with tool.simulated("yako-closed-loop"):
        tool.fails("a motor that is enabled", f"probe drive yako-closed-loop found.txt {WAIT}", 1, "refused: the motor is enabled")
        tool.check("and no file is made", not tool.exists("found.txt"))
    tool.fails("a device of which nothing is known", "probe no-such-port raw:1 found.txt", 2, "nothing is known to probe")
    tool.fails("words that are missing", "probe no-such-port zlac8015d", 2, "probe takes PORT DEVICE[:NODE] FILE")
    head = "servobus-findings format=1 device=zlac8015d\n"
    for text, line, why in [
        ("", 1, "it is no file of findings"),
        ("save=all\n", 1, "it is no file of findings"),
        ("servobus-findings format=2 device=zlac8015d\n", 1, "it has format '2', not 1"),
        ("servobus-findings format=1 device=c630s\n", 1, "it is not of a zlac8015d: '1 device=c630s'"),
        (head + "saves=all\n", 2, "unknown name 'saves'; did you mean save?"),
        (head + "save=some\n", 2, "save takes marked, all or ?, not 'some'"),
        (head + "save=all\n\nsave=?\n", 4, "save is there twice"),
        (head + "save\n", 2, "'save' is no name=value"),
    ]:
        tool.write("switches.txt", text)
        tool.fails(f"switches: {why}", "sim zlac8015d --switches switches.txt", 2, f"switches.txt:{line}: {why}")
    tool.fails("no file", "sim zlac8015d --switches none.txt", 2, "cannot read none.txt")
    tool.write("meter.csv", "address,name\n1,a\n")
    tool.fails("a device without switches", "sim meter.csv --switches switches.txt", 2, "meter.csv has no switches")


play_tool()
