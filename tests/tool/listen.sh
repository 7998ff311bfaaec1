# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: servobus listen. tapped_line.py is the line: it plays frames of the drives' manuals, or relays
# between a client and a simulated drive, and counts every byte that comes out of the listener.
# shellcheck shell=sh

tap=$dir/tap
told=$dir/told
capture=$dir/capture
listener=
limit="timeout 60"
mkfifo "$dir/feed"

# open_line play|relay ARGUMENT...: `feed` then talks to it
open_line() {
    rm -f "$told"
    python3 -B "$parts/tapped_line.py" "$tap" "$told" "$@" <"$dir/feed" 2>"$dir/line.err" &
    line=$!
    exec 6>"$dir/feed"
    until_true test -s "$told"
}
feed() { printf '%s\n' "$@" >&6; }
close_line() {
    exec 6>&-
    wait "$line"
}
# start_listening ARGUMENT...: until it has opened the tap
start_listening() {
    : >"$dir/err" # the last one's, which the next line looks at
    # shellcheck disable=SC2086
    $limit "$tool" listen "$@" >"$dir/out" 2>"$dir/err" &
    listener=$!
    until_true grep -q listening "$dir/err"
}
stop_listening() { # SIGNAL
    kill "-$1" "$listener"
    wait "$listener"
    status=$?
}
shows() { grep -qF -- "$1" "$dir/out"; }
is_shown() { until_true shows "$1"; }
# Lines without what a clock gives
without_clock() {
    sed -E 's/^[0-9]+\.[0-9]{3} //; s/\(after [0-9]+\.[0-9] ms\)$/(after T)/; s/gap of [0-9.]+ s/gap of T/
        s/slowest_ms=[0-9]+\.[0-9]/slowest_ms=T/' "$dir/out"
}
said() { [ "$(without_clock)" = "$1" ]; }
# What explain says of the capture is what listen said of the frames.
explains_the_same() { # DEVICE...
    sed -nE 's/^[0-9]+\.[0-9]{3} [<>?] //p' "$dir/out" |
        sed -E 's/ \(after [0-9.]+ ms\)$//; s/ \(without a request\)$//' >"$dir/listened"
    [ -s "$dir/listened" ] && "$tool" explain "$@" <"$capture" >"$dir/explained"
    explained=$?
    cmp -s "$dir/listened" "$dir/explained"
}
has_sent() { [ "$(cat "$told")" = "sent $1" ]; }
frames_of() { grep -v '^#' "$1"; }
has_frames() { [ "$(frames_of "$capture" | wc -l)" -ge "$1" ]; }
# Each line `name=value` of the client is `name = value` here, which has an address in addition when it is written.
is_heard() {
    sed -E 's/ \(0x[0-9A-F]{4}\)//g; s/_/ /g; s/$/ /' "$dir/out" >"$dir/values"
    sed -E 's/ \(0x[0-9A-F]{4}\)$//; s/_/ /g; s/\+/ + /g; s/=/ = /' "$dir/read" >"$dir/wanted"
    [ -s "$dir/wanted" ] && while read -r one; do
        grep -qE -- "(, | )$(echo "$one" | sed 's/[.+]/[&]/g')[ ,]" "$dir/values" || return 1
    done <"$dir/wanted"
}
# Each request of each node has one end, but for one at most that still waits.
sums_are_right() {
    grep '^# node=' "$dir/out" | tr ' =' '  ' | awk '
        { rest = $5 - $7 - $9 - $11 - $13; waiting += rest; if (rest < 0 || rest > 1) bad = 1 }
        END { exit bad || waiting > 1 || NR == 0 }'
}

run --help
check "--help has listen" grep -q '^  servobus listen PORT' "$dir/out"

# What is refused; there is no such port.

fails "listen: no device" 2 "listen takes PORT DEVICE[:NODE]..." listen /dev/no-such-port
fails "listen: an unknown device" 2 "known: zlac8015d" listen /dev/no-such-port zlac9000
fails "listen: no such port" 1 "cannot open /dev/no-such-port" listen /dev/no-such-port zlac8015d
fails "listen: Modbus TCP has no traffic of others" 2 "no traffic of others" listen mbap://127.0.0.1 zlac8015d
fails "listen: a gateway sets the rate" 2 "not --baud and --format" listen tcp://127.0.0.1:1 zlac8015d --baud 9600
fails "listen: two devices at an address" 2 "two devices at address 2" \
    listen /dev/no-such-port zlac8015d:2 c630s:2
fails "listen: two devices at all addresses" 2 "two devices for the addresses that are not named" \
    listen /dev/no-such-port zlac8015d c630s
fails "listen: a format that there is not" 2 "--format takes" listen /dev/no-such-port zlac8015d --format 7E1
fails "listen: nothing is sent, so nothing is repeated" 2 "unknown option '--retries'" \
    listen /dev/no-such-port zlac8015d --retries 1
echo "time,error,unix_time (ms)" >"$dir/rounds"
fails "listen: a log of watch is no file of frames" 2 "no file of frames" \
    listen /dev/no-such-port zlac8015d --log "$dir/rounds"
check "which stays as it is" [ "$(cat "$dir/rounds")" = "time,error,unix_time (ms)" ]

# Frames of the manuals, one drive each. --timeout: a busy machine is no drive that does not respond.

# plays DEVICE EXPECTED FRAME...
plays() {
    device=$1 expected=$2
    shift 2
    open_line play
    rm -f "$capture"
    start_listening "$tap" "$device" --timeout 2000 --log "$capture"
    feed "$@"
    until_true has_frames "$#"
    stop_listening INT
    check "listen, $device: what is said" said "$expected"
    check "status 0 at Ctrl-C" status_is 0
    check "the capture has the frames" [ "$(frames_of "$capture" | sed 's/^[<>] //')" = "$(printf '%s\n' "$@")" ]
    check "explain says the same" explains_the_same "$device"
    close_line
    check "nothing is sent" has_sent 0
}

plays zlac8015d \
    "> node 1: read left_actual_speed (0x20AB), right_actual_speed (0x20AC)
< node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min (after T)
> node 1: write control_word (0x200E) = enable (0x0008)
< node 1: response, control_word (0x200E) = enable (0x0008) written (after T)
> node 1: write left_encoder_lines (0x2030) = 1024, left_hall_offset_angle (0x2031) = 0 deg
< node 1: response, left_encoder_lines (0x2030), left_hall_offset_angle (0x2031) written (after T)
# node=1 requests=3 responses=3 exceptions=0 no_response=0 damaged=0 unpaired=0 slowest_ms=T
# frames=6 bad_crc=0 incomplete=0 noise=0 damaged_bytes=0" \
    "01 03 20 AB 00 02 BE 2B" "01 03 04 00 64 00 64 BA 07" "01 06 20 0E 00 08 E2 0F" "01 06 20 0E 00 08 E2 0F" \
    "01 10 20 30 00 02 04 04 00 00 00 68 4A" "01 10 20 30 00 02 4A 07"
check "and has status 0" [ "$explained" -eq 0 ]
plays yako-open-loop \
    "> node 1: read actual_position (0x000A), actual_speed (0x000C)
< node 1: response, actual_position = 5000 pulse, actual_speed = 0 r/min (in the factory's word order) (after T)
> node 1: write acceleration_time (0x0021) = 500 ms
< node 1: response, acceleration_time (0x0021) = 500 ms written (after T)
> node 1: write target_position (0x0024) = 5000 pulse (in the factory's word order)
< node 1: response, target_position (0x0024) written (after T)
> node 1: read unknown register (0x003C)
< node 1: response, exception 3 (register address not allowed) to read unknown register (0x003C) (after T)
# node=1 requests=4 responses=3 exceptions=1 no_response=0 damaged=0 unpaired=0 slowest_ms=T
# frames=8 bad_crc=0 incomplete=0 noise=0 damaged_bytes=0" \
    "01 03 00 0A 00 03 25 C9" "01 03 06 00 00 13 88 00 00 A5 DB" "01 06 00 21 01 F4 D9 D7" \
    "01 06 00 21 01 F4 D9 D7" "01 10 00 24 00 02 04 00 00 13 88 FD 12" "01 10 00 24 00 02 01 C3" \
    "01 03 00 3C 00 01 44 06" "01 83 03 01 31"
plays yako-closed-loop \
    "? node 1: valid frame of function 02 (read discrete inputs), data 00 00 00 04
< node 1: response, exception 2 (function code error) to function 02 (after T)
> node 1: write motion_command (0x0027) = stop (0x0100)
# node=1 requests=2 responses=0 exceptions=1 no_response=0 damaged=0 unpaired=0 slowest_ms=T
# frames=3 bad_crc=0 incomplete=0 noise=0 damaged_bytes=0" \
    "01 02 00 00 00 04 79 C9" "01 82 02 C1 61" "01 06 00 27 01 00 38 51"
plays c630s \
    "> node 1: read feedback_pulses (0x0B11)
< node 1: response, feedback_pulses = 13107300 counts (in the factory's word order) (after T)
> node 1: write speed_segment_1_speed (0x1214) = 500 r/min
< node 1: response, speed_segment_1_speed (0x1214) = 500 r/min written (after T)
> node 1: write position_segment_1_displacement (0x110C) = 80000 ref_unit (in the factory's word order)
< node 1: response, position_segment_1_displacement (0x110C) written (after T)
# node=1 requests=3 responses=3 exceptions=0 no_response=0 damaged=0 unpaired=0 slowest_ms=T
# frames=6 bad_crc=0 incomplete=0 noise=0 damaged_bytes=0" \
    "01 03 0B 11 00 02 96 2A" "01 03 04 00 64 00 C8 BA 7A" "01 06 12 14 01 F4 CC A1" "01 06 12 14 01 F4 CC A1" \
    "01 10 11 0C 00 02 04 38 80 00 01 FE E2" "01 10 11 0C 00 04 04 F5"
# What goes wrong on a line

reads="read left_actual_speed (0x20AB), right_actual_speed (0x20AC)"
speeds="response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min"
rm -f "$capture"
open_line play
start_listening "$tap" zlac8015d --timeout 300 --log "$capture"
feed "64 BA 07" "wait 60" "01 06 20 0E 00 08 E2 0F" "wait 700"          # the end of a response; which is it?
feed "01 06 20 0E 00 08 E2 0F" "01 06 20 0E 00 08 E2 0F"                # a request and its response
feed "01 03 20 AB 00 02 BE 2B" "wait 60" "01 03 04 00 64 00 64 BA 08" "wait 60" # a damaged response
feed "01 03 20 AB 00 02 BE 2B" "wait 700" "01 03 20 AB 00 02 BE 2B" "01 03 04 00 64 00 64 BA 07" # repeated
feed "01 03 20 AB 00 02 BE 2B" "02 03 20 AB 00 02 BE 18" "02 03 04 00 64 00 64 89 07"            # two addresses
feed "FF" "wait 60" "01 03 20 AB 00 02" "wait 60"                        # a glitch, and half a frame
feed "55 01 03 20 AB 00 02 BE 2B 01 03 04 00 64 00 64 BA 07"             # noise without a gap
feed "01 03 04 00 64 00 64 BA 07"                                        # a second response
feed "wait 1500" "00 06 20 0E 00 07 A3 DA"                               # to all nodes
is_shown "all nodes"
terminating=TERM
[ -z "${ON_WINE:-}" ] || terminating=INT # Windows has no other
stop_listening $terminating
check "listen: what is wrong is said" said "! noise: 64 BA 07
? node 1: write control_word (0x200E) = enable (0x0008) (request, or the response that echoes it)
> node 1: write control_word (0x200E) = enable (0x0008)
< node 1: response, control_word (0x200E) = enable (0x0008) written (after T)
> node 1: $reads
! bad CRC: 01 03 04 00 64 00 64 BA 08
> node 1: $reads
! no response from node 1 within 300 ms
> node 1: $reads
< node 1: $speeds (after T)
> node 1: $reads
! no response from node 1 before the next request
> node 2: $reads
< node 2: $speeds (after T)
! noise: FF
! incomplete: 01 03 20 AB 00 02
! noise: 55
> node 1: $reads
< node 1: $speeds (after T)
< node 1: $speeds (without a request)
! gap of T
> all nodes: write control_word (0x200E) = stop (0x0007)
# node=0 requests=1 responses=0 exceptions=0 no_response=0 damaged=0 unpaired=0 slowest_ms=T
# node=1 requests=6 responses=3 exceptions=0 no_response=2 damaged=1 unpaired=2 slowest_ms=T
# node=2 requests=1 responses=1 exceptions=0 no_response=0 damaged=0 unpaired=0 slowest_ms=T
# frames=14 bad_crc=1 incomplete=1 noise=3 damaged_bytes=20"
check "status 0 at SIG$terminating" status_is 0
check "the capture has 14 frames" [ "$(frames_of "$capture" | wc -l)" -eq 14 ]
check "and each damaged byte, with the reason, in a comment" \
    [ "$(grep -cE '^# [0-9T:.-]+Z (bad CRC: 01 03 04 00 64 00 64 BA 08|incomplete: 01 03 20 AB 00 02|noise: (55|FF|64 BA 07))$' "$capture")" -eq 5 ]
check "explain says the same" explains_the_same zlac8015d
check "and fails at none of them" [ "$explained" -eq 0 ]
limit=
start_listening "$tap" zlac8015d --timeout 300 --log "$capture"
limit="timeout 60"
feed "01 03 20 AB 00 02 BE 2B"
check "another run appends to the capture" until_true has_frames 15
kill -KILL "$listener"
wait "$listener" 2>/dev/null
check "after SIGKILL it is whole" sh -c "tail -c 1 '$capture' | od -c | grep -q '\\\\n'"
check "and explained" sh -c "'$tool' explain zlac8015d <'$capture' | grep -q actual_speed"
start_listening "$tap" zlac8015d --count 2
feed "01 03 20 AB 00 02 BE 2B" "01 03 04 00 64 00 64 BA 07" "01 03 20 AB 00 02 BE 2B"
wait "$listener"
status=$?
check "listen --count: status 0" status_is 0
check "after so many frames" shows "# frames=2 "
start_listening "$tap" zlac8015d:1 c630s:2
feed "02 03 0B 11 00 02 96 19" "01 03 20 AB 00 02 BE 2B" "03 03 20 AB 00 02 BF C9"
check "each device has its names: one" is_shown "> node 2: read feedback_pulses (0x0B11)"
check "the other" is_shown "> node 1: $reads"
check "and where none is named there are no names" is_shown "> node 3: read unknown registers (0x20AB..0x20AC)"
stop_listening INT
start_listening "$tap" zlac8015d
feed "01 03 20 AB 00 02 BE 2B"
is_shown "$reads"
feed "hang up"
wait "$listener"
status=$?
check "a port that is pulled is status 1" status_is 1
check "and said" err_has "servobus: the port is gone"
check "after the counters" shows "# node=1 requests=1 "
close_line
check "nothing was sent by any of them" has_sent 0

# Standard output that is lost
open_line play
if [ -n "${ON_WINE:-}" ]; then
    echo "left out: output that cannot be written (/dev/full is of Linux)"
else
    : >"$dir/err"
    timeout 20 "$tool" listen "$tap" zlac8015d >/dev/full 2>"$dir/err" &
    listener=$!
    until_true grep -q listening "$dir/err"
    feed "01 03 20 AB 00 02 BE 2B"
    wait "$listener"
    status=$?
    check "output that cannot be written ends it" status_is 1
    check "and is said once" [ "$(grep -c 'cannot write standard output: No space left on device' "$dir/err")" -eq 1 ]
fi
close_line

# A gateway that passes on what it receives
tap=tcp
open_line play
port=$(sed -n 's/^port //p' "$told")
start_listening "tcp://127.0.0.1:$port" zlac8015d
feed "01 03 20 AB 00 02 BE 2B" "01 03 04 00 64 00 64 BA 07"
check "listen to a gateway" is_shown "< node 1: $speeds"
# Timer 02 of the kernel: it asks whether the peer is still there.
is_kept_alive() { awk -v to=":$(printf %04X "$port")" 'index($3, to) && $4 == "01" && $6 ~ /^02:/ { n++ } END { exit n != 1 }' /proc/net/tcp; }
check "a gateway that vanishes without a word is noticed" is_kept_alive
feed "hang up"
wait "$listener"
status=$?
check "a connection that is closed is status 1" status_is 1
check "and said" err_has "servobus: the port is gone"
close_line
check "nothing is sent" has_sent 0
tap=$dir/tap

# A client and a simulated drive, with the listener between them

talk() { # DEVICE: more reads and writes than any test above
    case $1 in
    zlac8015d) names="bus_voltage left_actual_position status_word" change=left_acceleration_time=700 ;;
    yako-*) names="status_word actual_position node_address" change=acceleration_time=70 ;;
    c630s) names="mode_of_operation feedback_pulses" change=P06-03=100 ;;
    esac
    # A busy machine must not make the client repeat itself.
    # shellcheck disable=SC2086
    "$tool" read "$dir/client" "$1" $names --timeout 2000 >"$dir/read" 2>/dev/null
    "$tool" write "$dir/client" "$1" "$change" --yes --timeout 2000 >>"$dir/read" 2>/dev/null
    "$tool" read "$dir/client" raw:7 0x0020 --retries 1 >/dev/null 2>&1
    "$tool" backup "$dir/client" "$1" --timeout 2000 >"$dir/backup" 2>&1
}
for device in zlac8015d yako-closed-loop yako-open-loop c630s; do
    start_sim $device
    open_line relay "$dir/client" "$drive"
    rm -f "$capture"
    start_listening "$tap" $device --log "$capture" --timeout 2000
    talk $device
    sleep 0.2
    stop_listening INT
    check "listen beside a client of $device: nothing is damaged" \
        shows " bad_crc=0 incomplete=0 noise=0 damaged_bytes=0"
    check "every request has its response" grep -qE '^# node=1 requests=([0-9]+) responses=\1 .* unpaired=0 ' "$dir/out"
    check "or has none" shows "# node=7 requests=2 responses=0 exceptions=0 no_response=2 damaged=0 unpaired=0"
    check "what the client reads is what is heard" is_heard
    check "explain says the same" explains_the_same $device
    check "with status 0" [ "$explained" -eq 0 ]
    close_line
    check "nothing is sent" has_sent 0
    stop_sim
done

# A line with faults: the counters of requests and of their ends agree.
start_sim zlac8015d --faults late,lossy,noisy,doubled,cut --seed 3
open_line relay "$dir/client" "$drive"
rm -f "$capture"
start_listening "$tap" zlac8015d --log "$capture"
timeout 60 "$tool" watch "$dir/client" zlac8015d bus_voltage status_word --count 40 --interval 5 --timeout 120 \
    --retries 0 >/dev/null 2>&1
stop_listening INT
check "listen to a line with faults: status 0" status_is 0
check "each request has one end" sums_are_right
check "there was something damaged" sh -c "! grep -q damaged_bytes=0 '$dir/out'"
check "explain says the same" explains_the_same zlac8015d
close_line
check "nothing is sent" has_sent 0
stop_sim

# The check of what is sent can fail: a program that does send has the same port.
open_line play
run read "$tap" zlac8015d bus_voltage --retries 0 --timeout 20
close_line
check "a client on the tap is found out" has_sent 8
