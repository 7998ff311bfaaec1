# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The command-line tool and other programs, as tests run them: their output, their errors and their status.

The words of a command are one string, split at blanks, or a list. A program runs in the folder of its scene, so that
files and drives have short names there.
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from scenes import PATIENCE, Checks, play, scene, until

__all__ = ["Ended", "Running", "Tool", "broken_pipe", "patient", "play_tool", "scene", "until"]


def lines_of(text: str) -> list[str]:
    """Ends of lines are \\n alone, and the last line may lack its own."""
    return text.removesuffix("\n").split("\n") if text else []


@dataclass
class Ended:
    """A program that has ended. The status is negative if a signal ended it."""

    status: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        return lines_of(self.out)

    @property
    def err_lines(self) -> list[str]:
        return lines_of(self.err)


class Running:
    """A program that runs. Its output and errors can be read meanwhile."""

    all: set["Running"] = set()

    def __init__(self, command: list[str], folder: Path, *, stdin=None, out=None, err=None, sh="", env=None):
        """`stdin`: text, or a file; nothing if not given. `out`, `err`: a file instead of what `out` and `err` show.

        `sh`: a script that runs the command as "$@", to close descriptors or to set limits.
        """
        self.out_file, self.err_file = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        self.folder = folder
        own_stdin = piped(stdin) if isinstance(stdin, str) else None
        try:
            self.process = subprocess.Popen(["sh", "-c", sh, "sh", *command] if sh else command, cwd=folder,
                                            stdin=own_stdin or (subprocess.DEVNULL if stdin is None else stdin),
                                            stdout=out or self.out_file, stderr=err or self.err_file,
                                            env={**os.environ, **(env or {})})
        finally:
            if own_stdin is not None:
                os.close(own_stdin)
        self.all.add(self)

    @property
    def out(self) -> str:
        return content(self.out_file)

    @property
    def err(self) -> str:
        return content(self.err_file)

    @property
    def pid(self) -> int:
        return self.process.pid

    def send(self, number: int):
        self.process.send_signal(number)

    def wait(self) -> Ended:
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.all.discard(self)
        return Ended(self.process.returncode, self.out, self.err)

    def stop(self, number: int = signal.SIGTERM) -> Ended:
        self.send(number)
        return self.wait()


def broken_pipe() -> int:
    """The end of a pipe whose reader has gone. Called before scenes start programs, which may hold it for a moment."""
    reads, writes = os.pipe()
    os.close(reads)
    return writes


def content(file) -> str:
    return os.pread(file.fileno(), 1 << 24, 0).decode(errors="replace")


def piped(text: str) -> int:
    """The end of a pipe that has the text, which must be shorter than a pipe's buffer."""
    reads, writes = os.pipe()
    os.write(writes, text.encode())
    os.close(writes)
    return reads


# Milliseconds that the tool waits for a response, unless a test says how long: longer than a drive takes, since a busy
# machine is no drive that does not respond. A scan asks many addresses that no drive has.
PATIENT = {"scan": "500", "read": "2000", "write": "2000", "send": "2000", "watch": "2000", "backup": "2000", "restore": "2000",
           "doctor": "2000"}


def patient(words: list[str]) -> list[str]:
    is_at_a_drive = len(words) > 2 and words[0] in PATIENT and words[1].endswith(("drive", "client"))
    if not is_at_a_drive or any(word.startswith("--timeout") for word in words):
        return words
    return [*words, "--timeout", PATIENT[words[0]]]


class Tool(Checks):
    """The tool on the stage of a scene: a folder that is removed, and simulated drives that are stopped, at its end."""

    path = ""
    folders: list[Path] = []

    def __init__(self):
        super().__init__()
        self.last = Ended(0, "", "")

    def __enter__(self):
        self.folder = Path(tempfile.mkdtemp())
        self.folders.append(self.folder)
        return self

    def __exit__(self, *_):
        for one in [one for one in Running.all.copy() if one.folder == self.folder]:
            one.stop(signal.SIGKILL)
        shutil.rmtree(self.folder, ignore_errors=True)

    def found(self) -> str:
        """The errors first: only so many lines are shown, and they say why."""
        return f"status {self.last.status}\n{self.last.err[:2000]}\n{self.last.out[:2000]}"

    # Programs

    def start(self, words: str | list[str], *, program: list[str] | None = None, **how) -> Running:
        """Starts the tool, or `program`, with these words after it."""
        words = words.split() if isinstance(words, str) else words
        return Running((program or [self.path]) + patient(words), self.folder, **how)

    def run(self, words: str | list[str], **how) -> Ended:
        self.last = self.start(words, **how).wait()
        return self.last

    def ends(self, running: Running, number: int | None = None) -> Ended:
        """Waits for the end of a program, which a signal may ask for."""
        self.last = running.wait() if number is None else running.stop(number)
        return self.last

    @contextmanager
    def simulated(self, words: str, *, named: str = "", link: str = "drive", **how):
        """A simulated drive at `link`. With a name its start is a check."""
        drive = self.start(f"sim {words} --link {link}", **how)
        try:
            is_there = until(lambda: drive.process.poll() is not None or (drive.out and (self.folder / link).exists()))
            is_there = is_there and drive.process.poll() is None
            if named or not is_there:
                self.check(named or f"sim {words} starts", is_there, drive.err)
            yield drive
        finally:
            if drive.process.returncode is None:
                drive.stop()

    # Checks of a run

    def says(self, name: str, words: str | list[str], *lines: str):
        """The tool succeeds and prints these lines."""
        ended = self.run(words)
        self.check(name, ended.status == 0 and ended.lines == list(lines))

    def fails(self, name: str, words: str | list[str], status: int, text: str):
        """The tool fails with this status and prints one line of complaint alone, which has the text."""
        ended = self.run(words)
        is_so = ended.status == status and text in ended.err and len(ended.err_lines) == 1 and ended.out == ""
        self.check(name, is_so, f"expected {status}: {text}\n{self.found()}")

    def exits(self, name: str, words: str | list[str], status: int):
        self.check(name, self.run(words).status == status)

    def status_is(self, name: str, status: int):
        self.check(name, self.last.status == status)

    def out_is(self, name: str, *lines: str):
        self.check(name, self.last.lines == list(lines), "\n".join(["expected", *lines, "found", self.last.out]))

    def out_has(self, name: str, text: str):
        self.check(name, text in self.last.out)

    def err_has(self, name: str, text: str):
        self.check(name, text in self.last.err, f"expected {text}\n{self.found()}")

    def err_lacks(self, name: str, text: str):
        self.check(name, text not in self.last.err)

    # Files in the folder

    def read(self, name: str) -> str:
        return (self.folder / name).read_bytes().decode(errors="replace")

    def write(self, name: str, text: str):
        (self.folder / name).write_bytes(text.encode())

    def lines(self, name: str) -> list[str]:
        return lines_of(self.read(name))

    def exists(self, name: str) -> bool:
        return os.path.lexists(self.folder / name)


def end_all(*_):
    """Leaves no program and no folder behind when the test itself is ended."""
    for one in Running.all.copy():
        one.process.kill()
    for folder in Tool.folders:
        shutil.rmtree(folder, ignore_errors=True)
    os._exit(2)


def play_tool(stage=Tool):
    """Plays the scenes of a part with the programs of the command line: the tool, and the one that a stage drives."""
    if len(sys.argv) < 2:
        sys.exit(f"usage: {sys.argv[0]} PATH-TO-SERVOBUS [PROGRAM]")
    signal.signal(signal.SIGINT, end_all)
    signal.signal(signal.SIGTERM, end_all)
    Tool.path = os.path.abspath(sys.argv[1])
    play(stage)
