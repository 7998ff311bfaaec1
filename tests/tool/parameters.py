# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""backup and restore, a round trip on each drive."""
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from backup_file import other_values, with_checksum
from programs import Tool, play_tool, scene, until

NO_RESPONSE = "--timeout 20 --retries 0"


def backup(tool: Tool, device: str, options: str = "") -> str:
    """What the drive has now."""
    return tool.start(f"backup drive {device} {options}").wait().out


def changes_shown(tool: Tool) -> int:
    return sum(" -> " in line for line in tool.last.lines)


def round_trip(tool: Tool, device: str, rows: int, wear: str, *changes: str):
    """Saves into the file `saved`, changes, shows and restores. `wear`: the reported cost in EEPROM writes."""
    tool.exits(f"{device}: backup", f"backup drive {device} saved", 0)
    tool.err_has(f"{device}: backup shows how far it is", f"reading: {rows} of {rows}")
    saved = tool.lines("saved")
    found = [line for line in saved if re.match(r"[a-z0-9_]*=[-0-9?]* #", line)]
    tool.check(f"{device}: {rows} rows", len(found) == rows, len(found))
    tool.is_equal(f"{device}: the header says so", saved[0], f"servobus-backup format=1 device={device} rows={rows}")
    tool.check(f"{device}: no draft is left", not list(tool.folder.glob("*.part*")))
    tool.exits(f"{device}: changes", f"write drive {device} {' '.join(changes)}", 0)
    changed = backup(tool, device)
    differing = [line for line, before in zip(changed.splitlines(), saved, strict=True) if line != before]
    tool.check(f"{device}: {len(changes)} rows differ, and the checksum", len(differing) == len(changes) + 1, differing)
    tool.run(f"restore drive {device} saved --dry-run")
    tool.check(f"{device}: --dry-run shows them", changes_shown(tool) == len(changes))
    tool.check(f"{device}: and changes nothing", backup(tool, device) == changed)
    tool.exits(f"{device}: restore", f"restore drive {device} saved --yes", 0)
    tool.err_has(f"{device}: restore says what it costs", f"writes into the EEPROM: {wear}")
    tool.check(f"{device}: restore lists what it wrote", len(tool.last.lines) == len(changes))
    tool.check(f"{device}: the drive is as it was", backup(tool, device) == tool.read("saved"))
    tool.run(f"restore drive {device} saved --yes")
    tool.err_has(f"{device}: again there is nothing to do", "0 of ")
    tool.out_is(f"{device}: and nothing is written")


def refused_at_work(tool: Tool, device: str, name: str, text: str):
    """The drive is enabled, and the file `saved` differs from it."""
    before = backup(tool, device)
    tool.fails(name, f"restore drive {device} saved", 1, text)
    tool.check("S7: and nothing is written", backup(tool, device) == before)
    tool.exits("but --dry-run looks", f"restore drive {device} saved --dry-run", 0)
    tool.err_has("and says that it would be refused", "without --dry-run it is refused")


# The scenes that take longest are the first


@scene()
def bad_line(tool: Tool):
    """A write without a response ends the run, and the next run continues from there."""
    with tool.simulated("zlac8015d --faults lossy,noisy,doubled --seed 3"):
        before = backup(tool, "zlac8015d", "--retries 9 --timeout 50")
        tool.write("other", with_checksum(tool, "zlac8015d", other_values(tool, "zlac8015d", before)))
        restore = "restore drive zlac8015d other --retries 9 --timeout 50"
        lost = []
        while tool.run(f"{restore} --yes").status != 0 and len(lost) < 40:
            lost.append(tool.last.err)
        tool.status_is("a bad line: done at last", 0)
        tool.check("not in one run", lost)
        uncertain = r": unknown, .*; [0-9]* of [0-9]* written, perhaps [a-z_0-9]*"
        tool.check("and said what is uncertain", any(re.search(uncertain, err) for err in lost), "\n".join(lost))
        tool.run(f"{restore} --dry-run")
        tool.out_is("and as it should be")


# C630S


@scene()
def c630s(tool: Tool):
    with tool.simulated("c630s"):
        changes = "jog_speed=50", "gear_1_numerator=70000", "do1_function=warning"
        round_trip(tool, "c630s", 394, "3", *changes)
        tool.check("c630s: and nothing more", "servobus: writes into the EEPROM: 0" in tool.last.err_lines)
        tool.run("write drive c630s jog_speed=50 eeprom_update=off")
        tool.run("restore drive c630s saved --dry-run")
        tool.err_has("c630s: none while P0C-13 is 0", "writes into the EEPROM: none, since eeprom_update (0x0C0D) is 0")


@scene()
def c630s_functions_of_terminals(tool: Tool):
    write = "write drive c630s"
    with tool.simulated("c630s"):
        saved = backup(tool, "c630s")
        tool.write("saved", saved)
        tool.run(f"{write} jog_speed=50 eeprom_update=off")
        tool.fails("6.4.1: c630s: a function that another terminal has is not written",
                   f"{write} jog_speed=60 virtual_input_1_function=servo_on --yes", 1,
                   "di1_function (0x0302) has the function that virtual_input_1_function (0x1700) is to get")
        tool.says("c630s: nor anything else of that command", "read drive c630s jog_speed", "jog_speed=50 r/min")
        tool.fails("c630s: nor by its address", f"{write} 0x0302=31 --yes", 1,
                   "refused, nothing was written: di7_function (0x030E) has")
        tool.says("c630s: it is once the other one has lost it",
                  f"{write} di7_function=none di4_function=home_switch di4_function=home_switch",
                  "di7_function=none (0x0000)", "di4_function=home_switch (0x001F)",
                  "di4_function=home_switch (0x001F)")
        # DI4 and DI7 as before: DI4 first loses the function that DI7 gets.
        tool.exits("c630s: a restore moves functions between terminals", "restore drive c630s saved --yes", 0)
        tool.is_equal(
            "c630s: the one loses it before the other gets it",
            [line for line in tool.last.lines if "_function" in line],
            [
                "di4_function=none (0x0000)",
                "di4_function=alarm_reset (0x0002)",
                "di7_function=home_switch (0x001F)",
            ],
        )
        twice = re.sub("^di1_function=.*", "di1_function=31 #", saved, flags=re.M)
        tool.write("twice", with_checksum(tool, "c630s", twice))
        tool.run("restore drive c630s twice --yes")
        tool.status_is("c630s: a file that gives two terminals one function is refused", 1)
        tool.err_has("c630s: and says which",
                     "refused, nothing was written: di7_function (0x030E) has the function that di1_function (0x0302)")


@scene()
def c630s_enabled(tool: Tool):
    write = "write drive c630s"
    with tool.simulated("c630s"):
        tool.write("saved", backup(tool, "c630s"))
        tool.run(
            f"{write} di1_function=none eeprom_update=on virtual_inputs_enable=on virtual_input_1_function=servo_on"
            " virtual_input_levels=1 --yes"
        )
        refused_at_work(tool, "c630s", "S7: c630s: refused while enabled", "virtual input 1 enables the servo")
        tool.run(f"{write} virtual_input_levels=0")
        tool.write("wired", backup(tool, "c630s"))
        tool.run(f"{write} virtual_input_1_function=none virtual_input_levels=1 --yes")
        tool.exits("S7: c630s: a terminal that enables it ends a restore", "restore drive c630s wired --yes", 1)
        tool.err_has("and it says after which register",
                     "stopped after virtual_input_1_function: virtual input 1 enables the servo")
        tool.run(f"{write} virtual_input_levels=0")
        for name, words, text in [
            ("S7: c630s: refused where a virtual input enables it at power-on",
             "virtual_input_1_function=servo_on virtual_inputs_at_power_on=1",
             "virtual input 1 enables the servo at power-on"),
            ("S7: c630s: refused where P03-00 enables it", "virtual_inputs_at_power_on=0 power_on_functions_1_to_16=1",
             "power_on_functions_1_to_16 enables the servo"),
        ]:
            tool.run(f"{write} {words} --yes")
            refused_at_work(tool, "c630s", name, text)
        tool.run(f"{write} virtual_input_1_function=none power_on_functions_1_to_16=0 --yes")
        tool.fails("c630s: it has no command to save", "restore drive c630s saved --save", 2,
                   "--save: c630s has no command to save")


# ZLAC8015D


@scene()
def zlac8015d(tool: Tool):
    device = "zlac8015d"
    write, restore = "write drive zlac8015d", "restore drive zlac8015d saved"
    with tool.simulated(device):
        round_trip(tool, device, 88, "none; --save", "left_max_current=12.5", "right_speed_kp=77", "input_polarity=x1")
        tool.run(f"{write} left_max_current=12.5 node_address=5")
        tool.run(f"{restore} --yes --save")
        tool.err_has("zlac8015d: --save saves once", "none, but one save at the end")
        tool.says("S7: the line's settings stay", "read drive zlac8015d node_address left_max_current",
                  "node_address=5", "left_max_current=30.0 A")
        tool.run(f"{write} node_address=1 left_max_current=5 mode_of_operation=velocity control_word=enable --yes")
        refused_at_work(tool, device, "S7: zlac8015d: refused while enabled", "a shaft is held, the drive is enabled")
        tool.run(f"{write} left_target_speed=20 --yes")
        until(lambda: "20.0 r/min" in tool.run("read drive zlac8015d left_actual_speed").out)
        tool.fails("S7: zlac8015d: refused while it turns", f"{restore} --yes", 1, "a wheel turns")
        tool.run(f"{write} left_target_speed=0 control_word=stop")
        released = "left_released+right_released (0x0000)"
        tool.check(
            "zlac8015d: at rest again", until(lambda: released in tool.run("read drive zlac8015d status_word").out)
        )
        tool.run(f"{write} mode_of_operation=torque --yes")
        tool.fails("S7: zlac8015d: refused in torque mode, where the status may not tell that it is enabled",
                   f"{restore} --yes", 1, "in torque mode")
        tool.run(f"{write} mode_of_operation=velocity --yes")
        tool.exits("zlac8015d: a save clears the mode first, which would be kept perhaps", f"{restore} --yes --save", 0)
        tool.says("and it is cleared", "read drive zlac8015d mode_of_operation", "mode_of_operation=undefined (0x0000)")
        tool.run(f"{write} mode_of_operation=undefined left_max_current=5")
        tool.run(f"{restore} --yes")
        tool.out_is("zlac8015d: and restored", "left_max_current=30.0 A")
        for name, words, text in [
            ("zlac8015d: no response", f"restore drive zlac8015d:7 saved {NO_RESPONSE}",
             "the drive's state: no response; nothing was written"),
            ("a backup of a node that does not respond", f"backup drive zlac8015d:7 none {NO_RESPONSE}", "no response"),
        ]:
            tool.fails(name, words, 1, text)
        tool.check("makes no file", not tool.exists("none"))
        tool.exits("a backup into nowhere is status 1", "backup drive zlac8015d none/file", 1)
        tool.err_has("and says so", "cannot write none/file: No such file")


@scene()
def no_watchdog(tool: Tool):
    write, read, restore = "write drive zlac8015d", "read drive zlac8015d", "restore drive zlac8015d zero"
    with tool.simulated("zlac8015d"):
        for name, words, text in [
            ("S3: a watchdog time of 0 is not written", f"{write} host_timeout=0 --yes",
             'host_timeout: what 0 does is not documented; only "write PORT raw'),
            ("S3: nor by its address", f"{write} 0x2000=0x0 --yes", "what 0 does is not documented"),
        ]:
            tool.fails(name, words, 2, text)
        tool.exits("S3: but as a raw address, by name", "write drive raw 0x2000=0 --yes --baud 115200", 0)
        tool.says("S3: it is shown", f"{read} host_timeout", "host_timeout=0 ms")
        tool.run("backup drive zlac8015d zero")
        is_there = any(line.startswith("host_timeout=0 # 0 ms") for line in tool.lines("zero"))
        tool.check("S3: and backed up", is_there)
        tool.err_has("with no register left out", "reading: 88 of 88")
        tool.exits("S3: a restore has nothing to do there", f"{restore} --yes", 0)
        tool.run(f"{write} host_timeout=500")
        tool.exits("S3: a restore of 0 is refused", f"{restore} --yes", 1)
        tool.err_has("and says why", "refused, nothing was written: host_timeout: what 0 does")
        tool.run(f"{restore} --dry-run")
        tool.err_has("S3: and --dry-run says so", "without --dry-run it is refused: host_timeout")
        tool.says("S3: and nothing was written", f"{read} host_timeout", "host_timeout=500 ms")


@scene()
def interrupted(tool: Tool):
    """At a rate slow enough for it. The file differs in every register that may be changed."""
    with tool.simulated("zlac8015d --baud 9600"):
        before = backup(tool, "zlac8015d", "--baud 9600")
        tool.write("before", before)
        tool.write("other", with_checksum(tool, "zlac8015d", other_values(tool, "zlac8015d", before)))
        restorer = tool.start("restore drive zlac8015d other --baud 9600 --yes")
        tool.check("a restore is under way", until(lambda: restorer.out), restorer.err)
        tool.ends(restorer, signal.SIGINT)
        tool.status_is("an interrupted restore is status 1", 1)
        written = re.search(r"interrupted; ([0-9]*) of [0-9]* written, not: ", tool.last.err)
        tool.check("and says where it stopped", written)
        tool.is_equal("as many as it has listed", len(tool.last.lines), int(written[1]))
        tool.run("restore drive zlac8015d before --baud 9600 --dry-run")
        tool.is_equal("and as the drive has", len(tool.last.lines), int(written[1]))


# YAKOTEC steppers


@scene(("yako-closed-loop", 191), ("yako-open-loop", 195))
def stepper(tool: Tool, device: str, rows: int):
    with tool.simulated(device):
        tool.run(f"write drive {device} auxiliary_command=release --yes")
        changes = "acceleration_time=250", "home_offset=-70000", "position_segment_3_speed=99"
        round_trip(tool, device, rows, "none; --save", *changes)
        tool.run(f"write drive {device} auxiliary_command=enable acceleration_time=250 --yes")
        refused_at_work(tool, device, f"S7: {device}: refused while enabled", "the motor is enabled")
        tool.fails(f"{device}: --part is the C630S's", f"restore drive {device} saved --part", 2, "--part")


play_tool()
