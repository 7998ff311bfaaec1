# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What a real browser shows of the pages: the filter, and the width of a phone."""
import html
import json
import re
import subprocess
from pathlib import Path
from urllib.parse import quote

from names import file_of
from registers import manual_table, printed_map, rows_of

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
            ("Maximum OUTPUT current", of_map("zlac8015d", lambda row: all(
                word in row["description"].lower() for word in ("maximum", "output", "current")))),
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


def check_browser(pages, tool, chromium, work, only=""):
    """Problems, and what was looked at. Two pages with all queries, the others for their width; or one page."""
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
    cases, wanted = zip(*(look for look in zip(cases, wanted) if only in look[0]["url"]))
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
