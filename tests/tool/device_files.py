# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Files that describe a device: what is read of them, and what is refused with the file's line."""
import csv
import io
import random
import re
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene

DEVICES = "zlac8015d", "yako-closed-loop", "yako-open-loop", "c630s"
FULL = ("address,name,words,type,access,saved,when,effective,modes,min,max,default,scale,unit,description,"
        "flags,names,word_order,table,bits,offset,none,factor,byte_order")
MANY_SECONDS = 60  # two are usual; with sanitizers, on a busy machine, half a minute


def profile_and_rows(text: str) -> tuple[list[str], list[dict[str, str]]]:
    lines = text.splitlines()
    profile = [line for line in lines if line.startswith("#")]
    return profile, list(csv.DictReader(lines[len(profile):]))


def file_of(profile: list[str], rows: list[dict[str, str]], columns: list[str], end: str) -> str:
    out = io.StringIO()
    table = csv.DictWriter(out, columns, lineterminator=end, extrasaction="ignore")
    table.writeheader()
    table.writerows(rows)
    return "".join(line + end for line in profile) + out.getvalue()


@scene(*DEVICES)
def comes_back(tool: Tool, device: str):
    """A drive's map as a file is the same map, in whatever form a spreadsheet leaves it."""
    shown = tool.run(f"map {device} --long --profile").out
    tool.write("copy.csv", shown)
    tool.is_equal(f"{device}: map, file, map", tool.run("map copy.csv --long --profile").out, shown)
    tool.is_equal(f"{device}: without the profile", tool.run("map ./copy.csv --long").out,
                  tool.run(f"map {device} --long").out)
    profile, rows = profile_and_rows(shown)
    columns = list(rows[0])
    shuffle = random.Random(len(rows)).shuffle
    for name, end in [("rows and columns in another order", "\n"), ("lines that end with CR LF", "\r\n")]:
        shuffle(rows)
        shuffle(columns)
        shuffle(profile)
        text = file_of(profile, rows, columns, end)
        tool.write("other.csv", "\ufeff## from a spreadsheet\n\n" + text + "," * (len(columns) - 1) + "\n")
        again = tool.run("map other.csv --long --profile").out
        tool.is_equal(f"{device}: {name}, a byte order mark", sorted(again.splitlines()), sorted(shown.splitlines()))
        tool.is_equal(f"{device}: and the rows by address", profile_and_rows(again)[1], profile_and_rows(shown)[1])
    tool.write("short.csv", file_of([], rows, ["name", "address"], "\n"))
    short = profile_and_rows(tool.run("map short.csv").out)[1]
    tool.check(f"{device}: address and name are enough", len(short) == len(rows) and
               all((row["type"], row["access"], row["scale"]) == ("u16", "ro", "1") for row in short))


@scene()
def one_register_of_a_file(tool: Tool):
    tool.write("meter.csv", 'address,name,unit,scale,description\n0x0010,voltage,V,0.1,"Between L1, ""N""."\n')
    tool.says("a register in words", "map meter.csv voltage", "voltage", 'Between L1, "N".', "", "address    0x0010",
              "type       u16", "access     read-only", "unit       0.1 V")
    tool.says("with its sentence in quotes", "map meter.csv --long", FULL,
              '0x0010,voltage,1,u16,ro,no,,,,,,,0.1,V,"Between L1, ""N"".",,,,holding,,,,,')
    tool.fails("an unknown one", "map meter.csv amperage", 2,
               "meter has no register 'amperage'; servobus map meter.csv lists them")
    tool.fails("one of a name nearby", "map meter.csv votlage", 2, "did you mean voltage?")
    tool.write("plain.csv", "address,name\n10h,first\n17,second\n")
    tool.says("without a sentence", "map plain.csv first", "first", "", "address    0x0010", "type       u16",
              "access     read-only")
    tool.fails("has no alarms", "alarms meter.csv", 2, "meter.csv: a device file has no alarms")


HEAD = ("address,name,type,access,min,max,default,scale,unit,saved,when,effective,modes,flags,names,word_order,words,table,"
        "bits,offset,none,factor,byte_order\n")
TYPES = "u16, i16, u32, i32, u64, i64, f32, f64, bcd16, bcd32, sm16, sm32 or text"
LATER = "a newer version of servobus may have written the file"


def row(**cells: str) -> str:
    given = {"address": "0x10", "name": "speed", **{key.rstrip("_"): cell for key, cell in cells.items()}}
    return ",".join(given.get(column, "") for column in HEAD.strip().split(",")) + "\n"


# A file, the line that the complaint is about, and the complaint.
WRONG = [
    ("", 1, "the file is empty"),
    ("\n\n", 2, "the file ends before a header line"),
    ("# name = x\n", 1, "the file ends before a header line"),
    ("address,name\n", 1, "there is no row after the header line"),
    ("address,name\n\n## nothing\n,\n", 4, "there is no row after the header line"),
    ("address;name\n0x10;a\n", 1, "unknown column 'address;name'; cells are separated by commas"),
    ("address,nmae\n", 1, "unknown column 'nmae'; did you mean name?"),
    ("address,name,name\n", 1, "the column name is there twice"),
    ("name,unit\na,V\n", 1, "the column address is missing"),
    ("address,unit\n1,V\n", 1, "the column name is missing"),
    ("0x10,a\n", 1, "unknown column '0x10'"),
    ("address,name\n0x10\n", 2, "the row has 1 cell, the header line 2"),
    ("address,name\n0x10,a,b\n", 2, "the row has 3 cells, the header line 2"),
    ('address,name\n0x10,"a\n', 2, "a quote is not closed"),
    ('address,name\n0x10,"a"b\n', 2, "there is text behind the closing quote"),
    ('address,name\n0x10,a"b"\n', 2, "a quote stands inside a cell"),
    ("address,name\n0x10,a\0\n", 2, "a control character (00h)"),
    ("address,name\r0x10,a\r", 1, "a control character (0Dh)"),
    ("address,name\n0x10,a\n# baud = 9600\n", 3, "stands before the header line"),
    (HEAD + row(name=""), 2, "the row has no name"),
    (HEAD + row(name="a b"), 2, "the name 'a b' is no letter"),
    (HEAD + row(name="1a"), 2, "the name '1a' is no letter"),
    (HEAD + row(name="größe"), 2, "the name 'gr????e' is no letter"),
    (HEAD + row(name="a" * 48), 2, "has more than 47 characters"),
    (HEAD + row(name="a" * 47) + row(name="a" * 47, address="1"), 3, "is there twice, first in line 2"),
    (HEAD + row(name="a") + row(), 3, "speed: the address 0x0010 is taken by the row in line 2"),
    (HEAD + row(name="a", type="u32") + row(address="17"), 3, "speed: the address 0x0011 is taken by the pair in line 2"),
    (HEAD + row(name="a", type="u32") + row(), 3, "speed: the address 0x0010 is taken by the pair in line 2"),
    (HEAD + row(name="a") + row(address="15", type="i32"), 3, "the address 0x0010 is taken by the row in line 2"),
    (HEAD + row(address=""), 2, "speed: address takes 0x0000 to 0xFFFF, 8244 or 2034h, not ''"),
    (HEAD + row(address="-1"), 2, "not '-1'"),
    (HEAD + row(address="65536"), 2, "not '65536'"),
    (HEAD + row(address="400021"), 2, "not '400021'; an address is that in the frame, 0x0000 for 40001 or 400001 in a manual"),
    (HEAD + row(address="0x1G"), 2, "not '0x1G'"),
    (HEAD + row(address="65535", type="u32"), 2, "its second word is beyond address 0xFFFF"),
    (HEAD + row(type="u8"), 2, f"type takes {TYPES}, not 'u8'; {LATER}"),
    (HEAD + row(type="f16"), 2, f"not 'f16'; {LATER}"),
    ("address,name,colour\n1,x,red\n", 1, f"unknown column 'colour'; the header line names the columns; {LATER}"),
    (HEAD + row(address="65533", type="u64"), 2, "its last word is beyond address 0xFFFF"),
    (HEAD + row(type="text"), 2, "speed: a text needs its length, in the column words"),
    (HEAD + row(type="text", words="0"), 2, "words takes the registers of a text, 1 to 123, not '0'"),
    (HEAD + row(type="text", words="124"), 2, "words takes the registers of a text, 1 to 123, not '124'"),
    (HEAD + row(type="text", words="nan"), 2, "not 'nan'"),
    (HEAD + row(type="text", words="2", unit="V"), 2, "a text has neither scale nor unit"),
    (HEAD + row(type="text", words="2", min="0", max="1"), 2, "a text has neither min nor max"),
    (HEAD + row(type="text", words="2", default="1"), 2, "a text has no default"),
    (HEAD + row(type="text", words="2", names="1=a"), 2, "names are for whole numbers of one or two registers"),
    (HEAD + row(type="text", words="2", word_order="low"), 2, "word_order is for numbers of several words"),
    (HEAD + row(type="text", words="2", bits="0"), 2, "text has no bits"),
    (HEAD + row(type="text", words="2", offset="1"), 2, "text has no offset"),
    (HEAD + row(type="text", words="2", none="0"), 2, "text has no none"),
    (HEAD + row(type="text", words="2", factor="x"), 2, "text has no factor"),
    (HEAD + row(type="f32", words="4"), 2, "words is '4', but f32 has 2"),
    (HEAD + row(type="f32", min="5", max="-5"), 2, "the range is upside down: min 5, max -5"),
    (HEAD + row(type="f32", min="nan", max="5"), 2, "min takes a whole number of its unit, not 'nan'"),
    (HEAD + row(type="f64", min="0", max="inf"), 2, "max takes a whole number of its unit, not 'inf'"),
    (HEAD + row(type="f32", min="0", max="1", default="NaN"), 2, "default takes a whole number of its unit, not 'NaN'"),
    (HEAD + row(type="f32", min="0", max="1", default="2"), 2, "default 2 is outside 0 .. 1"),
    (HEAD + row(type="f32", scale="inf", unit="V"), 2, "scale takes 0.1, 25, 1/3 or the like, of numbers up to 65535, not 'inf'"),
    (HEAD + row(type="f32", scale="nan", unit="V"), 2, "scale takes"),
    (HEAD + row(type="f32", offset="1"), 2, "f32 has no offset"),
    (HEAD + row(type="f32", factor="x"), 2, "f32 has no factor: a program scales it"),
    (HEAD + row(type="f32", names="0=off"), 2, "names are for whole numbers of one or two registers"),
    (HEAD + row(type="f32", names="hex"), 2, "hex is for whole numbers"),
    (HEAD + row(type="f32", none="nan"), 2, "none takes raw values of f32, such as 0x8000;0xFFFF, not 'nan'"),
    (HEAD + row(type="f32", none="0x100000000"), 2, "none takes raw values of f32"),
    (HEAD + row(type="f32", bits="0..3"), 2, "f32 has no bits: bits are of one register"),
    (HEAD + row(type="u64", names="0=off"), 2, "names are for whole numbers of one or two registers"),
    (HEAD + row(type="u64", max="9223372036854775808", min="0"), 2, "max takes a whole number of counts, not '9223372036854775808'"),
    (HEAD + row(type="i64", none="0x10000000000000000"), 2, "none takes raw values of i64"),
    (HEAD + row(type="i64", none="-9223372036854775809"), 2, "none takes raw values of i64"),
    (HEAD + row(type="u64", default="-1"), 2, "default -1 is outside 0 .. 9223372036854775807"),
    (HEAD + row(none="0x10000"), 2, "none takes raw values of u16, such as 0x8000;0xFFFF, not '0x10000'"),
    (HEAD + row(none="-32769"), 2, "none takes raw values of u16"),
    (HEAD + row(none="0xFFFF;"), 2, "none takes"),
    (HEAD + row(none="inf"), 2, "none takes"),
    (HEAD + row(offset="1.5"), 2, "offset takes a whole number of counts up to 2147352576, not '1.5'"),
    (HEAD + row(offset="1", type="i64"), 2, "i64 has no offset"),
    (HEAD + row(bits="high", byte_order="low"), 2, "byte_order low is for whole registers"),
    (HEAD + row(offset="2147483648"), 2, "offset takes"),
    (HEAD + row(offset="nan"), 2, "offset takes"),
    (HEAD + row(offset="-1000", max="65000", min="0"), 2, "is not inside u16, -1000 .. 64535"),
    (HEAD + row(byte_order="big"), 2, "byte_order takes low, high or nothing, not 'big'"),
    (HEAD + row(bits="4..2"), 2, "bits takes 7, 0..3, high or low, of bits 0 to 15, not '4..2'"),
    (HEAD + row(bits="16"), 2, "bits takes"),
    (HEAD + row(bits="0..16"), 2, "bits takes"),
    (HEAD + row(bits="-1"), 2, "bits takes"),
    (HEAD + row(bits="nan..3"), 2, "bits takes"),
    (HEAD + row(bits="0..3", type="u32"), 2, "u32 has no bits: bits are of one register"),
    (HEAD + row(bits="0..2", type="bcd16"), 2, "bits takes four bits a digit for bcd16"),
    (HEAD + row(bits="0..3", max="16", min="0"), 2, "the range 0 .. 16 is not inside u16, 0 .. 15"),
    (HEAD + row(bits="0..3", names="16=x"), 2, "'16' is no code of u16"),
    (HEAD + row(bits="0..3", names="b4=x"), 2, "'b4' is no bit from b0 to b3"),
    (HEAD + row(bits="high", names="halves"), 2, "halves are of a whole register, u16 or i16"),
    (HEAD + row(bits="0..3") + row(name="b", bits="3..5"), 3, "b: a bit of it is taken by the row in line 2"),
    (HEAD + row(bits="low") + row(name="b", bits="high") + row(name="c", bits="15"), 4, "c: a bit of it is taken by the row in line 3"),
    (HEAD + row(bits="low") + row(name="b"), 3, "b: the address 0x0010 is taken by the row in line 2"),
    (HEAD + row() + row(name="b", bits="low"), 3, "b: the address 0x0010 is taken by the row in line 2"),
    (HEAD + row(address="15", type="u32") + row(name="b", bits="low"), 3, "the address 0x0010 is taken by the pair in line 2"),
    (HEAD + row(factor="10^sf"), 2, "speed: factor names 'sf', but the file has no such row"),
    (HEAD + row(factor="10^0x20"), 2, "factor names '0x20', but the file has no such row"),
    (HEAD + row(factor="10^"), 2, "factor takes 10^ROW of an exponent, or the ROW of a factor, not '10^'"),
    (HEAD + row(factor="nan"), 2, "factor names 'nan', but the file has no such row"),
    (HEAD + row(factor="10^speed"), 2, "factor names 'speed', the row itself"),
    (HEAD + row(factor="b") + row(name="b", address="17", factor="speed"), 2, "factor names 'b', which another row scales itself"),
    (HEAD + row(factor="b") + row(name="b", address="17", factor="c") + row(name="c", address="18"), 2, "factor names 'b', which another row scales itself"),
    (HEAD + row(factor="b") + row(name="b", address="17", type="f32"), 2, "factor names 'b', which is no whole number of one or two registers"),
    (HEAD + row(factor="b") + row(name="b", address="17", type="u64"), 2, "which is no whole number"),
    (HEAD + row(factor="b") + row(name="b", address="17", bits="0..3"), 2, "which is no whole number"),
    (HEAD + row(factor="b") + row(name="b", address="17", table="coil"), 2, "which is no whole number"),
    (HEAD + row(factor="b") + row(name="b", address="17", access="wo"), 2, "factor names 'b', which cannot be read"),
    (HEAD + row(table="coil", bits="0"), 2, "bool has no bits"),
    (HEAD + row(table="coil", offset="1"), 2, "bool has no offset"),
    (HEAD + row(table="coil", none="1"), 2, "bool has no none"),
    (HEAD + row(table="coil", factor="x"), 2, "bool has no factor"),
    (HEAD + row(table="coil", byte_order="low"), 2, "bool has no byte_order"),
    (HEAD + row(table="coil", names="0xFF00=x"), 2, "'0xFF00' is no code of bool"),
    (HEAD + row(table="coil", names="0x10000=x"), 2, "'0x10000' is no code of bool"),
    (HEAD + row(table="discrete", names="0x5500=x"), 2, "'0x5500' is no code of bool"),
    (HEAD + row(type="u32", names="0xFFFF:1=x"), 2, "'0xFFFF:1' is the low word of a pair: name its bits"),
    (HEAD + row(type="u32", names="b32=x"), 2, "'b32' is no bit from b0 to b31"),
    (HEAD + row(type="u32", names="4294967296=x"), 2, "'4294967296' is no code of u32"),
    (HEAD + row(type="u32", words="1"), 2, "words is '1', but u32 has 2"),
    (HEAD + row(access="r"), 2, "access takes ro, rw or wo, not 'r'"),
    (HEAD + row(min="5", max="4"), 2, "the range is upside down: min 5, max 4"),
    (HEAD + row(min="5"), 2, "min and max are given both, or neither"),
    (HEAD + row(max="5"), 2, "min and max are given both, or neither"),
    (HEAD + row(min="1.5", max="4"), 2, "min takes a whole number of counts, not '1.5'"),
    (HEAD + row(min="0", max="65536"), 2, "the range 0 .. 65536 is not inside u16, 0 .. 65535"),
    (HEAD + row(min="-1", max="5"), 2, "is not inside u16"),
    (HEAD + row(min="1", max="5", default="6"), 2, "default 6 is outside 1 .. 5"),
    (HEAD + row(type="i16", default="32768"), 2, "default 32768 is outside -32768 .. 32767"),
    (HEAD + row(default="x"), 2, "default takes a whole number of counts, not 'x'"),
    (HEAD + row(default="9" * 30), 2, "default takes a whole number"),
    (HEAD + row(scale="0", unit="V"), 2, "scale takes 0.1, 25, 1/3"),
    (HEAD + row(scale="-1", unit="V"), 2, "scale takes"),
    (HEAD + row(scale="1/0", unit="V"), 2, "scale takes"),
    (HEAD + row(scale="1e3", unit="V"), 2, "scale takes"),
    (HEAD + row(scale="0.000001", unit="V"), 2, "scale takes"),
    (HEAD + row(scale="0.1"), 2, "scale '0.1' needs a unit; that of a plain ratio is times"),
    (HEAD + row(unit='"a,b"'), 2, "unit takes a symbol of at most 31 bytes without commas and quotes, not 'a,b'"),
    (HEAD + row(unit="x" * 32), 2, "unit takes a symbol of at most 31 bytes"),
    (HEAD + row(saved="true"), 2, "saved takes yes or no, not 'true'"),
    (HEAD + row(when="always"), 2, "when takes stopped, running or nothing"),
    (HEAD + row(effective="now"), 2, "effective takes immediate, at_stop, power_cycle or nothing"),
    (HEAD + row(modes="PP"), 2, "modes takes ALL, letters of PST or nothing"),
    (HEAD + row(modes="X"), 2, "modes takes"),
    (HEAD + row(access="rw", flags="moton"), 2, "unknown flag 'moton'; did you mean motion?"),
    (HEAD + row(access="rw", flags="xyz"), 2, "unknown flag 'xyz'; known: saved_on_write, trigger"),
    (HEAD + row(access="rw", flags="motion;motion"), 2, "the flag motion is given twice"),
    (HEAD + row(access="rw", flags="motion;"), 2, "unknown flag ''"),
    (HEAD + row(access="ro", flags="motion"), 2, "access ro and the flag motion contradict each other"),
    (HEAD + row(flags="trigger"), 2, "contradict each other (ro, since the cell access is empty)"),
    (HEAD + row(access="rw", flags="saved_on_write", saved="no"), 2, "saved no and the flag saved_on_write contradict"),
    (HEAD + row(access="rw", flags="zero_by_name", min="1", max="2"), 2, "but 0 is outside the range"),
    (HEAD + row(names="0"), 2, "names takes 3=enable, b3=ready, 0x00C0:0x0040=locked, hex or halves, not '0'"),
    (HEAD + row(names="x=off"), 2, "'x' is no code of u16"),
    (HEAD + row(names="pulse=2"), 2, "names takes CODE=name, as in '2=pulse', not 'pulse=2'"),
    (HEAD + row(names="bypass=2"), 2, "names takes CODE=name, as in '2=bypass', not 'bypass=2'"),
    (HEAD + row(names="open=1", table="coil"), 2, "names takes CODE=name, as in '1=open', not 'open=1'"),
    (HEAD + row(names="-1=off"), 2, "'-1' is no code of u16"),
    (HEAD + row(names="b16=off"), 2, "'b16' is no bit from b0 to b15"),
    (HEAD + row(names="3:4=off"), 2, "'3:4' is no MASK:VALUE of bits inside the mask"),
    (HEAD + row(names="0:0=off"), 2, "'0:0' is no MASK:VALUE"),
    (HEAD + row(names="0="), 2, "a code or bit has no name"),
    (HEAD + row(names="0=a+b"), 2, "has a character that is not ASCII, or one of"),
    (HEAD + row(names="0=" + "a" * 48), 2, "has more than 47 characters"),
    (HEAD + row(names="0=0x10"), 2, "the name '0x10' would be read as a number"),
    (HEAD + row(names="0=1"), 2, "the name '1' is also another value of the register"),
    (HEAD + row(names="0=off;1=off"), 2, "the name 'off' is there twice"),
    (HEAD + row(names="0=a b;1=a_b"), 2, "is there twice"),
    (HEAD + row(names="0=off;0=on"), 2, "a code has two names: 'off' and 'on'"),
    (HEAD + row(names="b3=x;0x8:0x8=y"), 2, "a code has two names"),
    (HEAD + row(word_order="low"), 2, "word_order is for numbers of several words"),
    (HEAD + row(word_order="big", type="u32"), 2, "word_order takes high, low, selectable or nothing"),
    (HEAD + row(word_order="selectable", type="u32"), 2, "no line '# word_order_register = ADDRESS'"),
    (HEAD + row(table="coils"), 2, "table takes coil, discrete, holding or input, not 'coils'"),
    (HEAD + row(type="bool"), 2, "type 'bool' and table holding contradict each other"),
    (HEAD + row(type="u16", table="coil"), 2, "type 'u16' and table coil contradict each other"),
    (HEAD + row(access="rw", table="input"), 2, "access rw and table input contradict each other"),
    (HEAD + row(access="wo", table="discrete"), 2, "access wo and table discrete contradict each other"),
    (HEAD + row(unit="V", table="coil"), 2, "a bit has neither scale nor unit"),
    (HEAD + row(names="hex", table="coil"), 2, "a bit has neither halves nor hex"),
    (HEAD + row(min="0", max="2", table="coil"), 2, "the range 0 .. 2 is not inside bool, 0 .. 1"),
    (HEAD + row(words="2", table="coil"), 2, "words is '2', but bool has 1"),
    (HEAD + row(table="input") + row(name="b", table="input"), 3, "is taken by the row in line 2"),
    (HEAD + row(table="input") + row(table="coil"), 3, "the name speed is there twice, first in line 2"),
    (HEAD + row() + row(name="b", address="\033[31m"), 3, "a control character (1Bh)"),
]
# The same of lines of the profile, in front of a file that is good.
WRONG_PROFILES = [
    ("# bauds = 9600", 1, "unknown key 'bauds'; did you mean baud?"),
    ("#", 1, "'#' and no key = value"),
    ("# my meter", 1, "'#' and no key = value: 'my meter'; a line that begins with ## is a comment"),
    ("# file_format = 2", 1, "file_format '2' is of a later version of this tool, which reads 1"),
    ("# file_format = 0", 1, "file_format takes a whole number from 1 to 1"),
    ("# name = a b", 1, "name takes letters"),
    ("# name = " + "a" * 48, 1, "name takes letters"),
    ("# baud = fast", 1, "baud takes a whole number from 600 to 4000000, not 'fast'"),
    ("# baud = 9600\n# baud = 9600", 2, "'baud' is given twice"),
    ("# highest_address = 256", 1, "highest_address takes a whole number from 1 to 255"),
    ("# byte_order = big", 1, "byte_order takes high or low, not 'big'"),
    ("# writes_blocks_only = 1", 1, "writes_blocks_only takes yes, registers, coils or no, not '1'"),
    ("# colour = red", 1, f"unknown key 'colour'; a line that begins with ## is a comment; {LATER}"),
    ("# lowest_address = 9\n# highest_address = 8", 1, "lowest_address 9 is above highest_address 8"),
    ("# character_format = 7E1", 1, "character_format takes 8N1, 8N2, 8E1 or 8O1"),
    ("# word_order = big", 1, "word_order takes high, low or selectable, not 'big'"),
    ("# name = x\n# word_order = selectable", 2, "needs a line '# word_order_register = ADDRESS'"),
    ("# word_order_register = 5", 1, "needs a line '# word_order = selectable'"),
    ("# max_read = 126", 1, "max_read takes a whole number from 1 to 125"),
    ("# gap_ms = 1.0005", 1, "gap_ms takes milliseconds from 0 to 60000, not '1.0005'"),
    ("# gap_ms = 1.", 1, "gap_ms takes"),
    ("# response_ms = 0", 1, "response_ms takes"),
    ("# echoes_byte_count = 1", 1, "echoes_byte_count takes yes or no"),
    ("# exception_0 = x", 1, "is none of exception_1 to exception_255"),
    ("# exception_01 = x", 1, "is none of exception_1 to exception_255"),
    ("# exception_\u1234 = x", 1, "'exception_???' is none of exception_1 to exception_255"),
    ("# exception_2 =", 1, "takes its meaning"),
    ("# exception_2 = größe", 1, "is no ASCII text"),
]


@scene()
def wrong_files(tool: Tool):
    """Nothing is sent: there is no such port, which would be another complaint and status 1."""
    files = WRONG + [(f"{lines}\n{HEAD}{row()}", number, why) for lines, number, why in WRONG_PROFILES]
    for number, (text, line, why) in enumerate(files):
        tool.write("bad.csv", text)
        ended = tool.run("read nowhere bad.csv:1 speed")
        is_so = ended.status == 2 and ended.err.startswith(f"servobus: bad.csv:{line}: ") and why in ended.err
        is_so = is_so and len(ended.err_lines) == 1 and ended.out == "" and "\033" not in ended.err
        tool.check(f"file {number}, {why[:60]}", is_so, f"expected {line}: {why}\n{tool.found()}")


@scene()
def units(tool: Tool):
    """The page lists the units that the tool knows. Others are kept."""
    page = (Path(__file__).resolve().parents[2] / "examples/servobus/README.md").read_text("utf-8")
    listed = re.search(r"(?m)^The units are (.+(?:\n.+)*)", page)
    symbols = re.findall(r"`([^`]+)`", listed[1]) if listed else []
    rows = "".join(f"{i},register_{i},{symbol}\n" for i, symbol in enumerate(symbols))
    tool.write("all.csv", f"address,name,unit\n{rows}")
    tool.check("each unit of the page is one", symbols and tool.run("map all.csv").status == 0, tool.found())
    tool.is_equal("and shown", [shown["unit"] for shown in profile_and_rows(tool.last.out)[1]], symbols)
    tool.write("own.csv", "address,name,unit\n1,a,ppm\n2,b,kvar\n3,c,mV/m\n4,d,°C\n5,e,rpm\n6,f,µg/m³\n7,g,% RH\n")
    shown = [shown["unit"] for shown in profile_and_rows(tool.run("map own.csv").out)[1]]
    tool.is_equal("another one is kept, or is one of these", shown, ["ppm", "kvar", "mV/m", "degC", "r/min", "µg/m³", "% RH"])
    tool.check("meters have theirs", {"Wh", "kWh", "VA", "var", "bar", "l/min", "h"} <= set(symbols))


@scene()
def no_files(tool: Tool):
    (tool.folder / "folder.csv").mkdir()
    for name, word, text in [
        ("a folder", "folder.csv", "cannot read folder.csv: it is a folder"),
        ("a folder by its path", "./", "cannot read ./: it is a folder"),
        ("no file", "none.csv:3", "cannot read none.csv: No such file"),
        ("no file in a folder", "dir/none", "cannot read dir/none: No such file"),
    ]:
        for command in (f"read nowhere {word} x", f"write nowhere {word} x=1", f"watch nowhere {word} x",
                        f"listen nowhere {word}", f"backup nowhere {word}", f"restore nowhere {word} y",
                        f"explain {word}", f"map {word.split(':')[0]}", f"alarms {word.split(':')[0]}"):
            tool.fails(f"{command.split()[0]}: {name}", command, 2, text)
    tool.write("meter.csv", "# highest_address = 32\naddress,name\n1,x\n")
    for word, text in [("meter.csv:33", "'33' is no node address of meter: 1 to 32"),
                       ("meter.csv:x", "'x' is no node address of meter"),
                       ("meter.csv:", "'' is no node address of meter")]:
        tool.fails(f"read {word}", f"read nowhere {word} x", 2, text)


@scene()
def large_files(tool: Tool):
    """Every address has a row, with names and a sentence; a row more is refused; both in a time that is no square."""
    rows = [f'0x{i:04X},register_{i},"Sentence {i}, of many.",0=off;1=on;b5=ready {i}' for i in range(65536)]
    tool.write("large.csv", "address,name,description,names\n" + "\n".join(rows))
    begin = time.monotonic()
    lines = tool.run("map large.csv --long").lines
    tool.check("a row at each address", len(lines) == 65537 and tool.last.status == 0)
    tool.check("the last one is itself", lines[-1].startswith("0xFFFF,register_65535,1,u16,ro,no,"))
    tool.write("more.csv", "address,name\n" + "\n".join(f"{i % 65536},register_{i}" for i in range(100_000)))
    tool.fails("a row more", "map more.csv", 2,
               "more.csv:65538: register_65536: the address 0x0000 is taken by the row in line 2")
    tool.write("names.csv", "address,name,names\n1,x," + ";".join(f"{i}=name {i}" for i in range(65536)))
    tool.check("a register with all codes", tool.run("map names.csv").status == 0)
    tool.write("wide.csv", ",".join(["address", "name"] + ["x"] * 100_000))
    tool.fails("many columns", "map wide.csv", 2, "wide.csv:1: unknown column 'x'")
    tool.write("long.csv", "address,name\n1," + "x" * 1_000_000)
    tool.fails("a long cell", "map long.csv", 2, "long.csv:2: the name '" + "x" * 40 + "...' has more than 47")
    tool.write("huge.csv", "\n" * 33_000_000)
    tool.fails("a large file", "map huge.csv", 2, "huge.csv has more than 32000000 bytes")
    tool.check("in a few seconds", time.monotonic() - begin < MANY_SECONDS, time.monotonic() - begin)


play_tool()
