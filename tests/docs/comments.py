# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What a machine can judge of comments: lines over 120 columns, first sentences that begin with a word of doubt, and
sentences of more than 25 words. Names each, or counts them by room.

comments.py [--list N] [--rooms] [FOLDER...]    include/servobus if none is given
comments.py --check                             fails if a room has more than comments.txt allows, or fewer: then write
                                                its own figures into it
comments.py --bounds                            prints that file
"""
import re
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOST_COLUMNS = 120
MOST_WORDS = 25
OPENINGS = re.compile(r"(?:For that|What|How|Whether|Of|That|One)\b")
KINDS = ("columns", "opening", "words")
LINE = re.compile(r"^(?P<code>.*?)(?P<mark>//[/!]?<?)(?P<text>.*)$")
# `e.g.` and `1.5` end no sentence; a colon before a list does not either.
END = re.compile(r"(?<=[.!?])(?<!e\.g\.)(?<!i\.e\.)(?<!No\.)\s+(?=[A-Z`0-9(])")


def is_in_string(code):
    return len(re.findall(r'(?<!\\)"', re.sub(r"'\"'", "", code))) % 2 == 1


def blocks(path):
    """(number of its first line, mark, text) of each run of comments; a comment behind code is one of its own."""
    run, begun, mark = [], 0, ""
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        found = LINE.match(line)
        if not found or is_in_string(found["code"]) or "://" in line[: found.end("mark") + 1]:
            if run:
                yield begun, mark, run
            run = []
            continue
        text = found["text"]
        behind = found["code"].strip() != ""
        is_code = re.match(r"\s{3,}\S", text) or re.match(r"\s*(\||SPDX-|clang-format|NOLINT|EXPECT|MEND|cppcheck)", text)
        begins = re.match(r"\s*(- |Errors\b)", text)  # an item of a list is a sentence of its own
        if run and (behind or found["mark"] != mark or not text.strip() or is_code or begins):
            yield begun, mark, run
            run = []
        if is_code or not text.strip():
            continue
        if not run:
            begun, mark = number, found["mark"]
        run.append(text.strip())
        if behind:
            yield begun, mark, run
            run = []
    if run:
        yield begun, mark, run


def sentences(lines):
    said = re.sub(r"\s+", " ", " ".join(lines))
    # A list of errors has a semicolon or a comma between its items.
    return re.split(r"[;,] ", said) if said.startswith("Errors") else END.split(said)


def words(sentence):
    return len([w for w in re.sub(r"`[^`]*`", "code", sentence).split() if re.search(r"\w", w)])


def hits(path):
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        # A row of the manual's table, and what a wrong program is expected to print, have one line by their form.
        is_one_line = re.match(r"// (EXPECT|MEND): |/// ([0-9A-F]{4}h|P[0-9A-F]{2}-)", line)
        if "//" in line and len(line) > MOST_COLUMNS and not is_one_line:
            yield number, "columns", len(line), line.strip()
    for number, mark, lines in blocks(path):
        said = sentences(lines)
        if mark.startswith("///") and OPENINGS.match(said[0]):
            yield number, "opening", words(said[0]), said[0]
        for sentence in said:
            if words(sentence) > MOST_WORDS:
                yield number, "words", words(sentence), sentence


def room_of(path):
    parts = path.relative_to(ROOT).parts
    return "/".join(parts[1:3]) if parts[:2] == ("include", "servobus") and len(parts) > 3 else "/".join(parts[:-1][:2])


ROOMS = ["include/servobus", "examples", "tests", "fuzz", "bench"]
BOUNDS = Path(__file__).with_suffix(".txt")
HEAD = """# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What `python3 tests/docs/comments.py` may find in each room: lines of more than 120 columns, doc comments that begin with
# What, How, Whether, Of, That or One, and sentences of more than 25 words. A figure may fall, and never rises.
"""


def counts_of(folders):
    """By room, how many there are of each kind; and all of them, as (kind, size, place, text)."""
    counts, found, sentences_in_all = defaultdict(lambda: dict.fromkeys(KINDS, 0)), [], 0
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.?pp")):
            row = counts[room_of(path)]
            sentences_in_all += sum(len(sentences(lines)) for _, _, lines in blocks(path))
            for number, kind, size, text in hits(path):
                row[kind] += 1
                found.append((kind, size, f"{path.relative_to(ROOT)}:{number}", text))
    return counts, found, sentences_in_all


def table_of(counts):
    return HEAD + "".join(f"{room}\t" + "\t".join(str(counts[room][kind]) for kind in KINDS) + "\n" for room in sorted(counts))


def compare(counts):
    """The rooms whose figures differ from those of the file, in words."""
    lines = [line.split("\t") for line in BOUNDS.read_text("utf-8").splitlines() if line and line[0] != "#"]
    bounds = {room: dict(zip(KINDS, map(int, most))) for room, *most in lines}
    for room in sorted(counts.keys() | bounds.keys()):
        now, most = counts.get(room, dict.fromkeys(KINDS, 0)), bounds.get(room, dict.fromkeys(KINDS, 0))
        for kind in KINDS:
            if now[kind] > most[kind]:
                yield f"{room}: {kind} {now[kind]}, {most[kind]} at most: comments.py --list 30 {room} shows them"
            elif now[kind] < most[kind]:
                yield f"{room}: {kind} fell to {now[kind]}: comments.py --bounds > tests/docs/comments.txt keeps it"


def main(arguments):
    folders = [a for a in arguments if (ROOT / a).is_dir()] or (ROOMS if set(arguments) & {"--check", "--bounds"} else ROOMS[:1])
    counts, found, sentences_in_all = counts_of(folders)
    if "--bounds" in arguments:
        print(table_of(counts), end="")
        return 0
    wrong = list(compare(counts)) if "--check" in arguments else []
    for line in wrong:
        print("FAILED  " + line)
    if "--rooms" in arguments:
        print(table_of(counts).removeprefix(HEAD), end="")
    most = int(arguments[arguments.index("--list") + 1]) if "--list" in arguments else 0
    for kind, size, where, text in sorted(found, key=lambda h: -h[1] - (0 if h[0] == "words" else 200))[:most]:
        print(f"{where}\t{kind} {size}\t{text}")
    total = {kind: sum(row[kind] for row in counts.values()) for kind in KINDS}
    print("comments.py:", ", ".join(f"{n} {kind}" for kind, n in total.items()), "of", sentences_in_all, "sentences")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
