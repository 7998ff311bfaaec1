# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""tshark's view of the frames that we make, which are those that the manuals print."""
import re

from peers import build, folder, need_peer
from checks import ROOT, check, expect_lines, finish, must, passes, same, text_of

# The columns of frames_pcap.cpp.
FIELDS = ("mbrtu.crc16.status mbrtu.unit_id modbus.func_code modbus.exception_code modbus.reference_num "
          "modbus.word_cnt modbus.byte_cnt modbus.regval_uint16 modbus.data _ws.expert.severity _ws.col.Info").split()
# Those of frames of all functions: of each the head and no expert warning.
HEADS = "mbrtu.crc16.status mbrtu.unit_id modbus.func_code modbus.exception_code _ws.expert.severity _ws.col.Info".split()
NAMES = {"1": "Read Coils", "2": "Read Discrete Inputs", "3": "Read Holding Registers", "4": "Read Input Registers",
         "5": "Write Single Coil", "6": "Write Single Register", "8": "Return Query Data", "15": "Write Multiple Coils",
         "16": "Write Multiple Registers", "17": "Report Slave ID", "22": "Mask Write Register",
         "23": "Read Write Register", "43": "Read Device Identification"}


def dissected(frames, columns=FIELDS):
    fields = [word for field in columns for word in ("-e", field)]
    said = must("tshark", "-r", frames, "-o", "mbrtu.crc_verification:TRUE", "-o", "mbrtu.tcp.port:1502",
                "-T", "fields", "-E", "separator=,", "-E", "aggregator= ", *fields, apart=True)
    said = re.sub(r" *(Query:|Response:).*", r"\1", said)
    said = re.sub(r"^,,,,,.*", "too short", said, flags=re.M)
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
passes("frames of all functions are made for tshark", frames_pcap, folder / "functions.pcap", folder / "heads")
heads = text_of(folder / "heads")
check(f"tshark names the function of {heads.count(chr(10))} frames, and warns of none", expect_lines, heads,
      dissected(folder / "functions.pcap", HEADS))
named = must("tshark", "-r", folder / "functions.pcap", "-o", "mbrtu.tcp.port:1502", "-T", "fields", "-e", "_ws.col.Info")
same("tshark's names of the functions", NAMES, dict(re.findall(r"Func: +(\d+)(?:/ *\d+)?: ([^.\n]*)", named)))
finish()
