# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The cost of a device's map for a program that includes it and reads two registers: the instructions that the compiler
executes for each row, and bytes of flash on a Cortex-M0+.

Cachegrind counts the instructions, so they are the same in every run with one compiler. Both figures are compared with
the same program with only these two rows, so they exclude the cost of reading. Fails if a row costs more instructions
than its bound (for g++ 12), or if unused rows cost flash. A bound is 3 % above the counted figure.
"""
import sys
from collections import namedtuple

from measuring import bytes_on, compiler_instructions, need_arm, side_by_side

Map = namedtuple("Map", "name rows bound header namespace device registers addresses")
YAKO = ("yako", ("error_code", "drive_model"), ("0x0006", "0x0000"))
MAPS = [
    Map("zlac8015d", 116, 313500, "zlac8015d/registers.hpp", "zlac8015d", "zlac8015d",
        ("speed_resolution", "max_motor_speed"), ("0x2022", "0x2008")),
    Map("yako-closed-loop", 204, 157700, "yako/closed_loop.hpp", "yako::closed_loop", *YAKO),
    Map("yako-open-loop", 208, 145000, "yako/open_loop.hpp", "yako::open_loop", *YAKO),
    Map("c630s", 463, 292800, "c630s/registers.hpp", "c630s", "c630s", ("software_version", "servo_status"),
        ("0x0100", "0x3000")),
]
WITHOUT = "#include <servobus/client/client.hpp>\n"
ROW = """namespace map { inline constexpr servobus::reg<servobus::u16, servobus::access::ro, device> %s{
    %s, servobus::full<servobus::u16>, servobus::no_unit, servobus::no_default}; }
"""
READING = """struct uart {
    servobus::transfer send(servobus::bytes);
    bool sent();
    servobus::transfer receive(servobus::byte_buffer);
    servobus::instant now();
};
unsigned both(servobus::client<servobus::line<uart>, map::device>& c) {
    const auto a = c.template read<map::%s>();
    const auto b = c.template read<map::%s>();
    return a && b ? 1u : 0u;
}
"""


def whole(device_map):
    """A program that reads two registers of a map."""
    return (f"#include <servobus/device/{device_map.header}>\n"
            f"namespace map = servobus::{device_map.namespace};\n" + READING % device_map.registers)


def two_rows(device_map):
    """The same program with these two rows only."""
    device, names = device_map.device, ("row_a", "row_b")
    rows = "".join(ROW % (name, address) for name, address in zip(names, device_map.addresses))
    return (f"#include <servobus/device/{device}/values.hpp>\n"
            f"namespace map {{ using servobus::{device}::device; }}\n" + rows + READING % names)


def flash(text):
    return sum(bytes_on("cortex-m0plus", WITHOUT + text))


need_arm()
texts = [program(device_map) for device_map in MAPS for program in (whole, two_rows)]
sizes = dict(zip(texts, side_by_side(flash, texts)))
counted = compiler_instructions(texts, head=WITHOUT)
passes = True
line = "{:18}{:>6}{:>15}{:>12}{:>12}{:>8}{:>14}{}"
print(line.format("map", "rows", "instructions", "for a row", "bound", "flash", "with two rows", ""))
for each in MAPS:
    text, small = whole(each), two_rows(each)
    more = counted[text] - counted[small]
    a_row = more // (each.rows - 2)
    verdict = "" if a_row <= each.bound else "  ABOVE ITS BOUND"
    verdict += "" if sizes[text] <= sizes[small] else "  UNUSED ROWS COST FLASH"
    passes = passes and not verdict
    print(line.format(each.name, each.rows, more, a_row, each.bound, sizes[text], sizes[small], verdict))
sys.exit(not passes)
