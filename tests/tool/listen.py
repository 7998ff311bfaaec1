# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""servobus listen, on a line (tapped_line.py) that plays frames of the drives' manuals, or that a client uses."""
import os
import re
import signal
import socket
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import standard_frames
from programs import Running, Tool, play_tool, scene, until
from standard_frames import framed
from tapped_line import TappedLine

NOWHERE = "/dev/no-such-port"
ASKS_SPEEDS = "01 03 20 AB 00 02 BE 2B"
SAYS_SPEEDS = "01 03 04 00 64 00 64 BA 07"
ENABLES = "01 06 20 0E 00 08 E2 0F"
READS = "read left_actual_speed (0x20AB), right_actual_speed (0x20AC)"
SPEEDS = "response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min"
PATIENT = "--timeout 2000"  # a busy machine is no drive that does not respond


def end_of(node: int, requests: int, responses: int, exceptions=0, no_response=0, damaged=0, unpaired=0) -> str:
    return (
        f"# node={node} requests={requests} responses={responses} exceptions={exceptions} no_response={no_response}"
        f" damaged={damaged} unpaired={unpaired} slowest_ms=T"
    )


class Listening(Tool):
    """A stage with a tapped line at `tap`, and a listener that captures what it receives in `capture`."""

    def listen(self, words: str, **how) -> Running:
        """Starts a listener and waits until it has opened its port."""
        listener = self.start(f"listen {words}", **how)
        until(lambda: "listening" in listener.err or listener.process.poll() is not None)
        return listener

    def captured(self) -> list[str]:
        """The frames of the capture, which has comments too."""
        return [line for line in self.lines("capture") if not line.startswith("#")] if self.exists("capture") else []

    def without_clock(self) -> list[str]:
        """The output without what a clock gives."""
        text = re.sub(r"^[0-9]+\.[0-9]{3} ", "", self.last.out, flags=re.M)
        text = re.sub(r"\(after [0-9]+\.[0-9] ms\)$", "(after T)", text, flags=re.M)
        text = re.sub(r"gap of [0-9.]+ s", "gap of T", text)
        return re.sub(r"slowest_ms=[0-9]+\.[0-9]", "slowest_ms=T", text).splitlines()

    def explains_the_same(self, name: str, device: str, status_name: str = ""):
        """explain says of the capture what listen has said of the frames."""
        listened = re.findall(r"^[0-9]+\.[0-9]{3} [<>?] (.*)$", self.last.out, re.M)
        listened = [re.sub(r" \(after [0-9.]+ ms\)$| \(without a request\)$", "", line) for line in listened]
        with open(self.folder / "capture") as capture:
            explained = self.start(f"explain {device}", stdin=capture).wait()
        self.check(name, listened and explained.lines == listened, f"{listened}\n{explained}")
        if status_name:
            self.check(status_name, explained.status == 0, explained)

    def nothing_is_sent(self, name: str, tap: TappedLine):
        self.is_equal(name, tap.close(), 0)


@scene()
def refused(tool: Listening):
    """There is no such port."""
    out = tool.run("--help").out
    tool.check("--help has listen", re.search("^  servobus listen PORT", out, re.M))
    tool.write("rounds", "time,error,unix_time (ms)\n")
    for name, words, status, text in [
        ("listen: no device", NOWHERE, 2, "listen takes PORT DEVICE[:NODE]..."),
        ("listen: an unknown device", f"{NOWHERE} zlac9000", 2, "known: c630s"),
        ("listen: no such port", f"{NOWHERE} zlac8015d", 1, f"cannot open {NOWHERE}"),
        ("listen: Modbus TCP has no traffic of others", "mbap://127.0.0.1 zlac8015d", 2, "no traffic of others"),
        ("listen: a gateway sets the rate", "tcp://127.0.0.1:1 zlac8015d --baud 9600", 2, "not --baud and --format"),
        ("listen: two devices at an address", f"{NOWHERE} zlac8015d:2 c630s:2", 2, "two devices at address 2"),
        ("listen: two devices at all addresses", f"{NOWHERE} zlac8015d c630s", 2,
         "two devices for the addresses that are not named"),
        ("listen: a format that there is not", f"{NOWHERE} zlac8015d --format 7E1", 2, "--format takes"),
        ("listen: nothing is sent, so nothing is repeated", f"{NOWHERE} zlac8015d --retries 1", 2,
         "unknown option '--retries'"),
        ("listen: a log of watch is no file of frames", f"{NOWHERE} zlac8015d --log rounds", 2, "no file of frames"),
    ]:
        tool.fails(name, f"listen {words}", status, text)
    tool.check("which stays as it is", tool.read("rounds") == "time,error,unix_time (ms)\n")


# Frames of the manuals, one drive each: a frame, and what is said of it.
MANUALS = {
    "zlac8015d": [
        (ASKS_SPEEDS, f"> node 1: {READS}"),
        (SAYS_SPEEDS, f"< node 1: {SPEEDS} (after T)"),
        (ENABLES, "> node 1: write control_word (0x200E) = enable (0x0008)"),
        (ENABLES, "< node 1: response, control_word (0x200E) = enable (0x0008) written (after T)"),
        ("01 10 20 30 00 02 04 04 00 00 00 68 4A",
         "> node 1: write left_encoder_lines (0x2030) = 1024, left_hall_offset_angle (0x2031) = 0 deg"),
        ("01 10 20 30 00 02 4A 07",
         "< node 1: response, left_encoder_lines (0x2030), left_hall_offset_angle (0x2031) written (after T)"),
        ("", end_of(node=1, requests=3, responses=3)),
    ],
    "yako-open-loop": [
        ("01 03 00 0A 00 03 25 C9", "> node 1: read actual_position (0x000A), actual_speed (0x000C)"),
        (
            "01 03 06 00 00 13 88 00 00 A5 DB",
            "< node 1: response, actual_position = 5000 pulse, actual_speed = 0 r/min (in the factory's word order)"
            " (after T)",
        ),
        ("01 06 00 21 01 F4 D9 D7", "> node 1: write acceleration_time (0x0021) = 500 ms"),
        ("01 06 00 21 01 F4 D9 D7", "< node 1: response, acceleration_time (0x0021) = 500 ms written (after T)"),
        ("01 10 00 24 00 02 04 00 00 13 88 FD 12",
         "> node 1: write target_position (0x0024) = 5000 pulse (in the factory's word order)"),
        ("01 10 00 24 00 02 01 C3", "< node 1: response, target_position (0x0024) written (after T)"),
        ("01 03 00 3C 00 01 44 06", "> node 1: read unknown register (0x003C)"),
        (
            "01 83 03 01 31",
            "< node 1: response, exception 3 (register address not allowed) to read unknown register (0x003C)"
            " (after T)",
        ),
        ("", end_of(node=1, requests=4, responses=3, exceptions=1)),
    ],
    "yako-closed-loop": [
        ("01 02 00 00 00 04 79 C9", "> node 1: read discrete inputs 0x0000..0x0003"),
        ("01 82 02 C1 61", "< node 1: response, exception 2 (function code error) to read discrete inputs 0x0000..0x0003 (after T)"),
        ("01 06 00 27 01 00 38 51", "> node 1: write motion_command (0x0027) = stop (0x0100)"),
        ("", end_of(node=1, requests=2, responses=0, exceptions=1)),
    ],
    "c630s": [
        ("01 03 0B 11 00 02 96 2A", "> node 1: read feedback_pulses (0x0B11)"),
        ("01 03 04 00 64 00 C8 BA 7A",
         "< node 1: response, feedback_pulses = 13107300 counts (in the factory's word order) (after T)"),
        ("01 06 12 14 01 F4 CC A1", "> node 1: write speed_segment_1_speed (0x1214) = 500 r/min"),
        ("01 06 12 14 01 F4 CC A1", "< node 1: response, speed_segment_1_speed (0x1214) = 500 r/min written (after T)"),
        ("01 10 11 0C 00 02 04 38 80 00 01 FE E2",
         "> node 1: write position_segment_1_displacement (0x110C) = 80000 ref_unit (in the factory's word order)"),
        ("01 10 11 0C 00 04 04 F5", "< node 1: response, position_segment_1_displacement (0x110C) written (after T)"),
        ("", end_of(node=1, requests=3, responses=3)),
    ],
}


@scene(*MANUALS)
def manual(tool: Listening, device: str):
    frames = [frame for frame, _ in MANUALS[device] if frame]
    said = [words for _, words in MANUALS[device]]
    said.append(f"# frames={len(frames)} bad_crc=0 incomplete=0 noise=0 damaged_bytes=0")
    tap = TappedLine.at(tool.folder / "tap")
    listener = tool.listen(f"tap {device} {PATIENT} --log capture")
    tap.play(*frames)
    until(lambda: len(tool.captured()) >= len(frames))
    tool.ends(listener, signal.SIGINT)
    tool.is_equal(f"listen, {device}: what is said", tool.without_clock(), said)
    tool.status_is("status 0 at Ctrl-C", 0)
    bare = [re.sub("^[<>] ", "", line) for line in tool.captured()]
    tool.is_equal("the capture has the frames", bare, frames)
    status_name = "and has status 0" if device == "zlac8015d" else ""
    tool.explains_the_same("explain says the same", device, status_name)
    tool.nothing_is_sent("nothing is sent", tap)


@scene()
def device_of_a_file(tool: Listening):
    """Coils and inputs have the names of the file's rows and of their states."""
    tool.write("plant.csv", "address,name,table,access,names\n3,valve,coil,rw,0=shut;1=open\n4,pump,coil,rw,\n"
                            "3,door,discrete,,0=closed;1=open\n3,level,input,,\n")
    frames = [("01 0003 0003", "> node 1: read valve (0x0003), pump (0x0004), coil 0x0005"),
              ("01 01 03", "< node 1: response, valve = open (0x0001), pump = on, coil 0x0005 = off (after T)"),
              ("02 0003 0001", "> node 1: read door (0x0003)"),
              ("02 01 00", "< node 1: response, door = closed (0x0000) (after T)"),
              ("04 0003 0001", "> node 1: read level (0x0003) as input registers"),
              ("04 02 0007", "< node 1: response, level = 7 (after T)"),
              ("05 0003 0000", "> node 1: write valve (0x0003) = shut (0x0000)"),
              ("05 0003 0000", "< node 1: response, valve (0x0003) = shut (0x0000) written (after T)"),
              ("0F 0003 0002 01 02", "> node 1: write valve (0x0003) = shut (0x0000), pump (0x0004) = on"),
              ("0F 0003 0002", "< node 1: response, valve (0x0003), pump (0x0004) written (after T)")]
    tap = TappedLine.at(tool.folder / "tap")
    listener = tool.listen(f"tap plant.csv {PATIENT} --log capture")
    tap.play(*(framed(pdu) for pdu, _ in frames))
    until(lambda: len(tool.captured()) >= len(frames))
    tool.ends(listener, signal.SIGINT)
    tool.is_equal("listen, a device of a file: what is said", tool.without_clock()[:len(frames)],
                  [words for _, words in frames])
    tool.explains_the_same("explain says the same", "plant.csv", "and has status 0")
    tool.nothing_is_sent("nothing is sent", tap)


@scene("with gaps", "glued")
def every_function(tool: Listening, how: str):
    frames = [framed(pdu) for row in standard_frames.FUNCTIONS for pdu in row[::2]]
    said = []
    for _, asks, _, answers in standard_frames.FUNCTIONS:
        said += [f"> node 1: {asks}", f"< node 1: response, {answers} (after T)"]
    count = len(standard_frames.FUNCTIONS)
    said += [end_of(node=1, requests=count, responses=count - 1, exceptions=1),
             f"# frames={2 * count} bad_crc=0 incomplete=0 noise=0 damaged_bytes=0"]
    tap = TappedLine.at(tool.folder / "tap")
    listener = tool.listen(f"tap zlac8015d {PATIENT} --log capture")
    tap.play(*(frames if how == "with gaps" else [" ".join(frames)]))
    until(lambda: len(tool.captured()) >= len(frames))
    tool.ends(listener, signal.SIGINT)
    tool.is_equal(f"listen, {how}: every function of the standard", tool.without_clock(), said)
    tool.explains_the_same("explain says the same", "zlac8015d", "and has status 0")
    tool.nothing_is_sent("nothing is sent", tap)


@scene()
def toggled_coils(tool: Listening):
    """A relay module that toggles at 05 with 5500h, or switches for a time: its responses repeat the requests."""
    tap = TappedLine.at(tool.folder / "tap")
    listener = tool.listen(f"tap raw {PATIENT} --log capture")
    for coil, value in [(0, "5500"), (1, "0064"), (2, "5500")]:
        tap.play(framed(f"05 000{coil} {value}"), framed(f"05 000{coil} {value}"))
    tap.play(framed("05 0003 5500"), framed("85 03"))
    until(lambda: len(tool.captured()) >= 8)
    tool.ends(listener, signal.SIGINT)
    odd = "(no value of the standard)"
    tool.is_equal("listen: coils with other values than on and off", tool.without_clock(), [
        f"? node 1: write coil 0x0000 = 0x5500 {odd} (request, or the response that echoes it)",
        f"< node 1: response, coil 0x0000 = 0x5500 {odd} written (after T)",
        f"> node 1: write coil 0x0001 = 0x0064 {odd}",
        f"< node 1: response, coil 0x0001 = 0x0064 {odd} written (after T)",
        f"> node 1: write coil 0x0002 = 0x5500 {odd}",
        f"< node 1: response, coil 0x0002 = 0x5500 {odd} written (after T)",
        f"> node 1: write coil 0x0003 = 0x5500 {odd}",
        f"< node 1: response, exception 3 (illegal data value) to write coil 0x0003 = 0x5500 {odd} (after T)",
        end_of(node=1, requests=4, responses=3, exceptions=1),
        "# frames=8 bad_crc=0 incomplete=0 noise=0 damaged_bytes=0"])


@scene()
def what_goes_wrong(tool: Listening):
    tap = TappedLine.at(tool.folder / "tap")
    listener = tool.listen("tap zlac8015d --timeout 300 --log capture")
    for frames, lines in [  # and how many lines of the listener there are then
        (["64 BA 07"], 1),  # the end of a response
        ([ENABLES, 0.6], 2),  # a request or a response, and none within the limit
        ([ENABLES, ENABLES], 4),  # a request and its response
        ([ASKS_SPEEDS], 5),
        (["01 03 04 00 64 00 64 BA 08"], 6),  # a damaged response
        ([ASKS_SPEEDS], 8),  # no response
        ([ASKS_SPEEDS, SAYS_SPEEDS], 10),
        ([ASKS_SPEEDS, "02 03 20 AB 00 02 BE 18", "02 03 04 00 64 00 64 89 07"], 14),  # two addresses
        (["FF"], 15),  # a glitch
        (["01 03 20 AB 00 02"], 16),  # half a frame
        ([f"55 {ASKS_SPEEDS} {SAYS_SPEEDS}"], 19),  # noise without a gap
        ([SAYS_SPEEDS], 20),  # a second response
        ([1.5, "00 06 20 0E 00 07 A3 DA"], 22),  # to all nodes, after a gap
    ]:
        tap.play(*frames)
        until(lambda: listener.out.count("\n") >= lines)
    terminating = signal.SIGINT if os.environ.get("ON_WINE") else signal.SIGTERM  # Windows has no other
    tool.ends(listener, terminating)
    tool.is_equal(
        "listen: what is wrong is said",
        tool.without_clock(),
        [
            "! noise: 64 BA 07",
            "? node 1: write control_word (0x200E) = enable (0x0008) (request, or the response that echoes it)",
            "> node 1: write control_word (0x200E) = enable (0x0008)",
            "< node 1: response, control_word (0x200E) = enable (0x0008) written (after T)",
            f"> node 1: {READS}",
            "! bad CRC: 01 03 04 00 64 00 64 BA 08",
            f"> node 1: {READS}",
            "! no response from node 1 within 300 ms",
            f"> node 1: {READS}",
            f"< node 1: {SPEEDS} (after T)",
            f"> node 1: {READS}",
            "! no response from node 1 before the next request",
            f"> node 2: {READS}",
            f"< node 2: {SPEEDS} (after T)",
            "! noise: FF",
            "! incomplete: 01 03 20 AB 00 02",
            "! noise: 55",
            f"> node 1: {READS}",
            f"< node 1: {SPEEDS} (after T)",
            f"< node 1: {SPEEDS} (without a request)",
            "! gap of T",
            "> all nodes: write control_word (0x200E) = stop (0x0007)",
            end_of(node=0, requests=1, responses=0),
            end_of(node=1, requests=6, responses=3, no_response=2, damaged=1, unpaired=2),
            end_of(node=2, requests=1, responses=1),
            "# frames=14 bad_crc=1 incomplete=1 noise=3 damaged_bytes=20",
        ],
    )
    tool.status_is(f"status 0 at {terminating.name}", 0)
    tool.check("the capture has 14 frames", len(tool.captured()) == 14)
    damaged = "bad CRC: 01 03 04 00 64 00 64 BA 08|incomplete: 01 03 20 AB 00 02|noise: (?:55|FF|64 BA 07)"
    comments = re.findall(f"^# [0-9T:.-]+Z (?:{damaged})$", tool.read("capture"), re.M)
    tool.check("and each damaged byte, with the reason, in a comment", len(comments) == 5, tool.read("capture"))
    tool.explains_the_same("explain says the same", "zlac8015d", "and fails at none of them")

    listener = tool.listen("tap zlac8015d --timeout 300 --log capture")
    tap.play(ASKS_SPEEDS)
    tool.check("another run appends to the capture", until(lambda: len(tool.captured()) >= 15))
    tool.ends(listener, signal.SIGKILL)
    tool.check("after SIGKILL it is whole", tool.read("capture").endswith("\n"))
    tool.run("explain zlac8015d", stdin=tool.read("capture"))
    tool.out_has("and explained", "actual_speed")
    tool.nothing_is_sent("nothing was sent by any of them", tap)


@scene()
def named_devices_and_ends(tool: Listening):
    tap = TappedLine.at(tool.folder / "tap")
    listener = tool.listen("tap zlac8015d --count 2")
    tap.play(ASKS_SPEEDS, SAYS_SPEEDS, ASKS_SPEEDS)
    tool.ends(listener)
    tool.status_is("listen --count: status 0", 0)
    tool.out_has("after so many frames", "# frames=2 ")

    listener = tool.listen("tap zlac8015d:1 c630s:2")
    tap.play("02 03 0B 11 00 02 96 19", ASKS_SPEEDS, "03 03 20 AB 00 02 BF C9")
    for name, text in [
        ("each device has its names: one", "> node 2: read feedback_pulses (0x0B11)"),
        ("the other", f"> node 1: {READS}"),
        ("and where none is named there are no names", "> node 3: read unknown registers (0x20AB..0x20AC)"),
    ]:
        tool.check(name, until(lambda: text in listener.out), listener.out)
    tool.ends(listener, signal.SIGINT)

    listener = tool.listen("tap zlac8015d")
    tap.play(ASKS_SPEEDS)
    until(lambda: READS in listener.out)
    tap.hang_up()
    tool.ends(listener)
    tool.status_is("a port that is pulled is status 1", 1)
    tool.err_has("and said", "servobus: the port is gone")
    tool.out_has("after the counters", "# node=1 requests=1 ")
    tool.nothing_is_sent("nothing was sent by any of them", tap)


@scene()
def lost_output(tool: Listening):
    if os.environ.get("ON_WINE"):
        return tool.say("left out: output that cannot be written (/dev/full is of Linux)")
    tap = TappedLine.at(tool.folder / "tap")
    with open("/dev/full", "wb") as full:
        listener = tool.listen("tap zlac8015d", out=full)
    tap.play(ASKS_SPEEDS)
    tool.ends(listener)
    tool.status_is("output that cannot be written ends it", 1)
    complaint = "cannot write standard output: No space left on device"
    tool.check("and is said once", tool.last.err.count(complaint) == 1)
    tap.close()


@scene()
def gateway(tool: Listening):
    """One that passes on what it receives."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        listener = tool.listen(f"tcp://127.0.0.1:{port} zlac8015d")
        tap = TappedLine(server.accept()[0].detach())
    tap.play(ASKS_SPEEDS, SAYS_SPEEDS)
    tool.check("listen to a gateway", until(lambda: f"< node 1: {SPEEDS}" in listener.out), listener.out)
    # Timer 02 of the kernel: it asks whether the peer is still there.
    sockets = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()]
    kept_alive = [one for one in sockets if f":{port:04X}" in one[2] and one[3] == "01" and one[5].startswith("02:")]
    tool.check("a gateway that vanishes without a word is noticed", len(kept_alive) == 1, sockets)
    tap.hang_up()
    tool.ends(listener)
    tool.status_is("a connection that is closed is status 1", 1)
    tool.err_has("and said", "servobus: the port is gone")
    tool.nothing_is_sent("nothing is sent", tap)


# A client and a simulated drive, with the listener between them


def talk(tool: Listening, device: str, registers: str, change: str) -> list[str]:
    """More reads and writes than any test above. Returns what the client reads."""
    read = tool.start(f"read client {device} {registers}").wait().lines
    read += tool.start(f"write client {device} {change} --yes").wait().lines
    tool.start("read client raw:7 0x0020 --retries 1 --timeout 200").wait()
    tool.start(f"backup client {device}").wait()
    return read


def is_heard(client_line: str, out: str) -> bool:
    """`name=value` of the client is `name = value` of the listener, which has an address in addition when it writes."""
    heard = re.sub(r" \(0x[0-9A-F]{4}\)", "", out).replace("_", " ").replace("\n", " \n")
    wanted = re.sub(r" \(0x[0-9A-F]{4}\)$", "", client_line).replace("_", " ")
    wanted = wanted.replace("+", " + ").replace("=", " = ")
    return re.search(f"(?:, | ){re.escape(wanted)}[ ,]", heard) is not None


@scene(
    ("zlac8015d", "bus_voltage left_actual_position status_word", "left_acceleration_time=700"),
    ("yako-closed-loop", "status_word actual_position node_address", "acceleration_time=70"),
    ("yako-open-loop", "status_word actual_position node_address", "acceleration_time=70"),
    ("c630s", "mode_of_operation feedback_pulses", "P06-03=100"),
)
def beside_a_client(tool: Listening, device: str, registers: str, change: str):
    with tool.simulated(device):
        tap = TappedLine.relay(tool.folder / "tap", tool.folder / "client", tool.folder / "drive")
        listener = tool.listen(f"tap {device} --log capture {PATIENT}")
        read = talk(tool, device, registers, change)
        until(lambda: sum(len(bytes.fromhex(frame[1:])) for frame in tool.captured()) == tap.carried)
        tool.ends(listener, signal.SIGINT)
        tool.out_has(f"listen beside a client of {device}: nothing is damaged",
                     " bad_crc=0 incomplete=0 noise=0 damaged_bytes=0")
        paired = re.search(r"^# node=1 requests=([0-9]+) responses=\1 .* unpaired=0 ", tool.last.out, re.M)
        tool.check("every request has its response", paired)
        tool.out_has("or has none", "# node=7 requests=2 responses=0 exceptions=0 no_response=2 damaged=0 unpaired=0")
        missing = [line for line in read if not is_heard(line, tool.last.out)]
        tool.check("what the client reads is what is heard", read and not missing, f"{read}\nmissing: {missing}")
        tool.explains_the_same("explain says the same", device, "with status 0")
        tool.nothing_is_sent("nothing is sent", tap)


def has_one_end_each(out: str) -> bool:
    """Each request of each node has one end, but for one at most that still waits."""
    waiting = []
    for line in re.findall("^# node=.*", out, re.M):
        of = {name: int(value) for name, value in re.findall(r"([a-z_]+)=([0-9]+)(?= |$)", line)}
        ends = of["responses"] + of["exceptions"] + of["no_response"] + of["damaged"]
        waiting.append(of["requests"] - ends)
    return bool(waiting) and min(waiting) >= 0 and sum(waiting) <= 1


@scene()
def line_with_faults(tool: Listening):
    """The counters of requests and of their ends agree."""
    with tool.simulated("zlac8015d --faults late,lossy,noisy,doubled,cut --seed 3"):
        tap = TappedLine.relay(tool.folder / "tap", tool.folder / "client", tool.folder / "drive")
        listener = tool.listen("tap zlac8015d --log capture")
        words = "watch client zlac8015d bus_voltage status_word --count 40 --interval 5 --timeout 120 --retries 0"
        tool.start(words).wait()
        tool.ends(listener, signal.SIGINT)
        tool.status_is("listen to a line with faults: status 0", 0)
        tool.check("each request has one end", has_one_end_each(tool.last.out))
        tool.check("there was something damaged", "damaged_bytes=0" not in tool.last.out)
        tool.explains_the_same("explain says the same", "zlac8015d")
        tool.nothing_is_sent("nothing is sent", tap)


@scene()
def one_that_sends(tool: Listening):
    """The check of what is sent can fail: a program that does send has the same port."""
    tap = TappedLine.at(tool.folder / "tap")
    tool.run("read tap zlac8015d bus_voltage --retries 0 --timeout 20")
    tool.is_equal("a client on the tap is found out", tap.close(), 8)


play_tool(Listening)
