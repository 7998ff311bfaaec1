# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Types keys in an interactive bash and prints the last line that it then shows.

    python3 tests/tool/typed.py SCRIPT-THAT-IT-READS-FIRST KEYS
"""
import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios
import time

PROMPT = "typed> "
script, keys = sys.argv[1], sys.argv[2]
pid, terminal = pty.fork()
if pid == 0:
    fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("4H", 24, 200, 0, 0))  # the line is not scrolled
    os.environ.update(PS1=PROMPT, TERM="dumb")
    os.execvp("bash", ["bash", "--noprofile", "--rcfile", script, "-i"])


def shown_until(text):
    shown = ""
    end = time.monotonic() + 20
    while text not in shown and time.monotonic() < end:
        if select.select([terminal], [], [], 0.1)[0]:
            try:
                shown += os.read(terminal, 4096).decode(errors="replace")
            except OSError:
                break
    return shown


shown_until(PROMPT)
os.write(terminal, keys.encode() + b"|")  # this comes once the completions before it have ended
print(shown_until("|").splitlines()[-1].removeprefix(PROMPT))
os.kill(pid, signal.SIGKILL)
os.waitpid(pid, 0)
