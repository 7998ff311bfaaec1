# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The recipes of vcpkg and Conan, with stand-ins for their functions."""
import re
import shutil
import sys

from package_tree import folder, make_tree, maker, out
from checks import check, expect, finish, must, need, passes, run

need("cmake", "cmake")
need("g++", "g++")
vcpkg_folder = folder / "vcpkg"
damaged = folder / "damaged"
INSTALLED = ("include/servobus/servobus.hpp", "share/servobus/servobus-config.cmake", "share/servobus/copyright",
             "share/servobus/usage", "share/pkgconfig/servobus.pc")


def vcpkg(port):
    shutil.rmtree(vcpkg_folder, ignore_errors=True)
    for name in ("trees", "packages"):
        (vcpkg_folder / name).mkdir(parents=True)
    return ["cmake", f"-DPORTFILE={port}/portfile.cmake", "-DPORT=servobus",
            f"-DCURRENT_BUILDTREES_DIR={vcpkg_folder}/trees", f"-DCURRENT_PACKAGES_DIR={vcpkg_folder}/packages",
            "-P", "tests/packages/vcpkg.cmake"]


def vcpkg_installs():
    must(*vcpkg(out / "vcpkg/servobus"))
    installed, moved, build = vcpkg_folder / "packages", vcpkg_folder / "moved", vcpkg_folder / "user"
    for file in INSTALLED:
        expect((installed / file).is_file() and (installed / file).stat().st_size > 0, f"no {file}")
    for name in ("debug", "lib", "bin"):
        expect(not (installed / name).exists(), name)
    must("cmp", "LICENSE", installed / "share/servobus/copyright")
    installed.rename(moved)  # vcpkg moves what it installs
    must("cmake", "-S", "examples/packages/conan/test_package", "-B", build, f"-DCMAKE_PREFIX_PATH={moved}")
    must("cmake", "--build", build)
    must(build / "user")


def refuses(words, *command):
    done = run(*command)
    expect(done.returncode != 0 and re.search(words, " ".join(done.stdout.split())), done.stdout)


def conan(recipe, *standard):
    return [sys.executable, "-B", "tests/packages/conan.py", recipe, folder / f"conan{''.join(standard)}", *standard]


make_tree()
must(*maker(), out)
for kind in ("vcpkg/servobus", "conan"):
    shutil.copytree(out / kind, damaged / kind)
for archive in damaged.rglob("*.tar.gz"):
    archive.write_bytes(archive.read_bytes() + b"\n")
check("vcpkg: the port installs, and a program finds it", vcpkg_installs)
check("vcpkg: another archive than the port's is refused", refuses, "not the archive that this port was made with",
      *vcpkg(damaged / "vcpkg/servobus"))
passes("Conan: the recipe makes a package, and its test passes", *conan(out / "conan"))
check("Conan: another archive than the recipe's is refused", refuses, "ERROR: .*sha256",
      *conan(damaged / "conan", "23"))
check("Conan: C++17 is refused", refuses, r"ERROR: .*C\+\+20 is needed", *conan(out / "conan", "17"))
finish()
