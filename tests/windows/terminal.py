# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Runs an example program on a terminal, consents, and types Ctrl-C while the machine turns.

terminal.py COMMAND...     prints what the program shows, and ends with its status
"""
import os
import pty
import re
import select
import sys
import termios
import time

child, terminal = pty.fork()
if child == 0:
    mode = termios.tcgetattr(0)
    mode[0] &= ~termios.ICRNL  # the console of Windows takes a carriage return for Enter
    termios.tcsetattr(0, termios.TCSANOW, mode)
    os.execvp(sys.argv[1], sys.argv[1:])

shown = b""
text = b""
consents = turns = False
deadline = time.monotonic() + 120
while time.monotonic() < deadline:
    if select.select([terminal], [], [], 0.1)[0]:
        try:
            shown += os.read(terminal, 65536)
        except OSError:  # the program has ended
            break
    # The console writes a blank as a movement of the cursor.
    text = re.sub(rb"\x1b\[[?0-9;]*[A-Za-z]|\s", b"", shown)
    if not consents and b"TypeMOVEtogoon" in text:
        consents = True
        os.write(terminal, b"MOVE\r")
    if not turns and b"left" in text.partition(b"withoppositesigns")[2]:
        turns = True
        os.write(terminal, b"\x03")
else:
    print("terminal.py: the program does not end")
    os.kill(child, 9)
print(text.decode(errors="replace"))
if not turns:
    print("terminal.py: no Ctrl-C was typed, since the program did not say that it turns")
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) & 0xFF)
