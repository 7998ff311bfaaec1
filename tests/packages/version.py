# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The version is the same in the header, CMakeLists.txt and meson.build."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import ROOT, finish, same


def version_in(file, pattern):
    found = re.search(pattern, (ROOT / file).read_text("utf-8"), re.M)
    return ".".join(found.groups()) if found else None


VERSION = version_in("include/servobus/core/version.hpp",
                     r"^inline constexpr version_number version\{(\d+), (\d+), (\d+)\};$")

if __name__ == "__main__":
    same("CMakeLists.txt", VERSION, version_in("CMakeLists.txt", r"^project\(servobus VERSION ([0-9.]+) "))
    same("meson.build", VERSION, version_in("meson.build", r"^project\('servobus'.* version: '([0-9.]+)'"))
    finish()
