# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The wheel program asks for consent before it moves a real machine, and stops it on a signal and on every error."""
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from job import Job, asks_first, drive_dies, play_job
from programs import scene

DEVICE = "zlac8015d"


@scene()
def consent(job: Job):
    no_port = asks_first(job, DEVICE, "mode_of_operation", "undefined (0x0000)")
    job.is_equal("S8: with the system's reason", no_port.out + no_port.err,
                 "wheels: cannot open /nowhere/at/all: No such file or directory\n")


@scene()
def whole_job(job: Job):
    with job.simulated(DEVICE) as drive:
        job.ends(job.begin(drive))
        job.status_is("the whole job", 0)
        # Whether a sign is forward depends on how the motors are mounted, and a fraction of a turn on the encoder.
        claims = re.findall("on the spot|forward|half a turn|quarter", job.last.out + job.last.err)
        job.check("no direction of a robot and no fraction of a turn is claimed", not claims, claims)


@scene(signal.SIGINT, signal.SIGTERM)
def interruption(job: Job, number: signal.Signals):
    with job.moving(DEVICE, "turning") as (_, program):
        job.interrupted(f"S8: {number.name} while the wheels turn ends it with an error", program, number)
        job.is_value(f"S8: {number.name} leaves the drive stopped and released",
                     *(DEVICE, "status_word", "left_released+right_released (0x0000)"))


@scene()
def dead_drive(job: Job):
    drive_dies(job, DEVICE, "turning")


play_job()
