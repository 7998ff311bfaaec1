# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The packages that examples/packages/make.py makes of the work tree: twice the same bytes, the version that of
CMakeLists.txt, and nothing from a tree that is not a commit.
"""
import os
import shutil
import subprocess
import sys

from package_tree import (VERSION, commit, expect_as_it_was, expect_refused, folder, git, listed, make_tree, maker, out,
                          tree, unpack)
from checks import check, expect, expect_lines, expect_same, finish, must, must_fail, need, run

DEBIAN_PYTHON = "/usr/bin/python3"  # the one that has Debian's modules
need(lambda: run(DEBIAN_PYTHON, "-c", "import yaml").returncode == 0, "python3", "python3-yaml")


def make_in(where, *to, **more):
    return must(*maker(where), *to, **more)


# ---- made twice

def again_elsewhere():
    again.parent.mkdir()
    must("git", "clone", "-q", tree, again)
    must("git", "-C", again, "config", "core.autocrlf", "true")
    make_in(again, folder / "again", umask=0o077, cwd="/", env={**os.environ, "TZ": "Asia/Tokyo", "LC_ALL": "C"})
    expect(first.count("\n") >= 30, first)
    expect_lines(first, listed(folder / "again"))


def over_an_earlier_run():
    make_in(tree, out)
    expect_lines(first, listed(out))


def by_default():
    make_in(again)
    expect_lines(first, listed(again / "build/packages"))


def at_another_time():
    timed = folder / "timed"
    make_in(tree, timed, env={**os.environ, "SOURCE_DATE_EPOCH": "1000000000"})
    expect_same(1000000000, (timed / "single/servobus.hpp").stat().st_mtime)
    expect("01-Sep-09 " in must("unzip", "-Zs", timed / f"servobus-{VERSION}-arduino.zip"), "the zip's time")
    lines = must("tar", "tvzf", timed / f"servobus-{VERSION}.tar.gz", "--utc").splitlines()
    expect(lines and all("2001-09-09 01:46" in line for line in lines), "the archive's time")


# ---- refused

def changed():
    with open(tree / "include/servobus/servobus.hpp", "a", encoding="utf-8") as header:
        header.write("// changed\n")


def untracked():
    (tree / "include/servobus/new.hpp").write_text("#pragma once\n")


def dirty(name, text, *changes):
    """Refused after the changes, which are taken back."""
    for change in changes:
        change()
    refused(name, 2, f"the tree is dirty: commit or remove {text}", [*maker(), out])
    git("reset", "-q", "--hard")
    git("clean", "-q", "-f", "-d")


def refused(name, status, text, command, **more):
    check(f"refused: {name}", expect_refused, status, text, command, **more)


def stopped():
    """At whatever point it is stopped: OUT is as it was, and nothing is left beside it."""
    for seconds in (0.2, 0.4, 0.6, 0.8, 1.0, 1.2):
        done = run("timeout", seconds, *maker(), out, apart=True)
        expect_as_it_was(first)
        expect(done.returncode == 0 or done.stderr in ("", "make.py: stopped\n"), done.stderr)


def without_git():
    (folder / "bin").mkdir()
    return {**os.environ, "PATH": str(folder / "bin")}


def cannot_join(name, line):
    """A header with this line at its end is refused."""
    with open(tree / "include/servobus/core/slice.hpp", "a", encoding="utf-8") as header:
        header.write(line + "\n")
    commit("A header that cannot be joined")
    refused(name, 1, "core/slice.hpp:", [*maker(), out])
    git("reset", "-q", "--hard", "HEAD~")


def all_refusals():
    dirty("a changed file", "include/servobus/servobus.hpp", changed)
    dirty("a change that is staged", "include/servobus/servobus.hpp", changed, lambda: git("add", "-A"))
    dirty("a file that was removed", "README.md", (tree / "README.md").unlink)
    dirty("a file that git does not know", "include/servobus/new.hpp", untracked)
    dirty("two changes, in one line", "include/servobus/servobus.hpp and 1 more", changed, untracked)
    file, foreign = folder / "file", folder / "foreign"
    foreign.mkdir()
    for path in (file, foreign / "notes.txt"):
        path.write_text("something else\n")
    refused("OUT is a file", 1, f"{file} is not a folder", [*maker(), file])
    refused("OUT in a file", 1, f"{file}/out cannot be written", [*maker(), file / "out"])
    refused("OUT where nothing can be written", 1, "/proc/out cannot be written", [*maker(), "/proc/out"])
    refused("OUT with other files", 1, f"{foreign} has files that are not of an earlier run", [*maker(), foreign])
    refused("two folders", 2, "usage:", [*maker(), out, out])
    refused("a folder without a name", 2, "usage:", [*maker(), ""])
    refused("an unknown option", 2, "usage:", [*maker(), "--fast"])
    for time in ("today", "4354819200"):
        refused(f"the time {time}", 2, f"SOURCE_DATE_EPOCH is not a number of seconds until 2107: {time}",
                [*maker(), out], env={**os.environ, "SOURCE_DATE_EPOCH": time})
    refused("a file that cannot be written whole", 1, f"{out} cannot be written",
            ["sh", "-c", 'ulimit -f 64 && exec "$@"', "sh", *maker(), out])
    check("stopped by a signal: OUT as it was", stopped)
    refused("no git", 1, "git is needed", [*maker(), out], env=without_git())
    unpacked = folder / f"unpacked/servobus-{VERSION}"
    unpacked.parent.mkdir()
    must("tar", "xzf", out / f"servobus-{VERSION}.tar.gz", "-C", unpacked.parent)
    refused("the unpacked source archive, which is no checkout", 2, f"{unpacked} is not a git checkout with a commit",
            [*maker(unpacked), out])
    must("git", "-C", unpacked.parent, "init", "-q")
    refused("a folder in another checkout", 2, f"{unpacked} is not a git checkout of its own", [*maker(unpacked), out])
    shutil.rmtree(unpacked.parent)
    cannot_join("a header with an include of ours after its code", "#include <servobus/core/bytes.hpp>")
    cannot_join("a header with an include in quotes", '#include "bytes.hpp"')


# ---- the version

def manifests(made, version, used):
    unpacked = [used / kind / "servobus" for kind in ("arduino", "platformio", "zephyr", "esp-idf")]
    must(DEBIAN_PYTHON, "-B", "tests/packages/manifests.py", version, *unpacked, made / "vcpkg/servobus")


def another_version():
    lists = tree / "CMakeLists.txt"
    text = lists.read_text("utf-8")
    lists.write_text(text.replace(f"servobus VERSION {VERSION} ", "servobus VERSION 7.8.9 "), "utf-8")
    commit("Another version")
    made, used = folder / "out789", folder / "used789"
    make_in(tree, made)
    git("reset", "-q", "--hard", "HEAD~")
    unpack(made, "7.8.9", used)
    manifests(made, "7.8.9", used)
    header = (made / "single/servobus_yako.hpp").read_text("utf-8")
    recipe = made / "conan/conanfile.py"
    expect('\n    version = "7.8.9"\n' in recipe.read_text("utf-8"), "conanfile.py")
    expect("// servobus 7.8.9: " in header and "\n#define SERVOBUS_SINGLE_HEADER_VERSION 7008009\n" in header, "single")
    # Nothing else says the version: the old one is only in what the commit itself has in other files.
    expect_same([], [*made.rglob(f"*{VERSION}*")])
    for path in (recipe, *(made / "vcpkg/servobus").glob("*file.cmake"), made / "vcpkg/servobus/vcpkg.json",
                 *(made / "single").iterdir()):
        expect(VERSION not in path.read_text("utf-8"), f"{path} has {VERSION}")


def two_versions():
    mixed = folder / "mixed"
    mixed.mkdir()
    shutil.copy(out / "single/servobus_yako.hpp", mixed / "old.hpp")
    shutil.copy(folder / "out789/single/servobus.hpp", mixed / "new.hpp")
    must_fail("servobus: single headers of two versions", "g++", "-std=c++20", f"-I{mixed}", "-fsyntax-only",
              "-x", "c++", "-", typed="#include <old.hpp>\n#include <new.hpp>\n")


def whole():
    """The source archive has the files of the commit."""
    for name in ("whole", "archived"):
        (folder / name).mkdir()
    with subprocess.Popen(["git", "-C", tree, "archive", "HEAD"], stdout=subprocess.PIPE) as archive:
        subprocess.run(["tar", "xf", "-", "-C", folder / "whole"], stdin=archive.stdout, check=True)
    must("tar", "xzf", out / f"servobus-{VERSION}.tar.gz", "-C", folder / "archived")
    must("diff", "-r", folder / "whole", folder / f"archived/servobus-{VERSION}")


make_tree()
if not check("packages are made", make_in, tree, out):
    sys.exit(1)
first = listed(out)
again = folder / "elsewhere/again"
check("from another clone, umask, time zone and line endings: the same bytes, modes and times", again_elsewhere)
check("over those of an earlier run: the same", over_an_earlier_run)
check("without OUT: in build/packages, which git ignores", by_default)
check("SOURCE_DATE_EPOCH is the time of all files", at_another_time)
all_refusals()
check("each archive can be unpacked", unpack, out, VERSION, folder / "used")
check(f"the manifests have their form, and version {VERSION}", manifests, out, VERSION, folder / "used")
check("another version in CMakeLists.txt: that of all packages", another_version)
check("single headers of two versions: an error that says so", two_versions)
check("the source archive has the files of the commit", whole)
finish()
