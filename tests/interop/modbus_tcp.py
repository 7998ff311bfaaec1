# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The tool at libmodbus' server of Modbus TCP.    modbus_tcp.py TOOL"""
import re
import sys

from peers import ask, begin_server, build, fails, has_libmodbus, need_peer, values
from checks import finish, same

tool, = sys.argv[1:]
need_peer(has_libmodbus, "libmodbus-dev")
url = f"mbap://127.0.0.1:{begin_server('libmodbus', build('libmodbus_tcp_server', '-lmodbus'))[1]}"


def read(*words):
    return ask(tool, "read", url, "raw:1", *words)


same("reads", "0x0010=16 (0x0010) 0x0011=17 (0x0011)", values(read("0x0010:2")))
same("reads the most that a frame holds", 125, read("0x0000:125").stdout.count("\n"))
same("writes one register", "0x0020=7 (0x0007)", values(ask(tool, "write", url, "raw:1", "0x0020=7", "--yes")))
ask(tool, "write", url, "raw:1", "0x0030:3=1,2,3", "--yes")
same("writes several registers in a frame", ["1", "2", "3"], re.findall(r"=(\d+) ", read("0x0030:3").stdout))
fails(tool, "an exception reaches the caller", 1, "exception 2", "read", url, "raw:1", "0x2000")
fails(tool, "no response of another node", 1, "no response", "read", url, "raw:9", "0x0000", "--timeout", "100",
      "--retries", "0")
# The response to the first try arrives while the second one is awaited, and is not taken for it.
same("G2: a late response is dropped by its number", "0x01F4=502 (0x01F6)",
     values(read("0x01F4", "--timeout", "1000", "--retries", "3")))
fails(tool, "a connection that is closed instead of a response", 1, "port", "read", url, "raw:1", "0x01F5",
      "--retries", "0")
fails(tool, "a connection that is lost in the middle of a response", 1, "port", "read", url, "raw:1", "0x01F6",
      "--retries", "0")
same("watch ends where the connection is lost", 1,
     ask(tool, "watch", url, "raw:1", "0x0001", "0x01F6", "--count", "5", "--interval", "0").returncode)
finish()
