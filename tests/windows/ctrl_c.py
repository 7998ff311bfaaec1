# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Someone at a terminal who consents to what an example program asks, and types Ctrl-C while the machine turns."""
import os
import pty
import re
import termios


def interrupted_on_a_terminal(*command):
    """The program's status, and what it has shown."""
    child, terminal = pty.fork()
    if child == 0:
        mode = termios.tcgetattr(0)
        mode[0] &= ~termios.ICRNL  # the console of Windows takes a carriage return for Enter
        termios.tcsetattr(0, termios.TCSANOW, mode)
        os.execvp(command[0], [str(word) for word in command])
    shown = text = b""
    consents = turns = False
    while True:
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
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return status, text.decode("utf-8", "replace")
