# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Builds the reference (examples/reference/make.py) twice, and checks it.    check.py TOOL

Doxygen has no warning; every link leads somewhere; every register is on its drive's page once, with the words of its
manual; client::read has its summary and errors; in a real browser, at a phone's width and a desk's, the filter works
and nothing is wider than the page.

It shares no code with the makers of the pages: it reads HTML, the tool's `map`, the manuals' tables in tests/manuals
and the headers' comments. It also damages a copy of the pages in several ways, and fails if a check does not notice.
"""
import os
import re
import shutil
import sys
from pathlib import Path

from browser import check_browser
from client_read import check_read
from links import check_links
from names import DEVICES
from registers import check_registers

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import ROOT, check, expect, finish, must, must_fail, need, work

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


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
        ("map_c630s.html", lambda t: re.sub('(data-label="Description">)[A-Z]', r"\1x", t, count=1), "registers"),
        (client, lambda t: t.replace("no gap on the line was long enough to send", ""), "read"),
        (client, lambda t: t.replace("Reads one register", "Reads"), "read"),
        ("map_c630s.html", lambda t: t.replace("words.every(", "words.some("), "browser"),
        ("map_zlac8015d.html", lambda t: t.replace("</style>", ".register { min-width: 500px }</style>"), "browser"),
    ]


def make(out, tree=ROOT):
    return [sys.executable, "-B", tree / "examples/reference/make.py", out]


def wrong_comment(folder):
    """A comment that doxygen cannot read ends the build with an error."""
    tree = folder / "tree"
    shutil.copytree(ROOT / "include", tree / "include")
    shutil.copytree(ROOT / "examples/reference", tree / "examples/reference")
    shutil.copy(ROOT / "CMakeLists.txt", tree)
    with open(tree / "include/servobus/core/version.hpp", "a", encoding="utf-8") as header:
        header.write("/// See @ref no_such_thing.\nstruct spoilt {};\n")
    must_fail("no_such_thing", *make(folder / "spoilt", tree))


def none(problems):
    more = [f"and {len(problems) - 20} more"] if len(problems) > 20 else []
    expect(not problems, "\n".join(problems[:20] + more))


def noticed(pages, checks):
    """Each damage of a copy is found by its check."""
    for name, change, by in damages():
        page = pages / name
        text = page.read_text("utf-8")
        changed = change(text)
        expect(changed != text, f"a damage of {name} changes nothing")
        page.write_text(changed, "utf-8")
        expect(checks[by](name), f"a damage of {name} is not noticed by the check of {by}")
        page.write_text(text, "utf-8")


def main():
    tool, = sys.argv[1:]
    need("doxygen", "doxygen")
    need(lambda: any(map(shutil.which, BROWSERS)), "chromium")
    chromium = next(filter(None, map(shutil.which, BROWSERS)))
    folder = work().resolve()
    pages, again = folder / "pages", folder / "again"
    os.environ["SERVOBUS"] = tool
    if not check("built, and doxygen has no warning", must, *make(pages)):
        finish()
    must(*make(again))
    check("a second run gives the same bytes", must, "diff", "-rq", pages, again)
    check("a wrong comment is noticed", wrong_comment, folder)

    problems, links, count = check_links(pages)
    check(f"{links} links in {count} pages lead somewhere", none, problems)
    for device in DEVICES:
        problems, rows, same = check_registers(pages, tool, device)
        check(f"{device}: {rows} registers, each once and with words of the manual, {same} with its table's very words",
              none, problems)
    problems, errors = check_read(pages)
    check(f"client::read has its summary and {errors} errors", none, problems)
    problems, looks = check_browser(pages, tool, chromium, folder)
    check(f"a browser, {looks} looks: the filter finds what the tables have, no page is wider than a phone",
          none, problems)
    check(f"{len(damages())} damaged copies are noticed", noticed, again, {
        "links": lambda name: check_links(again)[0],
        "registers": lambda name: check_registers(again, tool, "c630s")[0],
        "read": lambda name: check_read(again)[0],
        "browser": lambda name: check_browser(again, tool, chromium, folder, name)[0],
    })
    finish()


main()
