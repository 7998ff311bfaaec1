# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The errata of a drive: as HTML, and the registers that each one names."""
import html
import re

from drives import HEADERS, address_of


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
