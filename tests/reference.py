# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks the pages that examples/reference/make.sh built.    reference.py PAGES TOOL CHROMIUM WORK

It shares no code with the makers of the pages: it reads HTML, the tool's `map`, the manuals' tables in tests/manuals
and the headers' comments. It also damages a copy of the pages in several ways, and fails if a check does not notice.
"""
import csv
import html
import json
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import quote, unquote

ROOT = Path(__file__).resolve().parent.parent
DEVICES = ["zlac8015d", "yako-closed-loop", "yako-open-loop", "c630s"]
VOID = {"area", "base", "br", "col", "hr", "img", "input", "link", "meta", "wbr"}
# Where a row's words are not the characters of its line in the manual's table, in their order.
OTHER_WORDS = {("yako-open-loop", 0x0065)}  # the heading of the row below it, as in the closed loop's table


def file_of(device):
    return device.replace("-", "_")


# Links

class Links(HTMLParser):
    """The anchors of a page, what it leads to, and what it loads."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.loads, self.twice = set(), [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        name = of.get("id")
        if name is not None:
            if name in self.anchors:
                self.twice.append(name)
            self.anchors.add(name)
        if tag == "a" and of.get("name"):
            self.anchors.add(of["name"])
        for key in ("href", "src"):
            if of.get(key) is not None:
                self.links.append(of[key])
                if tag in ("link", "script", "img", "iframe"):
                    self.loads.append(of[key])

    handle_startendtag = handle_starttag


def check_links(pages):
    """Problems, and how many links there are."""
    parsed = {path: Links(path.read_text("utf-8")) for path in sorted(pages.rglob("*.html"))}
    files = {path for path in pages.rglob("*") if path.is_file()}
    problems = []
    count = 0

    def follow(page, link):
        nonlocal count
        if re.match(r"(https?|mailto|javascript|data):", link):
            return
        count += 1
        target, _, anchor = link.partition("#")
        where = (page.parent / unquote(target)).resolve() if target else page
        if where not in files:
            problems.append(f"{page.relative_to(pages)}: {link} leads to no file")
        elif anchor and not anchor.startswith("q=") and where.suffix == ".html" and \
                unquote(anchor) not in parsed[where].anchors:
            problems.append(f"{page.relative_to(pages)}: {link} leads to no anchor")

    for page, of in parsed.items():
        for link in of.links:
            follow(page, link)
        problems += [f"{page.relative_to(pages)}: loads {link}" for link in of.loads
                     if re.match(r"(https?:)?//", link)]
        if page.parent == pages:  # doxygen repeats some ids
            problems += [f"{page.relative_to(pages)}: two anchors {name}" for name in of.twice]
            if page.name != "index.html" and "index.html" not in of.links:
                problems.append(f"{page.name}: does not lead to the start page")
    for menu in pages.rglob("menudata.js"):
        for link in re.findall(r'url:"([^"]*)"', menu.read_text("utf-8")):
            follow(menu, link)
    for entries in pages.glob("api/search/*_*.js"):
        for link in re.findall(r"\['(\.\./[^']*)'", entries.read_text("utf-8")):
            follow(entries, link)
    for style in pages.rglob("*.css"):
        for link in re.findall(r"url\([\"']?([^\"')]+)", style.read_text("utf-8")):
            follow(style, link)
    for page in [pages / f"map_{file_of(device)}.html" for device in DEVICES] + [pages / "api/index.html"]:
        if page.name != "index.html" and page.name not in parsed[pages / "index.html"].links or page not in files:
            problems.append(f"index.html does not lead to {page.name}")
    return problems, count, len(parsed)


# Registers

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
    said = subprocess.run([tool, "map", device], check=True, capture_output=True, text=True).stdout
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
            "Address": said["address"], "Name": said["name"], "Access": said["access"], "Type": said["type"],
            "Range": f"{said['min']}..{said['max']}" if said["min"] else "", "Default": said["default"],
            "Unit": said["unit"] if said["scale"] == "1" else f"{said['scale']} {said['unit']}",
        }
        if device == "c630s":
            expected["Parameter"] = manual[address]["code"]
        for label, value in expected.items():
            if row["first"][label].strip() != value:
                problems.append(f"{name_of}: {said['address']}: {label} is {row['first'][label]!r}, not {value!r}")
        for label, value in (("saved", "saved by command"), ("saved", "EEPROM at each write")):
            if value in row["cells"]["Effect"] and said[label] != "yes":
                problems.append(f"{name_of}: {said['address']}: {value}")
        is_kept = "saved by command" in row["cells"]["Effect"] or "EEPROM at each write" in row["cells"]["Effect"]
        when = {"stopped": "while stopped", "running": "at any time", "": None}[said["when"]]
        if is_kept != (said["saved"] == "yes") or when is not None and when not in row["cells"]["Effect"]:
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


# The page of client::read

def text_of(fragment):
    return " ".join(html.unescape(re.sub(r"<[^>]+>", "", fragment)).split())


def check_read(pages):
    """Problems, and how many errors client::read has."""
    header = (ROOT / "include/servobus/client/client.hpp").read_text("utf-8")
    comment = re.search(r"((?:^    ///.*\n)+)(?:    .*\n){2}    constexpr result<reading<R>> read\(\) \{", header, re.M)
    lines = [line.strip().removeprefix("///").strip() for line in comment.group(1).splitlines()]
    about, errors = "\n".join(lines).split("Errors:")
    about = " ".join(about.replace("`", "").split())
    summary = re.match(r".*?\.(?= |$)", about).group(0)
    items = [" ".join(item.replace("`", "").split()) for item in errors.split("\n- ")[1:]]
    known = set(re.findall(r"^    (\w+),", re.search(r"enum class errc .*?\n};", (
        ROOT / "include/servobus/core/status.hpp").read_text("utf-8"), re.S).group(0), re.M))
    named = [name for name in re.findall(r"`(\w+)`", errors) if name in known]

    page = (pages / "api/classservobus_1_1client.html").read_text("utf-8")
    parts = re.split(r'<h2 class="memtitle">', page)
    of_read = [part for part in parts[1:] if re.search(r"</span>read\(\)", part.split("</h2>")[0])]
    problems = []
    if len(of_read) != 3:
        problems.append(f"client::read is there {len(of_read)} times, not 3")
    first = next((part for part in of_read if "<em>index</em>" not in part and "Rs" not in part), "")
    if summary not in text_of(parts[0]):
        problems.append("the list of members does not have the summary of client::read")
    if about not in text_of(first):
        problems.append("client::read does not have its description")
    listed = [text_of(item) for item in re.findall(r"<li>(.*?)</li>", first, re.S)]
    problems += [f"client::read does not list: {item}" for item in items if item not in listed]
    for name in named:
        if not re.search(rf'<a class="el" href="[^"#]*#\w+">{name}</a>', first):
            problems.append(f"client::read: {name} does not lead to its meaning")
    if len(items) < 10 or len(named) < 15:
        problems.append(f"only {len(named)} errors of client::read are documented")
    return problems, len(named)


# The browser

# Loads the pages one after the other into a frame as wide as a phone or a desk's screen, types into the filter, and
# leaves what it saw in the document.
FRAME = """<!DOCTYPE html><meta charset=utf-8><body><script>
const CASES = %s;
const seen = [];
function look(one) {
    return new Promise(done => {
        const frame = document.createElement("iframe");
        frame.style = `width:${one.width}px;height:700px;border:0`;
        frame.onload = () => {
            const page = frame.contentDocument;
            const box = page.getElementById("q");
            const shown = () => [...page.querySelectorAll("tr.register")]
                .filter(row => row.getClientRects().length > 0).map(row => row.id);
            const found = {opened: shown(), width: page.documentElement.scrollWidth};
            if (box) {
                found.box = box.value;
                found.count = page.getElementById("count").textContent;
                found.none = page.getElementById("none").getClientRects().length > 0;
                found.cell = frame.contentWindow.getComputedStyle(page.querySelector("tr.register td")).display;
                box.value = "";
                box.dispatchEvent(new Event("input"));
                found.cleared = shown().length;
                found.clearedHash = frame.contentWindow.location.hash;
                box.value = one.query;
                box.dispatchEvent(new Event("input"));
                found.typed = shown();
                found.hash = decodeURIComponent(frame.contentWindow.location.hash);
            }
            seen.push(found);
            done();
        };
        frame.src = one.url;
        document.querySelector("iframe")?.remove();
        document.body.append(frame);
    });
}
(async () => {
    for (const one of CASES) await look(one);
    const out = document.createElement("pre");
    out.id = "seen";
    out.textContent = JSON.stringify(seen);
    document.body.append(out);
})();
</script>"""

PHONE, DESK = 360, 1280


def queries(tool):
    """For a page: what is typed, and the addresses that the tool's map or the manual's table gives for it."""

    def of_map(device, condition):
        return [row["address"] for row in printed_map(tool, device) if condition(row)]

    def of_manual(device, words):
        return [f"0x{address:04X}" for address, row in manual_table(device).items() if words in row["name"]]

    return {
        "zlac8015d": [
            ("0x2088", ["0x2088"]), ("2088h", ["0x2088"]),
            ("LEFT_target", of_map("zlac8015d", lambda row: "left_target" in row["name"])),
            ("-3000..3000 r/min", of_map("zlac8015d", lambda row: row["min"] == "-3000" and row["unit"] == "r/min")),
            ("编码器线数", of_manual("zlac8015d", "编码器线数")),
            ("[B21]", ["0x2022", "0x2088", "0x2089"]),
            ("no register has these words", []),
        ],
        "c630s": [
            ("P0B-17", ["0x0B11"]), ("p11-12", ["0x110C"]),
            ("转矩", of_manual("c630s", "转矩")),
            ("ref_unit", of_map("c630s", lambda row: row["unit"] == "ref_unit")),
            ("segment_16_ speed", of_map("c630s", lambda row: "segment_16_" in row["name"] and "speed" in row["name"])),
            ("torque", None),
        ],
    }


def holds(row, query):
    text = " ".join([*row["visible"].values(), row["also"]]).lower()
    return all(word in text for word in query.lower().split())


def check_browser(pages, tool, chromium, work):
    """Problems, and what was looked at. Two pages with all queries, the others for their width."""
    cases, wanted = [], []
    for device, asked in queries(tool).items():
        rows = rows_of(pages, device)
        for width in (PHONE, DESK):
            for query, by_tables in asked:
                expected = [row["id"] for row in rows if holds(row, query)]
                cases.append({"url": f"{(pages / f'map_{file_of(device)}.html').as_uri()}#q={quote(query)}",
                              "width": width, "query": query})
                wanted.append((device, expected, by_tables, len(rows)))
    for name in ("index.html", "map_yako_closed_loop.html", "map_yako_open_loop.html", "map_zlac8015d.html",
                 "map_c630s.html", "api/classservobus_1_1client.html"):
        cases.append({"url": (pages / name).as_uri(), "width": PHONE, "query": ""})
        wanted.append((name, None, None, None))
    frame = Path(work) / "frame.html"
    frame.write_text(FRAME % json.dumps(cases), "utf-8")
    command = [chromium, "--headless=new", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage",
               "--allow-file-access-from-files", "--enable-logging=stderr", f"--user-data-dir={work}/profile",
               "--window-size=1400,900", "--virtual-time-budget=60000", "--timeout=120000", "--dump-dom",
               frame.as_uri()]
    if subprocess.run(["id", "-u"], capture_output=True, text=True).stdout.strip() == "0":
        command.insert(1, "--no-sandbox")
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300)
    answer = re.search(r'<pre id="seen">(.*?)</pre>', ran.stdout, re.S)
    if not answer:
        return [f"{chromium} gave nothing (status {ran.returncode}): {ran.stderr[-500:]}"], 0
    seen = json.loads(html.unescape(answer.group(1)))
    problems = [f"the console: {line}" for line in ran.stderr.splitlines() if "Uncaught" in line]
    if len(seen) != len(cases):
        problems.append(f"{len(seen)} of {len(cases)} pages were seen")
    for case, found, (name, expected, by_tables, count) in zip(cases, seen, wanted):
        what = f"{name} at {case['width']} px"
        if found["width"] > case["width"]:
            problems.append(f"{what} is {found['width']} px wide")
        if expected is None:
            continue
        what += f", filter {case['query']}"
        if by_tables is not None and expected != by_tables:
            problems.append(f"{what}: the page has these words in {expected}, the tables in {by_tables}")
        if by_tables is None:  # at least the names
            names = [row["address"] for row in printed_map(tool, name) if case["query"] in row["name"]]
            if not names or not set(names) <= set(found["opened"]):
                problems.append(f"{what}: not all of {names}")
        for key in ("opened", "typed"):
            if found[key] != expected:
                problems.append(f"{what}, {key}: {found[key]}, not {expected}")
        if found["box"] != case["query"] or found["hash"] != f"#q={case['query']}":
            problems.append(f"{what}: the box has {found['box']}, the address {found['hash']}")
        if found["cleared"] != count or found["clearedHash"] != "":
            problems.append(f"{what}: without a filter {found['cleared']} of {count}, {found['clearedHash']}")
        if found["count"] != f"{len(expected)} of {count} registers" or found["none"] != (not expected):
            problems.append(f"{what}: says {found['count']}")
        if (found["cell"] == "table-cell") != (case["width"] == DESK) and expected:
            problems.append(f"{what}: cells are {found['cell']}")
    return problems, len(cases)


# Damage that the checks must notice

def without_row(text):
    return re.sub(r'<tr class=register id="0x0B11".*?</tr>', "", text, count=1, flags=re.S)


def with_row_twice(text):
    return re.sub(r'(<tr class=register id="0x0B11".*?</tr>)', r"\1\1", text, count=1, flags=re.S)


def damages():
    """A file, its change, and the check that must find it."""
    client = "api/classservobus_1_1client.html"
    return [
        ("index.html", lambda t: t.replace('"map_c630s.html"', '"map_c630.html"'), "links"),
        ("map_c630s.html", lambda t: t.replace('id="C32"', 'id="C320"'), "links"),
        (client, lambda t: t.replace('href="classservobus_1_1raw__client.html"', 'href="classservobus_1_1raw.html"'),
         "links"),
        ("map_zlac8015d.html", lambda t: t.replace("</body>", '<script src="https://example.org/a.js"></script></body>'),
         "links"),
        ("map_c630s.html", without_row, "registers"),
        ("map_c630s.html", with_row_twice, "registers"),
        ("map_c630s.html", lambda t: t.replace("反馈脉冲计数器", ""), "registers"),
        ("map_c630s.html", lambda t: t.replace("<td data-label=\"Range\">-1073741824..1073741824",
                                               "<td data-label=\"Range\">0..1073741824", 1), "registers"),
        (client, lambda t: t.replace("no gap on the line was long enough to send", ""), "read"),
        (client, lambda t: t.replace("Reads one register", "Reads"), "read"),
        ("map_c630s.html", lambda t: t.replace("words.every(", "words.some("), "browser"),
        ("map_zlac8015d.html", lambda t: t.replace("</style>", ".register { min-width: 500px }</style>"), "browser"),
    ]


def main():
    pages, tool, chromium, work = Path(sys.argv[1]).resolve(), *sys.argv[2:]
    failed = 0

    def report(name, problems):
        nonlocal failed
        print(f"{'FAILED' if problems else 'ok    '}  {name}")
        for problem in problems[:20]:
            print(f"        {problem}")
        if len(problems) > 20:
            print(f"        and {len(problems) - 20} more")
        failed += bool(problems)

    problems, links, count = check_links(pages)
    report(f"{links} links in {count} pages lead somewhere", problems)
    registers = 0
    for device in DEVICES:
        problems, rows, same = check_registers(pages, tool, device)
        registers += rows
        report(f"{device}: {rows} registers, each once and with words of the manual, {same} with its table's very words",
               problems)
    problems, errors = check_read(pages)
    report(f"client::read has its summary and {errors} errors", problems)
    problems, looks = check_browser(pages, tool, chromium, work)
    report(f"a browser, {looks} looks: the filter finds what the tables have, no page is wider than a phone", problems)

    checks = {
        "links": lambda at: check_links(at)[0],
        "registers": lambda at: check_registers(at, tool, "c630s")[0],
        "read": lambda at: check_read(at)[0],
        "browser": lambda at: check_browser(at, tool, chromium, work)[0],
    }
    copy = Path(work).resolve() / "damaged"
    shutil.copytree(pages, copy)
    unnoticed = []
    for name, change, check in damages():
        text = (copy / name).read_text("utf-8")
        changed = change(text)
        if changed == text:
            unnoticed.append(f"a damage of {name} changes nothing")
        (copy / name).write_text(changed, "utf-8")
        if not checks[check](copy):
            unnoticed.append(f"a damage of {name} is not noticed by the check of {check}")
        (copy / name).write_text(text, "utf-8")
    report(f"{len(damages())} damaged copies are noticed", unnoticed)
    print(f"reference.py: {count} pages, {links} links, {registers} registers, {errors} errors of client::read, "
          f"{looks} looks; {failed} checks failed")
    return 1 if failed else 0


sys.exit(main())
