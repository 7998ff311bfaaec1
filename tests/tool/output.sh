# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: standard output that cannot be written, standard input that cannot be read, and
# standard descriptors that are closed when the tool starts.

# Descriptor 9 is a pipe without a reader.
mkfifo "$dir/pipe"
exec 8<>"$dir/pipe" 9>"$dir/pipe"
exec 8>&-

# into SINK ARGUMENTS...: standard output is a full disk (full), closed (closed) or the pipe without a reader (gone)
into() {
    sink=$1
    shift
    case $sink in
    full) timeout 20 "$tool" "$@" 2>"$dir/err" >/dev/full </dev/null ;;
    closed) timeout 20 "$tool" "$@" 2>"$dir/err" >&- </dev/null ;;
    gone) timeout 20 "$tool" "$@" 2>"$dir/err" >&9 </dev/null ;;
    esac
    status=$?
    : >"$dir/out"
}
reason_of() {
    case $1 in
    full) echo "No space left on device" ;;
    closed) echo "Bad file descriptor" ;;
    gone) echo "Broken pipe" ;;
    esac
}
is_lost() { status_is 1 && [ "$(grep -c 'cannot write standard output' "$dir/err")" -eq 1 ] && err_has "$reason"; }
# lost NAME ARGUMENTS...: with every sink, status 1 and one line with the reason
lost() {
    what=$1
    shift
    for sink in full closed gone; do
        reason=$(reason_of $sink)
        into $sink "$@"
        check "$what, output $sink (status $status)" is_lost
    done
}

lost "--help" --help
lost "map" map c630s
lost "alarms" alarms c630s
lost "sim, whose path is not known" sim zlac8015d
check "which says nothing else" err_lines_are 1
lost "sim with a link" sim zlac8015d --link "$dir/other"
check "and leaves none" [ ! -L "$dir/other" ]

# explain reads frames in a file, and one frame of a capture that continues.
explained() { timeout 20 "$tool" explain zlac8015d "$@" <"$dir/frames"; }
for frames in '> 01 03 20 AB 00 02 BE 2B' 'not a frame'; do
    printf '%s\n' "$frames" >"$dir/frames"
    explained 2>"$dir/err" >/dev/full
    status=$? reason=$(reason_of full)
    check "explain '$frames', output full" is_lost
    explained 2>"$dir/err" >&-
    status=$? reason=$(reason_of closed)
    check "explain '$frames', output closed" is_lost
    explained 2>"$dir/err" >&9
    status=$? reason=$(reason_of gone)
    check "explain '$frames', output gone" is_lost
done
{ yes '01 06 20 0E 00 08 E2 0F' 2>/dev/null; } | timeout 20 "$tool" explain zlac8015d 2>"$dir/err" >/dev/full
status=$? reason=$(reason_of full)
check "explain ends with its output, not with its input" is_lost

# Standard input

: >"$dir/out"
timeout 20 "$tool" explain zlac8015d <"$dir" >"$dir/out" 2>"$dir/err"
status=$?
check "explain: a folder is no input (status $status)" status_is 1
check "and it says so" err_has "cannot read standard input: Is a directory"
check "in one line" err_lines_are 1
timeout 20 "$tool" explain zlac8015d <&- >"$dir/out" 2>"$dir/err"
status=$?
check "explain: nor is a closed descriptor (status $status)" status_is 1
check "and it says so" err_has "cannot read standard input: Bad file descriptor"
timeout 20 "$tool" explain zlac8015d </dev/null >"$dir/out" 2>"$dir/err"
status=$?
check "explain: an empty input is one" status_is 0
check "and says nothing" err_lines_are 0
printf '01 06 20 0E 00 08 E2 0F' | timeout 20 "$tool" explain zlac8015d >"$dir/out" 2>"$dir/err"
status=$?
check "explain: a last line without its end is a line" [ "$(wc -l <"$dir/out")" -eq 1 ]
check "and no error" status_is 0

# With a drive

start_sim zlac8015d
holds() { [ "$("$tool" read "$drive" zlac8015d "$1")" = "$2" ]; }
"$tool" backup "$drive" zlac8015d "$dir/good" 2>/dev/null
lost "read" read "$drive" zlac8015d bus_voltage
lost "watch" watch "$drive" zlac8015d bus_voltage --count 2 --interval 10
lost "an endless watch" watch "$drive" zlac8015d bus_voltage --interval 10
lost "scan" scan "$drive" --baud 115200 --format 8N1 --nodes 1-2
lost "backup without a file" backup "$drive" zlac8015d
for sink in full closed gone; do
    reason=$(reason_of $sink)
    run write "$drive" zlac8015d left_max_current=30 right_max_current=30
    into $sink write "$drive" zlac8015d left_max_current=12.5
    check "write, output $sink (status $status)" is_lost
    check "and that it is written" err_has "; 1 of 1 written"
    check "as it is" holds left_max_current "left_max_current=12.5 A"
    into $sink write "$drive" zlac8015d left_max_current=11 right_max_current=11
    check "several writes end with the output" is_lost
    check "and say where" err_has "; 1 of 2 written"
    check "the first is written" holds left_max_current "left_max_current=11.0 A"
    check "the other is not" holds right_max_current "right_max_current=30.0 A"
    run write "$drive" zlac8015d right_max_current=11
    into $sink restore "$drive" zlac8015d "$dir/good" --dry-run
    check "restore --dry-run, output $sink (status $status)" is_lost
    into $sink restore "$drive" zlac8015d "$dir/good" --yes
    check "restore, output $sink (status $status)" is_lost
    check "ends too" err_has "; 1 of 2 written, not: right_max_current"
    check "where it says" holds right_max_current "right_max_current=11.0 A"
    into $sink restore "$drive" zlac8015d:9 "$dir/good" --timeout 20 --retries 0
    check "what prints nothing fails for its own reason" err_has "no response"
    check "and for no other" sh -c "! grep -q 'standard output' '$dir/err'"
    into $sink backup "$drive" zlac8015d "$dir/again"
    check "a backup into a file needs no output" status_is 0
done

# No port or file that is opened later gets the numbers 0, 1 or 2.
"$tool" write "$drive" zlac8015d left_max_current=30 right_max_current=30 >/dev/null 2>&1
rm -f "$dir/again"
"$tool" backup "$drive" zlac8015d "$dir/again" <&- >&- 2>&-
status=$?
check "a backup with all three closed (status $status)" status_is 0
check "is that with all three open" cmp -s "$dir/again" "$dir/good"
# points_at NUMBER WORD...: where a descriptor of the tool in the background points
points_at() { readlink "/proc/$user/fd/$1" 2>/dev/null; }
has_port() { find "/proc/$user/fd" -lname '/dev/pts/*' 2>/dev/null | grep -q .; }
is_no_port() { # NUMBER: the descriptor is open and not a port
    place=$(points_at "$1")
    case $place in /dev/pts/* | "") return 1 ;; esac
}
# A write has its port open while it waits for consent.
mkfifo "$dir/consent"
exec 7<>"$dir/consent"
for closed in 1 2; do
    case $closed in
    1) "$tool" write "$drive" zlac8015d left_target_speed=5 <"$dir/consent" 2>"$dir/err" >&- & ;;
    2) "$tool" write "$drive" zlac8015d left_target_speed=5 <"$dir/consent" >"$dir/out" 2>&- & ;;
    esac
    user=$!
    check "descriptor $closed closed: the port is open" until_true has_port
    check "descriptor $closed closed: it is no port" is_no_port "$closed"
    echo no >&7
    wait "$user"
    status=$?
    check "descriptor $closed closed: not confirmed (status $status)" status_is 1
done
exec 7>&-
rm -f "$dir/rounds"
"$tool" watch "$drive" zlac8015d bus_voltage --interval 10 <&- >"$dir/rounds" 2>"$dir/err" &
user=$!
check "input closed: watch needs none" until_true test -s "$dir/rounds"
check "descriptor 0 is no port" is_no_port 0
kill -INT "$user"
wait "$user"
status=$?
check "and ends at an interrupt with status 0" status_is 0
stop_sim

exec 9>&-
