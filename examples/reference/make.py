# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Builds the reference as HTML: a start page, the API with the pages of the library, and the register map of each drive
with a filter.

python3 examples/reference/make.py OUT                 OUT/index.html is the start page
SERVOBUS=PATH python3 examples/reference/make.py OUT   with a tool that is built already

It needs doxygen (1.9.4 or newer) and a compiler (CXX, g++ if not given). A comment of a public header that doxygen
cannot read is an error. The same headers give the same bytes.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True  # the tree stays as it is
import comments
import maps
import pages

ROOT = Path(__file__).resolve().parent.parent.parent
HERE = ROOT / "examples/reference"
CXX = [*os.environ.get("CXX", "g++").split(), "-std=c++20", "-O0", f"-I{ROOT}/include"]


def run(*command):
    """Runs a command, whose output this program's user sees."""
    if subprocess.run([str(word) for word in command]).returncode != 0:
        sys.exit(f"make.py: {command[0]} failed")


def clear(out):
    """Only what an earlier run wrote is replaced."""
    out.mkdir(parents=True, exist_ok=True)
    start = out / "index.html"
    is_earlier = start.exists() and "<title>servobus: reference</title>" in start.read_text("utf-8")
    if any(out.iterdir()) and not is_earlier:
        sys.exit(f"make.py: {out} is neither empty nor an earlier reference")
    shutil.rmtree(out / "api", ignore_errors=True)
    for page in [start, *out.glob("map_*.html")]:
        page.unlink(missing_ok=True)


def make_api(out, work, version):
    include = work / "include"
    comments.write(ROOT / "include/servobus", include / "servobus")
    pages.write(ROOT / "include/servobus", include)
    shutil.copy(HERE / "api.dox", include)
    (out / "api").mkdir()
    settings = {"INPUT": include, "STRIP_FROM_PATH": include, "STRIP_FROM_INC_PATH": include,
                "OUTPUT_DIRECTORY": out / "api", "GENERATE_TAGFILE": work / "tags", "WARN_LOGFILE": work / "warnings"}
    (work / "Doxyfile").write_text("".join([
        (HERE / "Doxyfile").read_text("utf-8"), f"PROJECT_NUMBER = {version}\n",
        *(f'{name} = "{value}"\n' for name, value in settings.items())]), "utf-8")
    done = subprocess.run(["doxygen", work / "Doxyfile"], cwd=ROOT)
    warnings = (work / "warnings").read_text("utf-8").replace(f"{work}/", "") if (work / "warnings").exists() else ""
    if done.returncode != 0 or warnings:
        sys.exit(f"{warnings}make.py: doxygen failed, or has warnings")


def name_folders(api):
    """The page of a folder has the hash of its whole path in its name: each gets the name of the folder."""
    names = {}
    for page in sorted(api.glob("dir_*.html")):
        folder = re.search("<title>servobus: (.*) Directory Reference</title>", page.read_text("utf-8"))
        if not folder:
            sys.exit(f"make.py: {page} has no title")
        names[page.stem] = "dir_" + folder[1].replace("/", "_")
        page.rename(api / f"{names[page.stem]}.html")
    hashed = re.compile("|".join(names))
    for page in [*api.rglob("*.html"), *api.rglob("*.js")]:
        text = page.read_bytes().decode("utf-8")
        page.write_bytes(hashed.sub(lambda found: names[found[0]], text).encode())


def make_maps(out, work, version):
    tool = os.environ.get("SERVOBUS")
    if not tool:
        tool = work / "servobus"
        run(*CXX, ROOT / "examples/servobus.cpp", "-o", tool)
    run(*CXX, HERE / "values.cpp", "-o", work / "values")
    values = subprocess.run([work / "values"], check=True, capture_output=True, text=True).stdout
    maps.write(out, version, os.path.abspath(tool), values, work / "tags")


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit("usage: python3 examples/reference/make.py OUT")
    for program in ("doxygen", CXX[0]):
        if shutil.which(program) is None:
            sys.exit(f"make.py: {program} is needed: sudo apt-get install {program}")
    out = Path(os.path.abspath(sys.argv[1]))
    version = re.search(r"^project\(servobus VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text("utf-8"), re.M)[1]
    clear(out)
    with tempfile.TemporaryDirectory() as work:
        print("make.py: the API", flush=True)
        make_api(out, Path(work), version)
        name_folders(out / "api")
        print("make.py: the maps", flush=True)
        make_maps(out, Path(work), version)
    print(f"make.py: {len([*out.rglob('*.html')])} pages; begin with {out}/index.html")


main()
