# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The .deb packages that CPack makes of the work tree, and cmake --install.

Made twice, the same bytes; lintian's judgement; dpkg puts them into a copy of this machine, where they are used and
removed (installed.py).
"""
import os
import shutil
import sys
import time

from package_tree import VERSION, folder, git, make_tree, tree
from checks import check, expect, expect_lines, expect_same, finish, must, need, of_program, passes, run

need("g++", "g++", "libc6-dev")
need("cmake", "cmake")
need("ninja", "ninja-build")
need("dpkg-shlibdeps", "dpkg-dev")
need("lintian", "lintian")
need("man", "man-db")
need("groff", "groff")
need("pkg-config", "pkg-config")
need("/usr/share/bash-completion/bash_completion", "bash-completion")

again = folder / "elsewhere/again"
prefix = folder / "prefix"
debs = folder / "debs"
tool_deb = debs / f"servobus_{VERSION}_{must('dpkg', '--print-architecture').strip()}.deb"
headers_deb = debs / f"libservobus-dev_{VERSION}_all.deb"
# What is installed besides headers.
OF_HEADERS = ["share/cmake/servobus/servobus-config-version.cmake", "share/cmake/servobus/servobus-config.cmake",
              "share/cmake/servobus/servobus-targets.cmake", "share/pkgconfig/servobus.pc"]
OF_TOOL = ["bin/servobus", "share/bash-completion/completions/servobus", "share/man/man1/servobus.1.gz"]

# A copy of this machine, whose changes are lost: an overlay over its root, in a mount namespace. Nothing that runs
# beside this test finds what is installed here.
IN_A_COPY = """set -eu
work=$1
mkdir "$work/layer" && mount -t tmpfs tmpfs "$work/layer"
mkdir "$work/layer/upper" "$work/layer/work" "$work/layer/root"
root=$work/layer/root
mount -t overlay overlay -o "lowerdir=/,upperdir=$work/layer/upper,workdir=$work/layer/work" "$root"
mkdir -p "$root$work" && mount --rbind "$work" "$root$work"
mount --rbind /dev "$root/dev" && mount --rbind /proc "$root/proc"
shift
exec chroot "$root" "$@"
"""


def pack(build, to, **more):
    must("cpack", "-D", f"CPACK_PACKAGE_DIRECTORY={to}", cwd=build, **more)
    shutil.rmtree(to / "_CPack_Packages")


def configure(source, build, *options, **more):
    must("cmake", "-S", source, "-B", build, "-DSERVOBUS_TESTS=OFF", *options, **more)


def make_debs(source, to, *options, **more):
    """Only the tool is compiled, and not optimised: the example programs are in no package."""
    configure(source, source / "build", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O0", *options, **more)
    must("cmake", "--build", source / "build", "-j", os.environ.get("JOBS", "2"), "--target", "servobus_tool")
    pack(source / "build", to, **more)


def made_elsewhere():
    again.parent.mkdir()
    must("git", "clone", "-q", tree, again)
    make_debs(again, folder / "debs2", "-G", "Ninja", env={**os.environ, "TZ": "Asia/Tokyo", "LC_ALL": "C"})


def same_bytes():
    must("diff", "-r", debs, folder / "debs2")
    expect_same(4, len([*debs.iterdir()]))


def depends(deb, of):
    return must("dpkg-deb", "-f", deb, of).strip()


def of_its_time():
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(int(git("log", "-1", "--format=%ct"))))
    lines = must("dpkg-deb", "-c", tool_deb).splitlines()
    expect(lines and all(f" {when} ./" in line and " root/root " in line for line in lines), "\n".join(lines))


def installed_by_dpkg():
    in_a_copy = ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--map-root-user"]), "sh", "-c", IN_A_COPY, "sh",
                 folder]
    if run(*in_a_copy, "true").returncode != 0:
        print("this system allows no copy: the packages are installed on the machine itself, and removed")
        in_a_copy = []
    shutil.rmtree(folder / "layer", ignore_errors=True)
    of_program("dpkg installs, uses and removes the packages",
               run(*in_a_copy, sys.executable, "-B", tree / "tests/packages/installed.py", folder, VERSION, tool_deb,
                   headers_deb, cwd="/").stdout, 21)
    check("and this machine has nothing of them", expect, run("dpkg", "-s", "servobus").returncode != 0
          and run("dpkg", "-s", "libservobus-dev").returncode != 0, "it has")


def installs(build, files):
    """These files, and no other but headers."""
    shutil.rmtree(prefix, ignore_errors=True)
    must("cmake", "--install", build, "--prefix", prefix)
    found = {str(path.relative_to(prefix)) for path in prefix.rglob("*") if path.is_file()}
    expect("include/servobus/servobus.hpp" in found, "no headers")
    expect_same(sorted(files), sorted(path for path in found if not path.startswith("include/servobus/")))


def in_prefix():
    included = must("pkg-config", "--variable=includedir", "servobus",
                    env={**os.environ, "PKG_CONFIG_PATH": f"{prefix}/share/pkgconfig"}).strip()
    expect_same(os.path.realpath(prefix / "include"), os.path.realpath(included))


def headers_alone():
    pack(folder / "headers", folder / "debs3")
    must("cmp", folder / "debs3" / headers_deb.name, headers_deb)
    expect(not (folder / "debs3" / tool_deb.name).exists(), "a package of the tool")


def parts_of(deb, to):
    to.mkdir()
    must("ar", "x", deb, cwd=to)
    return must("sh", "-c", "sha256sum *", cwd=to)


def by_another_umask():
    """The modes that ar gives to a package's three parts, which dpkg does not read, are all that a umask changes."""
    configure(tree, folder / "umask", "-DSERVOBUS_EXAMPLES=OFF", umask=0o077)
    pack(folder / "umask", folder / "debs4", umask=0o077)
    again = folder / "debs4" / headers_deb.name
    expect_lines(parts_of(headers_deb, folder / "parts"), parts_of(again, folder / "parts4"))


make_tree()
check("CPack makes the .deb packages", make_debs, tree, debs)
check("by Ninja, from another clone and time zone", made_elsewhere)
check("the same bytes", same_bytes)
for deb in (tool_deb, headers_deb):
    passes(f"lintian has neither an error nor a warning: {deb.name}", "lintian", "--allow-root", "--no-cfg",
           "--fail-on", "error,warning", deb)
on = depends(tool_deb, "Depends")
check("the tool depends on the C and C++ libraries", expect, on.startswith("libc6 ") and "libstdc++6 " in on, on)
check("the headers depend on nothing", expect_same, "", depends(headers_deb, "Depends"))
check("its files are of the commit's time, and root's", of_its_time)
installed_by_dpkg()
check("cmake --install: headers, tool, manual page and completion", installs, tree / "build", OF_HEADERS + OF_TOOL)
check("its tool runs", expect_same, f"servobus {VERSION}\n", must(prefix / "bin/servobus", "--version"))
check("its pkg-config file leads to its headers", in_prefix)
check("without building anything", configure, tree, folder / "unbuilt")
check("cmake --install: headers", installs, folder / "unbuilt", OF_HEADERS)
check("without the examples", configure, tree, folder / "headers", "-DSERVOBUS_EXAMPLES=OFF")
check("cmake --install: headers", installs, folder / "headers", OF_HEADERS)
check("CPack: the package of the headers alone, the same", headers_alone)
check("CPack: by another umask, the same content", by_another_umask)
finish()
