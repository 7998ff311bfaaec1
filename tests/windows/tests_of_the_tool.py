# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The tool's own tests (tests/tool/) on wine, those that need nothing of Linux.

tests_of_the_tool.py TOOL BUILD PART
"""
import re

import on_wine
from alike import main
from checks import check, expect, run

PARTS = ("offline", "zlac8015d", "devices", "refused_files", "device_files", "parameters", "listen")
NO_RESPONSE = re.compile("^ .*no response.*", re.M) # in what a failed check has found


def passes(part):
    """Tries three times if a request got no response: see alike.expect_alike."""
    for _ in range(3):
        done = run("python3", "-B", f"tests/tool/{part}.py", "tests/windows/on_wine.py")
        if done.returncode == 0 or not (unanswered := NO_RESPONSE.search(done.stdout)):
            break
        on_wine.again(unanswered[0])
    print(done.stdout, end="")
    check(f"its own tests on wine: {part}", expect, done.returncode == 0, f"status {done.returncode}")


main({part: lambda part=part: passes(part) for part in PARTS})
