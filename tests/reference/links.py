# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Each link of the pages leads somewhere, and a map loads nothing."""
import functools
import re
from html.parser import HTMLParser
from urllib.parse import unquote

from names import DEVICES, file_of


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


@functools.cache
def parse(text):
    return Links(text)


def check_links(pages):
    """Problems, and how many links there are."""
    parsed = {path: parse(path.read_text("utf-8")) for path in sorted(pages.rglob("*.html"))}
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
