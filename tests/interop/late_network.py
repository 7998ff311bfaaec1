# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A network that is late for longer than any limit, and loses nothing.    late_network.py TOOL"""
import re
import sys

from peers import ask, begin_drive, begin_server, folder
from checks import end, finish, same, text_of, until

tool, = sys.argv[1:]
drive = folder / "drive"
begin_drive(tool, "zlac8015d", drive)


def begin_late(name, after, seconds):
    server, port = begin_server(name, sys.executable, "-B", "tests/interop/stalling_gateway.py", drive, after, seconds)
    return server, f"tcp://127.0.0.1:{port}"


server, url = begin_late("late", 7, 1.6)
said = ask(tool, "watch", url, "zlac8015d", "bus_voltage", "left_max_current", "host_timeout", "--count", "40",
           "--interval", "0").stdout
same("G2: a late response is not taken for the next one",
     {"bus_voltage=24.00", "host_timeout=1000", "left_max_current=30.0"}, set(re.findall(r"[a-z_]+=[0-9.]+", said)))
same("G2: after it the values go on", 1,
     said.split("\n")[-2].count("bus_voltage=24.00 V, left_max_current=30.0 A, host_timeout=1000 ms"))
end(server)

server, url = begin_late("later", 0, 3)
late = ask(tool, "write", url, "zlac8015d", "left_acceleration_time=777", "--timeout", "200")
same("a write without a response is unknown", (1, 1), (late.returncode, late.stderr.count("unknown")))
notes = folder / "later.notes"
until(lambda: text_of(notes).count("\n") > 1, server, "the request")
same("and is not carried out any more", ["dropped"], text_of(notes).split()[1:])
finish()
