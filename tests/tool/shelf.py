# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The device files of examples/devices: the frames that their makers print, and each row of a simulated device."""
import csv
import struct
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene

DEVICES = Path(__file__).resolve().parents[2] / "examples/devices"

# File, the PDUs of a request and its response as the maker's document prints them, and what the document says they mean.
PRINTED = [
    ("eastron_sdm120", "04 00 00 00 02", "04 04 43 66 33 34", ["voltage = 230.2"]),
    ("peacefair_pzem004t", "04 00 00 00 0A",
     "04 14 08 98 03 E8 00 00 08 98 00 00 00 00 00 00 01 F4 00 64 00 00",
     ["voltage = 220.0 V", "current = 1.000 A", "power = 220.0 W", "energy = 0 Wh", "frequency = 50.0 Hz"]),
    ("epever_tracer_b", "04 31 04 00 01", "04 02 04 CE", ["battery_voltage = 12.30 V"]),
    ("cwt_soil_thc_s", "03 00 00 00 03", "03 06 02 92 FF 9B 03 E8", ["65.8 %", "-10.1 degC", "1000 uS/cm"]),
    ("abb_a43", "03 50 00 00 04", "03 08 00 00 00 00 00 0D 12 90", ["import_active_energy = 8567.20 kWh"]),
]


def framed(pdu: str, node: int = 1) -> str:
    body = bytes([node]) + bytes.fromhex(pdu)
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return (body + struct.pack("<H", crc)).hex(" ")


@scene()
def frames(tool: Tool):
    """The frames that the makers print."""
    for name, request, response, meanings in PRINTED:
        tool.run(["explain", str(DEVICES / f"{name}.csv")], stdin=f"> {framed(request)}\n< {framed(response)}\n")
        for meaning in meanings:
            tool.check(f"{name}: {meaning}", meaning in tool.last.out, tool.found())


@scene()
def rows(tool: Tool):
    """A simulated device has each row of its file."""
    files = sorted(DEVICES.glob("*.csv"))
    tool.check("there are files", len(files) >= 5)
    for path in files:
        known = list(csv.DictReader(tool.run(["map", str(path)]).lines))
        text = path.read_text(encoding="utf-8")
        tool.check(f"{path.name} names its source", "## Source: " in text and "## Never tried on the device." in text)
        with tool.simulated(str(path)):
            names = [row["name"] for row in known if row["access"] != "wo"]
            ended = tool.run(["read", "drive", str(path), *names])
            tool.check(f"{path.name}: each row is read", ended.status == 0 and len(ended.lines) == len(names), tool.found())


play_tool()
