# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Makes the start page and the page of each drive's register map.

    maps.py OUT VERSION TOOL VALUES TAGS

TOOL is the tool servobus, whose `map` has the numbers. VALUES is the output of values.cpp: what a register does, and
the names of its values. The rows of the headers have the words of the manuals and the errata; errata.md and
errata_c630s.md have the text of these. TAGS is doxygen's tag file: where the API pages have the constants.

A page is one file, so that it can be kept beside the machine.
"""
import csv
import html
import io
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from fractions import Fraction
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
     "headers": ["c630s/registers.hpp", *sorted(str(p.relative_to(HEADERS)) for p in HEADERS.glob("c630s/*.hpp"))],
     "errata": "errata_c630s.md", "letter": "C", "elsewhere": None},
]

HEAD = r"((?:[0-9A-F]{4}h|P[0-9A-F]{2}-\d\d)(?:, [0-9A-F]+h? \.\. [0-9A-F]+h?)?)"
ROW = re.compile(rf"/// {HEAD} (.+?)(?:  (.+)| (\[errata .+\]))?")
CODE = re.compile(r'inline constexpr (.+?) +(\w+) +\{+(0x[0-9A-F]{4}|"P[0-9A-F]{2}-\d\d"_p)\b(.*)')
# What a row's comment says besides the words of the manual and what columns have.
IN_COLUMNS = re.compile(
    r"default .*|RO|RW|RW/S|shown|read only|stopped|running|immediate|power cycle|at stop|P|S|T|PS|PST|ALL|"
    r"ohm|W|rpm|%|reference units|encoder counts|deg|s|V|A|degC|r|pulses|r/min|mA/s")
RANGE = re.compile(r"-?\d[0-9A-Fx.]*(?:\.\.-?[0-9A-Fx.]+)?\b")


def page_name(drive):
    return "map_" + drive["name"].replace("-", "_") + ".html"


def parameter(address):
    """P0B-17 for 0x0B11."""
    return f"P{address >> 8:02X}-{address & 0xFF:02d}"


def address_of(text):
    """Of 0x2088, 2088h or P0B-17."""
    if text.startswith("P"):
        return int(text[1:3], 16) << 8 | int(text[4:6])
    return int(text.removesuffix("h").removeprefix("0x"), 16)


# The rows of the headers

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


# Errata

def errata_lines(drive):
    """The part of the markdown that is about this drive, without its title."""
    text = (HEADERS / drive["errata"]).read_text("utf-8")
    part = re.search(rf"^## {drive['letter']}\. .*?(?=^## [A-Z]\. |\Z)", text, re.M | re.S).group(0)
    return part.split("\n")[1:]


def cells_of(line):
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def inline(text, addresses, link_hexadecimal=False):
    """Markdown of one line: `code` and **strong**. Numbers of parameters and registers become links."""
    out = []
    for i, part in enumerate(re.split(r"`([^`]*)`", text)):
        if i % 2 == 1:
            out.append(f"<code>{html.escape(part)}</code>")
            continue
        part = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", html.escape(part))
        names = r"P[0-9A-F]{2}-\d\d" + (r"|\b[0-9A-F]{4}h\b" if link_hexadecimal else "")

        def linked(found):
            address = address_of(found.group(0))
            return f'<a href="#0x{address:04X}">{found.group(0)}</a>' if address in addresses else found.group(0)

        out.append(re.sub(names, linked, part))
    return "".join(out)


def errata_html(drive, rows):
    """The errata as HTML. Each number is an anchor; its registers are named below it."""
    addresses = {row["number"] for row in rows}
    out = []
    head = None
    for line in errata_lines(drive):
        if line.startswith("|"):
            cells = cells_of(line)
            if head is None:
                head = cells
                out.append("<table class=errata><thead><tr>" +
                           "".join(f"<th scope=col>{html.escape(c)}</th>" for c in cells) + "</tr></thead><tbody>")
                continue
            if set(cells[0]) <= set("-: "):
                continue
            number = cells[0] if re.fullmatch(r"[A-Z]\d+", cells[0]) else None
            out.append(f'<tr id="{number}">' if number else "<tr>")
            for label, cell in zip(head, cells):
                out.append(f'<td data-label="{html.escape(label)}">' + inline(cell, addresses, label == "where"))
                if cell is cells[0] and number:
                    out[-1] = f'<td data-label="{html.escape(label)}"><a href="#{number}">{number}</a>'
                if label == "where":
                    named = [row for row in rows if number in row["errata"]]
                    if named:
                        out.append(f'<a class=back href="#q=%5B{number}%5D">{len(named)} '
                                   f'register{"s" if len(named) > 1 else ""}</a>')
                out.append("</td>")
            out.append("</tr>")
            continue
        if head is not None:
            out.append("</tbody></table>")
            head = None
        if line.startswith("#"):
            out.append(f"<h3>{html.escape(line.lstrip('# '))}</h3>")
        elif line.strip():
            join = bool(out) and out[-1].startswith("<p>")
            if join:
                out[-1] = out[-1].removesuffix("</p>") + " " + inline(line, addresses) + "</p>"
            else:
                out.append(f"<p>{inline(line, addresses)}</p>")
        else:
            out.append("")
    if head is not None:
        out.append("</tbody></table>")
    return "\n".join(line for line in out if line)


def named_in_errata(drive):
    """By the number of an erratum: the addresses that its column `where` names."""
    found = {}
    for line in errata_lines(drive):
        cells = cells_of(line) if line.startswith("|") else []
        if len(cells) < 2 or not re.fullmatch(r"[A-Z]\d+", cells[0]):
            continue
        if drive["elsewhere"] and re.search(drive["elsewhere"], cells[1]):
            continue
        named = set()
        name = r"(?:P[0-9A-F]{2}-\d\d|\b[0-9A-F]{4}h\b)"
        for one, last in re.findall(rf"({name})(?:(?: to |\.\.)({name}))?", cells[1]):
            named.update(range(address_of(one), address_of(last or one) + 1))
        found[cells[0]] = named
    return found


# The rows of a page

def number_text(value):
    """Exact decimals: the denominators are powers of ten."""
    text = f"{float(value):.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def map_rows(drive, tool, values):
    printed = subprocess.run([tool, "map", drive["name"]], check=True, capture_output=True, text=True).stdout
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


def range_html(row):
    if row["min"] == "":
        return ""
    raw = f'{row["min"]}..{row["max"]}'
    if row["scale"] == "1":
        return raw
    low, high = (number_text(int(row[k]) * Fraction(row["scale"])) for k in ("min", "max"))
    return f'{raw} <small>{low}..{high} {html.escape(row["unit"])}</small>'


def default_html(row):
    if row["default"] == "" or row["scale"] == "1":
        return row["default"]
    physical = number_text(int(row["default"]) * Fraction(row["scale"]))
    return f'{row["default"]} <small>{physical} {html.escape(row["unit"])}</small>'


def unit_text(row):
    return row["unit"] if row["scale"] == "1" else f'{row["scale"]} {row["unit"]}'


def effect_html(row):
    """When it may be written, when that takes effect, what is kept."""
    said = []
    if row["when"]:
        said.append({"stopped": "while stopped", "running": "at any time"}[row["when"]])
    if row["effective"]:
        said.append({"immediate": "in effect immediately", "at_stop": "in effect from the next stop",
                     "power_cycle": "in effect after a power cycle"}[row["effective"]])
    if row["saved"] == "yes" and "EEPROM" not in row["flags"]:
        said.append("saved by command")
    said += [flag for flag in row["flags"].split("; ") if flag]
    if row["modes"]:
        said.append("modes " + row["modes"])
    return html.escape(", ".join(said))


def constant_html(row, tags):
    namespace = row["namespace"].removeprefix("servobus::")
    text = f'{namespace}::{row["constant"]}' + ("" if row["index"] is None else f'[{row["index"]}]')
    where = tags.get((row["namespace"], row["constant"]))
    text = html.escape(text).replace("::", "::<wbr>").replace("_", "_<wbr>")
    return f'<a href="api/{where}">{text}</a>' if where else text


def row_html(row, has_parameters, tags):
    cells = []

    def cell(label, content, attributes=""):
        cells.append(f'<td data-label="{label}"{attributes}>{content}</td>')

    address = row["address"]
    pair = f' <small>and 0x{row["number"] + 1:04X}</small>' if row["words"] == "2" else ""
    cell("Address", f'<a href="#{address}">{address}</a>{pair}', " class=at")
    if has_parameters:
        number = parameter(row["number"])
        cell("Parameter", f'<a href="#{number}">{number}</a>', f' class=at id="{number}"')
    name = html.escape(row["name"]).replace("_", "_<wbr>")
    cell("Name", f'<b>{name}</b> <small class=cpp>{constant_html(row, tags)}</small>')
    extra = f' <small>{html.escape(row["note"])}</small>' if row["note"] else ""
    if row["values"]:
        listed = [html.escape(v) for v in row["values"]]
        if len(listed) > 8:
            extra += f' <details><summary>{len(listed)} values</summary> {"<br> ".join(listed)}</details>'
        else:
            extra += f' <small>{", ".join(listed)}</small>'
    cell("Manual", f'<span lang=zh-Hans>{html.escape(row["manual"])}</span>{extra}')
    cell("Access", row["access"])
    cell("Type", row["type"])
    cell("Range", range_html(row))
    cell("Default", default_html(row))
    cell("Unit", html.escape(unit_text(row)))
    cell("Effect", effect_html(row))
    cell("Errata", " ".join(f'<a href="#{n}">{n}</a>' for n in row["errata"]))
    also = " ".join([f'{address[2:]}h {row["number"]}', *(f"[{n}]" for n in row["errata"])])
    return f'<tr class=register id="{address}" data-also="{also}">' + "".join(cells) + "</tr>"


def page(title, body, script=""):
    style = (HERE / "maps.css").read_text("utf-8").split("*/\n", 1)[1]
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<meta name="color-scheme" content="light dark">\n'
            f'<title>{html.escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n{body}'
            f'{script}</body>\n</html>\n')


def map_page(drive, rows, tags, version):
    has_parameters = drive["name"] == "c630s"
    columns = ["Address", *(["Parameter"] if has_parameters else []), "Name", "Manual", "Access", "Type", "Range",
               "Default", "Unit", "Effect", "Errata"]
    groups = []
    for row in rows:
        if not groups or groups[-1][0] != row["section"]:
            groups.append((row["section"], row["source"], []))
        groups[-1][2].append(row)
    sources = sorted({source for _, source, _ in groups})
    manual = header_source(drive)
    example = "P0B-17, torque 0.1 %, C36" if has_parameters else \
        {"zlac8015d": "0x2088, left speed, r/min B21"}.get(drive["name"], "0x0060, segment_3, homing A16")
    body = [f'<header><nav><a href="index.html">servobus {html.escape(version)}: start page</a></nav>',
            f'<h1>{html.escape(drive["title"])} <small>{html.escape(drive["kind"])}</small></h1>',
            f'<p>{len(rows)} registers, from the {html.escape(manual)}. Ranges and defaults are raw counts, and '
            'below them what they are worth. '
            f'<a href="#errata">Errata</a> say where the manual is wrong or states nothing.</p></header>',
            '<search id=bar hidden><label for=q>Filter</label>',
            f'<input id=q type=search autocomplete=off autocapitalize=off spellcheck=false placeholder="{example}">',
            '<output id=count for=q></output></search>',
            '<main><table class=map><thead><tr>' + "".join(f"<th scope=col class={c.lower()}>{c}</th>" for c in columns) +
            "</tr></thead>"]
    for section, source, of in groups:
        place = f" <small>{html.escape(source)}</small>" if len(sources) > 1 and has_parameters else ""
        section = section[:1].upper() + section[1:]
        body.append(f'<tbody><tr class=section><th colspan={len(columns)} scope=colgroup>'
                    f'{html.escape(section)}{place}</th></tr>')
        body += [row_html(row, has_parameters, tags) for row in of]
        body.append("</tbody>")
    body.append('</table><p id=none hidden>No register has all these words.</p>')
    body.append(f'<h2 id=errata>Errata</h2>\n{errata_html(drive, rows)}\n</main>')
    body.append(f'<footer><a href="index.html">servobus {html.escape(version)}: start page</a></footer>')
    code = (HERE / "maps.js").read_text("utf-8").split("\n\n", 1)[1]
    return page(f'{drive["title"]}: registers', "\n".join(body) + "\n", f"<script>\n{code}</script>\n")


def header_source(drive):
    about = first_paragraph((HEADERS / drive["headers"][-1 if "yako" in drive["name"] else 0]).read_text("utf-8"))
    return re.search(r"Source: ([^;]*?)[;.] ", about + " ").group(1)


def start_page(maps, tags, version):
    def api(text, name, kind):
        where = tags.get((kind, name))
        return f'<a href="api/{where}"><code>{text}</code></a>'

    listed = "".join(
        f'<li><a href="{page_name(d)}">{html.escape(d["title"])}</a>'
        f'<small>{html.escape(d["kind"])}: {len(rows)} registers</small></li>' for d, rows in maps)
    first = ", ".join(api(text, "servobus::" + text, "class") for text in
                      ("client", "line", "bus", "zlac8015d::drive", "yako::closed_loop::drive",
                       "yako::open_loop::drive", "c630s::drive", "posix::serial"))
    body = f'''<header><h1>servobus <small>{html.escape(version)}</small></h1>
<p>Drives motors over Modbus RTU, and knows the registers of these drives.</p></header>
<main>
<h2>Registers</h2>
<p>Each page finds a register by its address, parameter number, name, words of the manual, range, unit or erratum.</p>
<ul class=cards>{listed}</ul>
<h2>API</h2>
<ul class=cards>
<li><a href="api/index.html">Where to begin</a><small>what to use for what</small></li>
<li><a href="api/annotated.html">Classes</a><small>by namespace</small></li>
<li><a href="api/files.html">Headers</a><small>what each is for, with an example</small></li>
<li><a href="api/namespaces.html">Namespaces</a><small>functions and constants</small></li>
</ul>
<p>Often needed: {first}. Each call that can fail lists its errors; {api("errc", "errc", "servobus")} has their
meanings.</p>
</main>
'''
    return page("servobus: reference", body)


def read_tags(path):
    """(namespace, member) and ("class", name): where they are in the API pages."""
    found = {}
    for compound in ElementTree.parse(path).getroot().iter("compound"):
        name = compound.findtext("name")
        if compound.get("kind") in ("class", "struct"):
            found["class", name] = compound.findtext("filename")
        if compound.get("kind") == "namespace":
            for member in compound.findall("member"):
                found[name, member.findtext("name")] = f'{member.findtext("anchorfile")}#{member.findtext("anchor")}'
    return found


def main():
    out, version, tool, values_file, tags_file = sys.argv[1:]
    values = {}
    for line in Path(values_file).read_text("utf-8").splitlines():
        device, address, flags, *names = line.split("\t")
        values[device, address] = (flags, names)
    tags = read_tags(tags_file)
    maps = [(drive, map_rows(drive, tool, values)) for drive in DRIVES]
    for drive, rows in maps:
        (Path(out) / page_name(drive)).write_text(map_page(drive, rows, tags, version), "utf-8")
    (Path(out) / "index.html").write_text(start_page(maps, tags, version), "utf-8")


main()
