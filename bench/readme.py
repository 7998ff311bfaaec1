# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Writes the recorded figures into bench/README.md, so that they stay up to date.

readme.py            writes the tables that are marked `<!-- figures: NAME -->`, and the numbers in the sentences below
readme.py --check    checks that the page has all of them as recorded
"""
import re
import sys

import instructions
from measuring import ROOT, recorded

PAGE = ROOT / "bench" / "README.md"


def quoted(path, pattern):
    """The groups of a pattern in a script, such as a bound that it enforces."""
    found = re.search(pattern, (ROOT / path).read_text(encoding="utf-8"))
    if found is None:
        sys.exit(f"readme.py: {path} has no '{pattern}'")
    return found.groups()


TARGET = [row for row in recorded("tests/target/figures.tsv") if row[1] == "cortex-m0plus"]
BUS = [row for row in recorded("bench/figures/bus.tsv") if len(row) == 5]
EARLY_BUS = [row for row in recorded("bench/figures/bus.tsv") if len(row) != 5]

OPERATIONS = {
    "build 06": "build a write (06)",
    "build 03": "build a read (03)",
    "build 10h x10": "build a write of ten (10h)",
    "parse 03 x10": "parse a response of ten",
    "transaction 06": "transaction: write one",
    "transaction 03 x10": "transaction: read ten",
    "transaction 10h x10": "transaction: write ten",
}


def server():
    for name, *figures in recorded("tests/target/server.tsv"):
        yield [name.replace("alone", "ten holding registers"), *figures]


def on_a_host():
    counted = {}
    for compiler, name, *figures in recorded("bench/figures/instructions.tsv"):
        counted[compiler.split()[0], name] = figures
    for name, label in OPERATIONS.items():
        row = [label]
        for compiler in ("g++", "clang++"):
            own, other, library = counted[compiler, name]
            row += [own, other, f"{int(own) / int(other):.2f}"]
            row += ["" if library == "-" else library] if compiler == "g++" else []
        yield row


def bus():
    for baud in dict.fromkeys(row[0] for row in BUS):
        for row in (r for r in BUS if r[0] == baud):
            is_first = row[1] == "0 us"
            late = row[1].replace("1000 us", "1 ms") + " late"
            yield [baud if is_first else "", "to the microsecond" if is_first else late] + row[2:]


def early_bus():
    for _, late, *shares in EARLY_BUS:
        yield [late + " late", *shares]


def small_core():
    for name, _, flash, ram, stack, count, requests, flash_all, count_all in TARGET:
        if not name.startswith("line, "):
            yield [name, flash, ram, stack, count, requests, flash_all, count_all]


def facade_and_bus():
    for name, _, flash, ram, stack, count, requests, flash_all, count_all in TARGET:
        if name.startswith("line, "):
            yield [name, flash, ram, stack, count, requests, flash_all, count_all]


ENGINES = ("crc_trinomial<8>", "crc_trinomial<32>", "crc_trinomial<16>", "crc_table256", "crc_table16", "crc_bitwise")


def operations():
    counted = {name: figures for name, *figures in recorded("tests/target/operations.tsv")}
    sizes = {name: figures for name, *figures in recorded("bench/figures/sizes.tsv")}
    for engine in ENGINES:
        m0_eight, m0_byte, m4_eight, m4_byte = counted[engine]
        m4_size, m0_size = sizes[engine]
        is_first = engine == ENGINES[0]
        yield [f"CRC of 8 bytes, `{engine}`, the default" if is_first else f"... `{engine}`",
               f"{m0_eight}, {m0_byte} a byte more" if is_first else f"{m0_eight}, {m0_byte}",
               f"{m4_eight}, {m4_byte}", m0_size, m4_size]
    for name, figures in counted.items():
        if name not in ENGINES:
            yield [name, *figures, "", ""]


def included():
    """Billions of instructions of the compiler."""
    labels = {"span": "`<span>` alone, which is not included"}
    for name, millions in recorded("bench/figures/include_cost.tsv"):
        label = f"... and `{name}`" if name.startswith("device/") else f"`{name}`"
        yield [labels.get(name, label), f"{int(millions) / 1000:.2f}"]


TABLES = {"instructions": on_a_host, "bus": bus, "early bus": early_bus, "small core": small_core,
          "facade and bus": facade_and_bus, "other tables": lambda: recorded("tests/target/calls.tsv"),
          "operations": operations, "server": server, "include cost": included}


def of_a_read(thousands):
    """Millions of instructions."""
    return f"{int(thousands) / 1000:.1f}"


def sentences():
    """(sentence with a group for each number, the numbers)"""
    fast, byte_wise = (
        quoted("tests/target/operations.sh", rf"engine 'crc_trinomial<{bits}>' \S+ - (\S+) \S+ \S+ (\S+)")
        for bits in (32, 8))
    busiest, = quoted("bench/bench_bus.cpp", r"share >= (\d+)")
    early_least = [f"{int(least) / 10:g}" for late in ("60 us", "150 us")
                   for least in quoted("bench/bench_bus.cpp", rf'"{late}", .*, (\d+)}},')]
    least = min(float(share.split()[0]) for row in BUS if row[1] == "0 us" for share in row[2:])
    first = TARGET[0]
    return [
        (r"g\+\+ above (\S+) for frames and (\S+) for transactions, with clang\+\+ above (\S+) and (\S+),",
         [f"{instructions.BOUNDS[name][kind] / 100:.2f}"
          for name in ("g++", "clang++") for kind in ("frame", "transaction")]),
        (r"It uses (\S+) % or more", [f"{least:.1f}"]),
        (r"CI fails below (\S+) %", [f"{int(busiest) / 10:g}"]),
        (r"CI fails where the first row is below (\S+) % or that of 150 us below (\S+) %", early_least),
        (r"CI fails above (\S+) and (\S+) instructions a byte", fast),
        (r"and above (\S+) and (\S+) for the byte-wise one", byte_wise),
        (r"(\d+) bytes of flash, (\d+) of RAM for the line and its client, (\d+) of stack, (\d+) instructions",
         recorded("tests/target/budgets.tsv")[0][1:5]),
        (r"are (\d+) bytes, and (\d+) instructions in the first row",
         [str(int(first[7]) - int(first[2])), str(int(first[8]) - int(first[5]))]),
        (r"is the floor, (\d+) bytes and (\d+) instructions", recorded("bench/peers/recorded.tsv")[0][1::3]),
        (r"costs g\+\+ 12 (\S+) million instructions and clang\+\+ 14 (\S+) million",
         [of_a_read(thousands) for _, thousands in recorded("bench/figures/plan_cost.tsv")]),
        (r"CI fails above (\S+) and (\S+) million",
         [f"{int(bound) / 1000:g}"
          for bound in quoted("bench/plan_cost.py", r'BOUNDS = {"g\+\+": (\d+), "clang\+\+": (\d+)}')]),
    ]


def written(text):
    """The page with the recorded figures."""
    for name, rows in TABLES.items():
        pattern = rf"(<!-- figures: {name} -->\n(?:\|.*\n)?\|.*\n\|[-|: ]+\n)(?:\|.*\n)*"
        body = "".join("| " + " | ".join(row) + " |\n" for row in rows()).replace("|  |", "| |").replace("|  |", "| |")
        text, count = re.subn(pattern, lambda found: found[1] + body, text)
        if count != 1:
            sys.exit(f"readme.py: bench/README.md has {count} tables '{name}'")
    for sentence, numbers in sentences():
        found = re.findall(sentence.replace(" ", r"\s+"), text)
        if len(found) != 1:
            sys.exit(f"readme.py: bench/README.md has {len(found)} times '{sentence}'")

        def filled(match, numbers=numbers):
            words = match[0]
            for group in range(len(numbers), 0, -1):
                begin, end = match.start(group) - match.start(), match.end(group) - match.start()
                words = words[:begin] + numbers[group - 1] + words[end:]
            return words

        text = re.sub(sentence.replace(" ", r"\s+"), filled, text)
    return text


def main():
    now = PAGE.read_text(encoding="utf-8")
    wanted = written(now)
    if sys.argv[1:] == ["--check"]:
        pairs = zip(now.splitlines(), wanted.splitlines())
        stale = [f"bench/README.md: '{old}' is recorded as '{new}'" for old, new in pairs if old != new]
        if now != wanted:
            sys.exit("\n".join(stale or ["bench/README.md: a table has too many or too few rows"]))
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        PAGE.write_text(wanted, encoding="utf-8")


if __name__ == "__main__":
    main()
