# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The rows of a drive's map: the tool's numbers, the words of the headers, and which errata name a register."""
import csv
import io
import re
import subprocess

from drives import HEADERS, address_of, parameter
from errata import named_in_errata

HEAD = r"((?:[0-9A-F]{4}h|P[0-9A-F]{2}-\d\d)(?:, [0-9A-F]+h? \.\. [0-9A-F]+h?)?)"
ROW = re.compile(rf"/// {HEAD} (.+?)(?:  (.+)| (\[errata .+\]))?")
CODE = re.compile(r'inline constexpr (.+?) +(\w+) +\{+(0x[0-9A-F]{4}|"P[0-9A-F]{2}-\d\d"_p)\b(.*)')
# What a row's comment says besides the words of the manual and what columns have.
IN_COLUMNS = re.compile(
    r"default .*|RO|RW|RW/S|shown|read only|stopped|running|immediate|power cycle|at stop|P|S|T|PS|PST|ALL|"
    r"ohm|W|rpm|%|reference units|encoder counts|deg|s|V|A|degC|r|pulses|r/min|mA/s")
RANGE = re.compile(r"-?\d[0-9A-Fx.]*(?:\.\.-?[0-9A-Fx.]+)?\b")


def first_paragraph(text):
    lines = []
    for line in text.split("\n")[3:]:
        if not line.startswith("// "):
            break
        lines.append(line[3:])
    return " ".join(lines)


def note_of(facts):
    """The rest of a row's comment, without errata."""
    facts = re.sub(r" ?\[errata [^]]*\]", "", facts)
    main, _, note = facts.partition("; ")
    rest = []
    for fact in main.split(", "):
        fact = fact.strip()
        range_of = RANGE.match(fact)
        if range_of and re.search(r" of | a half| with ", fact):
            rest.append(fact[range_of.end():].strip())
        elif fact and not range_of and not IN_COLUMNS.fullmatch(fact):
            rest.append(fact)
    return ", ".join(rest) + ("; " if rest and note else "") + note


def header_rows(drive):
    """By address: what the headers say of a register."""
    found = {}
    for name in dict.fromkeys(drive["headers"]):
        text = (HEADERS / name).read_text("utf-8")
        about = first_paragraph(text)
        namespace = re.search(r"^namespace ([\w:]+) \{", text, re.M)
        subject = re.search(r": ([^:]+?), groups? P", about)
        source = re.search(r"Source: ([^;]*?)[;.] ", about + " ")
        title = ""
        lines = text.split("\n")
        for i, line in enumerate(lines):
            if re.fullmatch(r"// [A-Z][^.]*", line) and (i + 1 == len(lines) or lines[i + 1] == ""):
                title = line[3:]
            row = ROW.fullmatch(line)
            code = row and CODE.fullmatch(lines[i + 1])
            if not code:
                continue
            kind, constant, where, rest = code.groups()
            first = address_of(where.removesuffix("_p").strip('"'))
            assert first == address_of(re.split(r",", row.group(1))[0]), line
            array = re.match(r"segments<|reg_array<.*, (\d+)>", kind)
            count = int(array.group(1) or 16) if array else 1
            step = int(re.search(r"\}, (\d+)\};$", rest).group(1)) if array else 0
            facts = row.group(3) or row.group(4) or ""
            errata = re.search(r"\[errata ([^]]*)\]", facts)
            for n in range(count):
                address = first + n * step
                assert address not in found, line
                section = title
                if subject:
                    section = f"{parameter(address)[:3]}: {subject.group(1)}"
                found[address] = {
                    "words": re.sub(r"1\.\.16", str(n + 1), row.group(2)) if array else row.group(2),
                    "note": note_of(facts),
                    "errata": errata.group(1).split(", ") if errata else [],
                    "constant": constant,
                    "index": n if array else None,
                    "namespace": namespace.group(1),
                    "section": section,
                    "source": source.group(1) if source else "",
                }
    return found


def map_rows(drive, tool, values):
    printed = subprocess.run([tool, "map", drive["name"], "--long"], check=True, capture_output=True, text=True).stdout
    said = header_rows(drive)
    named = named_in_errata(drive)
    rows = []
    for row in csv.DictReader(io.StringIO(printed)):
        row["number"] = int(row["address"], 16)
        covered = {row["number"] + i for i in range(int(row["words"]))}
        row.update({k: said[row["number"]][k] for k in ("note", "constant", "index", "namespace", "section", "source")})
        row["manual"] = said[row["number"]]["words"]
        marked = set(said[row["number"]]["errata"]) | {n for n, where in named.items() if where & covered}
        row["errata"] = sorted(marked, key=lambda n: int(n[1:]))
        row["flags"], row["values"] = values[drive["name"], row["address"]]
        rows.append(row)
    assert {row["number"] for row in rows} == set(said), set(said) ^ {row["number"] for row in rows}
    return rows
