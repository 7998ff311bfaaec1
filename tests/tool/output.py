# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Standard output that cannot be written, standard input that cannot be read, and standard descriptors that are closed
when the tool starts.
"""
import os
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Ended, Running, Tool, broken_pipe, play_tool, scene, until

# A full disk, a closed descriptor, a pipe whose reader has gone; and what the system says of it.
SINKS = {"full": "No space left on device", "closed": "Bad file descriptor", "gone": "Broken pipe"}
GONE = broken_pipe()
NO_RESPONSE = "--timeout 20 --retries 0"


def into(tool: Tool, sink: str, words: str, **how) -> Ended:
    """Runs the tool with one of the sinks as standard output."""
    if sink == "closed":
        return tool.run(words, sh='exec "$@" >&-', **how)
    if sink == "full":
        with open("/dev/full", "wb") as full:
            return tool.run(words, out=full, **how)
    return tool.run(words, out=GONE, **how)


def is_lost(tool: Tool, name: str, sink: str):
    """Status 1, and one line of complaint about the output, with the reason."""
    complaints = [line for line in tool.last.err_lines if "cannot write standard output" in line]
    tool.check(name, tool.last.status == 1 and len(complaints) == 1 and SINKS[sink] in tool.last.err)


def lost(tool: Tool, what: str, words: str):
    for sink in SINKS:
        into(tool, sink, words)
        is_lost(tool, f"{what}, output {sink}", sink)


@scene()
def without_a_drive(tool: Tool):
    for what, words in [
        ("--help", "--help"),
        ("map", "map c630s"),
        ("alarms", "alarms c630s"),
        ("sim, whose path is not known", "sim zlac8015d"),
    ]:
        lost(tool, what, words)
    tool.check("which says nothing else", len(tool.last.err_lines) == 1)
    lost(tool, "sim with a link", "sim zlac8015d --link other")
    tool.check("and leaves none", not tool.exists("other"))


@scene("> 01 03 20 AB 00 02 BE 2B", "not a frame")
def explain(tool: Tool, frame: str):
    """Reads frames in a file."""
    tool.write("frames", frame + "\n")
    for sink in SINKS:
        with open(tool.folder / "frames") as frames:
            into(tool, sink, "explain zlac8015d", stdin=frames)
        is_lost(tool, f"explain '{frame}', output {sink}", sink)


@scene()
def explain_without_end(tool: Tool):
    """Reads a capture that continues."""
    with open("/dev/full", "wb") as full:
        tool.run("explain zlac8015d", out=full, sh='yes "01 06 20 0E 00 08 E2 0F" 2>/dev/null | "$@"')
    is_lost(tool, "explain ends with its output, not with its input", "full")


@scene()
def standard_input(tool: Tool):
    words = "explain zlac8015d"
    folder = os.open(tool.folder, os.O_RDONLY)
    tool.run(words, stdin=folder)
    os.close(folder)
    tool.status_is("explain: a folder is no input", 1)
    tool.err_has("and it says so", "cannot read standard input: Is a directory")
    tool.check("in one line", len(tool.last.err_lines) == 1)
    tool.run(words, sh='exec "$@" <&-')
    tool.status_is("explain: nor is a closed descriptor", 1)
    tool.err_has("and it says so", "cannot read standard input: Bad file descriptor")
    tool.exits("explain: an empty input is one", words, 0)
    tool.check("and says nothing", tool.last.err == "")
    tool.run(words, stdin="01 06 20 0E 00 08 E2 0F")
    tool.check("explain: a last line without its end is a line", len(tool.last.lines) == 1)
    tool.status_is("and no error", 0)


@scene(
    ("read", "read drive zlac8015d bus_voltage"),
    ("watch", "watch drive zlac8015d bus_voltage --count 2 --interval 10"),
    ("an endless watch", "watch drive zlac8015d bus_voltage --interval 10"),
    ("scan", "scan drive --baud 115200 --format 8N1 --nodes 1-2"),
    ("backup without a file", "backup drive zlac8015d"),
)
def with_a_drive(tool: Tool, what: str, words: str):
    with tool.simulated("zlac8015d"):
        lost(tool, what, words)


@scene(*SINKS)
def writes(tool: Tool, sink: str):
    def holds(name: str, register: str, value: str):
        found = tool.start(f"read drive zlac8015d {register}").wait().lines
        tool.is_equal(name, found, [f"{register}={value}"])

    with tool.simulated("zlac8015d"):
        tool.run("backup drive zlac8015d good")
        tool.run("write drive zlac8015d left_max_current=30 right_max_current=30")
        into(tool, sink, "write drive zlac8015d left_max_current=12.5")
        is_lost(tool, f"write, output {sink}", sink)
        tool.err_has("and that it is written", "; 1 of 1 written")
        holds("as it is", "left_max_current", "12.5 A")
        into(tool, sink, "write drive zlac8015d left_max_current=11 right_max_current=11")
        is_lost(tool, "several writes end with the output", sink)
        tool.err_has("and say where", "; 1 of 2 written")
        holds("the first is written", "left_max_current", "11.0 A")
        holds("the other is not", "right_max_current", "30.0 A")
        tool.run("write drive zlac8015d right_max_current=11")
        into(tool, sink, "restore drive zlac8015d good --dry-run")
        is_lost(tool, f"restore --dry-run, output {sink}", sink)
        into(tool, sink, "restore drive zlac8015d good --yes")
        is_lost(tool, f"restore, output {sink}", sink)
        tool.err_has("ends too", "; 1 of 2 written, not: right_max_current")
        holds("where it says", "right_max_current", "11.0 A")
        into(tool, sink, f"restore drive zlac8015d:9 good {NO_RESPONSE}")
        tool.err_has("what prints nothing fails for its own reason", "no response")
        tool.err_lacks("and for no other", "standard output")
        into(tool, sink, "backup drive zlac8015d again")
        tool.status_is("a backup into a file needs no output", 0)


# No port or file that is opened later gets the numbers 0, 1 or 2.


@scene()
def all_closed(tool: Tool):
    with tool.simulated("zlac8015d"):
        tool.run("backup drive zlac8015d good")
        tool.run("backup drive zlac8015d again", sh='exec "$@" <&- >&- 2>&-')
        tool.status_is("a backup with all three closed", 0)
        tool.check("is that with all three open", tool.read("again") == tool.read("good"))


def descriptors(of: Running) -> dict[int, str]:
    """Where the descriptors of a program point."""
    found = {}
    for one in Path(f"/proc/{of.pid}/fd").iterdir():
        try:
            found[int(one.name)] = os.readlink(one)
        except OSError:  # it is closed meanwhile
            pass
    return found


def is_a_port(place: str) -> bool:
    return place.startswith("/dev/pts/")


def is_open_and_no_port(of: Running, number: int) -> bool:
    place = descriptors(of).get(number, "")
    return place != "" and not is_a_port(place)


@scene(1, 2)
def one_closed(tool: Tool, number: int):
    """A write has its port open while it waits for consent."""
    with tool.simulated("zlac8015d"):
        reads, writes = os.pipe()
        user = tool.start("write drive zlac8015d left_target_speed=5", stdin=reads, sh=f'exec "$@" {number}>&-')
        os.close(reads)
        is_there = until(lambda: any(map(is_a_port, descriptors(user).values())))
        tool.check(f"descriptor {number} closed: the port is open", is_there)
        tool.check(f"descriptor {number} closed: it is no port", is_open_and_no_port(user, number))
        os.write(writes, b"no\n")
        tool.ends(user)
        os.close(writes)
        tool.status_is(f"descriptor {number} closed: not confirmed", 1)


@scene()
def input_closed(tool: Tool):
    with tool.simulated("zlac8015d"):
        user = tool.start("watch drive zlac8015d bus_voltage --interval 10", sh='exec "$@" <&-')
        tool.check("input closed: watch needs none", until(lambda: user.out))
        tool.check("descriptor 0 is no port", is_open_and_no_port(user, 0))
        tool.ends(user, signal.SIGINT)
        tool.status_is("and ends at an interrupt with status 0", 0)


play_tool()
