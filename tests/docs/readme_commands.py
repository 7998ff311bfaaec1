# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Follows README.md to the letter: runs the commands of its ```sh blocks in a fresh clone, from top to bottom.

readme_commands.py            clones the last commit, runs the commands, and builds a program by each build system
readme_commands.py --list     prints the commands, and which are not run and why

All commands run in one shell. Fails if
- a command fails, or what a ```text block quotes is not in the output of the ```sh block before it;
- the clone has a changed or new file afterwards that .gitignore does not name;
- the page has commands that this check does not find, or NOT_RUN names commands that the page does not have;
- the README's first program does not build as the lines for CMake, Meson and pkg-config say.

In a quoted output `...` stands for any lines, and one number for another.
"""
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = "README.md"

# Commands that are not run, by how they begin, and why.
NOT_RUN = {
    "sudo ": "it changes the system",
    "sh examples/run.sh /dev/": "it needs a drive at a serial port",
    "sh tests/run.sh": ".ci/run begins with it",
}
KINDS = {"sh", "text", "cpp"}
MARK = "\x1e"  # begins a line of the log that names a command


class Wrong(Exception):
    """A sentence about the page or a command."""


def blocks(page):
    """(kind, lines) of each fenced block. Indented code is refused: its commands would not be found."""
    found = []
    inside = None
    for number, line in enumerate(page.split("\n"), 1):
        if line.startswith("```"):
            if inside is None:
                inside = (line[3:].strip(), [])
                if inside[0] not in KINDS:
                    raise Wrong(f"{PAGE}:{number}: a block is sh, text or cpp, not '{inside[0]}'")
            else:
                found.append(inside)
                inside = None
        elif inside is not None:
            inside[1].append(line)
        elif line.startswith("    ") and line.strip():
            raise Wrong(f"{PAGE}:{number}: indented code; commands are in ```sh blocks")
    if inside is not None:
        raise Wrong(f"{PAGE}: the last block has no end")
    return found


def commands_of(lines):
    """The commands of a block, each without its comment."""
    commands = []
    for line in "\n".join(lines).replace("\\\n", " ").split("\n"):
        if command := re.sub(r"(^|\s+)#\s.*$", "", line).strip():
            commands.append(command)
    return commands


def why_not_run(command):
    return next((why for begin, why in NOT_RUN.items() if command.startswith(begin)), None)


def parse(page):
    """A list of (commands, quoted outputs), one for each ```sh block."""
    parts = []
    for kind, lines in blocks(page):
        if kind == "sh":
            parts.append((commands_of(lines), []))
        elif kind == "text":
            if not parts:
                raise Wrong(f"{PAGE}: an output is quoted before any command")
            parts[-1][1].append(lines)
    commands = [command for part, _ in parts for command in part]
    if not any(why_not_run(command) is None for command in commands):
        raise Wrong(f"{PAGE} has no command to run")
    for begin in NOT_RUN:
        if not any(command.startswith(begin) for command in commands):
            raise Wrong(f"{PAGE} has no command that begins with '{begin}': take it out of NOT_RUN")
    return parts


def check_scripts(page, clone):
    """Scripts that the page names in a sentence exist."""
    for script in re.findall(r"`(?:sh|python3) ([^\s`]+)", page):
        if not (clone / script).is_file():
            raise Wrong(f"{PAGE} names {script}, which does not exist")


def script_of(commands, log):
    """A shell script: each command writes into the log, and a line about it to the standard output."""
    lines = [f"exec 3>&1 >{shlex.quote(str(log))} 2>&1"]
    for number, command in enumerate(commands):
        shown = shlex.quote(command)
        lines += [f"printf '{MARK}%s\\n' {number}", f"printf 'run     %s\\n' {shown} >&3", "began=$(date +%s)", command,
                  f"status=$?; [ $status = 0 ] || {{ printf 'FAILED  status %s: %s\\n' $status {shown} >&3; exit 1; }}",
                  "printf 'ok      %s s\\n' $(($(date +%s) - began)) >&3"]
    return "\n".join(lines) + "\n"


def run(commands, clone, work):
    """The output of each command."""
    script, log = work / "commands.sh", work / "log"
    script.write_text(script_of(commands, log), "utf-8")
    sys.stdout.flush()
    shell = subprocess.Popen(["sh", str(script)], cwd=clone, stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        status = shell.wait()
    finally:
        try:  # what the commands left in the background
            os.killpg(shell.pid, signal.SIGTERM)
        except ProcessLookupError:
            pass
    outputs = [output.partition("\n")[2] for output in log.read_text("utf-8", "replace").split(MARK)[1:]]
    if status != 0:
        print("\n".join(outputs[-1].split("\n")[-60:]))
        raise Wrong("a command failed; above is the end of its output")
    return outputs


def plain(line):
    return re.sub(r"\d+", "0", " ".join(line.split()))


def check_quoted(quoted, output):
    """Each run of quoted lines is in the output, in this order."""
    said = [plain(line) for line in output.split("\n")]
    at = 0
    for piece in re.split(r"(?m)^\s*\.\.\.\s*$\n?", "\n".join(quoted)):
        wanted = [plain(line) for line in piece.strip("\n").split("\n")]
        if wanted == [""]:
            continue
        while said[at:at + len(wanted)] != wanted:
            at += 1
            if at >= len(said):
                raise Wrong("an output is quoted that the commands did not print:\n" + piece.strip("\n"))
        at += len(wanted)


def check_clean(clone):
    changed = subprocess.run(["git", "status", "--porcelain", "--untracked-files=all"], cwd=clone, check=True,
                             capture_output=True, text=True).stdout
    if changed:
        raise Wrong("the tree is dirty afterwards:\n" + changed.rstrip())


def found_in(page, pattern):
    found = re.search(pattern, page)
    if not found:
        raise Wrong(f"{PAGE} has no {pattern}")
    return found[0].strip("`")


def build_programs(page, clone, work):
    """The first program of the page, by each of the build systems as the page says."""
    program = "\n".join(next(lines for kind, lines in blocks(page) if kind == "cpp")) + "\n"

    def folder(name, **files):
        made = work / name
        made.mkdir()
        (made / "robot.cpp").write_text(program, "utf-8")
        for file, text in files.items():
            (made / file.replace("_txt", ".txt").replace("_build", ".build")).write_text(text, "utf-8")
        return made

    def step(where, command, **more):
        done = subprocess.run(command, cwd=where, shell=isinstance(command, str), env={**os.environ, **more},
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            print("\n".join(done.stdout.split("\n")[-40:]))
            raise Wrong(f"{where.name}: {command} failed")

    def report(name, tools, build):
        missing = [tool for tool in tools if shutil.which(tool) is None]
        if missing:
            raise Wrong(f"a program by {name}: {missing[0]} is not installed")
        build()
        print(f"ok      a program by {name}")

    def by_cmake():
        link = found_in(page, r"`target_link_libraries\([^`]*`")
        where = folder("cmake", CMakeLists_txt="cmake_minimum_required(VERSION 3.18)\nproject(robot CXX)\n"
                       f"add_subdirectory({clone} servobus)\nadd_executable(robot robot.cpp)\n{link}\n")
        step(where, ["cmake", "-S", ".", "-B", "made"])
        step(where, ["cmake", "--build", "made"])

    def by_meson():
        project, dependency = found_in(page, r"`project\('robot'[^`]*`"), found_in(page, r"`dependency\('[^`]*`")
        where = folder("meson", meson_build=f"{project}\n"
                       f"executable('robot', 'robot.cpp', dependencies: {dependency})\n")
        (where / "subprojects").mkdir()
        (where / "subprojects/servobus").symlink_to(clone)
        step(where, ["meson", "setup", "made"])
        step(where, ["meson", "compile", "-C", "made"])

    def by_pkg_config():
        where = folder("pkg-config")
        step(where, ["cmake", "-S", str(clone), "-B", "made", "-DSERVOBUS_TESTS=OFF", "-DSERVOBUS_EXAMPLES=OFF"])
        step(where, ["cmake", "--install", "made", "--prefix", str(where / "prefix")])
        step(where, found_in(page, r"`g\+\+ -std[^`]*pkg-config[^`]*`"),
             PKG_CONFIG_PATH=str(where / "prefix/share/pkgconfig"))

    report("CMake", ["cmake"], by_cmake)
    report("Meson", ["meson", "ninja"], by_meson)
    report("pkg-config", ["cmake", "pkg-config"], by_pkg_config)


def follow(work):
    clone = work / "clone"
    subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", str(ROOT), str(clone)], check=True)
    page = (clone / PAGE).read_text("utf-8")
    parts = parse(page)
    check_scripts(page, clone)
    commands = []
    for command in (command for part, _ in parts for command in part):
        if why := why_not_run(command):
            print(f"not run {command}: {why}")
        else:
            commands.append(command)
    outputs = iter(run(commands, clone, work))
    for part, quotes in parts:
        output = "".join(next(outputs) for command in part if why_not_run(command) is None)
        for quoted in quotes:
            check_quoted(quoted, output)
            print(f"ok      the output of {part[0]} is as quoted")
    check_clean(clone)
    build_programs(page, clone, work)
    check_clean(clone)
    print(f"readme_commands.py: {len(commands)} commands, and the tree is clean afterwards")


def main(arguments):
    try:
        if arguments == ["--list"]:
            for command in (command for part, _ in parse((ROOT / PAGE).read_text("utf-8")) for command in part):
                why = why_not_run(command)
                print(f"not run  {command}    ({why})" if why else f"run      {command}")
            return 0
        if arguments:
            print(__doc__)
            return 2
        with tempfile.TemporaryDirectory() as work:
            follow(Path(work))
        return 0
    except Wrong as wrong:
        print(f"FAILED  {wrong}")
        return 1


sys.exit(main(sys.argv[1:]))
