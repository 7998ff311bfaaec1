# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Headers that the tool makes of drives and files: a program with them prints the maps that they were made of.

CXX is the compiler, g++ if it is not set. One program has all headers, since each takes the compiler seconds.
"""
import os
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene

ROOT = Path(__file__).resolve().parents[2]
STRICT = "-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror".split()
DRIVES = "zlac8015d", "yako-closed-loop", "yako-open-loop", "c630s"
METER = '''# name = meter
# word_order = low
# character_format = 8E1
# gap_ms = 1.75
# response_ms = 250
# echoes_byte_count = yes
# exception_2 = no such "value" \\ here
address,name,type,access,scale,unit,min,max,default,flags,names,description
0x10,voltage,u16,ro,0.1,V,,,,,,"Between ""L1"" and N: not a \\"
0x11,delete,i16,rw,1/3,ms,-32768,32767,-1,saved_on_write,-1=never;0=once,
0x12,delete_,i16,rw,25,mm,-5,5,0,motion;trigger,,
0x13,temperatures,i16,ro,0.5,degC,,,,,halves,
0x14,signals,u16,ro,,,,,,,hex,
0x15,names,u16,wo,,,,,,communication,b0=ready;0x00C0:0x0040=locked,
0x20,energy,i32,rw,,,-2147483648,2147483647,-2147483648,,,
0x22,total,u32,ro,,,0,4294967295,4294967295,,,
'''
PLANT = '''address,name,table,type,access,unit,default,names,flags,when
0,pump,coil,bool,rw,,1,,motion,stopped
1,valve,coil,,rw,,,0=shut;1=open,,
0,door,discrete,,,,0,0=closed;1=open,,
0,level,input,u16,,mm,,,,
1,volume,input,i32,,mm,,,scaled_elsewhere,
'''
# A catalogue in a header for each table that has rows.
CATALOGUES = {"coil": "coil_catalogue", "discrete": "discrete_input_catalogue", "holding": "catalogue",
              "input": "input_register_catalogue"}
TABLES = {"coil": "coils", "discrete": "discrete_inputs", "holding": "holding_registers", "input": "input_registers"}

PRINTS = """
#include <cstdio>

#include <examples/servobus/text/map_text.hpp>

static void print(const servobus::catalogue& of, servobus::table in) {
    for (const servobus::entry& e : of.entries)
        std::puts(tool::map_row(e, *of.device, of.sentence(e.address), in).c_str());
}

static void begin(const servobus::profile& of) {
    std::fputs(tool::profile_lines(of).c_str(), stdout);
    std::puts(tool::map_header(true).c_str());
}

// Rows are rows of the library, which a client reads and writes.
static_assert(servobus::is_register<meter::voltage> && servobus::is_bit<plant::pump>);
static_assert(servobus::table_of<plant::level> == servobus::table::input_registers);
static_assert(servobus::row_type<meter::delete_>::rights == servobus::access::rw);
static_assert(meter::delete_.address == 0x11 && meter::delete__.address == 0x12 && meter::names_.address == 0x15);
static_assert(zlac8015d::left_max_current.limits.high == 300);
static_assert(servobus::has_fixed_word_order<meter::device> && !servobus::has_fixed_word_order<c630s::device>);
"""


def program(maps: dict[str, str]) -> str:
    headers = "".join(f'#include "{device}.hpp"\n' for device in maps)
    calls = ""
    for device, shown in maps.items():
        space = device.replace("-", "_")
        calls += f"    begin({space}::device::facts);\n"
        tables = [line.rsplit(",", 1)[-1] for line in shown.splitlines()]
        for table, catalogue in CATALOGUES.items():
            if table in tables:
                calls += f"    print({space}::{catalogue}, servobus::table::{TABLES[table]});\n"
    return f"{headers}{PRINTS}\nint main() {{\n{calls}}}\n"


@scene()
def comes_back(tool: Tool):
    tool.write("meter.csv", METER)
    tool.write("plant.csv", PLANT)
    maps = {}
    for device in (*DRIVES, "meter.csv", "plant.csv"):
        name = device.removesuffix(".csv")
        maps[name] = tool.run(f"map {device} --long --profile").out
        header = tool.run(f"header {device}")
        tool.check(f"header {device} is made", header.status == 0 and header.err == "")
        tool.write(f"{name}.hpp", header.out)
    tool.write("prints.cpp", program(maps))
    compiled = subprocess.run(
        [*os.environ.get("CXX", "g++").split(), "-std=c++20", "-O0", *STRICT, f"-I{ROOT}/include", f"-I{ROOT}",
         "prints.cpp", f"{ROOT}/examples/servobus/text/map_text.cpp", "-o", "prints"],
        cwd=tool.folder, capture_output=True, text=True, check=False)
    tool.check("a program with all headers compiles", compiled.returncode == 0, compiled.stderr)
    if compiled.returncode != 0:
        return
    printed = tool.run("", program=[str(tool.folder / "prints")]).lines
    for name, shown in maps.items():
        lines = shown.splitlines()
        tool.is_equal(f"{name}: header and map", printed[: len(lines)], lines)
        printed = printed[len(lines):]
    tool.is_equal("and nothing else", printed, [])


@scene()
def refused(tool: Tool):
    tool.write("mixed.csv", "address,name,type,word_order\n1,here,u32,high\n3,there,u32,low\n")
    tool.fails("two word orders", "header mixed.csv", 2, "mixed.csv: there has a word order of its own")
    tool.write("bad.csv", "address,name\n1,a b\n")
    tool.fails("a bad file", "header bad.csv", 2, "bad.csv:2: the name 'a b' is no letter")
    tool.fails("no device", "header", 2, "header takes one DEVICE")
    tool.fails("an unknown device", "header zlac9000", 2, "unknown device 'zlac9000'")
    tool.fails("a device without a map", "header raw", 2, "unknown device 'raw'")


play_tool()
