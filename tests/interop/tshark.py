# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""tshark's view of the frames that we make, which are those that the manuals print."""
import re

from peers import build, folder, need_peer
from checks import ROOT, check, expect_lines, finish, must, passes, same, text_of

# The columns of frames_pcap.cpp.
FIELDS = ("mbrtu.crc16.status mbrtu.unit_id modbus.func_code modbus.exception_code modbus.reference_num "
          "modbus.word_cnt modbus.byte_cnt modbus.regval_uint16 modbus.data _ws.expert.severity _ws.col.Info").split()


def dissected(frames):
    fields = [word for field in FIELDS for word in ("-e", field)]
    said = must("tshark", "-r", frames, "-o", "mbrtu.crc_verification:TRUE", "-o", "mbrtu.tcp.port:1502",
                "-T", "fields", "-E", "separator=,", "-E", "aggregator= ", *fields, apart=True)
    said = re.sub(r" *(Query:|Response:).*", r"\1", said)
    return re.sub(r"^0,.*", "bad CRC", said, flags=re.M)


need_peer("tshark", "tshark")
frames_pcap = build("frames_pcap")
passes("the printed frames are made again for tshark", frames_pcap, folder / "frames.pcap", folder / "expected",
       *sorted(ROOT.glob("tests/manuals/*_frames.csv")))
expected, seen = text_of(folder / "expected"), dissected(folder / "frames.pcap")
frames = expected.count("\n")
same("tshark reads every frame as a frame", frames, seen.count("\n"))
check(f"tshark sees in {frames} frames what we see, and warns of none", expect_lines, expected, seen)
bad = expected.count("bad CRC\n")
same(f"{bad} frames with a wrong CRC are so for tshark too", bad, seen.count("bad CRC\n"))
finish()
