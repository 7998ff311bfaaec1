# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Frames of every function as the standard prints them (Modbus Application Protocol V1.1b3, section 6), in words."""
from any_device import crc


def framed(pdu: str, node: int = 1) -> str:
    """A frame in hex around a PDU in hex."""
    data = bytes([node]) + bytes.fromhex(pdu)
    return (data + crc(data)).hex(" ").upper()


# A request, its words, the response to it, and its words. Registers are those of a ZLAC8015D.
FUNCTIONS = [
    ("01 0013 0013", "read coils 0x0013..0x0025", "01 03 CD6B05", "coils 0x0013..0x0025 = 10110011 11010110 101"),
    ("02 00C4 0016", "read discrete inputs 0x00C4..0x00D9", "02 03 ACDB35",
     "discrete inputs 0x00C4..0x00D9 = 00110101 11011011 101011"),
    ("03 20A1 0001", "read bus_voltage (0x20A1)", "03 02 0960", "bus_voltage = 24.00 V"),
    ("04 20A1 0001", "read bus_voltage (0x20A1) as input registers", "04 02 0960", "bus_voltage = 24.00 V"),
    ("05 00AC FF00", "write coil 0x00AC = on", "05 00AC FF00", "coil 0x00AC = on written"),
    ("06 2080 01F4", "write left_acceleration_time (0x2080) = 500 ms", "06 2080 01F4",
     "left_acceleration_time (0x2080) = 500 ms written"),
    ("07", "read exception status", "07 6D", "exception status 0x6D"),
    ("08 0000 A537", "return query data 0xA537", "08 0000 A537", "return query data 0xA537"),
    ("0B", "read event counter", "0B FFFF 0108", "event counter 264, busy"),
    ("0C", "read event log", "0C 08 0000 0108 0121 2000",
     "event log of 264 events and 289 messages, newest first: 20 00"),
    ("0F 0013 000A 02 CD01", "write coils 0x0013..0x001C = 10110011 10", "0F 0013 000A",
     "coils 0x0013..0x001C written"),
    ("10 2080 0001 02 01F4", "write left_acceleration_time (0x2080) = 500 ms", "10 2080 0001",
     "left_acceleration_time (0x2080) written"),
    ("11", "report server ID", "11 03 07FF41", "server ID 07 FF 41"),
    ("16 2034 00F2 0025", "mask write left_max_current (0x2034), and 0x00F2, or 0x0025", "16 2034 00F2 0025",
     "left_max_current (0x2034), and 0x00F2, or 0x0025 written"),
    ("17 20A1 0001 2080 0001 02 01F4",
     "write left_acceleration_time (0x2080) = 500 ms, then read bus_voltage (0x20A1)", "17 02 0960",
     "bus_voltage = 24.00 V"),
    ("18 04DE", "read FIFO queue (0x04DE)", "18 0006 0002 01B8 1284", "FIFO queue (0x04DE), 2 words 0x01B8 0x1284"),
    ("2B 0E 01 00", "read basic identification", "2B 0E 01 01 00 00 02 00 02 4142 01 01 43",
     'identification, vendor name "AB", product code "C"'),
    ("2B 0E 01 00", "read basic identification", "AB 01",
     "exception 1 (illegal function) to read basic identification"),
]
# Frames without words for their content.
NAMED_ALONE = [
    ("14 07 06 0004 0001 0002", "valid frame of function 14h (read file record), data 07 06 00 04 00 01 00 02"),
    ("65 01", "valid frame of function 65h (user-defined), data 01"),
]


def explained() -> list[tuple[str, str]]:
    """Each frame, and its words where its direction is not given."""
    all_frames = []
    for request, asks, response, answers in FUNCTIONS:
        equal = request == response
        all_frames.append((framed(request), asks + " (request, or the response that echoes it)" * equal))
        echo = asks + " (the request again, or the response that echoes it)"
        all_frames.append((framed(response), echo if equal else f"response, {answers}"))
    return [(frame, f"node 1: {words}") for frame, words in
            all_frames + [(framed(pdu), words) for pdu, words in NAMED_ALONE]]
