# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Draws bench/plots/size.svg from tests/target/figures.tsv and bench/peers/recorded.tsv, and bench/plots/crc.svg from
the benchmarks of the CRC, which it runs. Fails if a series or a value is missing in a plot.

plot.py --sizes    draws only size.svg
plot.py --check    checks that both files are XML and show every series, and that size.svg has the recorded values
"""
import json
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree
from xml.sax.saxutils import escape, quoteattr

from measuring import CXX, ROOT, built_benchmarks, family, folder, must, recorded

BENCH = ROOT / "bench"
SIZE, CRC = BENCH / "plots" / "size.svg", BENCH / "plots" / "crc.svg"

OWN_COLOUR, PEER_COLOUR = "#0072b2", "#9a9a9a"

LENGTHS = (6, 8, 25, 64, 253, 4096)
LIBMODBUS = "libmodbus, a frame"
# Benchmark: legend, colour, marker. Colours and shapes can be distinguished without seeing red and green.
ENGINES = {
    "crc_bitwise": ("crc_bitwise", "#666666", "M-4,-4H4V4H-4Z"),
    "crc_table16": ("crc_table16", "#cc79a7", "M0,-5L5,4H-5Z"),
    "crc_table256": ("crc_table256", "#d55e00", "M0,-5L5,0L0,5L-5,0Z"),
    "crc_slicing8": ("crc_slicing8", "#e69f00", "M0,5L5,-4H-5Z"),
    "crc_trinomial<8>": ("crc_trinomial<8>, default on 32 bits", "#56b4e9", "M-4,-4H4V4H-4Z"),
    "crc_trinomial<64>": ("crc_trinomial<64>, default on 64 bits", "#0072b2", "M-4,0a4,4 0 0 0 8,0a4,4 0 0 0-8,0"),
    LIBMODBUS: ("libmodbus: a frame, with its copies", "#000000", "M-4,-4L4,4M4,-4L-4,4"),
}


def text(x, y, words, anchor="start", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{escape(words)}</text>'


def line(x1, y1, x2, y2, colour="#dddddd"):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}"/>'


def series(name, parts):
    return f'<g class="series" data-name={quoteattr(name)}>\n' + "\n".join(parts) + "\n</g>"


def picture(width, height, title, subtitle, description, parts):
    head = [
        "<!-- SPDX-FileCopyrightText: The servobus authors -->",
        "<!-- SPDX-License-Identifier: BSL-1.0 -->",
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
        ' role="img" aria-labelledby="title desc" font-family="sans-serif" font-size="13" fill="#222222">',
        f'<title id="title">{escape(title)}</title>',
        f'<desc id="desc">{escape(description)}</desc>',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        text(20, 28, title, more=' font-size="17" font-weight="bold"'),
        text(20, 48, subtitle, more=' fill="#555555"'),
    ]
    return "\n".join(head + parts + ["</svg>", ""])


COLUMNS = ("flash, bytes", "static RAM, bytes", "stack, bytes", "executed instructions")


def sizes():
    """(name, flash, RAM, stack, instructions) of each program on one board, callbacks included; figures as text."""
    by_hand, *peers = [tuple(row) for row in recorded("bench/peers/recorded.tsv")]
    own = {name: (f"servobus, {name}", flash, ram, stack, count)
           for name, core, _, ram, stack, _, _, flash, count in recorded("tests/target/figures.tsv")
           if core == "cortex-m0plus"}
    return [by_hand, own["blocking line"], own["line"], *peers]


def draw_sizes(rows):
    """Two by two panels, each with a bar for each program."""
    label, wide, pitch, tall, gap = 226, 180, 28, 18, 44
    parts, bars = [], {row[0]: [] for row in rows}
    bottom = 0
    for column, title in enumerate(COLUMNS):
        left = label + (column % 2) * (wide + 70)
        top = 112 + (column // 2) * (pitch * len(rows) + gap + 12)
        bottom = top + pitch * len(rows)
        most = max(float(row[1 + column]) for row in rows)
        parts += [text(left, top - 8, title, more=' font-weight="bold"'), line(left, top, left, bottom, "#999999")]
        for i, row in enumerate(rows):
            y = top + pitch * i + (pitch - tall) / 2
            middle = y + tall / 2 + 4.5
            long = wide * float(row[1 + column]) / most
            if column % 2 == 0:
                bars[row[0]].append(text(left - 8, middle, row[0], "end"))
            colour = OWN_COLOUR if row[0].startswith("servobus") else PEER_COLOUR
            bars[row[0]] += [f'<rect x="{left}" y="{y:.1f}" width="{long:.1f}" height="{tall}" fill="{colour}"/>',
                             text(left + long + 6, middle, row[1 + column])]
    parts += [series(name, drawn) for name, drawn in bars.items()]
    for x, colour, words in ((label, OWN_COLOUR, "servobus"), (label + 120, PEER_COLOUR, "others")):
        parts += [f'<rect x="{x}" y="62" width="14" height="14" fill="{colour}"/>', text(x + 20, 74, words)]
    said = [f"{name}: " + ", ".join(f"{title} {figure}" for title, figure in zip(COLUMNS, figures)) + "."
            for name, *figures in rows]
    return picture(750, bottom + 20, "How small: read 8 registers, write 2, on one Cortex-M0+ board",
                   "Less is better. All include the callbacks that a user writes for the UART and the clock.",
                   "Horizontal bars. " + " ".join(said), parts)


def benchmark():
    """Runs the benchmarks of the CRC: Google Benchmark's JSON. Of many short, interleaved repetitions some of each run
    undisturbed, and the best one is drawn.
    """
    path = folder / "times.json"
    said = must(built_benchmarks(), "--benchmark_min_time=0.004", "--benchmark_repetitions=150",
                "--benchmark_enable_random_interleaving=true", f"--benchmark_out={path}", "--benchmark_out_format=json",
                r"--benchmark_filter=^(crc_(bitwise|table16|table256|slicing8|trinomial<(8|64)>)|libmodbus, a frame)/")
    print("\n".join(re.findall(r"^.*(?:\d x|ns,).*", re.search(r"^ns, CRC.*?(?:^$|\Z)", said, re.M | re.S)[0], re.M)))
    return path.read_text(encoding="utf-8")


def note():
    """The compiler, its options and the machine."""
    compiler = os.path.basename(CXX)
    if not compiler[-1].isdigit():  # the name may carry the version already, as g++-12 does
        compiler += f" {family()[1]}"
    machine = os.uname().machine.replace("_", "-")
    return f"{compiler} -O2, {machine}; the best of 150 repetitions."


def times(benchmarks):
    """Nanoseconds by engine and length: the best repetition, which other load on the machine disturbed least."""
    found = {name: {} for name in ENGINES}
    for run in json.loads(benchmarks)["benchmarks"]:
        name, _, length = run["run_name"].partition("/")
        if name not in found or run.get("run_type") == "aggregate" or run.get("error_occurred"):
            continue
        assert run["time_unit"] == "ns", run
        best = found[name]
        best[int(length)] = min(best.get(int(length), math.inf), run["cpu_time"])
    return {name: dict(sorted(best.items())) for name, best in found.items() if best}


def draw_times(found, note):
    left, right, top, bottom = 80, 550, 72, 440
    everything = [ns for best in found.values() for ns in best.values()]
    low, high = math.floor(math.log10(min(everything))), math.ceil(math.log10(max(everything)))

    def across(length):
        return left + 12 + (right - left - 24) * math.log(length / LENGTHS[0]) / math.log(LENGTHS[-1] / LENGTHS[0])

    def up(ns):
        return bottom - (bottom - top) * (math.log10(ns) - low) / (high - low)

    parts, said = [], []
    for decade in range(low, high + 1):
        heights = [up(10**decade * i) for i in range(1, 10 if decade < high else 2)]
        parts += [line(left, y, right, y, "#f0f0f0") for y in heights[1:]]
        parts += [line(left, heights[0], right, heights[0], "#bbbbbb"),
                  text(left - 8, heights[0] + 4.5, str(10**decade) if decade >= 0 else f"{10**decade:g}", "end")]
    for length in LENGTHS:
        x = across(length)
        parts += [line(x, top, x, bottom), text(x, bottom + 18, str(length), "middle")]
    middle = (top + bottom) / 2
    parts += [text((left + right) / 2, bottom + 40, "length, bytes (log)", "middle", ' font-weight="bold"'),
              text(24, middle, "time of one CRC, ns (log)", "middle",
                   f' font-weight="bold" transform="rotate(-90 24 {middle:g})"')]
    dashes = {LIBMODBUS: ' stroke-dasharray="5 3"'}  # it also copies a frame
    slowest_first = sorted(found, key=lambda name: -found[name].get(LENGTHS[-2], 0))  # as the curves lie
    for i, name in enumerate(slowest_first):
        label, colour, marker = ENGINES[name]
        points = [(across(length), up(ns)) for length, ns in found[name].items()]
        y = top + 14 + 24 * i
        stroke = f'fill="none" stroke="{colour}" stroke-width="2"' + dashes.get(name, "")
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        sign = f'd="{marker}" fill="{colour}" stroke="{colour}"'
        drawn = [f'<polyline {stroke} points="{path}"/>']
        drawn += [f'<path class="point" transform="translate({x:.1f} {y:.1f})" {sign}/>' for x, y in points]
        drawn += [f'<polyline {stroke} points="{right + 14},{y} {right + 42},{y}"/>',
                  f'<path transform="translate({right + 28} {y})" {sign}/>', text(right + 50, y + 4.5, label)]
        parts.append(series(name, drawn))
        said.append(f"{name}: " + ", ".join(f"{ns:.1f} for {length}" for length, ns in found[name].items()) + ".")
    return picture(880, 500, "How fast: time of a CRC by its length", f"Less is better. {note}",
                   "Lines, both axes logarithmic. Nanoseconds by engine and bytes: " + " ".join(said), parts)


def check():
    """The faults of the two files, one a line."""
    svg = "{http://www.w3.org/2000/svg}"
    wrong = []

    def shown(path):
        try:
            root = ElementTree.parse(path).getroot()
        except (OSError, ElementTree.ParseError) as error:
            wrong.append(f"{path.name}: {error}")
            return {}
        wrong.extend(f"{path.name}: no {tag}" for tag in ("title", "desc") if not root.findtext(svg + tag))
        return {group.get("data-name"): group for group in root.iter(svg + "g") if group.get("class") == "series"}

    drawn = shown(SIZE)
    for name, *figures in sizes():
        words = [node.text for node in drawn[name].iter(svg + "text")] if name in drawn else []
        if not all(figure in words for figure in figures):
            wrong.append(f"{SIZE.name}: {name} is missing or lacks {' and '.join(figures)}: bench/plot.py --sizes")
    drawn = shown(CRC)
    for name in ENGINES:
        wanted = len(LENGTHS) - (name == LIBMODBUS)  # a frame of libmodbus has at most 256 bytes
        points = len(drawn[name].findall(f"{svg}path[@class='point']")) if name in drawn else 0
        if points != wanted:
            wrong.append(f"{CRC.name}: {name} has {points} points of {wanted}")
    return wrong


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--sizes"], ["--check"]):
        sys.exit(__doc__)
    if sys.argv[1:] == []:
        CRC.write_text(draw_times(times(benchmark()), note()), encoding="utf-8")
        print("plot.py: bench/plots/size.svg and bench/plots/crc.svg are drawn")
    if sys.argv[1:] != ["--check"]:
        SIZE.write_text(draw_sizes(sizes()), encoding="utf-8")
    if sys.argv[1:] != ["--sizes"]:
        faults = check()
        sys.exit("\n".join(faults) if faults else 0)
