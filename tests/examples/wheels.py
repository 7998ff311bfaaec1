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
    job.is_equal("S8: with the reason", no_port.out + no_port.err,
                 "wheels: cannot open /nowhere/at/all: there is no such port\n")


@scene()
def whole_job(job: Job):
    with job.simulated(DEVICE) as drive:
        job.doctor_says("doctor refuses nothing", DEVICE, 0)
        job.ends(job.begin(drive))
        job.status_is("the whole job", 0)
        # Whether a sign is forward depends on how the motors are mounted, and a fraction of a turn on the encoder.
        claims = re.findall("on the spot|forward|half a turn|quarter", job.last.out + job.last.err)
        job.check("no direction of a robot and no fraction of a turn is claimed", not claims, claims)


@scene("input_polarity=x0", "input_polarity=x1 x1_function=9")
def refused_as_doctor_says(job: Job, write: str):
    """An emergency stop is active."""
    with job.simulated(DEVICE) as drive:
        job.run(f"write drive {DEVICE} {write}")
        job.doctor_says("doctor refuses an enable", DEVICE, 1)
        job.ends(job.begin(drive))
        job.status_is("and the program cannot enable the drive", 1)
        job.err_has("as its error says", "the expected state was not reached")


@scene()
def lossy_line(job: Job):
    """What may be repeated is repeated; another end names its step."""
    with job.simulated(f"{DEVICE} --faults lossy --seed 3") as drive:
        job.ends(job.begin(drive))
        has_ended_well = job.last.status == 0 and "both wheels at rest" in job.last.out
        names_step = job.last.status == 1 and re.search(r"^wheels: [a-z ]{8,}: [a-z ]+$", job.last.err, re.M)
        job.check("a line that loses frames", has_ended_well or names_step, job.found())


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
