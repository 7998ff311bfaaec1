# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks the pages that examples/reference/make.sh built.    check.py PAGES TOOL CHROMIUM WORK

It shares no code with the makers of the pages: it reads HTML, the tool's `map`, the manuals' tables in tests/manuals
and the headers' comments. It also damages a copy of the pages in several ways, and fails if a check does not notice.
"""
import re
import shutil
import sys
from pathlib import Path

from browser import check_browser
from client_read import check_read
from links import check_links
from names import DEVICES
from registers import check_registers


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
    print(f"check.py: {count} pages, {links} links, {registers} registers, {errors} errors of client::read, "
          f"{looks} looks; {failed} checks failed")
    return 1 if failed else 0


sys.exit(main())
