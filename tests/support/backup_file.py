# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Files of `servobus backup`, changed as a test needs them."""
import csv
import io
import re

from programs import Tool


def with_checksum(tool: Tool, device: str, text: str) -> str:
    """Corrects the checksum: restore prints the right one before it opens its port."""
    tool.write("unsigned", text)
    complaint = tool.start(f"restore /dev/no-such-port {device} unsigned").wait().err
    wanted = re.search(r"that of its content (.*)", complaint)
    return re.sub(r"^crc16=.*", f"crc16={wanted[1]}", text, flags=re.M) if wanted else text


def other_values(tool: Tool, device: str, backup: str) -> str:
    """Another value within the range in every register for which there is one."""
    registers = csv.DictReader(io.StringIO(tool.start(f"map {device}").wait().out))
    ranges = {row["name"]: (int(row["min"]), int(row["max"])) for row in registers if row["max"] != ""}

    def other(line: re.Match) -> str:
        name, value = line[1], int(line[2])
        if name not in ranges:
            return line[0]
        low, high = ranges[name]
        changed = value + 1 if value < high else value - 1
        return f"{name}={changed} #" if changed >= low else line[0]

    return re.sub(r"^([a-z0-9_]+)=(-?[0-9]+) #.*", other, backup, flags=re.M)
