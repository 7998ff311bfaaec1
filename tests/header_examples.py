# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Compiles the example in the first comment of each public header, and names the headers that should have one.

header_examples.py [COMPILER...]    g++ and clang++ if none is given

An example is the first run of lines `//     code` after a line `//`. It compiles at namespace scope or as a
function's body, after the headers and declarations below, whichever it is written for.
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HEADERS = ROOT / "include" / "servobus"
MOST_LINES = 5
STATEMENT = re.compile(r"^(if|for|while|return|\(void\)|[a-z_.]+\()", re.M)

# Rooms of which each public header must have an example.
WITH_EXAMPLES = {"core", "axis", "modbus", "registers", "explain", "sim", "posix", "bus", "client", "control", "line", "device", "server"}

BEFORE = """#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <span>
#include <fcntl.h>
#include <servobus/servobus.hpp>
#include <servobus/any_device.hpp>
#include <servobus/any_value.hpp>
#include <servobus/client/identification.hpp>
#include <servobus/client/peer_node.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/c630s/axis_drive.hpp>
#include <servobus/device/yako/axis_drive.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/device/zlac8015d/axes.hpp>
#include <servobus/device/zlac8015d/robot.hpp>
#include <servobus/posix/mbap.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/registers/value_forms.hpp>
#include <servobus/server/row_values.hpp>
#include <servobus/server/stored_number.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>
"""
UART = """struct my_uart { transfer send(bytes); bool sent(); transfer receive(byte_buffer); instant now(); };
inline my_uart uart;"""
SERVED = """struct tank_device { static constexpr profile facts{.name = "tank"}; };
namespace tank {
constexpr reg<u16, access::rw, tank_device> lowest{0, {0, 900}, no_unit, 0}, highest{1, {0, 900}, no_unit, 900};
constexpr reg<i32, access::ro, tank_device> level{2, full<i32>, no_unit, 0};
constexpr reg<u16, access::ro, tank_device> temperature{4, {0, 150}, no_unit, 20};
constexpr input_reg<u32, tank_device> uptime{0, full<u32>, no_unit, 0};
constexpr coil<access::rw, tank_device> valve{3};
}
"""
WIRE = "inline posix::serial serial; inline line wire{serial, modbus::timing_at(115200)};"
SERVO = WIRE + "inline c630s::drive servo{wire, 1};"
NODES = """constexpr node<zlac8015d::device> wheels_node{1};
constexpr node<yako::closed_loop::device> lift_node{2};
constexpr node<zlac8015d::device> pump_node{3};"""
TANK = """namespace tank {
struct device { static constexpr profile facts{.name = "tank"}; };
inline constexpr coil<access::rw, device> valve{3};
inline constexpr input_reg<u16, device> level{0, full<u16>, no_unit, no_default};
inline constexpr input_reg<i16, device> temperature{1, full<i16>, units::degree_celsius / 10, no_default};
inline constexpr reg<u16, access::rw, device> options{0, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> ramp{3, {10, 5000}, units::millisecond, 500};
inline constexpr reg<u16, access::ro, device> state{4, full<u16>, no_unit, 0};
}
using units::millisecond;"""
SENSOR = TANK + """inline posix::serial serial;
inline line<posix::serial, counters, unechoed, modbus::open_lengths> wire{serial, modbus::timing_at(115200)};
inline client io{wire, node<tank::device>{9}};"""
SDM120 = """namespace sdm120 {
struct device { static constexpr profile facts{.name = "sdm120"}; };
inline constexpr input_reg<f32, device> voltage{0x0000, full<f32>, units::volt, no_default};
}
"""
METER = """struct meter { static constexpr profile facts{.name = "meter"}; };
template <class T> using ro = reg<T, access::ro, meter>;
"""
# What an example speaks of without making it: by header, or for all headers of a folder.
LITERALS = "using namespace servobus::literals;\n"
LIFT = LITERALS + WIRE + """inline constexpr auto screw = axis::of(lead(5_mm, counts_per_turn{1000}));
inline yako::closed_loop::axis_drive lift{wire, 2, screw};"""
GIVEN = {
    "axis/axis.hpp": LITERALS,
    "axis/axis_place.hpp": LITERALS,
    "control/axis_commands.hpp": LIFT,
    "control/motion_commands.hpp": WIRE + """inline zlac8015d::drive wheels{wire, 1, unsupervised};
        inline yako::closed_loop::drive axis{wire, 2};""",
    "device/c630s/axis_drive.hpp": LITERALS + WIRE,
    "device/yako/axis_drive.hpp": LITERALS + WIRE,
    "device/zlac8015d/axes.hpp": LITERALS + WIRE,
    "device/zlac8015d/robot.hpp": LITERALS + WIRE,
    "bus/scheduled_line.hpp": NODES + """inline posix::serial serial;
        inline constexpr poll_plan plan{modbus::timing_at(115200), controlled(wheels_node, unsupervised)};""",
    "bus/bus.hpp": NODES + WIRE.replace("line wire", "scheduled_line wire") + """inline constexpr poll_plan plan{
        modbus::timing_at(115200), controlled(wheels_node, unsupervised), controlled(lift_node, unsupervised),
        cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(200))};
        inline zlac8015d::drive wheels{wire, wheels_node, unsupervised}; inline yako::closed_loop::drive lift{wire, lift_node};
        void show(reading<zlac8015d::bus_voltage>);""",
    "bus/plan.hpp": NODES,
    "bus/plan_entries.hpp": NODES,
    "any_device.hpp": TANK + WIRE,
    "any_value.hpp": SDM120 + WIRE + "void show(i32);",
    "registers/value_types.hpp": METER,
    "registers/values.hpp": """struct oven { static constexpr profile facts{.name = "oven"}; };""",
    "registers/value_forms.hpp": METER + """inline constexpr ro<f32> power{0x0000, full<f32>, units::watt, no_default};
        inline constexpr ro<with<u16, servobus::high_byte>> hour{0x0002, full<u16>, no_unit, no_default};""",
    "server/stored_number.hpp": SDM120 + "inline float measured;",
    "client/identification.hpp": SENSOR,
    "client/peer_node.hpp": TANK,
    "client/stepped_tables.hpp": SENSOR,
    "client/tables.hpp": SENSOR,
    "client/open_responses.hpp": TANK + UART,
    "modbus/response_lengths.hpp": UART,
    "registers/coil_value.hpp": TANK,
    "registers/table_readings.hpp": TANK,
    "client/": WIRE + "inline client servo{wire, node<c630s::device>{1}};",
    "control/": WIRE + "inline zlac8015d::drive wheels{wire, 1, unsupervised};",
    "device/c630s/": SERVO,
    "device/c630s/registers/": SERVO,
    "device/yako/": WIRE + "inline yako::closed_loop::drive axis{wire, 1};",
    "device/zlac8015d/": WIRE + "inline zlac8015d::drive wheels{wire, 1, unsupervised};",
    "line/blocking_line.hpp": UART,
    "line/mbap_port.hpp": UART.replace("my_uart", "my_connection"),
    "line/echo.hpp": WIRE,
    "line/observer.hpp": UART,
    "line/ring.hpp": UART,
    "server/": SERVED,
    "server/host_row_server.hpp": SERVED + UART,
    "server/row_server.hpp": SERVED + UART,
    "line/tcp_open.hpp": """struct address { const address* ai_next; }; inline const address* found = nullptr;
        instant clock_now(); errc connect_to(const address&, duration);""",
    "posix/descriptor.hpp": 'constexpr const char* path = "/dev/ttyUSB0";',
    "sim/c630s/plant.hpp": "inline sim::c630s drive;",
    "sim/faults.hpp": "constexpr bytes response;",
    "sim/memory.hpp": "inline sim::zlac8015d drive; inline constexpr sim::register_index<0x0010, 8> index{{}};",
    "sim/yako/machine.hpp": "inline sim::yako_closed_loop drive;",
}


def example(header):
    comment = header.read_text(encoding="utf-8").split("#pragma once")[0].splitlines()
    for i, line in enumerate(comment):
        if line == "//" and i + 1 < len(comment) and comment[i + 1].startswith("//     "):
            lines = []
            for code in comment[i + 1:]:
                if not code.startswith("//     "):
                    break
                lines.append(code[7:])
            return lines
    return []


def command(compiler):
    return [compiler, "-std=c++20", "-Wall", "-Wextra", "-Werror", "-Wno-unused", f"-I{ROOT / 'include'}"]


def precompile(compiler, folder):
    """What goes before each example, compiled once."""
    header = Path(folder) / "before.hpp"
    header.write_text(BEFORE, encoding="utf-8")
    ending = ".pch" if "clang" in compiler else ".gch"
    subprocess.run([*command(compiler), "-x", "c++-header", str(header), "-o", f"{header}{ending}"], check=True)
    return ["-include", str(header), "-fsyntax-only", "-x", "c++", "-"]


def scope(name, code, is_body):
    """An example in a namespace of its own. Errors name it."""
    given = GIVEN.get(name, GIVEN.get(f"{name.rpartition('/')[0]}/", ""))
    if is_body:
        code = f"int example() {{\n{code}\nreturn 0;\n}}"
    return (f"namespace example_{re.sub('[^a-z0-9]', '_', name)} {{\n#line 1 \"{name}\"\n"
            f"using namespace servobus;\nusing namespace servobus::units;\n{given}\n{code}\n}}\n")


def errors_of(compiler, before, examples):
    """{name: (code, whether it is a function's body)}, in one program. None if it compiles."""
    source = "".join(f"#include <servobus/{name}>\n" for name in examples)
    source += "".join(scope(name, *example) for name, example in examples.items())
    done = subprocess.run([*command(compiler), *before], input=source, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode else None


def refused(compiler, before, examples):
    """The examples that do not compile, with their errors. All are compiled together; those with errors alone, in
    both forms."""
    probable = {name: (code, bool(STATEMENT.search(code))) for name, code in examples.items()}
    errors = errors_of(compiler, before, probable)
    found = {}
    if errors is not None:
        for name in [name for name in examples if f"{name}:" in errors] or examples:
            code, is_body = probable[name]
            errors = errors_of(compiler, before, {name: (code, is_body)})
            if errors and errors_of(compiler, before, {name: (code, not is_body)}):
                found[name] = errors
    return found


def main():
    with tempfile.TemporaryDirectory() as folder:
        return check(sys.argv[1:] or ["g++", "clang++"], folder)


def check(compilers, folder):
    failed = 0
    examples, without = {}, {}
    for header in sorted(HEADERS.rglob("*.hpp")):
        name = str(header.relative_to(HEADERS))
        room = name.split("/")[0]
        if "/detail/" in name or room == "windows":  # tests/windows/headers.py compiles those of Windows
            continue
        lines = example(header)
        if not lines:
            without[room] = without.get(room, 0) + 1
            if room in WITH_EXAMPLES:
                print(f"header_examples.py: {name} has no example")
                failed += 1
            continue
        if len(lines) > MOST_LINES:
            print(f"header_examples.py: the example of {name} has {len(lines)} lines")
            failed += 1
        examples[name] = "\n".join(lines)
    for compiler in compilers:
        (Path(folder) / compiler).mkdir()
        for name, errors in refused(compiler, precompile(compiler, Path(folder) / compiler), examples).items():
            print(f"header_examples.py: the example of {name} does not compile with {compiler}:\n{errors[:1500]}")
            failed += 1
    rest = ", ".join(f"{room} {count}" for room, count in without.items())
    print(f"header_examples.py: {len(examples)} examples compile with {' and '.join(compilers)}, {failed} failed; "
          f"headers without one: {rest or 'none'}")
    return 1 if failed or len(examples) < 30 else 0


sys.exit(main())
