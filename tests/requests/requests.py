# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Records which requests the tests send, in a copy of a tree whose simulated clocks do not advance while a program only asks for
the time, and compares two records. See tests/requests.sh."""
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
INCLUDE = "#include <tests/requests/recorder.hpp>\n#pragma once\n"

# Of each simulated line: the call by which a request leaves, and the clock.
CHANGES = {
    "include/servobus/sim/line.hpp": [
        ("        if (!is_sending()) begin_request(out.size());\n",
         "        ::recorder::request(out.data(), out.size());\n        if (!is_sending()) begin_request(out.size());\n"),
        ("    void wait(duration longest) {\n",
         "    void wait(duration longest) {\n"
         "        if (arrived_ != 0 || is_unplugged_ || longest.us == 0) pass(settings_.poll.us);\n"),
        ("    instant now() {\n        pass(settings_.poll.us);\n",
         "    ::recorder::clock_use use_;\n    instant now() {\n"
         "        if (use_.takes_time(time_)) pass(settings_.poll.us);\n"),
    ],
    "tests/support/scripted_port.hpp": [
        ("    void take(std::uint8_t byte) {\n", "    void take(std::uint8_t byte) {\n        ::recorder::request(&byte, 1);\n"),
        ("    servobus::instant now() {\n        tick(call_us);\n",
         "    ::recorder::clock_use use_;\n    servobus::instant now() {\n        if (use_.takes_time(time)) tick(call_us);\n"),
    ],
    "tests/support/frame_port.hpp": [
        ("    instant now() { return instant{static_cast<std::uint32_t>(++time_)}; }\n",
         "    ::recorder::clock_use use_;\n    instant now() {\n        if (use_.takes_time(time_)) ++time_;\n"
         "        return instant{static_cast<std::uint32_t>(time_)};\n    }\n"),
        ("    transfer send(bytes out) {\n",
         "    transfer send(bytes out) {\n        ::recorder::request(out.data(), out.size());\n"),
    ],
}


def change(folder):
    """Makes the simulated lines of a copy record."""
    for name, changes in CHANGES.items():
        path = folder / name
        source = path.read_text()
        source = source.replace("#pragma once\n", INCLUDE, 1)
        for old, new in changes:
            if source.count(old) != 1:
                sys.exit(f"requests.py: {name} does not have once: {old.strip()}")
            source = source.replace(old, new)
        path.write_text(source)
    for name in ("recorder.hpp", "recorder.cpp"):
        (folder / "tests/requests").mkdir(exist_ok=True)
        shutil.copy(HERE / name, folder / "tests/requests" / name)
    shutil.copy(HERE / "recorder.cpp", folder / "tests/run/core/zz_recorder.cpp")


def place(fresh, folder):
    """Makes `folder` what `fresh` is. Files that are the same keep their time, so that little is built again."""
    files = {p.relative_to(fresh) for p in fresh.rglob("*") if p.is_file()}
    for old in [p for p in folder.rglob("*") if p.is_file() and p.relative_to(folder) not in files]:
        old.unlink()
    for file in files:
        if not (folder / file).is_file() or (folder / file).read_bytes() != (fresh / file).read_bytes():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(fresh / file, folder / file)


def build_and_record(folder, build, record, arguments):
    run = lambda *command, **o: subprocess.run(command, check=True, **o)  # noqa: E731
    settings = ["-DSERVOBUS_UNIT_FOLDERS=bus;control;core;device;sim", "-DCMAKE_BUILD_TYPE="]
    run("cmake", "-S", folder, "-B", build, "-G", "Ninja", *settings, stdout=subprocess.DEVNULL)
    run("ninja", "-C", build, "servobus_tests", stdout=subprocess.DEVNULL)
    environment = {**os.environ, "REQUESTS": str(record), "SERVOBUS_INTERPRETATIONS": "default"}
    done = subprocess.run([build / "tests/servobus_tests", "--no-version", *arguments], env=environment,
                          stdout=subprocess.PIPE, text=True)  # fmt: skip
    print(done.stdout.splitlines()[-2] if done.stdout.strip() else "no output")


def read(record):
    found = {}
    for line in Path(record).read_text().splitlines():
        parts = line.split("\t")
        if len(parts) == 4:
            found[tuple(parts[2:])] = parts[:2]
    return found


def compare(before, after):
    old, new = read(before), read(after)
    differ = [case for case in old if case in new and old[case] != new[case]]
    for source, name in differ:
        was, now = old[source, name][0], new[source, name][0]
        print(f"{source}: {name}: {was} requests, {now} now" if was != now else f"{source}: {name}: other requests")
    gone = [case for case in old if case not in new]
    for source, name in gone:
        print(f"{source}: {name}: only in the first record")
    same = sum(1 for case in old if new.get(case) == old[case])
    requests = sum(int(old[case][0]) for case in old if new.get(case) == old[case])
    print(f"requests.sh: {same} test cases with {requests} requests are the same, {len(differ)} differ, {len(gone)} are gone")
    return 1 if differ or gone else 0


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    if what == "place":
        change(Path(rest[0]))
        place(Path(rest[0]), Path(rest[1]))
    elif what == "record":
        build_and_record(Path(rest[0]), Path(rest[1]), Path(rest[2]), rest[3:])
    else:
        sys.exit(compare(*rest))
