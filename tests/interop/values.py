# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Floats, 64 bits and text in both word orders, with the servers of libmodbus and pymodbus: values.py PEER"""
import sys

from peers import begin_line, build, folder, has_libmodbus, holds_what_was_written, need_peer, ran
from checks import ROOT, begin, check, end, finish, run

HERE = ROOT / "tests/interop"
PYTHONS = sys.executable, "/usr/bin/python3"  # the second one has Debian's packages


def with_pymodbus():
    return next((python for python in PYTHONS
                 if run(python, "-c", "import pymodbus.payload, pymodbus.server").returncode == 0), None)


need_peer("socat", "socat")
need_peer(has_libmodbus, "libmodbus-dev")
need_peer(with_pymodbus, "python3-pymodbus", "python3-serial-asyncio")
client = build("values_client")
servers = {"libmodbus": [build("libmodbus_values_server", "-lmodbus")],
           "pymodbus": [with_pymodbus(), "-B", HERE / "pymodbus_values_server.py"]}
written, held = folder / "written", folder / "held"
near, far = begin_line()
for name, command in servers.items():
    print(f"# our client, the server of {name}")
    server = begin(*command, far, out=held)
    ran(client, near, written)
    check(f"{name} holds what servobus wrote", holds_what_was_written, held, written)
    end(server)
finish()
