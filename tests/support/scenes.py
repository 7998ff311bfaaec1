# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks that have a name each, in scenes that are played at the same time.

A scene is a function that takes a stage: a folder of its own, and what it needs to run programs there (programs.py).
So a part that waits for slow drives takes as long as the slowest one. Each scene's checks are printed together.
"""
import os
import sys
import time
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

PATIENCE = 120  # seconds: a limit against hangs, which no check depends on
# Scenes mostly wait. More of them at a time make the machine so busy that programs wait for each other. On wine all
# programs share one port.
AT_A_TIME = 1 if os.environ.get("ON_WINE") else 4
scenes: list[tuple[Callable, tuple]] = []


def scene(*cases):
    """Has the function below played once, or once with each of the cases: an argument, or a tuple of arguments."""

    def enlist(function):
        for case in cases or [()]:
            scenes.append((function, case if isinstance(case, tuple) else (case,)))
        return function

    return enlist


def until(condition: Callable[[], object]) -> bool:
    """Asks again and again until the condition holds; false if it never does."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


class Checks:
    """Counts the checks of a scene, and keeps what is to be printed of them."""

    def __init__(self):
        self.passed = self.failed = 0
        self.printed: list[str] = []

    def say(self, line: str):
        self.printed.append(line)

    def found(self) -> str:
        """Describes what the last check has looked at."""
        return ""

    def check(self, name: str, condition, found: object = None):
        """`found` is shown if the condition does not hold."""
        if condition:
            self.passed += 1
            return self.say(f"ok      {name}")
        self.failed += 1
        self.say(f"FAILED  {name}")
        for line in (self.found() if found is None else str(found)).splitlines()[:40]:
            self.say(f"        {line[:400]}")

    def is_equal(self, name: str, found, expected):
        self.check(name, found == expected, f"found     {found!r}\nexpected  {expected!r}")


def play(stage: Callable) -> None:
    """Plays all scenes, prints their checks and a summary, and ends the program: with status 1 if a check failed."""

    def play_one(function, arguments):
        with stage() as on:
            on.say(" ".join(["#", function.__name__, *map(str, arguments[:1])]))
            try:
                function(on, *arguments)
            except Exception:
                on.check(f"{function.__name__} is played to its end", False, traceback.format_exc())
            return on

    passed = failed = 0
    with ThreadPoolExecutor(AT_A_TIME) as pool:
        for ended in [pool.submit(play_one, *one) for one in scenes]:
            checks = ended.result()
            print("\n".join(checks.printed), flush=True)
            passed += checks.passed
            failed += checks.failed
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed or not passed else 0)
