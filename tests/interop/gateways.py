# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The tool says the same over a gateway as over a serial port, of each simulated drive.

gateways.py TOOL SCHEME     tcp: socat is a transparent gateway; mbap: one that passes Modbus TCP on
"""
import sys
from concurrent.futures import ThreadPoolExecutor

from peers import ask, begin_drive, folder, need_peer, said_port
from checks import begin, check, expect, expect_lines, expect_same, finish, same, text_of

DRIVES = {
    "zlac8015d": ("bus_voltage left_actual_position host_timeout", "left_acceleration_time=700"),
    "yako-closed-loop": ("status_word actual_position node_address", "acceleration_time=70"),
    "yako-open-loop": ("status_word actual_position node_address", "acceleration_time=70"),
    "c630s": ("actual_speed feedback_pulses max_speed", "max_speed=3000"),
}
tool, scheme = sys.argv[1:]


class Line:
    """A simulated drive, and gateways to it."""

    def __init__(self, device):
        self.device = device
        self.folder = folder / device
        self.folder.mkdir()
        self.drive = self.folder / "drive"
        self.gateways = {"tcp": ["socat", "-t0.05", "-d", "-d", "TCP-LISTEN:0,bind=127.0.0.1",
                                 f"OPEN:{self.drive},raw,echo=0"],
                         "mbap": [sys.executable, "-B", "tests/interop/mbap_gateway.py", self.drive]}
        begin_drive(tool, device, self.drive)

    def direct(self, command, *words):
        return ask(tool, command, self.drive, *words, port=self.drive)

    def behind(self, command, *words):
        """Over a gateway for one connection: it has the drive's port until it ends, and then the next may have it."""
        notes = self.folder / "gateway"
        gateway = begin(*self.gateways[scheme], out=notes)
        port = f"{scheme}://127.0.0.1:{said_port(gateway, notes)}"
        said = ask(tool, command, port, *words, port=port)
        gateway.wait()
        return said

    def expect_both(self, status, words):
        direct, behind = self.direct(*words), self.behind(*words)
        expect_lines(direct.stdout, behind.stdout)
        expect_lines(direct.stderr, behind.stderr)
        expect_same((status, status), (direct.returncode, behind.returncode))

    def both(self, name, status, *words):
        check(f"{scheme}, {self.device}: {name}", self.expect_both, status, words)

    def expect_same_backup(self, kept, again):
        self.direct("backup", self.device, kept)
        self.behind("backup", self.device, again)
        expect(text_of(kept).count("\ncrc16=") == 1, "no sum")
        expect_lines(text_of(kept), text_of(again))


def run_all(device):
    names, change = DRIVES[device]
    first = names.split()[0]
    line = Line(device)
    line.both("reads", 0, "read", device, *names.split())
    line.both("writes", 0, "write", device, change)
    line.both("a register that is refused", 1, "read", "raw", "0x7777")
    if scheme == "tcp":
        same(f"{scheme}, {device}: no response of another node", f"servobus: {first}: no response: the connection is open, and "
             "not a byte came; the gateway may serve one client at a time\n",
             line.behind("read", f"{device}:9", first, "--timeout", "200", "--retries", "0").stderr)
    else:
        same(f"{scheme}, {device}: the gateway says that another node does not respond", 1,
             line.behind("read", f"{device}:9", first, "--retries", "0").stderr.count("exception 11"))
    kept, again = line.folder / "direct.txt", line.folder / "behind.txt"
    check(f"{scheme}, {device}: backs up the same parameters", line.expect_same_backup, kept, again)
    line.both("restores what differs not", 0, "restore", device, kept, "--dry-run")
    same(f"{scheme}, {device}: watches", 3,
         line.behind("watch", device, first, "--count", "3", "--interval", "0").stdout.count(f"{first}="))
    same(f"{scheme}, {device}: finds the drive", f"- - 1 {device}\n",
         line.behind("scan", "--nodes", "1-2").stdout)


need_peer("socat", "socat")
# They mostly wait, so all drives do at once.
with ThreadPoolExecutor() as pool:
    for _ in pool.map(run_all, DRIVES):
        pass
finish()
