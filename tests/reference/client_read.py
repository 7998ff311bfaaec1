# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The page of client::read has the summary and the errors of the header."""
import html
import re

from names import ROOT


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
    if len(of_read) != 4:
        problems.append(f"client::read is there {len(of_read)} times, not 4")
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
