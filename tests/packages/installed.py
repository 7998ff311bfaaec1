# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Part of debian.py, which runs it as root in a copy of the machine: installs the packages, uses what they have as a
user does, and removes them.    installed.py WORK VERSION TOOL.deb HEADERS.deb
"""
import os
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from checks import (ROOT, begin, check, end, expect, expect_lines, expect_same, must, passes, run, same, text_of,
                    until)

work, version, tool_deb, headers_deb = Path(sys.argv[1]), *sys.argv[2:]
PAGE = "/usr/share/man/man1/servobus.1.gz"
COMPLETION = "/usr/share/bash-completion/completions/servobus"
PROGRAM = """#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>
int main() { return servobus::modbus::write_frame(1, 0x200E, 7).size == 8 ? 0 : 1; }
"""
LISTS = f"""cmake_minimum_required(VERSION 3.18)
project(user CXX)
find_package(servobus {version} REQUIRED)
add_executable(user main.cpp)
target_link_libraries(user PRIVATE servobus::servobus)
"""


def says(name, expected, *command):
    same(name, expected, run(*command).stdout.strip())


def machine():
    """The paths of all files where packages have theirs."""
    return must("sh", "-c", "find /usr /etc /opt /var/lib/dpkg/info ! -path '/usr/share/info/dir*' | sort")


def as_packed():
    expect_same("", must("dpkg", "-V", "servobus", "libservobus-dev"))
    expect_same("", must("dpkg", "-C"))


def has_license():
    license = (ROOT / "LICENSE").read_text("utf-8")
    copyright = re.sub(r"^ (\.$)?", "", Path("/usr/share/doc/servobus/copyright").read_text("utf-8"), flags=re.M)
    expect(copyright.endswith(license), copyright)


def simulated():
    link = work / "drive"
    drive = begin("servobus", "sim", "zlac8015d", "--link", link)
    until(link.exists, drive, "the simulated drive")
    expect_same("bus_voltage=24.00 V\n", must("servobus", "read", link, "zlac8015d", "bus_voltage"))
    expect_same(0, end(drive))


def page_without_warning():
    done = run("man", "--warnings", "servobus", apart=True, env={**os.environ, "MANWIDTH": "80"})
    expect(done.returncode == 0 and not done.stderr and "--dry-run" in done.stdout, done.stderr or done.stdout)


def by_find_package():
    must("cmake", "-S", user, "-B", user / "build")
    must("cmake", "--build", user / "build")
    must(user / "build/user")
    expect("\nservobus_DIR:PATH=/usr/share/cmake/servobus\n" in text_of(user / "build/CMakeCache.txt"), "another one")


def by_pkg_config():
    expect_same(version + "\n", must("pkg-config", "--modversion", "servobus"))
    flags = must("pkg-config", "--cflags", "servobus").split()
    must("g++", "-std=c++20", *flags, user / "main.cpp", "-o", user / "user")
    must(user / "user")


before = machine()
# Images of Debian for containers leave manual pages and documents out.
passes("dpkg installs both", "dpkg", "--path-include=/usr/share/man/*", "--path-include=/usr/share/doc/*", "-i",
       tool_deb, headers_deb)
check("their files are as they were packed", as_packed)
for file in ("servobus/copyright", "servobus/changelog.gz", "servobus/README.md", "libservobus-dev/copyright",
             "libservobus-dev/changelog.gz"):
    passes(f"/usr/share/doc/{file}", "test", "-s", f"/usr/share/doc/{file}")
check("the license is in copyright", has_license)
says("servobus is in the path", "/usr/bin/servobus", "sh", "-c", "command -v servobus")
says("servobus --version", f"servobus {version}", "servobus", "--version")
same("servobus map", 464, run("servobus", "map", "c630s").stdout.count("\n"))
check("a simulated drive, and a read of it", simulated)
says("man finds the page", PAGE, "man", "-w", "servobus")
check("man shows it without a warning", page_without_warning)
check("man -k knows what it is", expect, "motor drives" in run("lexgrog", PAGE).stdout, "it does not")
says("completion", "bus_voltage", "bash", "tests/tool/words.bash", COMPLETION, "servobus", ":=",
     "servobus read p zlac8015d:1 bus_v")
says("bash-completion loads it by the command's name", "complete -F _servobus servobus", "bash", "--norc", "-c",
     ". /usr/share/bash-completion/bash_completion; _completion_loader servobus; complete -p servobus")
user = work / "user"
user.mkdir()
(user / "main.cpp").write_text(PROGRAM)
(user / "CMakeLists.txt").write_text(LISTS)
check("a program by find_package", by_find_package)
check("a program by pkg-config", by_pkg_config)
passes("dpkg removes both", "dpkg", "-P", "servobus", "libservobus-dev")
check("and leaves nothing", expect_lines, before, machine())
