# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The names that a complaint suggests. Those expected are by hand: what a person would say is meant."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene

YAKO = "yako-closed-loop"


@scene()
def complaints(tool: Tool):
    """Each is this line and no other, with status 2 and no output."""

    def complains(line: str, *words: str):
        line = f"servobus: {line}"
        ended = tool.run(list(words))
        tool.check(line, ended.status == 2 and ended.err == line + "\n" and ended.out == "")

    names = tool.run(["write", "p", "yako-open-loop", "homing_method=up"]).err.partition("none of ")[2].strip()
    for line, *words in [
        ("unknown command 'raed'; did you mean read?", "raed"),
        ("unknown command 'watsh'; did you mean watch?", "watsh"),
        ("unknown command 'MAP'; did you mean map?", "MAP"),
        ("unknown command 'back'; did you mean backup?", "back"),
        ("unknown command 'fly'; see servobus --help", "fly"),
        ("unknown command ''; see servobus --help", ""),
        ("unknown command '_'; see servobus --help", "_"),
        ("unknown option '--jsno'; did you mean --json?", "read", "--jsno"),
        ("unknown option '--dryrun'; did you mean --dry-run?", "restore", "--dryrun"),
        ("unknown option '--node'; did you mean --nodes?", "scan", "--node=3"),
        ("unknown option '-yes'; did you mean --yes?", "write", "-yes"),
        ("unknown option '--colour'; see servobus map --help", "map", "--colour"),
        ("unknown device 'zlac8015'; did you mean zlac8015d?", "map", "zlac8015"),
        ("unknown device 'c360s'; did you mean c630s?", "map", "c360s"),
        ("unknown device 'yako'; did you mean yako-open-loop or yako-closed-loop?", "map", "yako"),
        ("unknown device 'yako_closed_loop'; did you mean yako-closed-loop?", "read", "p", "yako_closed_loop:1", "x"),
        ("unknown device 'servo'; known: c630s, yako-closed-loop, yako-open-loop, zlac8015d", "map", "servo"),
        ("c630s has no register 'jog_sped'; did you mean jog_speed?", "write", "p", "c630s", "jog_sped=5"),
        ("control_word: 'quikstop' is none of its names; did you mean quick_stop?",
         *("write", "p", "zlac8015d", "control_word=quikstop")),
        ("input_polarity: 'x0+x11' is none of its names; did you mean x1?",
         *("write", "p", YAKO, "input_polarity=x0+x11")),
        (f"homing_method: 'up' is none of {names}", "write", "p", "yako-open-loop", "homing_method=up"),
    ]:
        complains(line, *words)
    tool.err_has("and its names follow", "negative_limit")

    for register, words in [
        ("bus_volt", "; did you mean bus_voltage?"),
        ("bus_votlage", "; did you mean bus_voltage?"),
        ("Bus-Voltage", "; did you mean bus_voltage?"),
        ("left_max_curren", "; did you mean left_max_current?"),
        ("lef_max_curent", "; did you mean left_max_current?"),
        ("max_current", "; did you mean left_max_current or right_max_current?"),
        ("left_speed", "; did you mean left_max_speed, left_start_speed or left_target_speed?"),
        ("actual_speed", "; did you mean left_actual_speed or right_actual_speed?"),
        ("torque_actual", "; did you mean left_actual_torque or right_actual_torque?"),
        ("voltmeter", "; servobus map zlac8015d lists them"),
        ("0x3000", "; servobus map zlac8015d lists them"),
        ("", "; servobus map zlac8015d lists them"),
        ("0" * 200, "; servobus map zlac8015d lists them"),
    ]:
        complains(f"zlac8015d has no register '{register}'{words}", "read", "p", "zlac8015d", register)


play_tool()
