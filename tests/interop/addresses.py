# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Names that are no port, and hosts that are not there.    addresses.py TOOL"""
import socket
import sys

from peers import begin_server, fails, folder, need_peer
from checks import finish

tool, = sys.argv[1:]


def refused(name, status, words, port, *options):
    fails(tool, name, status, words, "read", port, "zlac8015d", "bus_voltage", *options)


refused("no host", 2, "the host is missing", "tcp://:4001")
refused("no port", 2, "the port is missing", "tcp://127.0.0.1")
refused("a port that is none", 2, "a number from 1 to 65535", "tcp://127.0.0.1:0")
refused("a port that is a word", 2, "a number from 1 to 65535", "mbap://127.0.0.1:http")
refused("IPv6 without brackets", 2, "brackets", "mbap://::1:502")
refused("a bracket that does not end", 2, "']' is missing", "mbap://[::1")
refused("a name that does not resolve", 1, "cannot open mbap://no.such.host.invalid", "mbap://no.such.host.invalid")
refused("a host that refuses", 1, "refused", "tcp://127.0.0.1:1")
refused("a port that is a folder", 1, "cannot open", folder)
fails(tool, "rates of a gateway", 2, "the gateway sets", "scan", "mbap://127.0.0.1:1", "--baud", "9600")
refused("a format of a gateway", 2, "the gateway sets", "tcp://127.0.0.1:1", "--format", "8N1")

# No program accepts, and the queue of connections is full: the system does not answer any more.
full = socket.create_server(("127.0.0.1", 0), backlog=0)
waiting = [socket.socket() for _ in range(8)]
for one in waiting:
    one.setblocking(False)
    one.connect_ex(full.getsockname())
refused("a host that never answers the connect", 1, "does not answer", f"tcp://127.0.0.1:{full.getsockname()[1]}")

# It returns each request: no register has that value.
need_peer("socat", "socat")
try:
    socket.create_server(("::1", 0), family=socket.AF_INET6).close()
except OSError:
    print("skipped 1 check: this machine has no IPv6")
else:
    _, port = begin_server("six", "socat", "-d", "-d", "TCP6-LISTEN:0,bind=[::1],reuseaddr,fork", "SYSTEM:cat")
    refused("G3: IPv6, and a gateway that returns requests only", 1, "what came is the request's own echo",
            f"tcp://[::1]:{port}", "--retries", "0")
finish()
