# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""An example program that moves a simulated drive: it asks for consent, and stops the drive on every way out (S8)."""
import os
import re
import signal
import sys
from contextlib import contextmanager

from programs import Running, Tool, play_tool, until


class Job(Tool):
    """The stage of an example program, the second word of the command line."""

    def job(self, words: str = "", **how):
        return self.run(words, program=[os.path.abspath(sys.argv[2])], **how)

    def begin(self, drive: Running) -> Running:
        return self.start(f"drive --simulator {drive.pid}", program=[os.path.abspath(sys.argv[2])])

    @contextmanager
    def moving(self, device: str, words: str):
        """The drive and the program, which has said the words and then shown a speed other than 0."""
        speed = re.compile(re.escape(words) + r".*[1-9]\d*\.\d r/min", re.S)
        with self.simulated(device) as drive:
            program = self.begin(drive)
            is_moving = until(lambda: speed.search(program.out) or program.process.poll() is not None)
            if not is_moving or program.process.poll() is not None:
                self.check(f"the drive moves after {words}", False, program.out + program.err)
            yield drive, program
            if program.process.poll() is None:
                program.stop(signal.SIGKILL)

    def value(self, device: str, register: str) -> str:
        """What another program reads from the drive."""
        return self.start(f"read drive {device} {register}").wait().out.strip().partition("=")[2]

    def is_value(self, name: str, device: str, register: str, expected: str):
        self.is_equal(name, self.value(device, register), expected)

    def doctor_says(self, name: str, device: str, status: int):
        """What `servobus doctor` judges of the drive, before or after the program enables it."""
        self.is_equal(name, self.start(f"doctor drive {device} --yes").wait().status, status)

    def interrupted(self, name: str, program: Running, number: int):
        self.ends(program, number)
        self.status_is(name, 1)


def asks_first(job: Job, device: str, register: str, untouched: str):
    with job.simulated(device):
        job.job()
        job.status_is("S8: without a port it says how to call it", 2)
        job.job("/nowhere/at/all --simulator 1")
        job.status_is("S8: a port that is not there is an error", 1)
        no_port = job.last
        job.job("drive", stdin="no\n")
        job.status_is("S8: without the typed consent nothing happens", 2)
        job.check("S8: and it says so", job.last.out.count("Nothing was sent") == 1)
        job.is_value("S8: the drive was not touched", device, register, untouched)
    return no_port


def drive_dies(job: Job, device: str, words: str):
    with job.moving(device, words) as (drive, program):
        drive.stop(signal.SIGKILL)
        job.ends(program)
        job.status_is("S8: a drive that dies under it ends it with an error", 1)
        job.check("S8: a stop that no one confirmed is said", job.last.err.count("stop was not confirmed") == 1)


def play_job():
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} PATH-TO-SERVOBUS PATH-TO-THE-PROGRAM")
    play_tool(Job)
