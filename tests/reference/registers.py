# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Each register is on its page once, with the numbers of the tool's map and the words of the manual's table."""
import csv
import re
import subprocess
from html.parser import HTMLParser

from links import Links
from names import ROOT, file_of

VOID = {"area", "base", "br", "col", "hr", "img", "input", "link", "meta", "wbr"}
# Where a row's words are not the characters of its line in the manual's table, in their order.
OTHER_WORDS = {("yako-open-loop", 0x0065)}  # the heading of the row below it, as in the closed loop's table


class Rows(HTMLParser):
    """The rows of a map's page: their id, their cells' words by label, what of them a filter reads."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.rows, self.row, self.label, self.folded, self.manual = [], None, None, 0, False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        if tag == "tr":
            self.row = None
            if of.get("class") == "register":
                self.row = {"id": of["id"], "also": of["data-also"], "cells": {}, "first": {}, "visible": {},
                            "words": ""}
                self.rows.append(self.row)
        if tag == "td" and self.row is not None:
            self.label = of["data-label"]
            for kind in ("cells", "first", "visible"):
                self.row[kind][self.label] = ""
            self.is_first = True
        if tag == "details":
            self.folded += 1
        if tag in ("small", "details"):
            self.is_first = False
        self.manual = self.manual or of.get("lang") == "zh-Hans"

    def handle_endtag(self, tag):
        if tag == "td":
            self.label = None
        if tag == "tr":
            self.row = None
        if tag == "details":
            self.folded -= 1
        if tag == "span":
            self.manual = False

    def handle_data(self, data):
        if self.row is None or self.label is None:
            return
        self.row["cells"][self.label] += data
        if self.is_first:
            self.row["first"][self.label] += data
        if not self.folded:
            self.row["visible"][self.label] += data
        if self.manual:
            self.row["words"] += data


def rows_of(pages, device):
    return Rows((pages / f"map_{file_of(device)}.html").read_text("utf-8")).rows


def printed_map(tool, device):
    said = subprocess.run([tool, "map", device, "--long"], check=True, capture_output=True, text=True).stdout
    return list(csv.DictReader(said.splitlines()))


def manual_table(device):
    lines = (ROOT / f"tests/manuals/{file_of(device)}.tsv").read_text("utf-8").splitlines()
    table = csv.DictReader((line for line in lines if not line.startswith("#")), delimiter="\t")
    return {int(row["address"].removesuffix("h"), 16): row for row in table}


def is_part_of(words, whole):
    """True if the characters of `words` stand in `whole` in this order."""
    rest = iter(whole)
    return all(any(c == other for other in rest) for c in words)


def errata_of_headers(device):
    """By address: the errata in the comment of the row, of an array its first element."""
    room = {"yako-closed-loop": ["yako/common.hpp", "yako/closed_loop.hpp"],
            "yako-open-loop": ["yako/common.hpp", "yako/open_loop.hpp"]}.get(device)
    folder = ROOT / "include/servobus/device"
    paths = [folder / name for name in room] if room else sorted((folder / device).glob("*.hpp"))
    row = re.compile(r"^/// ([0-9A-F]{4}h|P\w\w-\d\d)\b.*\[errata ([^]]*)\]\ninline constexpr", re.M)
    found = {}
    for path in paths:
        for where, numbers in row.findall(path.read_text("utf-8")):
            address = int(where[1:3], 16) << 8 | int(where[4:]) if where[0] == "P" else int(where[:4], 16)
            found[address] = set(numbers.split(", "))
    return found


def check_registers(pages, tool, device):
    """Problems, and how many registers there are, of which have exactly the words of the manual's table."""
    problems = []
    rows = rows_of(pages, device)
    wanted = printed_map(tool, device)
    manual = manual_table(device)
    name_of = f"map_{file_of(device)}.html"
    ids = [row["id"] for row in rows]
    for row in wanted:
        if ids.count(row["address"]) != 1:
            problems.append(f"{name_of}: {row['address']} {row['name']} is there {ids.count(row['address'])} times")
    for name in set(ids) - {row["address"] for row in wanted}:
        problems.append(f"{name_of}: {name} is no register")
    if problems:
        return problems, 0, 0
    if ids != [row["address"] for row in wanted]:
        problems.append(f"{name_of}: not in the order of the addresses")
    covered = set()
    same_words = 0
    marked = errata_of_headers(device)
    for row, said in zip(rows, wanted):
        address = int(said["address"], 16)
        if address not in manual:
            problems.append(f"{name_of}: {said['address']} is not in the manual's table")
            continue
        words_taken = range(address, address + int(said["words"]))
        covered.update(words_taken)
        expected = {
            "Address": said["address"], "Name": said["name"], "Description": said["description"],
            "Access": said["access"], "Type": said["type"],
            "Range": f"{said['min']}..{said['max']}" if said["min"] else "", "Default": said["default"],
            "Unit": said["unit"] if said["scale"] == "1" else f"{said['scale']} {said['unit']}",
        }
        if device == "c630s":
            expected["Parameter"] = manual[address]["code"]
        for label, value in expected.items():
            if row["first"][label].strip() != value:
                problems.append(f"{name_of}: {said['address']}: {label} is {row['first'][label]!r}, not {value!r}")
        effects = row["cells"]["Effect"].split(", ")
        is_kept = "saved" in effects or "EEPROM" in effects
        when = {"stopped": "while stopped", "running": "any time", "": None}[said["when"]]
        if is_kept != (said["saved"] == "yes") or when is not None and when not in effects:
            problems.append(f"{name_of}: {said['address']}: {row['cells']['Effect']}")
        printed = re.sub(r"(高|低)位$", "", manual[address]["name"])
        segment = re.fullmatch(r"(第\d+段)参数", printed)  # all that the manual says of segments from the second on
        same_words += row["words"] == printed
        if not row["words"]:
            problems.append(f"{name_of}: {said['address']}: no words of the manual")
        elif not (is_part_of(row["words"], printed) or segment and row["words"].startswith(segment.group(1)) or
                  (device, address) in OTHER_WORDS):
            problems.append(f"{name_of}: {said['address']}: {row['words']}, but the manual has {printed}")
        missing = marked.get(address, set()) - set(row["cells"]["Errata"].split())
        if missing:
            problems.append(f"{name_of}: {said['address']}: no {', '.join(sorted(missing))}")
    if not covered >= set(manual):
        problems.append(f"{name_of}: addresses that only the manual's table has: {sorted(set(manual) - covered)}")
    letter = {"z": "B", "y": "A", "c": "C"}[device[0]]
    source = (ROOT / f"include/servobus/device/errata{'_c630s' if letter == 'C' else ''}.md").read_text("utf-8")
    anchors = Links((pages / name_of).read_text("utf-8")).anchors
    for number in re.findall(rf"^\| ({letter}\d+) \|", source, re.M):
        if number not in anchors:
            problems.append(f"{name_of}: the erratum {number} is missing")
    return problems, len(rows), same_words
