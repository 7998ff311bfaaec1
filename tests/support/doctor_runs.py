# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The stage of tests that run `servobus doctor`."""
import re

from programs import Tool


class Doctor(Tool):
    def findings(self) -> list[str]:
        """Those of the last run, without what a busy computer may add: that responses begin late."""
        late = re.compile("matters  (responses begin|a response began) after ")
        return [line for line in self.all_findings() if not late.match(line)]

    def all_findings(self) -> list[str]:
        return [line for line in self.last.lines if re.match("(refused|matters|unread|differs) ", line)]

    def finds(self, name: str, *parts: str):
        """A finding of the last run has all these parts."""
        is_there = any(all(part in line for part in parts) for line in self.all_findings())
        self.check(name, is_there, f"expected {parts}\n{self.found()}")
