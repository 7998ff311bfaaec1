# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""unless_unchanged.py runs a check whenever something that it judges has changed, or whenever that is not known."""
import os
import sys

sys.path.insert(0, "tests/support")
from checks import ROOT, SKIPPED, expect, check, finish, must, run, same, work

FILES = {
    "include/servobus/low/word.hpp": "#pragma once\n",
    "include/servobus/high/line.hpp": "#include <servobus/low/word.hpp>\n",
    "include/servobus/other.hpp": "#pragma once\n",
    "tests/high/test.cpp": '#include <servobus/high/line.hpp>\n#include "beside.hpp"\n',
    "tests/high/beside.hpp": "#pragma once\n",
    "tests/judge.py": "import shared\n",
    "tests/support/shared.py": "",
    "tests/passed.txt": "",
}
folder = work()


def git(*words):
    return must("git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@example.org", *words)


def write(name, text):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def asked(*words, **environment):
    """The status and what is printed of a check that would end with 5."""
    names = {**os.environ, "SERVOBUS_ROOT": str(folder), **environment}
    if not environment:
        names.pop("SERVOBUS_EVERYTHING", None)
    done = run(sys.executable, "-B", ROOT / "tests/unless_unchanged.py", *words, "--", "sh", "-c", "exit 5", "tests/judge.py",
               env=names)
    return done.returncode, done.stdout


def runs(name, because, *words, **environment):
    def judged():
        status, printed = asked(*words, **environment)
        expect(status == 5 and because in printed, f"status {status}: {printed}")

    check(name, judged)


def is_left_out(name, *words):
    same(name, SKIPPED, asked(*words)[0])




for name, text in FILES.items():
    write(name, text)
git("init", "-q")
git("add", ".")
git("commit", "-qm", "all")
runs("no record", "no commit is in", "tests/high")
write("tests/passed.txt", git("rev-parse", "HEAD"))
git("commit", "-qam", "record")
is_left_out("nothing has changed since", "tests/high")
runs("everything", "asked for", "tests/high", SERVOBUS_EVERYTHING="1")
same("a path that is not there", 1, asked("tests/hihg")[0])

for name, text in (("what is named", "tests/high/test.cpp"), ("what it includes", "include/servobus/high/line.hpp"),
                   ("what that includes", "include/servobus/low/word.hpp"), ("what is beside it", "tests/high/beside.hpp"),
                   ("the judge", "tests/judge.py"), ("what the judge imports", "tests/support/shared.py")):
    before = (folder / text).read_text()
    write(text, before + "\n")
    runs(f"{name}, not committed", text, "tests/high")
    git("commit", "-qam", "change")
    runs(f"{name}, committed", text, "tests/high")
    git("reset", "-q", "--hard", "HEAD~")
write("tests/high/new.cpp", "")
runs("a new file that nobody has added", "tests/high/new.cpp", "tests/high")
git("clean", "-qfd")
git("rm", "-q", "tests/high/beside.hpp")
runs("a file that is gone", "tests/high/beside.hpp", "tests/high")
git("reset", "-q", "--hard")

write("include/servobus/other.hpp", "// changed\n")
is_left_out("what it does not include", "tests/high")
git("checkout", "-q", ".")
write("include/servobus/low/word.hpp", "// changed\n")
is_left_out("alone: what it includes", "--alone", "tests/high")
write("tests/high/test.cpp", "// changed\n")
runs("alone: the file itself", "tests/high/test.cpp", "--alone", "tests/high")
git("checkout", "-q", ".")

must("git", "clone", "-q", "--depth", "1", f"file://{folder}", folder / "shallow")
folder = folder / "shallow"
runs("a shallow clone", "ancestor", "tests/high")
git("checkout", "-q", "--orphan", "other")
git("commit", "-qm", "other")
runs("another history", "ancestor", "tests/high")
finish()
