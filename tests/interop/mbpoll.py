# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""mbpoll at the simulated drive of the tool.    mbpoll.py TOOL"""
import re
import sys

from peers import ask, begin_drive, folder, need_peer
from checks import finish, run, same

tool, = sys.argv[1:]
drive = folder / "drive"


def poll(*options, node=1, wait=5, values=()):
    """Polls the drive: the status and the output of mbpoll."""
    return run("mbpoll", "-m", "rtu", "-b", "115200", "-P", "none", "-0", "-1", "-o", wait, "-a", node, *options, drive,
               *values)


def polled(address, count):
    said = poll("-r", address, "-c", count).stdout
    return [int(value) for value in re.findall(r"^\[\d+\]:\s*(\S+)", said, re.M)]


def has_words(words, said):
    return len(re.findall(words, said.stdout, re.I))


need_peer("mbpoll", "mbpoll")
begin_drive(tool, "zlac8015d", drive)
same("mbpoll reads a register", [1000], polled(8192, 1))
same("mbpoll reads two registers", polled(8320, 1) + polled(8321, 1), polled(8320, 2))
same("mbpoll writes a register", 0, poll("-r", 8320, values=[700]).returncode)
same("the tool reads what mbpoll wrote", "left_acceleration_time=700 ms\n",
     ask(tool, "read", drive, "zlac8015d", "left_acceleration_time").stdout)
same("mbpoll writes two registers", 0, poll("-r", 8320, values=[300, 400]).returncode)
same("mbpoll reads what it wrote", [300, 400], polled(8320, 2))
ask(tool, "write", drive, "zlac8015d", "left_acceleration_time=900")
same("mbpoll reads what the tool wrote", [900], polled(8320, 1))
same("mbpoll gets the exception for a register that does not exist", 1,
     has_words("illegal data address", poll("-r", 4096, "-c", 1)))
same("mbpoll gets the exception for coils", 1, has_words("illegal function", poll("-t", 0, "-r", 1, "-c", 1)))
same("mbpoll gets no response from a node that does not exist", 1,
     has_words("timed out", poll("-r", 8192, "-c", 1, node=2, wait=0.3)))
finish()
