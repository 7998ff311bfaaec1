# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Runs a check, unless nothing that it judges has changed since everything passed.

unless_unchanged.py [--alone] PATH... -- COMMAND WORD...

PATH: a file or a folder of the repository; those that COMMAND names are added. What they include, import or run counts too,
unless --alone is given. tests/passed.txt has the commit of which `sh tests/everything.sh` has passed: not the last push,
so a check that failed stays due. Ends with 77, which CTest shows as skipped, if the check need not run. It runs if
SERVOBUS_EVERYTHING is set, and whenever that is not known: no record, a shallow clone, a commit that is no ancestor.
"""
import os
import re
import subprocess
import sys
from pathlib import Path, PurePosixPath

ROOT = Path(os.environ.get("SERVOBUS_ROOT", Path(__file__).resolve().parents[1]))
RECORD = "tests/passed.txt"
SKIPPED = 77
CODE = (".hpp", ".cpp", ".h", ".c", ".ino")
INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', re.M)
IMPORT = re.compile(r"^\s*(?:from|import)\s+(\w+)", re.M)
SCRIPT = re.compile(r"\b(?:tests|bench|fuzz|examples)/[\w/.]+\.(?:sh|py|cpp)\b")


class NotKnown(Exception):
    """Why the check runs."""


def git(*words):
    done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False)
    if done.returncode:
        raise NotKnown(f"git {words[0]} fails: {done.stderr.strip() or done.returncode}")
    return done.stdout.splitlines()


def files_of(paths):
    """The files of the repository in these paths, those that nobody has added yet among them."""
    found = set()
    for path in paths:
        files = git("ls-files", "--cached", "--others", "--exclude-standard", "--", path)
        if not files:  # a misspelt one would never change
            sys.exit(f"unless_unchanged.py: nothing is in {path}")
        found.update(files)
    return found


def named_by(name):
    """What a file may include, import or run, as its text has it."""
    folder = PurePosixPath(name).parent
    try:
        text = (ROOT / name).read_text("utf-8")
    except OSError:  # removed: git says so
        return
    if name.endswith(CODE):
        for included in INCLUDE.findall(text):
            yield from (os.path.normpath(folder / included), f"include/{included}", included, f"examples/{included}")
    if name.endswith(".py"):
        for module in IMPORT.findall(text):
            yield from (f"{folder}/{module}.py", f"tests/support/{module}.py")
    if name.endswith((".py", ".sh")):
        yield from SCRIPT.findall(text)


def with_included(files):
    """These files and all that they include, import or run."""
    known, todo = set(files), list(files)
    while todo:
        for name in named_by(todo.pop()):
            if name not in known and (ROOT / name).is_file():
                known.add(name)
                todo.append(name)
    return known


def changed_since_all_passed():
    try:
        base = (ROOT / RECORD).read_text("utf-8").split()[0]
    except (OSError, IndexError):
        raise NotKnown(f"no commit is in {RECORD}") from None
    try:
        git("merge-base", "--is-ancestor", base, "HEAD")
    except NotKnown:
        raise NotKnown(f"{base[:8]} is not known to be an ancestor") from None
    committed = git("diff", "--no-renames", "--name-only", base, "HEAD")
    return base[:8], {*committed, *(line[3:] for line in git("status", "--porcelain", "--no-renames", "-uall"))}


def is_inside(name, paths):
    return any(path == "." or name == path or name.startswith(path.rstrip("/") + "/") for path in paths)


def reason_to_run(paths, is_alone):
    """Empty if nothing has changed."""
    if os.environ.get("SERVOBUS_EVERYTHING"):
        return "everything is asked for"
    try:
        base, changed = changed_since_all_passed()
        files = files_of(paths)
        judged = files if is_alone else with_included(files)
        due = sorted(name for name in changed if name in judged or is_inside(name, paths))  # a removed one is no file
    except NotKnown as why:
        return str(why)
    return f"{due[0]} has changed since {base}" if due else ""


def main(words):
    is_alone = words[:1] == ["--alone"]
    end = words.index("--") if "--" in words else 0
    paths, command = words[is_alone:end], words[end + 1:]
    if not paths or not command:
        sys.exit(__doc__)
    paths += [word for word in command if word.startswith(("tests/", "bench/", "fuzz/")) and (ROOT / word).is_file()]
    why = reason_to_run(paths, is_alone)
    if not why:
        print(f"unchanged since everything passed: {' '.join(paths)}")
        return SKIPPED
    print(f"runs: {why}", flush=True)
    return subprocess.run(command, cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
