# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Makes the start page and the page of each drive's register map.

The tool's `map --long` has the numbers and the sentence about each register, values.cpp prints what a register does and the names of its values. The rows of the
headers have the words of the manuals and the errata; errata.md and errata_c630s.md have the text of these. Doxygen's
tag file has where the API pages have the constants.

A page is one file, so that it can be kept beside the machine.
"""
import html
import re
import xml.etree.ElementTree as ElementTree
from fractions import Fraction
from pathlib import Path

from drives import DRIVES, HEADERS, HERE, parameter
from errata import errata_html
from rows import first_paragraph, map_rows


def page_name(drive):
    return "map_" + drive["name"].replace("-", "_") + ".html"


def number_text(value):
    """Exact decimals: the denominators are powers of ten."""
    text = f"{float(value):.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


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


# The words of the column "Effect" that are explained above the table, where it has them.
EFFECTS = [("while stopped", "accepted only then"), ("from power-on", "in effect only then"),
           ("saved", "by a command of its own"), ("EEPROM", "each write wears it"),
           ("PST", "the modes that use it: position, speed, torque")]


def effects_html(rows):
    cells = "; ".join(effect_html(row) for row in rows)
    return "; ".join(f"<b>{word}</b>: {meaning}" for word, meaning in EFFECTS if word in cells)


def effect_html(row):
    """When it may be written, from when that holds, what is kept, and the modes; see EFFECTS."""
    said = []
    if row["when"]:
        said.append({"stopped": "while stopped", "running": "any time"}[row["when"]])
    if row["effective"]:
        said.append({"immediate": "at once", "at_stop": "from next stop", "power_cycle": "from power-on"}[row["effective"]])
    if row["saved"] == "yes" and "EEPROM" not in row["flags"]:
        said.append("saved")
    said += [flag for flag in row["flags"].split("; ") if flag]
    if row["modes"]:
        said.append(row["modes"])
    return html.escape(", ".join(said))


def name_html(row, tags):
    """The register's name, and the constant of C++ if it is written in another way; a link to its documentation."""
    def broken(text):
        return html.escape(text).replace("::", "::<wbr>").replace("_", "_<wbr>")

    constant = row["constant"] + ("" if row["index"] is None else f'[{row["index"]}]')
    whole = f'{row["namespace"].removeprefix("servobus::")}::{constant}'
    where = tags.get((row["namespace"], row["constant"]))
    name = f'<b>{broken(row["name"])}</b>'
    if where:
        name = f'<a class=cpp href="api/{where}" title="{html.escape(whole)}">{name}</a>'
    return name if constant == row["name"] else f'{name} <small class=cpp>{broken(constant)}</small>'


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
    cell("Name", name_html(row, tags))
    cell("Description", html.escape(row["description"]))
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
    columns = ["Address", *(["Parameter"] if has_parameters else []), "Name", "Description", "Manual", "Access", "Type", "Range",
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
            f'beside them what they are worth. Effect: {effects_html(rows)}. '
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
<p>Each page finds a register by its address, parameter number, name, description, words of the manual, range, unit or erratum.</p>
<ul class=cards>{listed}</ul>
<h2>The library</h2>
<ul class=cards>
<li><a href="api/guide.html">Guide</a><small>how do I ...?</small></li>
<li><a href="api/rules.html">Rules</a><small>late responses, limits, states, threads, gateways</small></li>
<li><a href="api/architecture.html">Architecture</a><small>layers, and which header for what</small></li>
<li><a href="api/devices.html">Devices</a><small>the drives, and your own</small></li>
<li><a href="api/promises.html">Promises</a><small>what holds on a bad line</small></li>
</ul>
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


def write(out, version, tool, printed_values, tags_file):
    """Writes the start page and the maps into a folder. `printed_values`: the output of values.cpp."""
    values = {}
    for line in printed_values.splitlines():
        device, address, flags, *names = line.split("\t")
        values[device, address] = (flags, names)
    tags = read_tags(tags_file)
    maps = [(drive, map_rows(drive, tool, values)) for drive in DRIVES]
    for drive, rows in maps:
        (Path(out) / page_name(drive)).write_text(map_page(drive, rows, tags, version), "utf-8")
    (Path(out) / "index.html").write_text(start_page(maps, tags, version), "utf-8")
