# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The program of the cell asks for consent before it moves anything, says what does not respond, and asks again."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from job import Job, play_job
from programs import scene

DEVICE = "zlac8015d"


@scene()
def consent(job: Job):
    job.job()
    job.status_is("S8: without a port it says how to call it", 2)
    job.job("/nowhere/at/all", stdin="MOVE\n")
    job.status_is("S8: a port that is not there is an error", 1)
    job.check("and it says which", "no such port" in job.last.err, job.last.err)
    with job.simulated(DEVICE):
        job.job("drive", stdin="no\n")
        job.status_is("S8: without the typed consent nothing happens", 2)
        job.check("S8: and it says so", job.last.out.count("Nothing was sent") == 1)
        job.is_value("S8: the drive was not touched", DEVICE, "mode_of_operation", "undefined (0x0000)")


@scene()
def a_drive_is_missing(job: Job):
    with job.simulated(DEVICE):
        job.job("drive", stdin="MOVE\nMOVE\nno\n")
        job.status_is("what is not at rest for sure is an error", 1)
        job.check("it says what does not respond", job.last.out.count("lift no response") == 2, job.last.out)
        job.check("each attempt needs a consent", job.last.out.count("Type MOVE") == 3, job.last.out)
        job.is_value("S1: the wheels were not enabled", DEVICE, "mode_of_operation", "undefined (0x0000)")


play_job()
