# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The codes and bits of every writable register: `map` shows them, and a write that is refused for a value names them.

The two are compared with each other, and some with the manuals by hand.
"""
import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene

# How many writable registers of a device have codes or bits.
HAVE_CODES = {"zlac8015d": 27, "yako-closed-loop": 39, "yako-open-loop": 41, "c630s": 184}


def shown(tool: Tool, device: str, register: str) -> list[str]:
    """What `map` has in the lines of the values: `5 deceleration`, as a complaint has it."""
    lines = tool.run(["map", device, register]).lines
    first = next((i for i, line in enumerate(lines) if line.startswith("values ")), len(lines))
    codes = [line.removeprefix("values").strip().partition(": ") for line in lines[first:]]
    return [f"{code} {name.replace(' ', '_')}" for code, _, name in codes]


@scene()
def writes(tool: Tool):
    """A value beyond the range, and a name that is none, of each register that has codes."""
    for device, expected in HAVE_CODES.items():
        rows = list(csv.DictReader(tool.run(["map", device]).lines))
        have_codes = 0
        for row in rows:
            codes = shown(tool, device, row["name"])
            if row["access"] == "ro" or not codes:
                continue
            have_codes += 1
            all_codes = ", ".join(codes)
            name = f"{device} {row['name']}: "
            ended = tool.run(["write", "nowhere", device, f"{row['name']}=qqqqqqqqqqqq"])
            tool.check(name + "a wrong name", ended.status == 2 and ended.err == f"servobus: {row['name']}: "
                       f"'qqqqqqqqqqqq' is none of {all_codes}\n")
            beyond = int(row["max"] or 0xFFFF) + 1
            if beyond > 0xFFFF:
                continue  # every content is in range
            ended = tool.run(["write", "nowhere", device, f"{row['name']}={beyond}"])
            tool.check(name + "beyond the range", ended.status == 2 and ended.err == f"servobus: {row['name']}: "
                       f"'{beyond}' is outside {row['min']} .. {row['max']}; it takes {all_codes}\n")
        tool.check(f"{device}: {have_codes} registers have codes", have_codes == expected)


@scene()
def by_hand(tool: Tool):
    for words, text in [
        ("zlac8015d 0x2011=9", "outside 5 .. 7; it takes 5 deceleration, 6 fast_deceleration, 7 immediate"),
        ("zlac8015d 0x2002=7", "it takes 1 128000_Bd, 2 115200_Bd, 3 57600_Bd, 4 38400_Bd, 5 19200_Bd, 6 9600_Bd"),
        ("zlac8015d 0x2016=4", "outside 0 .. 3; it takes bit 0 x0, bit 1 x1"),
        ("yako-closed-loop 0x0018=2", "it takes 0 disabled, 1 after_homing"),
        ("yako-open-loop 0x0014=fast", "is none of 0 115200_Bd, 1 38400_Bd, 2 19200_Bd, 3 9600_Bd"),
        ("c630s P02-31=3", "outside 0 .. 2; it takes 0 none, 1 factory_defaults, 2 clear_fault_records"),
        ("c630s P11-00=4", "it takes 0 single, 1 cyclic, 2 by_input, 3 sequential"),
    ]:
        tool.fails(f"{words}: its codes by number and name", f"write nowhere {words}", 2, text)
    # A register without codes has its range alone.
    ended = tool.run("write nowhere c630s P06-03=6001")
    tool.check("a speed has no codes", ended.err.endswith("is outside -6000 r/min .. 6000 r/min\n"))


play_tool()
