# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The servo program asks for consent before it moves a real machine, and stops it on a signal and on every error."""
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from job import Job, asks_first, drive_dies, play_job
from programs import scene

DEVICE = "c630s"
SERVO_OFF = "vdi16 (0x8000)"


@scene()
def consent(job: Job):
    asks_first(job, DEVICE, "target_speed", "200 r/min")


@scene()
def whole_job(job: Job):
    with job.simulated(DEVICE) as drive:
        job.doctor_says("doctor refuses a drive that is not set up", DEVICE, 1)
        job.ends(job.begin(drive))
        job.status_is("the program runs to its end", 0)
        ends = re.findall(r"^.*  0\.0 r/min *10000 units.*$", job.last.out, re.M)
        job.check("a turn forward ends on its target", len(ends) == 1)
        job.check("the motor is at rest", job.last.out.count("the motor is at rest") == 1)
        job.is_value("G17: writes are not kept any more", DEVICE, "eeprom_update", "off (0x0000)")
        job.is_value("servo off", DEVICE, "virtual_input_levels", SERVO_OFF)
        job.doctor_says("doctor refuses nothing once it is set up", DEVICE, 0)


@scene(signal.SIGINT, signal.SIGTERM)
def interruption(job: Job, number: signal.Signals):
    with job.moving(DEVICE, "turning") as (_, program):
        job.interrupted(f"S8: {number.name} while the motor turns ends it with an error", program, number)
        job.is_value(f"S8: {number.name} leaves the servo off", DEVICE, "virtual_input_levels", SERVO_OFF)
        job.is_value(f"S8: {number.name} leaves the motor standing", DEVICE, "actual_speed", "0 r/min")


@scene()
def dead_drive(job: Job):
    drive_dies(job, DEVICE, "turning")


play_job()
