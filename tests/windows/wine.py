# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Wine, and serial ports in it: COM ports are pseudo-terminals of this machine.

Wine cannot show: the removal of a real adapter, RTS and the parity of a real UART, the echo of a real bus, two programs
on one port (a file stands for it), Ctrl-Break and the end of a console.
"""
import atexit
import os
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import begin, check, expect, must, need, run, text_of, until

SETTINGS = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree=;mshtml="}


def install_windows(prefix):
    """Makes an installation of Windows for all tests; it has 700 MB."""
    for program in ("wine", "wineserver", "socat"):
        need(program, "wine64", "wine", "socat")
    prefix.mkdir()
    os.environ.update(SETTINGS, WINEPREFIX=str(prefix))
    with open(prefix / "installed", "wb") as said:  # no pipe: see begin_wine
        done = subprocess.run(["wineboot", "-i"], stdout=said, stderr=said)
    expect(done.returncode == 0, text_of(prefix / "installed"))
    must("wineserver", "-w")


def begin_wine(folder, installed):
    """Wine with registry and ports of its own in the folder. Its server runs until the program ends."""
    prefix = folder / "wine"
    (prefix / "dosdevices").mkdir(parents=True)
    for file in (".update-timestamp", "system.reg", "user.reg", "userdef.reg"):
        shutil.copy(installed / file, prefix)
    (prefix / "drive_c").symlink_to(installed.resolve() / "drive_c")
    (prefix / "dosdevices/c:").symlink_to("../drive_c")
    (prefix / "dosdevices/z:").symlink_to("/")
    os.environ.update(SETTINGS, WINEPREFIX=str(prefix))
    atexit.register(subprocess.run, ["wineserver", "-k"], stderr=subprocess.DEVNULL)
    # It lists all that it has, on its standard error, when a terminal that it has opened hangs up.
    subprocess.run(["wineserver", "-p"], stderr=subprocess.DEVNULL)
    # Windows' services begin with the first program and keep its output open, so that is none that a check reads.
    subprocess.run(["wineboot"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def com(number, path):
    """The COM port of this number is the terminal at the path, from now on."""
    link = Path(os.environ["WINEPREFIX"]) / f"dosdevices/com{number}"
    link.unlink(missing_ok=True)
    link.symlink_to(path)


def begin_drive(tool, link):
    """A simulated drive at a pseudo-terminal."""
    drive = begin(tool, "sim", "zlac8015d", "--link", link)
    until(link.exists, drive, "the simulated drive")
    return drive


def built(name, *command):
    """Builds a program for a test, which cannot go on without it."""
    if not check(name, must, *command):
        sys.exit(1)


def in_wine(*command, **more):
    """A program's status and output, with this machine's line ends."""
    done = run("wine", *command, apart=True, **more)
    done.stdout = done.stdout.replace("\r", "")
    return done
