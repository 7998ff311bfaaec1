# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Programs that use the library as their authors would.    consumers.py PART

copied   a copy of include/
cmake    built and installed; add_subdirectory, find_package, FetchContent
meson    built and installed; a subproject, pkg-config
"""
import os
import shutil
import sys

from version import VERSION
from checks import ROOT, check, expect, expect_same, finish, must, need, passes, work

PROGRAM = """#include <servobus/servobus.hpp>
#include <servobus/device/zlac8015d.hpp>
int main() { return servobus::modbus::write_frame(1, 0x200E, 7).size == 8 ? 0 : 1; }
"""
folder = work()
prefix = folder / "prefix"


def user(name, file=None, text=""):
    """A folder with the program, and a file of its build system."""
    made = folder / name
    made.mkdir()
    (made / "main.cpp").write_text(PROGRAM)
    if file:
        (made / file).write_text(text)
    return made


def pkg_config(*options):
    return must("pkg-config", *options, "servobus",
                env={**os.environ, "PKG_CONFIG_PATH": f"{prefix}/share/pkgconfig"}).strip()


def copied():
    made = user("copied")
    shutil.copytree(ROOT / "include/servobus", made / "servobus")
    passes("a copy is compiled", "g++", "-std=c++20", "-I.", "main.cpp", "-o", "main", cwd=made)
    passes("and runs", made / "main")


def by_cmake(name, how):
    made = user(name, "CMakeLists.txt", f"cmake_minimum_required(VERSION 3.18)\nproject({name} CXX)\n{how}\n"
                "add_executable(user main.cpp)\ntarget_link_libraries(user PRIVATE servobus::servobus)\n")
    must("cmake", "-S", made, "-B", made / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    must("cmake", "--build", made / "build")
    must(made / "build/user")


def cmake():
    """The tests are built by other checks."""
    build = folder / "cmake"
    passes("configured as C++23", "cmake", "-S", ".", "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
           "-DCMAKE_CXX_FLAGS_RELEASE=-O0", "-DCMAKE_CXX_STANDARD=23", "-DSERVOBUS_TESTS=OFF",
           f"-DCMAKE_INSTALL_PREFIX={prefix}")
    passes("built", "cmake", "--build", build, "-j", os.environ.get("JOBS", "2"))
    passes("installed", "cmake", "--install", build)
    check("the version of pkg-config", lambda: expect_same(VERSION, pkg_config("--modversion")))
    check("add_subdirectory", by_cmake, "by_subdirectory", f"add_subdirectory({ROOT} servobus)")
    check("find_package", by_cmake, "by_find_package", "find_package(servobus REQUIRED)")
    check("FetchContent", by_cmake, "by_fetch_content", "include(FetchContent)\n"
          f"FetchContent_Declare(servobus SOURCE_DIR {ROOT})\nFetchContent_MakeAvailable(servobus)")


def has_tests(build):
    expect("servobus_tests" in must("meson", "test", "-C", build, "--list"), "they are not there")


def as_subproject():
    made = user("meson_user", "meson.build", "project('user', 'cpp', default_options: ['cpp_std=c++20'])\n"
                "executable('user', 'main.cpp', dependencies: dependency('servobus', fallback: 'servobus'))\n")
    (made / "subprojects").mkdir()
    (made / "subprojects/servobus").symlink_to(ROOT)
    must("meson", "setup", "build", cwd=made)
    must("meson", "compile", "-C", "build", cwd=made)
    must(made / "build/user")


def by_pkg_config():
    made = user("by_pkg_config")
    must("g++", "-std=c++20", *pkg_config("--cflags").split(), "main.cpp", "-o", "user", cwd=made)
    must(made / "user")


def meson():
    need("meson", "meson")
    build = folder / "meson"
    passes("configured", "meson", "setup", build, ".", "--prefix", prefix, "--unity", "on", "--unity-size", "21")
    passes("built", "meson", "compile", "-C", build, "servobus", "servobus_manual", "servobus_completion", "wheels")
    check("the tests are known", has_tests, build)
    passes("installed", "meson", "install", "-C", build, "--no-rebuild")
    check("the version of pkg-config", lambda: expect_same(VERSION, pkg_config("--modversion")))
    check("a subproject", as_subproject)
    check("pkg-config", by_pkg_config)


need("cmake", "cmake")
need("ninja", "ninja-build")
need("g++", "g++")
need("pkg-config", "pkg-config")
{"copied": copied, "cmake": cmake, "meson": meson}[sys.argv[1]]()
finish()
