#!/usr/bin/env python3
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Plays the command-line tool for its tests: $SERVOBUS_EXE on wine. The simulated drives are those of $SERVOBUS.

A terminal among the arguments becomes COM20.

A response passes through wine's server, which on a busy machine takes longer than the limit of a drive. So reads and
writes at a port wait two seconds, unless the test says how long.

Once in some thousand times wine ends a program before it begins. The tool never fails without a word, so a failure
without one is wine's, and the program runs again. Not what runs until it is interrupted.
"""
import os
import stat
import subprocess
import sys
from pathlib import Path

AT_A_PORT = ("read", "write", "watch", "backup", "restore")
RUNS_ON = ("watch", "listen", "restore")


def again(why):
    """Notes that something ran again, and why."""
    with open(os.environ["SERVOBUS_AGAIN"], "a", encoding="utf-8") as notes:
        notes.write(why + "\n")


def is_terminal(word):
    return os.path.exists(word) and stat.S_ISCHR(os.stat(word).st_mode)


def words_on_wine(arguments):
    words = []
    for word in arguments:
        if is_terminal(word):
            link = Path(os.environ["WINEPREFIX"]) / "dosdevices/com20"
            link.unlink(missing_ok=True)
            link.symlink_to(os.path.realpath(word))
            word = "COM20"
        words.append(word)
    is_at_a_port = len(words) > 1 and words[0] in AT_A_PORT and words[1].startswith("COM")
    if is_at_a_port and not any(word.partition("=")[0] == "--timeout" for word in words):
        words += ["--timeout", "2000"]
    return words


def run(arguments, typed=None):
    """Runs what ends by itself: its status, output and errors. It reads what is typed, or this program's input."""
    words = words_on_wine(arguments)
    for attempt in range(1, 4):
        done = subprocess.run(["wine", os.environ["SERVOBUS_EXE"], *words], input=typed, capture_output=True)
        if done.returncode == 0 or done.stdout or done.stderr:
            break
        again(f"wine, attempt {attempt}: status {done.returncode} without a word: {' '.join(words)}")
    return done


def main(arguments):
    if arguments[:1] == ["sim"]:
        os.execv(os.environ["SERVOBUS"], ["servobus", *arguments])
    if arguments and arguments[0] in RUNS_ON:
        os.execvp("wine", ["wine", os.environ["SERVOBUS_EXE"], *words_on_wine(arguments)])
    done = run(arguments)
    sys.stdout.buffer.write(done.stdout)
    sys.stderr.buffer.write(done.stderr)
    return done.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
