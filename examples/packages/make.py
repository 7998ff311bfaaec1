# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Makes the packages of examples/packages/README.md from the commit that is checked out.

python3 examples/packages/make.py [OUT]
    OUT                 a folder, build/packages if not given; packages of an earlier run in it are replaced
    SOURCE_DATE_EPOCH   the time of all files in seconds since 1970, that of the commit if not given

The version is that of CMakeLists.txt. The same commit gives the same bytes: it reads the files of the commit, not those
of the work tree, so line endings and modes are git's.
Exit status: 0 made; 1 a tool is missing or OUT cannot be written; 2 wrong usage, or a tree that is not a commit. If it
is not 0, nothing was written, also if a signal ended it.
"""
import hashlib
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True  # the tree stays as the commit is
import reproducible
import single_header

ROOT = Path(__file__).resolve().parent.parent.parent
HERE = "examples/packages/"
DRIVES = ("c630s", "yako", "zlac8015d")
# Layers that need an operating system, and what their single headers have.
HOSTED = {"posix": "serial ports and pseudo-terminals of Linux.", "windows": "serial ports of Windows."}


class Refused(Exception):
    """A line for the user, and the exit status."""

    def __init__(self, line, status):
        super().__init__(line)
        self.status = status


def git(*arguments):
    try:
        done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, check=False)
    except FileNotFoundError:
        raise Refused("git is needed: packages are made from a commit", 1) from None
    if done.returncode != 0:
        why = done.stderr.decode(errors="replace").strip().splitlines()
        raise Refused(f"{ROOT} is not a git checkout with a commit: {why[0] if why else 'git failed'}", 2)
    return done.stdout


def check_tree():
    """Refuses a tree that differs from its commit: a package must be what its commit says."""
    top = git("rev-parse", "--show-toplevel").decode().strip()
    if Path(top).resolve() != ROOT:
        raise Refused(f"{ROOT} is not a git checkout of its own: it lies in that of {top}", 2)
    git("rev-parse", "--verify", "HEAD")
    changed = [line[3:] for line in git("status", "--porcelain", "--untracked-files=all").decode().splitlines()]
    if changed:
        more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        raise Refused(f"the tree is dirty: commit or remove {changed[0]}{more}", 2)


def read_commit():
    files = {}
    # Whatever the user's git makes of line endings in a work tree.
    archive = git("-c", "core.autocrlf=false", "-c", "core.eol=lf", "archive", "--format=tar", "HEAD")
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        for entry in tar:
            if entry.isfile():
                files[entry.name] = (tar.extractfile(entry).read(), bool(entry.mode & 0o100))
            elif not entry.isdir():
                raise Refused(f"{entry.name} is neither a file nor a folder", 1)
    return files


def time_of_files():
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not given:
        return int(git("log", "-1", "--format=%ct"))
    if not re.fullmatch("[0-9]{1,10}", given) or int(given) > reproducible.LATEST_IN_ZIP:
        raise Refused(f"SOURCE_DATE_EPOCH is not a number of seconds until 2107: {given}", 2)
    return int(given)


class Tree:
    """The files of the commit, and the folders that packages take from it."""

    def __init__(self):
        self.files = read_commit()
        found = re.search(r"^project\(servobus VERSION ([0-9]+\.[0-9]+\.[0-9]+) ", self.text("CMakeLists.txt"), re.M)
        if not found:
            raise Refused("CMakeLists.txt has no version", 1)
        self.version = found[1]
        self.headers = {path[len("include/servobus/"):]: self.text(path) for path in sorted(self.files)
                        if path.startswith("include/servobus/") and path.endswith(".hpp")}

    def text(self, path):
        return self.files[path][0].decode()

    def template(self, path, **more):
        """A file of this folder; its @NAME@ become values."""
        values = {"VERSION": self.version, **more}
        return re.sub("@([A-Z0-9_]+)@", lambda found: values[found[1]], self.text(HERE + path))

    def library(self, into, is_hosted):
        """The headers and pages of include/servobus/, without those for an operating system unless `is_hosted`."""
        prefix = "include/servobus/"
        return {f"{into}/{path[len(prefix):]}": file for path, file in self.files.items()
                if path.startswith(prefix) and (is_hosted or path[len(prefix):].split("/")[0] not in HOSTED)}

    def ports(self, into, *names):
        """Ports of examples/ports/, all if none is named. They are headers of the package, servobus/ports/."""
        prefix = "examples/ports/"
        return {f"{into}/ports/{path[len(prefix):]}": file for path, file in self.files.items()
                if path.startswith(prefix) and path.endswith(".hpp") and
                (not names or path[len(prefix):] in names)}


def plain(text):
    return text.encode(), False


def package(tree, readme, files):
    """A package's files in one folder, with what each package has."""
    both = {"LICENSE": tree.files["LICENSE"], "README.md": plain(tree.template(readme)), **files}
    return {f"servobus/{path}": file for path, file in both.items()}


def standard_includes(tree):
    """The standard headers that the library includes outside of its hosted layers."""
    names = set()
    for header, text in tree.headers.items():
        if header.split("/")[0] not in HOSTED:
            names.update(single_header.split(header, text)[1])
    return "\n".join(f"#include {name}" for name in sorted(names))


def arduino(tree):
    shim = tree.template("arduino/servobus.h.in", STANDARD_INCLUDES=standard_includes(tree))
    return package(tree, "arduino/README.md.in", {
        "library.properties": plain(tree.template("arduino/library.properties.in")),
        "keywords.txt": tree.files[HERE + "arduino/keywords.txt"],
        "src/servobus.h": plain(shim),
        "examples/wheels/wheels.ino": tree.files[HERE + "arduino/wheels/wheels.ino"],
        **tree.library("src/servobus", is_hosted=False),
        **tree.ports("src/servobus", "arduino_stream.hpp"),
    })


def platformio(tree):
    shim = tree.template("arduino/servobus.h.in", STANDARD_INCLUDES=standard_includes(tree))
    return package(tree, "platformio/README.md.in", {
        "library.json": plain(tree.template("platformio/library.json.in")),
        "include/servobus.h": plain(shim),
        "examples/wheels/wheels.ino": tree.files[HERE + "arduino/wheels/wheels.ino"],
        **tree.library("include/servobus", is_hosted=True),  # it has a platform `native` too
        **tree.ports("include/servobus"),
    })


def zephyr(tree):
    return package(tree, "zephyr/README.md.in", {
        "zephyr/module.yml": tree.files[HERE + "zephyr/module.yml"],
        "zephyr/CMakeLists.txt": tree.files[HERE + "zephyr/CMakeLists.txt"],
        "zephyr/Kconfig": tree.files[HERE + "zephyr/Kconfig"],
        **tree.library("include/servobus", is_hosted=False),
        **tree.ports("include/servobus", "zephyr_uart.hpp"),
    })


def esp_idf(tree):
    return package(tree, "esp_idf/README.md.in", {
        "CMakeLists.txt": tree.files["CMakeLists.txt"],
        "idf_component.yml": plain(tree.template("esp_idf/idf_component.yml.in")),
        **tree.library("include/servobus", is_hosted=False),
        **tree.ports("include/servobus", "esp_idf_uart.hpp"),
    })


def vcpkg(tree, archive, source):
    sha512 = hashlib.sha512(source).hexdigest()
    return {
        "vcpkg.json": plain(tree.template("vcpkg/vcpkg.json.in")),
        "portfile.cmake": plain(tree.template("vcpkg/portfile.cmake.in", SHA512=sha512)),
        "usage": tree.files[HERE + "vcpkg/usage"],
        archive: (source, False),
    }


def conan(tree, archive, source):
    test = {path[len(HERE) + len("conan/"):]: file for path, file in tree.files.items()
            if path.startswith(HERE + "conan/test_package/")}
    sha256 = hashlib.sha256(source).hexdigest()
    return {
        "conanfile.py": plain(tree.template("conan/conanfile.py.in", SHA256=sha256)),
        archive: (source, False),
        **test,
    }


def single_headers(tree):
    """servobus.hpp has all layers that know no drive and need no operating system; a drive's header has them too."""
    def of_layers(wanted):
        return sorted(header for header in tree.headers if "/detail/" not in header and wanted(header.split("/")[0]))

    core = ["servobus.hpp"] + of_layers(lambda layer: layer not in ("servobus.hpp", "device", "sim", *HOSTED))
    headers = {"servobus.hpp": (core, "lines, clients, registers, control and buses, without a drive.")}
    for drive in DRIVES:
        parts = core + [f"device/{drive}.hpp"]
        headers[f"servobus_{drive}.hpp"] = (parts, f"all of servobus.hpp, and the drive {drive}.")
    for layer, purpose in HOSTED.items():
        if own := of_layers(lambda other, layer=layer: other == layer):
            headers[f"servobus_{layer}.hpp"] = (own, purpose)
    return {name: plain(single_header.join(parts, tree.headers, tree.version, purpose))
            for name, (parts, purpose) in headers.items()}


def make_all(tree, seconds):
    """All files of OUT."""
    name = f"servobus-{tree.version}"
    source = reproducible.tar_gz({f"{name}/{path}": file for path, file in tree.files.items()}, seconds)
    archive = f"{name}.tar.gz"
    out = {
        archive: (source, False),
        f"{name}-arduino.zip": (reproducible.zip_archive(arduino(tree), seconds), False),
        f"{name}-platformio.tar.gz": (reproducible.tar_gz(platformio(tree), seconds), False),
        f"{name}-zephyr.tar.gz": (reproducible.tar_gz(zephyr(tree), seconds), False),
        f"{name}-esp-idf.tar.gz": (reproducible.tar_gz(esp_idf(tree), seconds), False),
    }
    for folder, files in (("vcpkg/servobus", vcpkg(tree, archive, source)), ("conan", conan(tree, archive, source)),
                          ("single", single_headers(tree))):
        out.update({f"{folder}/{path}": file for path, file in files.items()})
    return out


OF_EARLIER_RUN = re.compile(r"vcpkg|conan|single|servobus-[0-9.]+(-[a-z-]+)?\.(tar\.gz|zip)")


def check_out(out):
    """Refuses what is no folder, and a folder with files that are not of an earlier run: OUT is replaced as a whole."""
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise Refused(f"{out} is not a folder", 1)
    if not out.exists():
        return
    for entry in sorted(out.iterdir()):
        if not OF_EARLIER_RUN.fullmatch(entry.name):
            raise Refused(f"{out} has files that are not of an earlier run, such as {entry.name}", 1)


def write_files(folder, files, seconds):
    for path, (content, is_executable) in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        target.chmod(reproducible.mode(is_executable))
        os.utime(target, (seconds, seconds))
    for directory in (folder, *(path for path in folder.rglob("*") if path.is_dir())):
        directory.chmod(0o755)


STOPPING = (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)


def stop(number, _):
    raise Refused("stopped", 128 + number)


def replace_out(out, files, seconds):
    """Writes into a folder beside OUT, which then takes the place of OUT. A signal to stop leaves OUT as it was."""
    check_out(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    beside = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    try:
        write_files(beside / "new", files, seconds)
        if out.exists():
            out.rename(beside / "old")
        (beside / "new").rename(out)
    finally:
        for number in STOPPING:
            signal.signal(number, signal.SIG_IGN)
        if not out.exists() and (beside / "old").exists():
            (beside / "old").rename(out)
        shutil.rmtree(beside, ignore_errors=True)


def main(arguments):
    if arguments in (["-h"], ["--help"]):
        print("usage: python3 examples/packages/make.py [OUT]     (OUT: build/packages if not given)")
        return 0
    if len(arguments) > 1 or any(argument.startswith("-") or not argument for argument in arguments):
        raise Refused("usage: python3 examples/packages/make.py [OUT]", 2)
    for number in STOPPING:
        signal.signal(number, stop)
    out = Path(os.path.abspath(arguments[0])) if arguments else ROOT / "build/packages"
    check_tree()
    seconds = time_of_files()
    tree = Tree()
    check_out(out)
    files = make_all(tree, seconds)
    try:
        replace_out(out, files, seconds)
    except OSError as error:
        raise Refused(f"{out} cannot be written: {error.strerror}", 1) from None
    for path in sorted(files):
        print(out / path)
    return 0


try:
    sys.exit(main(sys.argv[1:]))
except Refused as refused:
    print(f"make.py: {refused}", file=sys.stderr)
    sys.exit(refused.status)
except single_header.CannotJoin as refused:
    print(f"make.py: {refused}", file=sys.stderr)
    sys.exit(1)
