# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The command-line tool on wine says what the one of this machine says.

tool.py TOOL BUILD PART      PART: commands, files, network or endings
"""
import os
import re
import signal

import wine
from alike import alike, begin_drive, by_linux, by_windows, complains, complains_of, drive, folder, main, says
from checks import begin, check, end, expect, same, text_of, until

FRAMES = """> 01 03 20 A1 00 01 DE 28
< 01 03 02 09 60 BE 3C

01 06 20 0E 00 08 E2 0F
# a comment
01 06 20 0E 00 08 E2 0E
no frame
"""


def commands():
    begin_drive()
    at = ("PORT", "zlac8015d")
    alike("--help", 0, "--help")
    alike("--version", 0, "--version")
    alike("map", 0, "map", "c630s")
    alike("alarms", 0, "alarms", "c630s")
    alike("explain: requests, responses, a bad CRC", 1, "explain", "zlac8015d", typed=FRAMES)
    alike("explain --hex", 1, "explain", "zlac8015d", "--hex", typed=FRAMES)
    alike("read", 0, "read", *at, "bus_voltage", "0x20A9", "left_actual_position", "left_faults", "status_word",
          "host_timeout")
    for form in ("--csv", "--json"):
        alike(f"read {form}", 0, "read", *at, "bus_voltage", "left_actual_position", "motor_temperature", form)
    alike("read: no such register", 2, "read", *at, "bus_volt")
    alike("read: no such option", 2, "read", *at, "bus_voltage", "--bauds", "9600")
    alike("read: no response", 1, "read", "PORT", "zlac8015d:9", "bus_voltage")
    alike("read: an exception", 1, "read", "PORT", "raw", "0x3000", "--baud", "115200")
    alike("read: no such port", 1, "read", "COM77", "zlac8015d", "bus_voltage")
    alike("write", 0, "write", *at, "left_max_current=12.5", "right_max_current=11")
    alike("write: a value outside the range", 2, "write", *at, "left_max_current=1000")
    alike("write: no consent", 1, "write", *at, "control_word=enable")
    alike("write: typed consent", 0, "write", *at, "control_word=enable", typed="write\r\n")
    alike("write: a stop needs none", 0, "write", *at, "control_word=stop")
    rounds = ("--count", "3", "--interval", "20")
    alike("watch", 0, "watch", *at, "bus_voltage", "host_timeout", *rounds)
    for form in ("--csv", "--json"):
        alike(f"watch {form}", 0, "watch", *at, "bus_voltage", "left_actual_position", *rounds, form)
    # Wine's port has rates and formats. That of Linux is a pseudo-terminal, which has none, and is scanned once.
    says("scan", 0, "115200 8N1 1 zlac8015d\n115200 8N2 1 zlac8015d\n", "scan", "PORT", "--baud", "115200", "--format",
         "8N1,8N2", "--nodes", "1-3", "--timeout", "500")
    alike("scan: no device responds", 1, "scan", "PORT", "--baud", "115200", "--format", "8N1", "--nodes", "2-3",
          "--timeout", "500")
    alike("backup to standard output", 0, "backup", *at)
    complains_of("a port that is a folder", f"servobus: cannot open {folder}: ", "read", folder, "zlac8015d",
                 "bus_voltage")


def files():
    begin_drive()
    at = ("PORT", "zlac8015d")
    backups = {"by_linux": by_linux, "by_windows": by_windows}
    by_linux("write", *at, "left_max_current=12.5", "right_max_current=11")
    same("the tool: backup into a file", [0, 0],
         [by("backup", *at, folder / name).status for name, by in backups.items()])
    kept = text_of(folder / "by_linux")
    same("the tool: both files are byte for byte the same", kept, text_of(folder / "by_windows"))
    check("the tool: it has all parameters", expect, kept.count("\n") > 80, kept)
    same("the tool: a file that exists is replaced", (0, kept),
         (by_windows("backup", *at, folder / "by_windows").status, text_of(folder / "by_windows")))
    same("the tool: no draft is left", [], list(folder.glob("*.part")))
    for (name, by), other in zip(backups.items(), ("by_windows", "by_linux")):
        by_linux("write", *at, "left_max_current=10", "right_max_current=9")
        alike(f"restore --dry-run of {other}", 0, "restore", *at, folder / other, "--dry-run")
        said = by("restore", *at, folder / other, "--yes")
        same(f"the tool: {name.removeprefix('by_')} restores {other}",
             (0, ["left_max_current=12.5 A", "right_max_current=11.0 A"]), (said.status, said.out.splitlines()))
    (folder / "changed").write_bytes((folder / "by_linux").read_bytes().replace(b"\n", b"\r\n"))
    alike("restore refuses changed line ends", 2, "restore", *at, folder / "changed", "--yes")
    backup_targets(at)
    logs(at)
    complains("sim is refused", 1,
              "servobus: a simulated drive needs a pseudo-terminal, which Windows does not have\n", "sim", "zlac8015d")


def backup_targets(at):
    alike("backup: a folder", 1, "backup", *at, folder)
    alike("backup: FILE is the port", 2, "backup", *at, "PORT")
    alike("backup: in a folder that does not exist", 1, "backup", *at, folder / "none/file")
    same("the tool: backup into NUL", 0, by_windows("backup", *at, "NUL").status)
    for port, target in (("COM3", r"\\.\COM3"), (r"\\.\COM3", "com3")):
        complains(f"backup from {port} into {target}", 2, f"servobus: {target} is the port\n",
                  "backup", port, "zlac8015d", target)


def logs(at):
    log = folder / "log"
    watch = ("watch", *at, "bus_voltage", "--count", "2", "--interval", "20", "--log", log)
    by_linux(*watch)
    same("the tool: --log appends to what Linux began", (0, 5), (by_windows(*watch).status, text_of(log).count("\n")))
    same("the tool: with no other line ends", 0, text_of(log).count("\r"))
    alike("--log: other columns", 2, "read", *at, "status_word", "--log", log)
    alike("--log: a folder", 1, "read", *at, "status_word", "--log", folder)
    (folder / "half").write_text("half a line")
    alike("--log: a line without an end", 2, "read", *at, "status_word", "--log", folder / "half")
    for name in ("COM3", r"\\.\COM12", "NUL"):
        complains(f"--log into {name}", 1, f"servobus: cannot write {name}: it is no regular file\n",
                  "read", *at, "status_word", "--log", name)
    by_windows("read", "PORT", "zlac8015d:9", "status_word", "--log", folder / "new")
    same("the tool: a row that says so is kept", 2, text_of(folder / "new").count("\n"))
    by_windows("read", "COM77", "zlac8015d", "status_word", "--log", folder / "none")
    same("the tool: a log without a row is removed", False, (folder / "none").exists())


def port_of(gateway, notes):
    """The port on which a gateway listens, as it says itself."""
    said = until(lambda: re.search(r"^(?:.*listening on .*:)?(\d+)$", text_of(notes), re.M), gateway, "the gateway")
    return said.group(1)


def network():
    """Over gateways of this machine: socat, and the one of the tests for Modbus TCP."""
    begin_drive()
    by_linux("write", "PORT", "zlac8015d", "left_max_current=12.5")
    gateways = {"tcp": ["socat", "-d", "-d", "TCP-LISTEN:0,bind=127.0.0.1,reuseaddr", f"OPEN:{drive},raw,echo=0"],
                "mbap": ["python3", "-B", "tests/interop/mbap_gateway.py", drive]}
    for scheme, command in gateways.items():
        notes = folder / scheme
        gateway = begin(*command, out=notes)
        says(f"read over {scheme}", 0, "bus_voltage=24.00 V\nleft_max_current=12.5 A\n", "read",
             f"{scheme}://127.0.0.1:{port_of(gateway, notes)}", "zlac8015d", "bus_voltage", "left_max_current")
        end(gateway)
    alike("tcp: nobody listens", 1, "read", "tcp://127.0.0.1:9", "zlac8015d", "bus_voltage")
    alike("mbap: an address without a host", 2, "read", "mbap://:502", "zlac8015d", "bus_voltage")
    nowhere = "tcp://no-such-host.invalid:4001"
    complains_of("a host name that does not resolve", f"servobus: cannot open {nowhere}: ",
                 "read", nowhere, "zlac8015d", "bus_voltage")
    # A gateway that ends in the middle of a response.
    (folder / "part").write_bytes(b"\1\3\2")
    gateway = begin("socat", "-d", "-d", "TCP-LISTEN:0,bind=127.0.0.1",
                    f"SYSTEM:head -c 8 >/dev/null; cat {folder / 'part'}", out=folder / "gateway")
    said = by_windows("read", f"tcp://127.0.0.1:{port_of(gateway, folder / 'gateway')}", "zlac8015d", "bus_voltage",
                      "--retries", "0")
    check("the tool: a connection lost in a response", expect,
          said.status == 1 and said.err.count("bus_voltage: the port is gone: ") == 1, said)


def watch(port, *options):
    return begin("wine", os.environ["SERVOBUS_EXE"], "watch", port, "zlac8015d", "bus_voltage", "--interval", "20",
                 *options, out=folder / "watched", err=folder / "watched.err")


def endings():
    begin_drive()
    log = folder / "shared"
    watcher = watch("COM15", "--log", log)
    until(lambda: text_of(log), watcher, "watch goes on")
    complains("a log has one writer", 1, f"servobus: cannot write {log}: another program has it open\n",
              "read", "COM3", "zlac8015d", "bus_voltage", "--log", log)
    same("the tool: Ctrl-C ends watch with status 0", 0, end(watcher, signal.SIGINT))
    same("the tool: its last line is whole", "\n", text_of(folder / "watched")[-1:])

    pulled = wine.begin_drive(os.environ["SERVOBUS"], folder / "pulled")
    wine.com(13, folder / "pulled")
    watcher = watch("COM13")
    until(lambda: "bus_voltage" in text_of(folder / "watched"), watcher, "watch goes on")
    end(pulled)
    until(lambda: "is gone: " in text_of(folder / "watched.err"), watcher, "watch goes on")
    same("the tool: Ctrl-C while the port is gone ends watch with status 1", 1, end(watcher, signal.SIGINT))
    check("the tool: and it says so", expect, re.search(r"^servobus: the port is gone[^\n]*\n\Z",
                                                       text_of(folder / "watched.err"), re.M),
          text_of(folder / "watched.err"))


main({part.__name__: part for part in (commands, files, network, endings)})
