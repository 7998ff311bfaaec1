# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Where things are, and how the pages are called."""
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DEVICES = ["zlac8015d", "yako-closed-loop", "yako-open-loop", "c630s"]


def file_of(device):
    return device.replace("-", "_")
