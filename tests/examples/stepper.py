# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The stepper program does its job on a simulated drive.

It asks for consent before it moves a real machine, and stops it on a signal and on every error.
"""
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from job import Job, asks_first, drive_dies, play_job
from programs import scene, until

DEVICE = "yako-closed-loop"
CREEP = 250  # pulses: the way of one bounded jog
SCALE = "r/min (at the factory's scale)"


def is_moving(job: Job) -> bool:
    return "moving" in job.value(DEVICE, "status_word")


def position(job: Job) -> int:
    return int(job.value(DEVICE, "actual_position").split()[0])


def stands(job: Job, name: str):
    word = job.value(DEVICE, "status_word")
    job.check(name, word and "moving" not in word, word)


@scene()
def consent(job: Job):
    asks_first(job, DEVICE, "positioning_speed", f"60 {SCALE}")


@scene()
def whole_job(job: Job):
    with job.simulated(DEVICE) as drive:
        job.doctor_says("doctor refuses nothing", DEVICE, 0)
        job.ends(job.begin(drive))
        job.status_is("it homes, positions, creeps and stops", 0)
        job.check("and says that the axis is at rest", job.last.out.count("the axis is at rest") == 1)
        job.is_equal("at zero, where it homed", position(job), 0)
        job.is_value("30 r/min at most", DEVICE, "positioning_speed", f"30 {SCALE}")


@scene(signal.SIGINT, signal.SIGTERM)
def interruption(job: Job, number: signal.Signals):
    with job.moving(DEVICE, "positioning") as (_, program):
        job.interrupted(f"S8: {number.name} while the axis moves ends it with an error", program, number)
        stands(job, f"S8: {number.name} leaves the axis standing")


@scene()
def interrupted_homing(job: Job):
    with job.simulated(DEVICE) as drive:
        program = job.begin(drive)
        until(lambda: "homing" in program.out)
        job.interrupted("S8: SIGINT does not wait for the end of a homing", program, signal.SIGINT)
        job.check("S8: it does not say that it is homed", "homed" not in job.last.out)
        stands(job, "S8: and leaves the axis standing")


@scene()
def killed_creep(job: Job):
    with job.moving(DEVICE, "creeping") as (_, program):
        program.stop(signal.SIGKILL)
        begin = position(job)
        is_at_rest = until(lambda: not is_moving(job))
        way = position(job) - begin
        job.check("S4: a creep ends by itself when its program is killed", is_at_rest and way <= CREEP, way)


@scene()
def dead_drive(job: Job):
    drive_dies(job, DEVICE, "positioning")


play_job()
