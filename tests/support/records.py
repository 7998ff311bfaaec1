# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Judges the records of `servobus read` and `watch` with the csv and json modules of Python; raises what is wrong."""
import csv
import datetime
import io
import json
import math
import re

TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z")
NUMBER = re.compile(r"-?\d+(\.\d+)?")
FIRST = ["time", "error", "unix_time (ms)"]


class Wrong(Exception):
    pass


def must(condition, words):
    if not condition:
        raise Wrong(words)


def unix_ms(text):
    must(TIME.fullmatch(text), f"no time: {text}")
    at = datetime.datetime.strptime(text, "%Y-%m-%dT%H:%M:%S.%fZ").replace(tzinfo=datetime.timezone.utc)
    return round(at.timestamp() * 1000)


def must_ascend(times):
    for before, after in zip(times, times[1:]):
        must(before <= after, f"{after} after {before}")


def csv_records(text):
    """Returns the names of the columns, and the rows."""
    rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    must(rows and rows[0][:3] == FIRST, f"header {rows[:1]}")
    names = rows[0]
    must(len(set(names)) == len(names), "two columns have one name")
    for row in rows[1:]:
        must(len(row) == len(names), f"{len(row)} cells for {len(names)} columns: {row}")
        must(unix_ms(row[0]) == int(row[2]), f"two times: {row}")
        for cell in row[3:]:
            must(cell == "nan" or NUMBER.fullmatch(cell), f"no number: {row}")
        must(("nan" in row[3:]) == (row[1] != ""), f"nan without a reason, or a reason without nan: {row}")
    must_ascend([int(row[2]) for row in rows[1:]])
    return names, rows[1:]


# ModbusScope splits each line at every comma, whatever is quoted, takes the columns from the time on, and refuses the
# file at a cell that is no number; it reads an empty one as 0 (src/importexport/datafileparser.cpp).
def must_load_into_modbusscope(text):
    lines = text.split("\n")
    must(lines.pop() == "", "the last line has no end")
    cells = [line.split(",") for line in lines]
    for row in cells:
        must(len(row) == len(cells[0]), f"another number of fields: {row}")
        must(not any('"' in cell or "\r" in cell for cell in row), f"a quote or a carriage return: {row}")
    for row in cells[1:]:
        for cell in row[2:]:
            must(cell != "", f"an empty field, which is 0: {row}")
            float(cell)


def no_duplicates(pairs):
    must(len({name for name, _ in pairs}) == len(pairs), f"a name twice: {pairs}")
    return dict(pairs)


def no_constant(text):
    raise Wrong(f"{text} is no JSON")


def json_records(text):
    lines = text.split("\n")
    must(lines.pop() == "", "the last line has no end")
    records = [json.loads(line, object_pairs_hook=no_duplicates, parse_constant=no_constant) for line in lines]
    for r in records:
        must(list(r) == ["time", "unix_ms", "registers", "errors"], f"keys {list(r)}")
        must(list(r["registers"]) == list(records[0]["registers"]), f"other registers: {r}")
        must(unix_ms(r["time"]) == r["unix_ms"], f"two times: {r}")
        for name, register in r["registers"].items():
            must(set(register) <= {"value", "unit", "text"} and "value" in register, f"{name}: {register}")
            if "text" in register:
                must((register["text"] is None) == (register["value"] is None), f"{name}: {register}")
        values = [register["value"] for register in r["registers"].values()]
        must((None in values) == (r["errors"] != {}), f"null without an error, or an error without null: {r}")
    must_ascend([r["unix_ms"] for r in records])
    return records


# What one line of `read` says, as {column: (number, unit, text)}.
def expected(line, rows):
    name, value = line.split("=", 1)
    coded = re.fullmatch(r"(?:(\S+) \()?0x([0-9A-F]{4})\)?", value)
    if name.startswith("0x"):
        return {name: (float(value.split()[0]), None, None)}
    row = rows[name]
    if coded:
        word = int(coded[2], 16)
        if row["type"] == "i16" and word >= 0x8000:
            word -= 0x10000
        return {name: (float(word), None, coded[1] or "0x" + coded[2])}
    number, _, unit = value.removesuffix(" (at the factory's scale)").partition(" ")
    if value.endswith("scale)"):
        return {name: (float(number) / float(row["scale"]), "counts", None)}
    if "/" in number:
        left, right = number.split("/")
        return {name + "_left": (float(left), unit or None, None), name + "_right": (float(right), unit or None, None)}
    return {name: (float(number), unit or None, None)}


def must_be_csv(text, rows, or_more=False):
    """A header and that many rows."""
    found = len(csv_records(text)[1])
    must(found >= rows if or_more else found == rows, f"{found} records")
    must_load_into_modbusscope(text)


def must_be_json(text, records):
    found = len(json_records(text))
    must(found == records, f"{found} records")


def must_be_recent(text):
    """The last record of CSV is of the last minute."""
    age = datetime.datetime.now().timestamp() * 1000 - int(csv_records(text)[1][-1][2])
    must(0 <= age < 60_000, f"{age} ms old")


def found_in_csv(text):
    names, records = csv_records(text)
    for name, cell in zip(names[3:], records[0][3:], strict=True):
        bare, unit = re.fullmatch(r"(\S+)(?: \((.+)\))?", name).groups()
        yield bare, (float(cell), unit, None)


def found_in_json(text):
    for name, register in json_records(text)[0]["registers"].items():
        yield name, (float(register["value"]), register.get("unit"), register.get("text"))


def must_be_like_read(kind, text, read, register_map):
    """The record has what `read` has printed, by the units of `map`."""
    rows = {row["name"]: row for row in csv.DictReader(io.StringIO(register_map))}
    wanted = {}
    for line in read.splitlines():
        wanted.update(expected(line, rows))
    must(wanted, "nothing was read")
    if kind == "csv":
        wanted = {name: (number, unit, None) for name, (number, unit, _) in wanted.items()}
    found = dict(found_in_csv(text) if kind == "csv" else found_in_json(text))
    must(list(found) == list(wanted), f"columns {list(found)}, not {list(wanted)}")
    for name, (number, unit, text) in wanted.items():
        is_same = math.isclose(found[name][0], number, rel_tol=1e-12, abs_tol=1e-12)
        must(is_same and found[name][1:] == (unit, text), f"{name}: {found[name]}, not {(number, unit, text)}")
