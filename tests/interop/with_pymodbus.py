# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""servobus' rows against pymodbus' server and client, over pseudo-terminals."""
import sys

from peers import begin_line, build, folder, holds_what_was_written, need_peer, ran, ran_by
from checks import ROOT, begin, check, end, finish, run, until

PYTHONS = sys.executable, "/usr/bin/python3"  # the second one has Debian's packages
HERE = ROOT / "tests/interop"


def with_pymodbus():
    for python in PYTHONS:
        if run(python, "-c", "import pymodbus.client, pymodbus.server").returncode == 0:
            return python
    return None


need_peer(with_pymodbus, "python3-pymodbus", "python3-serial-asyncio")
need_peer("socat", "socat")
python = with_pymodbus()
print(f"# pymodbus {run(python, '-c', 'import pymodbus.version as v; print(v.version.short())').stdout.strip()}")
tables_client, tables_server = build("tables_client"), build("tables_server")
own, written, held = (folder / name for name in ("own", "written", "held"))
near, far = begin_line()

print("# our client with rows of all tables, pymodbus' server")
server = begin(python, "-B", HERE / "pymodbus_server.py", far, out=held)
ran(tables_client, near, written, "16", "17", "11", "2B")
check("pymodbus' server holds what servobus' rows wrote", holds_what_was_written, held, written)
end(server)
print("# pymodbus' client, our server of rows")
server = begin(tables_server, own, out=held)
until(own.exists, server, "our server")
ran_by("pymodbus", python, "-B", HERE / "pymodbus_client.py", own, written)
check("servobus' rows hold what pymodbus' client wrote", holds_what_was_written, held, written)
finish()
