# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""mbpoll at the simulated drive of the tool, and at a server of rows with all four tables.    mbpoll.py TOOL"""
import re
import sys

from peers import ask, begin_drive, build, folder, need_peer
from checks import begin, finish, run, same, until

tool, = sys.argv[1:]
drive = folder / "drive"


def poll(*options, node=1, wait=5, values=(), at=drive):
    """Polls the drive: the status and the output of mbpoll."""
    return run("mbpoll", "-m", "rtu", "-b", "115200", "-P", "none", "-0", "-1", "-o", wait, "-a", node, *options, at,
               *values)


def read_from(said):
    return [int(value) for value in re.findall(r"^\[\d+\]:\s*(\S+)", said.stdout, re.M)]


def polled(address, count):
    return read_from(poll("-r", address, "-c", count))


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

rows = folder / "rows"
server = begin(build("row_server", "-I."), rows)
until(rows.exists, server, "the server of rows")


def poll_rows(*options, values=()):
    return poll(*options, node=17, values=values, at=rows)


same("mbpoll reads twelve rows", [0, 0, 500, 0, 0, 100, 0, 0, 65534, 31072, 0, 0],
     read_from(poll_rows("-r", 0, "-c", 12)))
same("mbpoll reads a pair", [-100000], read_from(poll_rows("-t", "4:int", "-B", "-r", 8, "-c", 1)))
same("mbpoll reads input registers", [25, 2400], read_from(poll_rows("-t", 3, "-r", 0, "-c", 2)))
same("mbpoll writes coils", 0, poll_rows("-t", 0, "-r", 0, values=[1, 0, 1, 1]).returncode)
same("mbpoll writes a coil", 0, poll_rows("-t", 0, "-r", 3, values=[0]).returncode)
same("mbpoll reads coils", [1, 0, 1, 0], read_from(poll_rows("-t", 0, "-r", 0, "-c", 4)))
same("mbpoll writes two rows", 0, poll_rows("-r", 1, values=[30, 100]).returncode)
same("mbpoll reads them", [30, 100], read_from(poll_rows("-r", 1, "-c", 2)))
same("mbpoll gets the exception for a value out of range", 1,
     has_words("illegal data value", poll_rows("-r", 5, values=[300])))
same("mbpoll gets the exception for a row that does not exist", 1,
     has_words("illegal data address", poll_rows("-r", 12, "-c", 1)))
same("mbpoll gets the exception for discrete inputs", 1,
     has_words("illegal function", poll_rows("-t", 1, "-r", 0, "-c", 1)))
finish()
