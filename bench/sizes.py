# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Prints the bytes of code and table of each CRC engine on Cortex-M, arm-none-eabi-g++ -Os. Fails if an engine exceeds
its bound, or if a size differs from bench/figures/sizes.tsv.

sizes.py [--record]    --record: writes the sizes there, and into bench/README.md
"""
import sys

from measuring import bytes_on, need_arm, record, recorded, side_by_side

FIGURES = "bench/figures/sizes.tsv"
COMMENT = "# CRC engine, bytes with its table on Cortex-M4, on Cortex-M0+"
CORES = ("cortex-m4", "cortex-m0plus")
MOST = {"crc_bitwise": 1000, "crc_table16": 1000, "crc_table256": 1000, "crc_trinomial<8>": 80,
        "crc_trinomial<16>": 1000, "crc_trinomial<32>": 220}
PROGRAM = """#include <servobus/modbus/crc_tables.hpp>
using namespace servobus::modbus;
std::uint16_t crc(const std::uint8_t* p, std::size_t n) {
    using e = ENGINE;
    return e::end(e::update(e::begin(), servobus::slice<const std::uint8_t>{p, n}));
}
"""


def sizes(engine):
    """The engine's row of figures: code and table on each core."""
    return [engine, *(str(sum(bytes_on(core, PROGRAM.replace("ENGINE", engine))[:2])) for core in CORES)]


need_arm()
is_recording = sys.argv[1:] == ["--record"]
known = recorded(FIGURES)
rows = side_by_side(sizes, MOST)
passes = True
print(f"{'bytes of code and table':28}{'Cortex-M4':>12}{'Cortex-M0+':>12}")
for row in rows:
    verdict = "  LARGER THAN IT MAY BE" if max(map(int, row[1:])) > MOST[row[0]] else ""
    verdict += "" if is_recording or row in known else "  NOT AS RECORDED"
    passes = passes and not verdict
    print(f"{row[0]:28}{row[1]:>12}{row[2]:>12}{verdict}")
if is_recording and passes:
    record(FIGURES, [COMMENT, *("\t".join(row) for row in rows)])
sys.exit(not passes)
