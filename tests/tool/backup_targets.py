# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the FILE of backup may be, and that an error leaves an old file intact.

If this machine does not allow a case, a line that begins with "NOT RUN" reports it.
"""
import os
import shutil
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Running, Tool, broken_pipe, play_tool, scene

IS_ROOT = os.getuid() == 0
GONE = broken_pipe()


class Backups(Tool):
    """A stage with a drive, whose whole backup is `good`."""

    good = ""

    @contextmanager
    def drive(self, **how):
        with self.simulated("zlac8015d", **how):
            self.good = self.run("backup drive zlac8015d").out
            self.write("good", self.good)
            yield

    def at(self, name: str) -> Path:
        return self.folder / name

    def back_up(self, file: Path | str, **how):
        return self.run(["backup", "drive", "zlac8015d", str(file)], **how)

    def is_good(self, name: str, file: str):
        self.check(name, self.exists(file) and self.read(file) == self.good)

    def is_still(self, name: str, kind, file: Path):
        """`kind`: one of the functions of `stat`, of the file itself and not of what it links to."""
        self.check(name, os.path.lexists(file) and kind(file.lstat().st_mode))

    def mode_is(self, name: str, file: str, mode: int):
        found = stat.S_IMODE(self.at(file).stat().st_mode)
        self.check(name, found == mode, oct(found))

    def leaves_no_draft(self, name: str):
        drafts = list(self.folder.rglob("*.part*"))
        self.check(name, not drafts, drafts)

    def refused(self, name: str, text: str, file: Path):
        self.back_up(file)
        self.status_is(f"{name}: status 1", 1)
        self.err_has(f"{name}: says why", f"cannot write {file}: {text}")
        self.leaves_no_draft(f"{name}: no draft is left")


# A new file, and one that exists


@scene()
def regular_files(tool: Backups):
    with tool.drive():
        tool.back_up(tool.at("new"), sh='umask 027; exec "$@"')
        tool.is_good("a new file is whole", "new")
        tool.mode_is("has the mode of the umask", "new", 0o640)
        for mode in (0o600, 0o644, 0o664):
            tool.write("old", "old\n")
            tool.at("old").chmod(mode)
            tool.back_up(tool.at("old"))
            tool.is_good(f"an old file of mode {mode:o} is replaced", "old")
            tool.mode_is("and keeps the mode", "old", mode)
        tool.leaves_no_draft("no draft is left")
        tool.back_up("here")
        tool.is_good("a file without a folder", "here")
        tool.back_up(tool.at("a" * 250))
        tool.is_good("a file with a long name", "a" * 250)
        if IS_ROOT:
            os.chown(tool.at("old"), 65534, 65533)
            tool.at("old").chmod(0o604)
            tool.back_up(tool.at("old"))
            tool.is_good("an old file of another owner is replaced", "old")
            now = tool.at("old").stat()
            tool.is_equal("and keeps its owner", (now.st_uid, now.st_gid), (65534, 65533))
            tool.mode_is("and its mode", "old", 0o604)
        else:
            tool.say("NOT RUN: a file of another owner, since only root makes one")


# Not a regular file: backup writes into it and does not replace it


def own_node(tool: Backups, name: str, minor: int) -> Path | None:
    """A device of the memory driver: a new one, or one in a folder without write permission.

    The tests use no device node of this machine that a faulty tool could replace, since all programs would lose it.
    """
    node = tool.at(name)
    try:
        os.mknod(node, stat.S_IFCHR | 0o666, os.makedev(1, minor))
        with open(node, "wb"):
            return node
    except OSError:
        node.unlink(missing_ok=True)
    node = Path("/dev") / name
    if not os.access("/dev", os.W_OK):
        return node
    tool.say(f"NOT RUN: a device like {node}, since mknod is not permitted and {node} itself would be at risk")
    return None


@scene()
def devices(tool: Backups):
    with tool.drive():
        if node := own_node(tool, "full", 7):
            tool.refused("a full device", "No space left on device", node)
            tool.is_still("it stays a device", stat.S_ISCHR, node)
        if node := own_node(tool, "null", 3):
            tool.back_up(node)
            tool.status_is("a device takes it", 0)
            tool.is_still("and stays a device", stat.S_ISCHR, node)
            tool.at("to_null").symlink_to(node)
            tool.back_up(tool.at("to_null"))
            tool.status_is("a link to a device", 0)
            tool.is_still("stays one", stat.S_ISLNK, tool.at("to_null"))
            tool.is_still("and the device one", stat.S_ISCHR, node)


@scene()
def block_device(tool: Backups):
    """With a number that no driver has, so that opening it would do no harm."""
    disk = tool.at("disk")
    try:
        os.mknod(disk, stat.S_IFBLK | 0o600, os.makedev(240, 99))
    except OSError:
        return tool.say("NOT RUN: a block device, since mknod is not permitted")
    with tool.drive():
        tool.refused("a block device", "it is a block device", disk)
        tool.is_still("stays one", stat.S_ISBLK, disk)
        tool.at("to_disk").symlink_to("disk")
        tool.refused("a link to a block device", "it is a block device", tool.at("to_disk"))
        tool.is_still("stays a link", stat.S_ISLNK, tool.at("to_disk"))


@scene()
def pipes(tool: Backups):
    with tool.drive():
        fifo = tool.at("fifo")
        os.mkfifo(fifo)
        reader = Running(["cat", "fifo"], tool.folder)
        tool.back_up(fifo)
        tool.status_is("a FIFO takes it", 0)
        is_a_fifo = stat.S_ISFIFO(fifo.lstat().st_mode)
        read = reader.wait() if is_a_fifo else reader.stop()
        tool.check("its reader has all", read.out == tool.good)
        tool.check("and it stays a FIFO", is_a_fifo)
        tool.back_up("/dev/fd/9", out=GONE, sh='exec "$@" 9>&1 >/dev/null')
        tool.status_is("a pipe whose reader has gone: status 1", 1)
        tool.err_has("and says so", "cannot write /dev/fd/9: Broken pipe")


@scene()
def descriptors(tool: Backups):
    with tool.drive():
        stdout = tool.at("stdout")  # as /dev/stdout is
        stdout.symlink_to("/proc/self/fd/1")
        tool.back_up(stdout, sh='"$@" | cat >copy')
        tool.is_good("standard output by its name, a pipe", "copy")
        tool.back_up(stdout, sh='exec "$@" >copy')
        tool.is_good("or a file", "copy")
        tool.write("copy", "first\n")
        tool.back_up(stdout, sh='exec "$@" >>copy')
        first, _, rest = tool.read("copy").partition("\n")
        tool.check("which keeps what it has before", first == "first")
        tool.check("and is added to", rest == tool.good)
        tool.at("to_stdout").symlink_to("stdout")
        tool.back_up(tool.at("to_stdout"), sh='"$@" | cat >copy')
        tool.is_good("or a link to it", "copy")
        tool.is_still("which stays one", stat.S_ISLNK, tool.at("to_stdout"))
        tool.is_still("and its name stays", stat.S_ISLNK, stdout)
        tool.back_up("/dev/fd/5", sh='exec "$@" 5>copy')
        tool.is_good("/dev/fd/5", "copy")
        tool.back_up(stdout, sh='exec "$@" >&-')
        tool.status_is("standard output by its name, closed: status 1", 1)
        tool.err_has("and says so", f"cannot write {stdout}: Bad file descriptor")
        # The port has one of these numbers when it is open. It must not be taken for the one that the caller named.
        for number in (3, 4, 5, 6):
            tool.back_up(f"/dev/fd/{number}", sh='exec "$@" 3>&- 4>&- 5>&- 6>&-')
            tool.status_is(f"/dev/fd/{number} that is closed: status 1", 1)
            tool.err_has("and says so", f"cannot write /dev/fd/{number}: ")


@scene()
def the_port(tool: Backups):
    with tool.drive():
        port = Path(os.readlink(tool.at("drive")))
        tool.at("to_port").symlink_to(port)
        for file in (tool.at("to_port"), port):
            tool.fails("the port itself is no file", f"backup drive zlac8015d {file}", 2, "is the port")
            tool.is_still("and stays a device", stat.S_ISCHR, port)
        tool.says("and the drive has received nothing of it", "read drive zlac8015d bus_voltage", "bus_voltage=24.00 V")


@scene()
def links(tool: Backups):
    with tool.drive():
        tool.at("folder").mkdir()
        target = tool.at("folder/target")
        for name, to in [
            ("link", "folder/target"),
            ("link2", "link"),
            ("dangling", "folder/nothing"),
            ("loop1", "loop2"),
            ("loop2", "loop1"),
            ("to_folder", "folder"),
        ]:
            tool.at(name).symlink_to(to)
        for link in ("link", "link2"):
            target.write_text("old\n")
            target.chmod(0o640)
            tool.back_up(tool.at(link))
            tool.status_is(f"{link}: status 0", 0)
            tool.is_still(f"{link}: it stays a link", stat.S_ISLNK, tool.at(link))
            tool.is_good(f"{link}: its target is written", "folder/target")
            tool.mode_is(f"{link}: and keeps its mode", "folder/target", 0o640)
            tool.leaves_no_draft(f"{link}: no draft is left")
        tool.refused("a link to nothing", "it is a symbolic link to nothing", tool.at("dangling"))
        tool.is_still("stays a link", stat.S_ISLNK, tool.at("dangling"))
        tool.check("and nothing is made", not tool.exists("folder/nothing"))
        tool.refused("a loop of links", "Too many levels of symbolic links", tool.at("loop1"))
        tool.is_still("stays one", stat.S_ISLNK, tool.at("loop1"))
        tool.refused("a folder", "Is a directory", tool.at("folder"))
        tool.refused("a link to a folder", "Is a directory", tool.at("to_folder"))
        tool.is_still("stays a link", stat.S_ISLNK, tool.at("to_folder"))
        tool.refused("a folder that is not there", "No such file or directory", tool.at("none/file"))
        tool.refused("a file taken for a folder", "Not a directory", tool.at("good/file"))


# An error leaves the old file as it was


@scene()
def too_large(tool: Backups):
    with tool.drive():
        tool.write("kept", "old\n")
        tool.at("kept").chmod(0o600)
        # The complaint goes through a pipe, since the limit holds for its file too.
        limited = '(ulimit -f 1; "$@" 2>&1 >/dev/null; echo "$?" >&3) 3>status | cat >&2'
        tool.back_up(tool.at("kept"), sh=limited)
        tool.is_equal("a file that grows too large: status 1", tool.read("status"), "1\n")
        tool.err_has("and says so", f"cannot write {tool.at('kept')}: File too large")
        is_kept = tool.read("kept") == "old\n" and stat.S_IMODE(tool.at("kept").stat().st_mode) == 0o600
        tool.check("the old one is intact", is_kept)
        tool.leaves_no_draft("no draft is left")
        tool.back_up(tool.at("unmade"), sh=limited)
        tool.check("and no new one is made", not tool.exists("unmade"))


# In a mount namespace, which ends with the script. Arguments: the volume, the good backup, then the tool's words
# without the file.
FULL_DISK = """
volume=$1 good=$2
shift 2
mount -t tmpfs -o size=32k none "$volume" || exit 99
echo old >"$volume/kept"
dd if=/dev/zero of="$volume/filler" bs=1k 2>/dev/null
"$@" "$volume/kept"
status=$?
"$@" "$volume/unmade" 2>/dev/null
[ "$(cat "$volume/kept")" = old ] && [ "$(ls "$volume" | tr '\\n' ' ')" = "filler kept " ] || exit 98
rm "$volume/filler"
"$@" "$volume/kept" 2>/dev/null && cmp "$volume/kept" "$good" || exit 97
exit $status
"""


@scene()
def full_disk(tool: Backups):
    volume = tool.at("volume")
    volume.mkdir()
    alone = ["unshare", "--mount", "--map-root-user"]
    if subprocess.run([*alone, "mount", "-t", "tmpfs", "none", volume], stderr=subprocess.DEVNULL).returncode != 0:
        return tool.say("NOT RUN: a full disk, since a tmpfs cannot be mounted, but the limit of a file's size was run")
    with tool.drive():
        script = [*alone, "sh", "-c", FULL_DISK, "sh", str(volume), "good", tool.path]
        tool.run("backup drive zlac8015d", program=script)
        tool.status_is("a full disk: status 1, the old file is intact, nothing else is left", 1)
        tool.err_has("and says so", f"cannot write {volume}/kept: No space left on device")


@scene()
def ordinary_user(tool: Backups):
    """As a user other than root, with a drive of that user, who must own its terminal, in a folder of that user."""
    own = tool.at("own")
    own.mkdir()
    shutil.copy(tool.path, own / "servobus")
    for path in (tool.folder, own / "servobus"):
        path.chmod(0o755)
    as_user = []
    if IS_ROOT:
        os.chown(own, 65534, 65534)
        as_user = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    if subprocess.run([*as_user, "test", "-w", own], stderr=subprocess.DEVNULL).returncode != 0:
        return tool.say(
            "NOT RUN: an ordinary user's files, since setpriv(1) is not permitted or the program cannot be reached"
        )
    program = [*as_user, str(own / "servobus")]
    with tool.simulated("zlac8015d", named="a drive of an ordinary user", link="own/drive", program=program):
        tool.good = tool.run("backup own/drive zlac8015d", program=program).out

        def back_up(name: str, mode: int, folder_mode: int | None = None):
            file = own / name
            if not file.exists():
                file.parent.mkdir(exist_ok=True)
                file.write_text("old\n")
            file.chmod(mode)
            if folder_mode:
                file.parent.chmod(folder_mode)
            tool.run(f"backup own/drive zlac8015d {file}", program=program)
            return file

        def denied(name: str, file: Path, intact: str):
            tool.status_is(f"{name}: status 1", 1)
            tool.err_has("and says so", f"cannot write {file}: Permission denied")
            tool.check(intact, file.read_text() == "old\n")

        denied("a file that may not be written", back_up("protected", 0o444), "it is intact")
        if IS_ROOT:
            back_up("shared", 0o666)
            tool.is_good("a file whose owner cannot be kept is written", "own/shared")
            tool.mode_is("and keeps its mode", "own/shared", 0o666)
            os.chown(own / "shared", 0, 65533)
            back_up("shared", 0o6766)
            tool.mode_is("but none of the bits that act with the rights of its owner", "own/shared", 0o766)
        file = back_up("closed/file", 0o666, folder_mode=0o555)
        denied("a folder that may not be written", file, "its file is intact")
        file.parent.chmod(0o755)


@scene()
def link_of_a_simulator(tool: Backups):
    """sim --link replaces a link to a pseudo-terminal, and nothing else."""
    tool.write("settings", "old\n")
    for name, to in [("mine", "settings"), ("dangling", "folder/nothing"), ("drive", "/dev/pts/999999")]:
        tool.at(name).symlink_to(to)
    tool.exits("sim: a link to something else", "sim zlac8015d --link mine", 1)
    tool.err_has("sim: says so", "it is a symbolic link to settings")
    tool.check("sim: and it stays", os.readlink(tool.at("mine")) == "settings")
    tool.exits("sim: a link to nothing", "sim zlac8015d --link dangling", 1)
    tool.check("sim: stays too", os.readlink(tool.at("dangling")) == "folder/nothing")
    with tool.simulated("zlac8015d", named="sim: one that another simulator has left is replaced"):
        tool.check("sim: by its own", tool.at("drive").is_char_device())


play_tool(Backups)
