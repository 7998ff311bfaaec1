# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The drives whose maps are pages, and how their documents write an address."""
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
HEADERS = ROOT / "include/servobus/device"

# The tool's name of a drive, its title, where its rows are, and its letter in the errata. In an erratum's second column
# `elsewhere` stands for the other variant of the same manual.
DRIVES = [
    {"name": "zlac8015d", "title": "ZLTECH ZLAC8015D", "kind": "dual hub servo",
     "headers": ["zlac8015d/registers.hpp"], "errata": "errata.md", "letter": "B", "elsewhere": None},
    {"name": "yako-closed-loop", "title": "YAKOTEC closed loop", "kind": "steppers ESS242-, ESS257-, ESS286-Rx1",
     "headers": ["yako/common.hpp", "yako/closed_loop.hpp"], "errata": "errata.md", "letter": "A",
     "elsewhere": r"\bOL\b|appendix 3"},
    {"name": "yako-open-loop", "title": "YAKOTEC open loop",
     "kind": "steppers ESD2205PR, ESD2505PR, YKE2405PR, YKE2608PR",
     "headers": ["yako/common.hpp", "yako/open_loop.hpp"], "errata": "errata.md", "letter": "A",
     "elsewhere": r"\bCL\b|appendix 2"},
    {"name": "c630s", "title": "Coolmay C630S", "kind": "AC servo",
     "headers": ["c630s/registers.hpp",
                 *sorted(str(p.relative_to(HEADERS)) for p in HEADERS.glob("c630s/registers/*.hpp"))],
     "errata": "errata_c630s.md", "letter": "C", "elsewhere": None},
]


def parameter(address):
    """P0B-17 for 0x0B11."""
    return f"P{address >> 8:02X}-{address & 0xFF:02d}"


def address_of(text):
    """Of 0x2088, 2088h or P0B-17."""
    if text.startswith("P"):
        return int(text[1:3], 16) << 8 | int(text[4:6])
    return int(text.removesuffix("h").removeprefix("0x"), 16)
