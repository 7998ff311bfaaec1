# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The robot program asks for consent before it moves a real machine, says where the robot is, and stops it on a signal."""
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from job import Job, asks_first, play_job
from programs import scene, until

DEVICE = "zlac8015d"
RELEASED = "left_released+right_released (0x0000)"


@scene()
def consent(job: Job):
    asks_first(job, DEVICE, "mode_of_operation", "undefined (0x0000)")


@scene(signal.SIGINT, signal.SIGTERM)
def interruption(job: Job, number: signal.Signals):
    with job.simulated(DEVICE) as drive:
        program = job.begin(drive)
        new = until(lambda: "Switch the drive off and on" in program.out)
        job.check("a new drive is to be switched off and on", new, program.out)
        drive.send(signal.SIGUSR2)
        moved = until(lambda: re.search(r"^x [1-9]\d+ mm, y .*urad$", program.out, re.M))
        job.check("it says where the robot is, and that the pose is continuous", moved, program.out)
        job.ends(program, number)
        job.status_is(f"S8: {number.name} ends it", 0)
        job.is_value(f"S8: {number.name} leaves the drive stopped and released", DEVICE, "status_word", RELEASED)


@scene()
def port_returns(job: Job):
    with job.simulated(DEVICE) as drive:
        program = job.begin(drive)
        new = until(lambda: "Switch the drive off and on" in program.out)
        job.check("a new drive is to be switched off and on", new, program.out)
        drive.send(signal.SIGUSR2)
        moved = until(lambda: re.search(r"^x [1-9]\d+ mm", program.out, re.M))
        job.check("it moves", moved, program.out)
        drive.stop(signal.SIGKILL)
        gone = until(lambda: "port: the port is gone" in program.out)
        job.check("G47: it says that its port is gone, and goes on", gone and program.process.poll() is None, program.out)
    with job.simulated(DEVICE):
        back = until(lambda: program.out.count("port: ok") == 2)
        job.check("G47: it opens the port again", back, program.out)
        taken = until(lambda: program.out.count("Switch the drive off and on") == 2)
        job.check("and takes the drive over, which is another new one", taken, program.out)
        job.ends(program, signal.SIGINT)
        job.is_value("G44: without another consent nothing was enabled", DEVICE, "status_word", RELEASED)


play_job()
