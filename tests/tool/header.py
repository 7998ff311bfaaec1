# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Headers that the tool makes of drives and files: a program with them prints the maps that they were made of, and
another one uses the enumerations of a file with the simulated device of this file.

CXX is the compiler, g++ if it is not set. One program has all headers, since each takes the compiler seconds.
"""
import csv
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
0x22,total,u32,ro,0.01,kWh,0,4294967295,4294967295,,,
0x24,reactive,u32,ro,1000,varh,,,,,,
0x26,run_time,u32,ro,,h,,,,,,
0x28,pressure,u16,ro,1/1000,bar,,,,,,
0x29,flow,u16,ro,0.1,l/min,,,,,,
'''
PLANT = '''address,name,table,type,access,unit,default,names,flags,when
0,pump,coil,bool,rw,,1,,motion,stopped
1,valve,coil,,rw,,,0=shut;1=open,,
0,door,discrete,,,,0,0=closed;1=open,,
0,level,input,u16,,mm,,,,
1,volume,input,i32,,mm,,,scaled_elsewhere,
'''
# Codes of all kinds, on a line of its own each: those of a row, of rows with the same, of a signed row, of an input
# register; names that are no names of C++, or that others have; and rows that are numbers.
CODES = '''# name = codes
address,name,table,type,access,unit,min,max,default,flags,names
1,mode,,u16,rw,,0,2,0,,0=off;1=once;2=for ever
2,first,,u16,rw,,,,0,,0=no;1=yes
3,second,,u16,rw,,,,1,,0=no;1=yes
4,trim,,i16,rw,,-1,1,-1,,-1=down;0=none;1=up
5,state,input,u16,ro,,,,1,,0=idle;1=busy
6,odd,,u16,rw,,0,14,0,,0=9600 Bd;1=default;2=a-b;3=a b;4=%;5=-20;6=20;7=a_b_;8=__LINE__;9=input;10=(on);11=\\;12=device;13=mode;14=rw
7,mode_code,,u16,rw,,0,1,0,,0=red;1=green
8,number_of,,u16,ro,,,,,,
9,pause,,u16,rw,ms,0,500,0,,0=never
10,mixed,,u16,rw,,,,,,0=none;b1=ready
11,word,,u16,rw,,,,,,hex
12,__FILE__,,u16,ro,,,,,,
13,scaled,,u16,rw,,,,,scaled_elsewhere,0=none
14,valve,coil,bool,rw,,,,,,0=shut;1=open
'''
USES_CODES = """
#include <cstdio>
#include <type_traits>

#include <servobus/any_device.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/servobus.hpp>

#include "codes.hpp"

using namespace servobus;

template <const auto& Row> using value = typename row_type<Row>::value_type;

static_assert(std::is_same_v<value<codes::mode>, codes::mode_code_> && codes::mode_code.address == 7);
static_assert(static_cast<int>(codes::mode_code_::for_ever) == 2);
static_assert(std::is_same_v<value<codes::first>, value<codes::second>>);
static_assert(std::is_same_v<codes::first_code, codes::second_code>);
static_assert(std::is_same_v<value<codes::mode_code>, codes::mode_code_code>);
static_assert(std::is_same_v<value<codes::state>, codes::state_code>);
static_assert(std::is_same_v<value<codes::trim>, i16> && codes::number_of(codes::trim_code::down) == -1);
static_assert(std::is_same_v<value<codes::pause>, u16> && std::is_same_v<value<codes::mixed>, u16>);
static_assert(std::is_same_v<value<codes::word>, u16> && std::is_same_v<value<codes::scaled>, u16>);
static_assert(codes::number_of_.address == 8);

// Each name once, by its code: two that were equal would not compile here.
constexpr int place_of(codes::odd_code code) {
    switch (code) {
    case codes::odd_code::code_9600_Bd: return 0;
    case codes::odd_code::default_: return 1;
    case codes::odd_code::a_b: return 2;
    case codes::odd_code::a_b_: return 3;
    case codes::odd_code::code_: return 4;
    case codes::odd_code::minus_20: return 5;
    case codes::odd_code::code_20: return 6;
    case codes::odd_code::a_b__: return 7;
    case codes::odd_code::code___LINE__: return 8;
    case codes::odd_code::input: return 9;
    case codes::odd_code::on: return 10;
    case codes::odd_code::code__: return 11;
    case codes::odd_code::device: return 12;
    case codes::odd_code::mode: return 13;
    case codes::odd_code::rw: return 14;
    }
    return -1;
}
static_assert(place_of(static_cast<codes::odd_code>(7)) == 7 && place_of(static_cast<codes::odd_code>(11)) == 11);

int main() {
    posix::serial port;
    if (port.open("drive", {.baud = 9600}) != errc::ok) return 2;
    line wire{port, modbus::timing_at(9600)};
    client io{wire, node<codes::device>{1}};
    const auto begun = io.read<codes::mode, codes::second, codes::trim, codes::state>();
    if (!begun) return 3;
    const bool is_default = begun->get<codes::mode>() == codes::mode_code_::off &&
                            begun->get<codes::second>() == codes::first_code::yes &&
                            begun->get<codes::trim>() == codes::number_of(codes::trim_code::down) &&
                            begun->get<codes::state>() == codes::state_code::busy;
    if (!is_default) return 4;
    if (!io.write<codes::mode>(codes::mode_code_::for_ever)) return 5;
    if (!io.write<codes::trim>(codes::number_of(codes::trim_code::up))) return 6;
    if (!io.write<codes::odd>(codes::odd_code::minus_20)) return 7;
    const auto mode = io.read<codes::mode>();
    if (!mode || *mode != codes::mode_code_::for_ever) return 8;
    std::puts("done");
}
"""
VALUES = """# name = values
# writes_blocks_only = yes
# highest_address = 247
address,name,words,type,access,scale,unit,min,max,default,flags,names,word_order,table,bits,offset,none,factor,byte_order
0x0000,relay,,bool,rw,,,,,,,0x5500=toggle,,coil,,,,,
0x0010,setpoint,,f32,rw,,degC,-10,50,21,,,,,,,,,
0x0012,mass,,f64,ro,1/1000,kg,,,,,,,,,,,,
0x0020,energy,,u64,ro,,Wh,,,,,,,,,,0xFFFFFFFFFFFFFFFF;0x8000000000000000,,
0x0024,balance,,i64,rw,,,,,,,,low,,,,-1,,
0x0030,serial,5,text,rw,,,,,,,,,,,,,,
0x0035,model,4,text,ro,,,,,,,,,,,,,,low
0x0040,mode,,u16,rw,,,,,,,0=auto;1=manual,,,0..3,,,,
0x0040,level,,u16,ro,,%,,,,,,,,4..15,,,,
0x0041,inside,,i16,ro,,degC,,,,,,,,high,,,,
0x0041,outside,,i16,ro,,degC,,,,,,,,low,,,,
0x0042,hour,,bcd16,rw,,h,,,,,,,,,,,,
0x0043,ct1,,sm32,rw,0.001,A,,,,,,,,,,,,
0x0045,battery,,u16,ro,0.1,degC,,,,,,,,,-1000,0xFFFF,,
0x0046,ac_power,,i32,ro,,W,,,,,,,,,,0x80000000,,
0x0048,daily,,u32,ro,0.1,kWh,,,,,,low,,,,,,
0x0050,power,,i16,ro,,W,,,,,,,,,,0x8000,10^power_exponent,
0x0051,power_exponent,,i16,ro,,,,,,,,,,,,0x8000,,
0x0052,current,,u16,ro,0.001,A,,,,,,,,,,,ct_ratio,
0x0053,ct_ratio,,u16,rw,,times,1,1000,1,,,,,,,,,
0x0054,swapped,,f32,ro,,V,,,,,,low,,,,,,low
0x0056,co2,,u16,ro,0.1,ppm,0,5000,415,,,,,,,,,
0x0057,code,,u32,ro,,,,,,,0=none;0x80000000=broken,,,,,,,
0x0059,date,,bcd32,ro,,,,,,,,,,,,,,
0x005B,trim,,sm16,rw,,mm,-100,100,0,,,,,,,,,
0x0000,voltage,,f32,ro,,V,,,,,,,input,,,,,
0x0002,scaled,,u16,ro,,W,,,,,,,input,,,,10^exponent,
0x0003,exponent,,i16,ro,,,,,,,,,input,,,,,
"""
VALUES_IN_CPP = [
    "#include <servobus/registers/device_unit.hpp>\n",
    "#include <servobus/registers/value_forms.hpp>\n",
    ".writes_blocks_only = servobus::block_writes::all",
    "rw<servobus::f32> setpoint{0x0010, {-10, 50}, servobus::units::degree_celsius, 21}",
    "rw<servobus::with<servobus::i64, servobus::or_none<-1>, servobus::low_word_first>> balance{",
    "servobus::or_none<-1, -9223372036854775807 - 1>",
    "rw<servobus::text_of<5>> serial{",
    "ro<servobus::with<servobus::text_of<4>, servobus::low_byte_first>> model{",
    "rw<servobus::with<servobus::u16, servobus::bits<0, 3>>> mode{",
    "ro<servobus::with<servobus::i16, servobus::high_byte>> inside{",
    "rw<servobus::bcd<1>> hour{",
    "rw<servobus::sign_magnitude<2>> ct1{",
    "ro<servobus::with<servobus::u16, servobus::offset<-1000>, servobus::or_none<65535>>> battery{",
    "ro<servobus::with<servobus::i16, servobus::or_none<-32768>, servobus::ten_to<power_exponent>>> power{",
    "ro<servobus::with<servobus::u16, servobus::times_row<ct_ratio>>> current{",
    "ro<servobus::with<servobus::f32, servobus::low_word_first, servobus::low_byte_first>> swapped{",
    "servobus::units::device_unit / 10",
    'servobus::form_with_symbol(servobus::list("co2", ::values::co2), "ppm")',
    "enum class code_code : std::uint32_t {\n    none = 0,\n    broken = 2147483648,\n};",
    "input<servobus::with<servobus::u16, servobus::ten_to<exponent>>> scaled{{",
    "    {0xFFFF, 0x5500, \"toggle\"},",
]
# A catalogue in a header for each table that has rows.
CATALOGUES = {"coil": "coil_catalogue", "discrete": "discrete_input_catalogue", "holding": "catalogue",
              "input": "input_register_catalogue"}
TABLES = {"coil": "coils", "discrete": "discrete_inputs", "holding": "holding_registers", "input": "input_registers"}

PRINTS = """
#include <cstdio>

#include <examples/servobus/device_file/map_text.hpp>

static void print(const servobus::catalogue& of, servobus::table in, const servobus::catalogue* inputs,
                  const servobus::catalogue& holding) {
    for (const servobus::entry& e : of.entries) {
        const bool is_by_input = e.form != nullptr && e.form->scale_table == servobus::table::input_registers;
        const char* const by = tool::scaling_name(e, is_by_input ? inputs->entries : holding.entries);
        std::puts(tool::map_row(e, *of.device, of.sentence(e), in, by).c_str());
    }
}

static void begin(const servobus::profile& of) {
    std::fputs(tool::profile_lines(of).c_str(), stdout);
    std::puts(tool::map_header(true).c_str());
}

"""
USES_DRIVES = """
// Rows are rows of the library, which a client reads and writes.
static_assert(servobus::is_register<meter::voltage> && servobus::is_bit<plant::pump>);
static_assert(servobus::table_of<plant::level> == servobus::table::input_registers);
static_assert(servobus::row_type<meter::delete_>::rights == servobus::access::rw);
static_assert(meter::delete_.address == 0x11 && meter::delete__.address == 0x12 && meter::names_.address == 0x15);
static_assert(zlac8015d::left_max_current.limits.high == 300);
static_assert(servobus::has_fixed_word_order<meter::device> && !servobus::has_fixed_word_order<c630s::device>);
"""


def program(maps: dict[str, str], more: str = "") -> str:
    headers = "".join(f'#include "{device}.hpp"\n' for device in maps)
    calls = ""
    for device, shown in maps.items():
        space = device.replace("-", "_")
        calls += f"    begin({space}::device::facts);\n"
        tables = {row["table"] for row in csv.DictReader(line for line in shown.splitlines() if not line.startswith("#"))}
        inputs = f"&{space}::input_register_catalogue" if "input" in tables else "nullptr"
        for table, catalogue in CATALOGUES.items():
            if table in tables:
                calls += f"    print({space}::{catalogue}, servobus::table::{TABLES[table]}, {inputs}, {space}::catalogue);\n"
    return f"{headers}{PRINTS}{more}\nint main() {{\n{calls}}}\n"


def compiles(tool: Tool, name: str, program: str, *words: str) -> bool:
    """Compiles NAME.cpp, with more sources and options, to NAME."""
    tool.write(f"{name}.cpp", program)
    compiled = subprocess.run(
        [*os.environ.get("CXX", "g++").split(), "-std=c++20", "-O0", *STRICT, f"-I{ROOT}/include", f"-I{ROOT}",
         f"{name}.cpp", *words, "-o", name],
        cwd=tool.folder, capture_output=True, text=True, check=False)
    tool.check(f"the program {name} compiles", compiled.returncode == 0, compiled.stderr)
    return compiled.returncode == 0


@scene()
def enumerations(tool: Tool):
    tool.write("codes.csv", CODES)
    header = tool.run("header codes.csv")
    tool.check("header codes.csv is made", header.status == 0 and header.err == "")
    tool.write("codes.hpp", header.out)
    tool.out_has("with the codes of a row",
                 "enum class mode_code_ : std::uint16_t {\n    off = 0,\n    once = 1,\n    for_ever = 2,\n};\n")
    tool.out_has("with the texts of names that are others", "    code_9600_Bd = 0, ///< 9600 Bd\n")
    if not compiles(tool, "uses_codes", USES_CODES, "-fno-exceptions", "-fno-rtti"):
        return
    with tool.simulated("codes.csv"):
        used = tool.run("", program=[str(tool.folder / "uses_codes")])
        tool.check("a program uses them with the simulated device", used.status == 0 and used.out == "done\n")
        tool.says("and the tool reads what it has written", "read drive codes.csv mode trim odd",
                  "mode=for_ever (0x0002)", "trim=up (0x0001)", "odd=-20 (0x0005)")


@scene()
def comes_back(tool: Tool):
    tool.write("meter.csv", METER)
    tool.write("plant.csv", PLANT)
    tool.write("codes.csv", CODES)
    maps = {}
    for device in (*DRIVES, "meter.csv", "plant.csv", "codes.csv"):
        name = device.removesuffix(".csv")
        maps[name] = tool.run(f"map {device} --long --profile").out
        header = tool.run(f"header {device}")
        tool.check(f"header {device} is made", header.status == 0 and header.err == "")
        tool.write(f"{name}.hpp", header.out)
    print_maps(tool, maps, USES_DRIVES)


def print_maps(tool: Tool, maps: dict[str, str], more: str = ""):
    """A program with the headers of devices prints the maps that they were made of."""
    if not compiles(tool, "prints", program(maps, more), f"{ROOT}/examples/servobus/device_file/map_text.cpp"):
        return
    printed = tool.run("", program=[str(tool.folder / "prints")]).lines
    for name, shown in maps.items():
        lines = shown.splitlines()
        tool.is_equal(f"{name}: header and map", printed[: len(lines)], lines)
        printed = printed[len(lines):]
    tool.is_equal("and nothing else", printed, [])


@scene()
def values_come_back(tool: Tool):
    """Headers of files with values of every form, and of the device files of the examples."""
    tool.write("values.csv", VALUES)
    maps = {}
    for path in [tool.folder / "values.csv", *sorted((ROOT / "examples/devices").glob("*.csv"))]:
        name = path.stem
        maps[name] = tool.run(f"map {path} --long --profile").out
        header = tool.run(f"header {path}")
        tool.check(f"header {name} is made", header.status == 0 and header.err == "", header.err)
        tool.write(f"{name}.hpp", header.out)
        if name != "values":
            continue
        for line in VALUES_IN_CPP:
            tool.check(f"has {line.splitlines()[0]}", line in header.out)
        tool.check("rows that scale others stand before these",
                   0 < header.out.index(" power_exponent{") < header.out.index(" power{"))
    print_maps(tool, maps)


@scene()
def refused(tool: Tool):
    for cells in ("bcd16,,,", "u16,0.1,times,", "u16,,,1=x"):
        tool.write("scaled.csv", f"address,name,factor,type,scale,unit,names\n1,power,ratio,i16,,,\n2,ratio,,{cells}\n")
        tool.fails(f"a scale that the library does not take, {cells}", "header scaled.csv", 2, "scaled.csv: ratio scales power; "
                   "in a header such a row is u16, i16, u32 or i32, without names and a scale of its own")
    tool.write("bad.csv", "address,name\n1,a b\n")
    tool.fails("a bad file", "header bad.csv", 2, "bad.csv:2: the name 'a b' is no letter")
    tool.fails("no device", "header", 2, "header takes one DEVICE")
    tool.fails("an unknown device", "header zlac9000", 2, "unknown device 'zlac9000'")
    tool.fails("a device without a map", "header raw", 2, "unknown device 'raw'")


play_tool()
