# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the tests of packages share: a repository of what the work tree has, and the packages made from it.

So changes that are not yet committed are checked, and a tree without git too.
"""
import re
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import ROOT, expect, must, need, run, work

for program in ("git", "unzip"):
    need(program, program)
folder = work()
tree = folder / "tree"
out = folder / "out"
VERSION = re.search(r"^project\(servobus VERSION ([0-9.]+) ", (ROOT / "CMakeLists.txt").read_text("utf-8"), re.M)[1]


def git(*arguments):
    return must("git", "-C", tree, "-c", "user.name=test", "-c", "user.email=test@example.org",
                "-c", "commit.gpgsign=false", "-c", "core.hooksPath=/dev/null", *arguments)


def commit(message):
    git("add", "-A")
    git("commit", "-q", "-m", message)


def work_tree_files():
    if run("git", "rev-parse", "--show-toplevel").stdout.strip() == str(ROOT):
        return must("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard").split("\0")[:-1]
    files = (path.relative_to(ROOT) for path in ROOT.rglob("*") if not path.is_dir())
    return [str(file) for file in files if not re.match(r"build|\.git$", file.parts[0])]


def make_tree():
    for file in work_tree_files():
        if (ROOT / file).exists():
            (tree / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / file, tree / file, follow_symlinks=False)
    git("init", "-q")
    commit("What the work tree has")


def maker(of=tree):
    return [sys.executable, "-B", of / "examples/packages/make.py"]


def listed(of):
    """Names, modes, times and sums of the files in a folder."""
    return "".join(must("sh", "-c", command, cwd=of) for command in (
        "find . -type f -printf '%p %m %T@\\n' | sort", "find . -type f -exec sha256sum {} + | sort"))


def unpack(made, version, to):
    """Unpacks the archives that are for a framework."""
    for kind in ("arduino", "platformio", "zephyr", "esp-idf"):
        (to / kind).mkdir(parents=True)
    must("unzip", "-q", made / f"servobus-{version}-arduino.zip", "-d", to / "arduino")
    for kind in ("platformio", "zephyr", "esp-idf"):
        must("tar", "xzf", made / f"servobus-{version}-{kind}.tar.gz", "-C", to / kind)


def expect_refused(status, text, command, **more):
    """One line on standard error, this status, and OUT as it was."""
    before = listed(out)
    done = run(*command, apart=True, **more)
    expect(done.returncode == status, f"status {done.returncode}: {done.stdout}{done.stderr}")
    expect(not done.stdout and done.stderr.count("\n") == 1 and f"make.py: {text}" in done.stderr, done.stderr)
    expect_as_it_was(before)


def expect_as_it_was(before):
    expect(listed(out) == before, "OUT has changed")
    expect(not [*folder.glob(".*-*")], "a folder is left")
