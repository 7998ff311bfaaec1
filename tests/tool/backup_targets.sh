# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: what the FILE of backup may be, and that an error leaves an old file intact. If this machine
# does not allow a case, a line that begins with "NOT RUN" reports it.

start_sim zlac8015d
"$tool" backup "$drive" zlac8015d >"$dir/good" 2>/dev/null
is_good() { cmp -s "$1" "$dir/good"; }
mode_is() { [ "$(stat -c %a "$1")" = "$2" ]; }
owner_is() { [ "$(stat -c %u:%g "$1")" = "$2" ]; }
is_alone() { [ -z "$(find "$1" -name '*.part*')" ]; } # no draft is left
back_up() { run backup "$drive" zlac8015d "$@"; }
# refused NAME WORDS FILE: status 1, and standard error has the words
refused() {
    back_up "$3"
    check "$1: status 1 (status $status)" status_is 1
    check "$1: says why" err_has "cannot write $3: $2"
    check "$1: no draft is left" is_alone "$dir"
}

# A new file, and one that exists

(umask 027 && "$tool" backup "$drive" zlac8015d "$dir/new" 2>/dev/null)
check "a new file is whole" is_good "$dir/new"
check "has the mode of the umask" mode_is "$dir/new" 640
for mode in 600 644 664; do
    echo old >"$dir/old"
    chmod $mode "$dir/old"
    back_up "$dir/old"
    check "an old file of mode $mode is replaced" is_good "$dir/old"
    check "and keeps the mode" mode_is "$dir/old" $mode
done
check "no draft is left" is_alone "$dir"
program=$(realpath "$tool")
(cd "$dir" && "$program" backup "$drive" zlac8015d here 2>/dev/null)
check "a file without a folder" is_good "$dir/here"
long=$(printf 'a%.0s' $(seq 1 250))
back_up "$dir/$long"
check "a file with a long name" is_good "$dir/$long"
if [ "$(id -u)" -eq 0 ]; then
    chown 65534:65533 "$dir/old"
    chmod 604 "$dir/old"
    back_up "$dir/old"
    check "an old file of another owner is replaced" is_good "$dir/old"
    check "and keeps its owner" owner_is "$dir/old" 65534:65533
    check "and its mode" mode_is "$dir/old" 604
else
    echo "NOT RUN: a file of another owner, since only root makes one"
fi

# Not a regular file: backup writes into it and does not replace it

# The tests use no device node of this machine that a faulty tool could replace, since all programs would lose it.
# own_node NAME MINOR: $node is a device of the memory driver, a new one or one in a folder without write permission
own_node() {
    node=$dir/$1
    if mknod "$node" c 1 "$2" 2>/dev/null && test -w "$node"; then return 0; fi
    rm -f "$node"
    node=/dev/$1
    [ ! -w /dev ] && return 0
    echo "NOT RUN: a device like $node, since mknod is not permitted and $node itself would be at risk"
    return 1
}
if own_node full 7; then
    refused "a full device" "No space left on device" "$node"
    check "it stays a device" test -c "$node"
fi
if own_node null 3; then
    back_up "$node"
    check "a device takes it" status_is 0
    check "and stays a device" test -c "$node"
    ln -s "$node" "$dir/to_null"
    back_up "$dir/to_null"
    check "a link to a device" status_is 0
    check "stays one" test -L "$dir/to_null"
    check "and the device one" test -c "$node"
fi
mkfifo "$dir/fifo"
timeout 20 cat "$dir/fifo" >"$dir/copy" &
reader=$!
timeout 20 "$tool" backup "$drive" zlac8015d "$dir/fifo" >"$dir/out" 2>"$dir/err"
status=$?
check "a FIFO takes it" status_is 0
[ -p "$dir/fifo" ] || kill "$reader"
wait "$reader"
check "its reader has all" is_good "$dir/copy"
check "and it stays a FIFO" test -p "$dir/fifo"
exec 8<>"$dir/fifo" 9>"$dir/fifo"
exec 8>&-
timeout 20 "$tool" backup "$drive" zlac8015d /dev/fd/9 >"$dir/out" 2>"$dir/err"
status=$?
exec 9>&-
check "a pipe whose reader has gone: status 1 (status $status)" status_is 1
check "and says so" err_has "cannot write /dev/fd/9: Broken pipe"
stdout=$dir/stdout # as /dev/stdout is
ln -s /proc/self/fd/1 "$stdout"
: >"$dir/copy"
"$tool" backup "$drive" zlac8015d "$stdout" 2>/dev/null | cat >"$dir/copy"
check "standard output by its name, a pipe" is_good "$dir/copy"
"$tool" backup "$drive" zlac8015d "$stdout" >"$dir/copy" 2>/dev/null
check "or a file" is_good "$dir/copy"
echo first >"$dir/copy"
"$tool" backup "$drive" zlac8015d "$stdout" >>"$dir/copy" 2>/dev/null
check "which keeps what it has before" [ "$(head -n 1 "$dir/copy")" = first ]
tail -n +2 "$dir/copy" >"$dir/rest"
check "and is added to" is_good "$dir/rest"
ln -s stdout "$dir/to_stdout"
"$tool" backup "$drive" zlac8015d "$dir/to_stdout" 2>/dev/null | cat >"$dir/copy"
check "or a link to it" is_good "$dir/copy"
check "which stays one" test -L "$dir/to_stdout"
check "and its name stays" test -L "$stdout"
"$tool" backup "$drive" zlac8015d /dev/fd/5 5>"$dir/copy" 2>/dev/null
check "/dev/fd/5" is_good "$dir/copy"
"$tool" backup "$drive" zlac8015d "$stdout" 2>"$dir/err" >&-
status=$?
check "standard output by its name, closed: status 1 (status $status)" status_is 1
check "and says so" err_has "cannot write $stdout: Bad file descriptor"
# The port has one of these numbers when it is open. It must not be taken for the descriptor that the caller named.
for number in 3 4 5 6; do
    timeout 20 "$tool" backup "$drive" zlac8015d /dev/fd/$number >"$dir/out" 2>"$dir/err" 3>&- 4>&- 5>&- 6>&- </dev/null
    status=$?
    check "/dev/fd/$number that is closed: status 1 (status $status)" status_is 1
    check "and says so" err_has "cannot write /dev/fd/$number: "
done
port=$(readlink "$drive")
ln -s "$port" "$dir/to_port"
for file in "$dir/to_port" "$port"; do
    fails "the port itself is no file" 2 "is the port" backup "$drive" zlac8015d "$file"
    check "and stays a device" test -c "$file"
done
succeeds "and the drive has received nothing of it" "bus_voltage=24.00 V" read "$drive" zlac8015d bus_voltage

# Symbolic links

mkdir "$dir/folder"
echo old >"$dir/folder/target"
chmod 640 "$dir/folder/target"
ln -s folder/target "$dir/link"
ln -s link "$dir/link2"
for link in link link2; do
    echo old >"$dir/folder/target"
    back_up "$dir/$link"
    check "$link: status 0" status_is 0
    check "$link: it stays a link" test -L "$dir/$link"
    check "$link: its target is written" is_good "$dir/folder/target"
    check "$link: and keeps its mode" mode_is "$dir/folder/target" 640
    check "$link: no draft is left" is_alone "$dir"
done
ln -s folder/nothing "$dir/dangling"
refused "a link to nothing" "it is a symbolic link to nothing" "$dir/dangling"
check "stays a link" test -L "$dir/dangling"
check "and nothing is made" test ! -e "$dir/folder/nothing"
ln -s loop2 "$dir/loop1"
ln -s loop1 "$dir/loop2"
refused "a loop of links" "Too many levels of symbolic links" "$dir/loop1"
check "stays one" test -L "$dir/loop1"
refused "a folder" "Is a directory" "$dir/folder"
ln -s folder "$dir/to_folder"
refused "a link to a folder" "Is a directory" "$dir/to_folder"
check "stays a link" test -L "$dir/to_folder"
refused "a folder that is not there" "No such file or directory" "$dir/none/file"
refused "a file taken for a folder" "Not a directory" "$dir/good/file"

# A block device with a number that no driver has, so that opening it would do no harm.
if mknod "$dir/disk" b 240 99 2>/dev/null; then
    refused "a block device" "it is a block device" "$dir/disk"
    check "stays one" test -b "$dir/disk"
    ln -s disk "$dir/to_disk"
    refused "a link to a block device" "it is a block device" "$dir/to_disk"
    check "stays a link" test -L "$dir/to_disk"
else
    echo "NOT RUN: a block device, since mknod is not permitted"
fi

# An error leaves the old file as it was

echo old >"$dir/kept"
chmod 600 "$dir/kept"
is_kept() { [ "$(cat "$dir/kept")" = old ] && mode_is "$dir/kept" 600; }
(ulimit -f 1 && "$tool" backup "$drive" zlac8015d "$dir/kept" >/dev/null 2>&1)
status=$?
(ulimit -f 1 && "$tool" backup "$drive" zlac8015d "$dir/kept" 2>&1 >/dev/null | cat >"$dir/err")
check "a file that grows too large: status 1 (status $status)" status_is 1
check "and says so" err_has "cannot write $dir/kept: File too large"
check "the old one is intact" is_kept
check "no draft is left" is_alone "$dir"
(ulimit -f 1 && "$tool" backup "$drive" zlac8015d "$dir/unmade" >/dev/null 2>&1)
check "and no new one is made" test ! -e "$dir/unmade"
# A full disk in a separate mount namespace, which is removed with it.
mkdir "$dir/volume"
cat >"$dir/volume.sh" <<'END'
mount -t tmpfs -o size=32k none "$2" || exit 99
echo old >"$2/kept"
dd if=/dev/zero of="$2/filler" bs=1k 2>/dev/null
"$1" backup "$3" zlac8015d "$2/kept"
status=$?
"$1" backup "$3" zlac8015d "$2/unmade" 2>/dev/null
[ "$(cat "$2/kept")" = old ] && [ "$(ls "$2" | tr '\n' ' ')" = "filler kept " ] || exit 98
rm "$2/filler"
"$1" backup "$3" zlac8015d "$2/kept" 2>/dev/null && cmp "$2/kept" "$4" || exit 97
exit $status
END
if unshare --mount --map-root-user sh -c 'mount -t tmpfs none "$1"' mount "$dir/volume" 2>/dev/null; then
    unshare --mount --map-root-user sh "$dir/volume.sh" "$tool" "$dir/volume" "$drive" "$dir/good" >"$dir/out" 2>"$dir/err"
    status=$?
    check "a full disk: status 1, the old file is intact, nothing else is left (status $status)" status_is 1
    check "and says so" err_has "cannot write $dir/volume/kept: No space left on device"
else
    echo "NOT RUN: a full disk, since a tmpfs cannot be mounted, but the limit of a file's size was run"
fi
stop_sim

# As a user other than root, with a separate simulated drive, since that user must own its terminal.
common=$dir
dir=$common/own
mkdir "$dir"
cp "$tool" "$dir/servobus"
chmod 755 "$common" "$dir/servobus"
as_user=
if [ "$(id -u)" -eq 0 ]; then
    chown 65534:65534 "$dir"
    as_user="setpriv --reuid=65534 --regid=65534 --clear-groups"
fi
if $as_user test -w "$dir"; then
    $as_user "$dir/servobus" sim zlac8015d --link "$dir/drive" >"$dir/sim.out" 2>"$dir/sim.err" &
    sim=$!
    check "a drive of an ordinary user" until_true test -s "$dir/sim.out" -a -e "$dir/drive"
    as_user_back_up() {
        $as_user "$dir/servobus" backup "$dir/drive" zlac8015d "$1" >"$dir/out" 2>"$dir/err"
        status=$?
    }
    echo old >"$dir/protected"
    chmod 444 "$dir/protected"
    as_user_back_up "$dir/protected"
    check "a file that may not be written: status 1 (status $status)" status_is 1
    check "and says so" err_has "cannot write $dir/protected: Permission denied"
    check "it is intact" [ "$(cat "$dir/protected")" = old ]
    if [ "$(id -u)" -eq 0 ]; then
        echo old >"$dir/shared"
        chmod 666 "$dir/shared"
        as_user_back_up "$dir/shared"
        check "a file whose owner cannot be kept is written" cmp -s "$dir/shared" "$common/good"
        check "and keeps its mode" mode_is "$dir/shared" 666
        chown 0:65533 "$dir/shared"
        chmod 6766 "$dir/shared"
        as_user_back_up "$dir/shared"
        check "but none of the bits that act with the rights of its owner" mode_is "$dir/shared" 766
    fi
    mkdir "$dir/closed"
    echo old >"$dir/closed/file"
    chmod 666 "$dir/closed/file"
    chmod 555 "$dir/closed"
    as_user_back_up "$dir/closed/file"
    check "a folder that may not be written: status 1 (status $status)" status_is 1
    check "and says so" err_has "cannot write $dir/closed/file: Permission denied"
    check "its file is intact" [ "$(cat "$dir/closed/file")" = old ]
    chmod 755 "$dir/closed"
    stop_sim
else
    echo "NOT RUN: an ordinary user's files, since setpriv(1) is not permitted or the program cannot be reached"
fi
dir=$common

# sim --link replaces a link to a pseudo-terminal, and nothing else.
linked() { timeout 20 "$tool" sim zlac8015d --link "$1" >"$dir/out" 2>"$dir/err"; status=$?; }
echo old >"$dir/settings"
ln -s settings "$dir/mine"
linked "$dir/mine"
check "sim: a link to something else (status $status)" status_is 1
check "sim: says so" err_has "it is a symbolic link to settings"
check "sim: and it stays" [ "$(readlink "$dir/mine")" = settings ]
linked "$dir/dangling"
check "sim: a link to nothing (status $status)" status_is 1
check "sim: stays too" [ "$(readlink "$dir/dangling")" = folder/nothing ]
ln -sf /dev/pts/999999 "$drive"
check "sim: one that another simulator has left is replaced" start_sim zlac8015d
check "sim: by its own" test -c "$drive"
stop_sim
