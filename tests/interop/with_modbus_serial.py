# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""servobus' rows against the server and client of npm's modbus-serial, over pseudo-terminals.

    with_modbus_serial.py TOOL

npm installs it beside the tool, once.
"""
import sys
from pathlib import Path

from peers import begin_line, build, folder, holds_what_was_written, need_peer, ran, ran_by
from checks import ROOT, begin, check, end, finish, run, skip, until

# serialport 12 is compiled for this machine by its authors, and needs no newer node than that of Debian 12.
PACKAGES = "modbus-serial@8.0.25", "serialport@12.0.0"
HERE = ROOT / "tests/interop"
home = Path(sys.argv[1]).resolve().parent / "modbus_serial"


def is_installed():
    words = "const {SerialPort} = require('serialport'); require('modbus-serial'); console.log(typeof SerialPort.list)"
    return home.exists() and run("node", "-e", words, cwd=home).stdout == "function\n"


need_peer("npm", "npm")
need_peer("socat", "socat")
if not is_installed():
    home.mkdir(parents=True, exist_ok=True)
    said = run("npm", "install", "--no-audit", "--no-fund", "--prefix", home, *PACKAGES, cwd=home)
    if not is_installed():
        print(said.stdout)
        skip("modbus-serial cannot be installed")
print(f"# {' '.join(PACKAGES)}, node {run('node', '--version').stdout.strip()}")
tables_client, tables_server = build("tables_client"), build("tables_server")
own, written, held = (folder / name for name in ("own", "written", "held"))
near, far = begin_line()

print("# our client with rows of all tables, modbus-serial's server, which has neither 11h, 16h nor 17h")
server = begin("node", HERE / "modbus_serial_server.js", home, far, out=held)
ran(tables_client, near, written, "2B")
check("modbus-serial's server holds what servobus' rows wrote", holds_what_was_written, held, written)
end(server)
print("# modbus-serial's client, our server of rows")
server = begin(tables_server, own, out=held)
until(own.exists, server, "our server")
ran_by("modbus-serial", "node", HERE / "modbus_serial_client.js", home, own, written)
check("servobus' rows hold what modbus-serial's client wrote", holds_what_was_written, held, written)
finish()
